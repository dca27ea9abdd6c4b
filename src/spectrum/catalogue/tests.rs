use super::*;
use crate::spectrum::normal_reflectance::reflectance_of_index;
use std::collections::BTreeSet;

#[test]
fn every_entry_can_be_read_by_every_name() {
    for kind in Kind::ALL {
        assert!(!names(kind).is_empty());
    }
    for record in records::all() {
        let entry = read(record).unwrap();
        assert!(
            !entry.source.is_empty() && !entry.licence.is_empty() && !entry.units.is_empty(),
            "{entry:?}"
        );
        for name in record.names() {
            let found = lookup(record.kind, &name.to_uppercase().replace('-', " ")).unwrap();
            assert_eq!((&found.name, found.kind), (&record.name, record.kind), "{name} means two things");
        }
    }
}

#[test]
fn every_column_of_every_table_is_named() {
    let known: BTreeSet<(&str, &str)> = records::all().iter().map(|r| (r.file, r.column.as_str())).collect();
    let files: BTreeSet<&str> = known.iter().map(|(file, _)| *file).collect();
    for (file, text) in data::FILES {
        // What a model is made of is no spectrum that anyone would ask for.
        if *file == "illuminants/cie_daylight_basis_s0_s1_s2_5nm" || file.starts_with("sky/") {
            continue;
        }
        assert!(files.contains(file), "{file} is not in the catalogue");
        let by_column = ["illuminants/", "reflectance/", "cie/", "rgb_upsampling/", "photons/"];
        if by_column.iter().any(|folder| file.starts_with(folder)) {
            for column in &TableFile::parse(text).unwrap().columns[1..] {
                assert!(known.contains(&(*file, column.as_str())), "{file}: {column}");
            }
        }
    }
}

#[test]
fn names_that_nobody_has_come_with_the_nearest() {
    let nearest = |kind, name| lookup(kind, name).unwrap_err().nearest;
    assert_eq!(nearest(Kind::Conductor, "golld").as_deref(), Some("gold"));
    assert_eq!(nearest(Kind::Illuminant, "D66").as_deref(), Some("D65"));
    assert_eq!(
        nearest(Kind::Reflectance, "colorchecker/drak skin").as_deref(),
        Some("colorchecker/dark-skin")
    );
    assert_eq!(nearest(Kind::Dielectric, "§§§§"), None);
    let message = lookup(Kind::Conductor, "golld").unwrap_err().to_string();
    assert_eq!(message, "there is no conductor named 'golld'; did you mean 'gold'?");
}

#[test]
fn names_of_the_documentation_are_found() {
    for (kind, name) in [
        (Kind::Illuminant, "F11"),
        (Kind::Illuminant, "fl3.15"),
        (Kind::Illuminant, "led-b1"),
        (Kind::Reflectance, "ColourChecker/dark skin"),
        (Kind::Reflectance, "colorchecker/white"),
        (Kind::Reflectance, "TCS01"),
        (Kind::Reflectance, "usgs/calcite"),
        (Kind::Reflectance, "derived/Au/johnson-christy"),
        (Kind::Conductor, "gold"),
        (Kind::Conductor, "Au/mcpeak"),
        (Kind::Conductor, "aluminum"),
        (Kind::Dielectric, "N-BK7"),
        (Kind::Dielectric, "water"),
        (Kind::Absorption, "soda_lime_gray"),
        (Kind::Sensitivity, "cone/L"),
    ] {
        assert!(lookup(kind, name).is_ok(), "{name}");
    }
    assert_eq!(lookup(Kind::Conductor, "gold").unwrap().name, "Au/johnson-christy");
}

