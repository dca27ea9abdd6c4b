//! Measured surfaces: their places in the shared table, Mitsuba's values, and what was measured.

use super::*;
use abbe::bsdf::{Measured, MeasuredTable};
use abbe::scene::description::BsdfKind;
use abbe::scene::{ReadOptions, read_str};
use std::path::Path;

/// What the scene format makes of the files of validation/optics/make_measured_reference.py.
const FILES: [&str; 3] = ["gold", "half", "quarter"];

fn file(name: &str) -> &'static MeasuredTable {
    let scene = format!(
        r#"<scene version="3.0.0"><sensor type="perspective"/><shape type="sphere">
            <bsdf type="measured"><string name="filename" value="tests/data/measured/{name}.bsdf"/></bsdf>
        </shape></scene>"#
    );
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scene.xml");
    let description = read_str(scene, &path, &ReadOptions::default()).unwrap();
    let BsdfKind::Measured(source) = &description.shapes[0].bsdf.kind else { panic!("{description:?}") };
    source.table
}

fn measured<const C: usize>(name: &str, nm: impl Fn(usize) -> f64) -> Bsdf<C> {
    let table = file(name);
    Bsdf::Measured(Measured { table, wavelengths: Sampled::from_fn(|lane| table.wavelength(nm(lane))) })
}

pub fn table<const C: usize>() -> Vec<(String, Bsdf<C>)> {
    let nm = |lane: usize| 405.0 + 45.0 * lane as f64;
    FILES.into_iter().map(|name| (format!("measured {name}"), measured(name, nm))).collect()
}

/// Any wavelengths, some beyond those that were measured.
pub fn random<const C: usize>(uniform: &mut Uniform) -> Bsdf<C> {
    let name = FILES[uniform.between(0.0, FILES.len() as f64) as usize];
    let nm: [f64; C] = std::array::from_fn(|_| uniform.between(300.0, 900.0));
    measured(name, |lane| nm[lane])
}

/// Values of Mitsuba 3 in single precision: isotropic, and anisotropic with half and a quarter of the
/// azimuths.
#[test]
fn values_of_files_are_mitsubas() {
    let reference = include_str!("../../data/measured_reference.csv");
    let nm = reference.lines().find_map(|line| line.strip_prefix("# wavelengths ")).unwrap();
    let nm: Vec<f64> = nm.split(' ').map(|number| number.parse().unwrap()).collect();
    let mut rows = 0;
    let mut worst = 0.0f64;
    for line in reference.lines().filter(|line| !line.starts_with(['#', 'f'])) {
        let (name, numbers) = line.split_once(',').unwrap();
        let numbers: Vec<f64> = numbers.split(',').map(|field| field.parse().unwrap()).collect();
        let vector = |first: usize| Vec3::from_slice(&numbers[first..first + 3]).normalize();
        let found = measured::<4>(name, |lane| nm[lane]).evaluate(vector(0), vector(3));
        let found = found.f_cos.0.into_iter().chain([found.density.hero()]);
        for (found, &expected) in found.zip(&numbers[6..]) {
            worst = worst.max((found / expected - 1.0).abs());
            assert!(close(found, expected, 2e-4), "{line}: {found}, not {expected}");
        }
        rows += 1;
    }
    println!("off by {worst:e} at most");
    assert_eq!(rows, 120);
}

/// The rough gold that the first file was computed from, by its albedo. Between six wavelengths, eight angles
/// and 16 × 16 directions the table is linear, so this is no test of digits.
#[test]
fn a_table_of_rough_gold_is_rough_gold() {
    for (nm, index) in [(400.0, [1.467, 1.956]), (700.0, [0.131, 4.065])] {
        let [eta, k] = index.map(|value| Sampled([value]));
        let facet = Conductor { eta, k, specular_reflectance: Sampled::ONE };
        let microfacets = Microfacets::new(Distribution::Ggx, 0.35, 0.35);
        let gold = Bsdf::RoughConductor(RoughConductor { facet, microfacets });
        for cosine in [1.0, 0.8, 0.5, 0.2] {
            let albedos = [measured(FILES[0], |_| nm), gold].map(|bsdf| {
                let mut uniform = Uniform::new(11);
                let eye = at(cosine, 0.4);
                let samples = (0..20_000).map(|_| bsdf.sample(eye, 0.0, uniform.pair()));
                let weights: Moments =
                    samples.map(|scatter| scatter.map_or(0.0, |found| found.weight.hero())).collect();
                weights.estimate()
            });
            let [table, gold] = albedos;
            println!("{nm} nm, {cosine}: {table:?}, {gold:?}");
            assert!(close(table.mean, gold.mean, 0.03), "{nm} nm, cosine {cosine}: {table:?}, {gold:?}");
        }
    }
}
