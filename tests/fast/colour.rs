//! Colours of every illuminant of `data/` on every reflectance of `data/`, and of black bodies, against
//! colour-science.
//!
//! The references are computed by `validation/colour/make_reference.py`, which reads the same published
//! tables but interpolates, integrates and continues daylight with colour-science.

use crate::common::text_of;
use abbe::spectrum::Spectrum;
use abbe::spectrum::catalogue::{self, Entry, Kind, Quantity};
use abbe::spectrum::colour::{Observer, Xyz, delta_e_2000};
use abbe::spectrum::table_file::TableFile;
use abbe::units::WavelengthRange;
use std::collections::BTreeMap;
use std::path::Path;

const RANGE: WavelengthRange = WavelengthRange::VISIBLE;

/// Spectra by table and column.
fn spectra(kind: Kind) -> BTreeMap<(&'static str, String), Spectrum> {
    let entries = catalogue::names(kind).into_iter().map(|name| catalogue::lookup(kind, name).unwrap());
    let pair = |entry: Entry| match entry.quantity {
        Quantity::Spectrum(spectrum) => {
            ((entry.file.rsplit('/').next().unwrap_or(entry.file), entry.column), spectrum)
        }
        other => panic!("{}: {other:?}", entry.name),
    };
    entries.map(pair).collect()
}

fn reference(name: &str) -> TableFile {
    let path = format!("{}/tests/data/{name}", env!("CARGO_MANIFEST_DIR"));
    TableFile::parse(&text_of(Path::new(&path))).unwrap()
}

fn colours(table: &TableFile) -> Vec<Xyz> {
    let [x, y, z] = ["X", "Y", "Z"].map(|column| table.numbers(column).unwrap());
    x.iter().zip(&y).zip(&z).map(|((&x, &y), &z)| Xyz { x, y, z }).collect()
}

#[test]
fn every_reflectance_under_every_illuminant() {
    let observer = Observer::cie1931();
    let (lights, surfaces) = (spectra(Kind::Illuminant), spectra(Kind::Reflectance));

    let table = reference("illuminant_xyz.csv");
    let files = table.texts("illuminant_file").unwrap();
    let whites: BTreeMap<_, _> = files
        .iter()
        .zip(table.texts("illuminant").unwrap())
        .map(|(file, name)| (*file, name.to_owned()))
        .zip(colours(&table))
        .collect();
    assert_eq!(whites.len(), lights.len());
    for (light, expected) in &whites {
        let found = observer.white(&lights[light], RANGE);
        let ((x, y), (ex, ey)) = (found.chromaticity().unwrap(), expected.chromaticity().unwrap());
        assert!((x - ex).abs() < 1e-5 && (y - ey).abs() < 1e-5, "{light:?}: {x} {y}, expected {ex} {ey}");
    }

    let table = reference("reflected_xyz.csv");
    let [light_files, light_names, surface_files, surface_names] =
        ["illuminant_file", "illuminant", "reflectance_file", "reflectance"].map(|c| table.texts(c).unwrap());
    let expected = colours(&table);
    assert_eq!(expected.len(), lights.len() * surfaces.len(), "every pair has its reference");
    let mut worst = (0.0, String::new());
    for i in 0..expected.len() {
        let light = (light_files[i], light_names[i].to_owned());
        let surface = (surface_files[i], surface_names[i].to_owned());
        let found = observer.reflected(&lights[&light], &surfaces[&surface], RANGE);
        // Each side with its own white, as a user of either program would have it.
        let white = observer.white(&lights[&light], RANGE);
        let difference = delta_e_2000(found.to_lab(white), expected[i].to_lab(whites[&light]));
        if difference > worst.0 || difference.is_nan() {
            worst = (difference, format!("{surface:?} under {light:?}"));
        }
    }
    println!("{} pairs, greatest colour difference {:.2e}: {}", expected.len(), worst.0, worst.1);
    assert!(worst.0 < 0.01, "colour difference {} for {}", worst.0, worst.1);
}

#[test]
fn black_bodies_have_their_chromaticity() {
    let table = reference("blackbody_xy.csv");
    let [kelvin, x, y] = ["kelvin", "x", "y"].map(|column| table.numbers(column).unwrap());
    for i in 0..kelvin.len() {
        let body = Spectrum::blackbody(kelvin[i]).unwrap();
        let found = Observer::cie1931().white(&body, RANGE).chromaticity().unwrap();
        let error = (found.0 - x[i]).abs().max((found.1 - y[i]).abs());
        assert!(error < 1e-5, "{} K: {found:?}, expected {} {}", kelvin[i], x[i], y[i]);
    }
}