#[test]
fn values_are_physical_over_the_visible_range() {
    let range = WavelengthRange::VISIBLE;
    for record in records::all() {
        let entry = read(record).unwrap();
        let name = &entry.name;
        let bounds_of = |spectrum: &Spectrum| spectrum.bounds(range);
        match &entry.quantity {
            Quantity::Spectrum(spectrum) => {
                let (least, greatest) = bounds_of(spectrum);
                assert!(least >= 0.0 && greatest > 0.0, "{name}: {least}..{greatest}");
                assert!(entry.kind != Kind::Reflectance || greatest <= 1.0, "{name}: {greatest}");
            }
            Quantity::ComplexIndex { n, k } => {
                // Clear bodies have k = 0 all over.
                assert!(bounds_of(n).0 > 0.0 && (bounds_of(k).0 > 0.0 || k.is_zero(range)), "{name}");
            }
            Quantity::Index(index) => {
                let (least, greatest) = bounds_of(&index.to_spectrum(range).unwrap());
                assert!(least >= 1.0 && greatest < 4.0, "{name}: {least}..{greatest}");
            }
        }
    }
}

/// n_d and the Abbe number of every formula, as `data/` states them (for SCHOTT glasses the data sheet's
/// values).
#[test]
fn indices_and_abbe_numbers_agree_with_the_tables() {
    let table = TableFile::parse(data::text("dielectrics/dispersion_formulas")).unwrap();
    let nd = table.numbers("nd_check").unwrap();
    let abbe: Vec<f64> =
        table.texts("abbe_check").unwrap().iter().map(|stated| stated.parse().unwrap()).collect();
    for (row, name) in table.texts("name").unwrap().iter().enumerate() {
        let (formula, _) = read_formula(&table, name).unwrap();
        assert!((formula.index(587.5618) - nd[row]).abs() < 6e-7, "{name}: n_d {}", formula.index(587.5618));
        let (found, stated) = (formula.abbe_number(), abbe[row]);
        // One number has no dispersion.
        assert!(found == stated || (found - stated).abs() < 6e-4, "{name}: V_d {found}");
    }
}

/// Catalogue values of n_d and V_d: SCHOTT data sheets.
#[test]
fn abbe_numbers_of_the_catalogue() {
    for (name, nd, abbe) in [
        ("N-BK7", 1.51680, 64.17),
        ("SF11", 1.78472, 25.76),
        ("N-SF11", 1.78472, 25.68),
        ("F2", 1.62004, 36.37),
        ("SF10", 1.72825, 28.41),
        ("N-SF66", 1.92286, 20.88),
        ("LASFN9", 1.85025, 32.17),
        ("N-FK51A", 1.48656, 84.47),
        ("N-BAF10", 1.67003, 47.11),
        ("N-BAK1", 1.57250, 57.55),
    ] {
        let glass = dielectric(name).unwrap();
        assert!((glass.at(587.5618) - nd).abs() < 1e-5, "{name}: n_d {}", glass.at(587.5618));
        assert!((glass.abbe_number() - abbe).abs() < 0.01, "{name}: V_d {}", glass.abbe_number());
    }
}

/// Indices at common lines, tabulated independently to five decimals.
#[test]
fn reference_indices() {
    let nm = [400.0, 435.8, 486.1, 550.0, 587.6, 656.3, 700.0];
    for (name, expected) in [
        ("fused-silica", [1.47012, 1.46670, 1.46313, 1.45991, 1.45846, 1.45637, 1.45529]),
        ("N-BK7", [1.53085, 1.52669, 1.52238, 1.51852, 1.51680, 1.51432, 1.51306]),
        ("SF10", [1.77826, 1.76199, 1.74649, 1.73366, 1.72825, 1.72085, 1.71729]),
        ("diamond", [2.46413, 2.44998, 2.43555, 2.42295, 2.41748, 2.40990, 2.40624]),
        ("NaCl", [1.56746, 1.56036, 1.55316, 1.54691, 1.54420, 1.54046, 1.53865]),
    ] {
        let glass = dielectric(name).unwrap();
        for (nm, expected) in nm.iter().zip(expected) {
            assert!((glass.at(*nm) - expected).abs() < 6e-6, "{name} at {nm} nm: {}", glass.at(*nm));
        }
    }
}

/// The reflectances that `data/` derives from n and k, to the five digits that it gives.
#[test]
fn metals_reflect_as_the_table_says() {
    let mut compared = 0;
    for entry in names(Kind::Conductor).into_iter().map(|name| lookup(Kind::Conductor, name).unwrap()) {
        let Quantity::ComplexIndex { n, k } = &entry.quantity else { panic!("{} has no k", entry.name) };
        let Ok(derived) = reflectance(&format!("derived/{}", entry.name)) else { continue };
        compared += 1;
        for step in 0..=80 {
            let nm = 380.0 + 5.0 * f64::from(step);
            let found = reflectance_of_index(n.at(nm), k.at(nm));
            assert!(
                (found - derived.at(nm)).abs() < 6e-6,
                "{} at {nm} nm: {found}, {}",
                entry.name,
                derived.at(nm)
            );
        }
    }
    assert_eq!(compared, 26);
}

/// Absorption stated in the tables' README at 550 nm, and whole blood from its defining formula.
#[test]
fn absorption_is_per_metre() {
    let at = |name: &str, nm: f64| absorption(name).unwrap().at(nm);
    assert!((at("water", 550.0) - 0.0588).abs() < 1e-4);
    assert!((at("water/hale-querry", 550.0) - 0.0448).abs() < 1e-4);
    assert!((at("blood-oxygenated", 1000.0) - 100.0 * 2.303 * 1024.0 * 150.0 / 64_500.0).abs() < 1e-9);
}

#[test]
fn what_lies_outside_a_table_follows_from_its_kind() {
    assert_eq!(illuminant("FL2").unwrap().at(780.1), 0.0);
    assert_eq!(reflectance("colorchecker/red").unwrap().at(800.0), 0.738);
    assert!(illuminant("D65").unwrap().at(830.0) > 60.0);
    let assumption = dielectric("rutile").unwrap().assumption(WavelengthRange::VISIBLE).unwrap();
    assert!(assumption.contains("430–1530"), "{assumption}");
    assert_eq!(dielectric("BK7").unwrap().assumption(WavelengthRange::VISIBLE), None);
    let zinc = conductor("Zn").unwrap().0;
    assert_eq!(held_outside(&zinc, WavelengthRange::VISIBLE), None);
    assert!(
        held_outside(&reflectance("TCS01").unwrap(), WavelengthRange { min: 350.0, max: 830.0 }).is_some()
    );
}

/// The liquids of Glassner's table (*An Introduction to Ray Tracing*, 1989, figure 4.12), to its two digits.
#[test]
fn liquids_have_the_indices_of_the_books() {
    for (name, stated) in
        [("water", 1.33), ("ethanol", 1.36), ("carbon-disulphide", 1.63), ("methylene-iodide", 1.74)]
    {
        let found = dielectric(name).unwrap().at(589.3);
        assert!((found - stated).abs() < 0.005, "{name}: {found}");
    }
    // Handbooks have 1.6277 at the D line and 20 °C (Weast, *CRC Handbook of Chemistry and Physics*).
    let disulphide = dielectric("CS2").unwrap();
    assert!((disulphide.at(589.3) - 1.6277).abs() < 1e-3);
    assert!((disulphide.abbe_number() - 18.0).abs() < 0.3);
    // What is one number at the D line says so elsewhere.
    let iodide = dielectric("CH2I2").unwrap();
    assert_eq!(iodide.at(450.0), 1.74);
    let told = iodide.assumption(WavelengthRange::VISIBLE).expect("an assumption");
    assert!(told.contains("589.3"), "{told}");
}

/// The energy of a photon of 555 nm is 3.58e-19 J (Glassner 1989, section 4.1.2).
#[test]
fn photons_per_joule_are_the_inverse_of_their_energy() {
    let Quantity::Spectrum(photons) = lookup(Kind::Sensitivity, "photons").unwrap().quantity else {
        panic!("a spectrum")
    };
    for nm in [1.0, 380.0, 555.0, 829.5, 1e5] {
        let energy = crate::units::PLANCK * crate::units::SPEED_OF_LIGHT / (nm * 1e-9);
        assert!((photons.at(nm) * 1e18 * energy - 1.0).abs() < 1e-12, "{nm}");
    }
    assert!((1e-18 / photons.at(555.0) - 3.58e-19).abs() < 0.005e-19);
}
