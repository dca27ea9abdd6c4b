//! Metals by name, from a folder of tables and from the catalogue.

use crate::common::text_of;
use abbe::scene::description::{BsdfKind, ConductorIndex, Description, SpectrumKind};
use abbe::scene::{CompileOptions, ReadOptions, compile, json, read_str};
use std::path::{Path, PathBuf};

const FOLDER: &str = "tests/scenes/ior";

/// The names that Mitsuba 3.9 has tables of (`data/ior`).
const MITSUBA: &str = "\
    Ag Al AlAs AlAs_palik AlSb AlSb_palik Au Be Be_palik Cr CsI CsI_palik Cu Cu2O Cu2O_palik CuO \
    CuO_palik Cu_palik Hg HgTe HgTe_palik Hg_palik Ir Ir_palik K K_palik Li Li_palik MgO MgO_palik \
    Mo Mo_palik Na_palik Nb Nb_palik Ni_palik Rh Rh_palik Se Se-e Se-e_palik Se_palik SiC SiC_palik \
    SnTe SnTe_palik Ta Ta_palik Te Te-e Te-e_palik Te_palik ThF4 ThF4_palik TiC TiC_palik TiN \
    TiN_palik TiO2 TiO2-e TiO2-e_palik TiO2_palik VC VC_palik VN VN_palik V_palik W a-C d-C \
    d-C_palik";

fn read(name: &str, folder: Option<&Path>) -> Result<Description, String> {
    let text = format!(
        r#"<scene version="3.0.0"><sensor type="perspective"/><shape type="sphere"><bsdf type="conductor">
           <string name="material" value="{name}"/></bsdf></shape></scene>"#
    );
    let options = ReadOptions { ior_tables: folder.map(PathBuf::from), ..ReadOptions::default() };
    read_str(text, Path::new("scene.xml"), &options).map_err(|errors| errors.to_string())
}

fn from_folder(name: &str) -> Result<Description, String> {
    read(name, Some(Path::new(FOLDER)))
}

/// n and k, or `None` for a metal of the catalogue.
fn tables(scene: &Description) -> Option<[SpectrumKind; 2]> {
    match &scene.shapes[0].bsdf.kind {
        BsdfKind::Conductor { index: ConductorIndex::Complex { n, k }, .. } => {
            Some([n.kind.clone(), k.kind.clone()])
        }
        _ => None,
    }
}

/// Every name of Mitsuba's is a metal here, or its error says how it becomes one.
#[test]
fn every_name_of_mitsubas_is_known_or_says_what_to_do() {
    let mut missing = Vec::new();
    for name in MITSUBA.split(' ') {
        match read(name, None) {
            Ok(scene) => {
                compile(&scene, &CompileOptions::default())
                    .unwrap_or_else(|errors| panic!("{name}: {errors}"));
                let told = |text: &str| scene.assumptions.iter().any(|note| note.text.contains(text));
                assert!(told("--ior-tables"), "{name}: {:?}", scene.assumptions);
            }
            Err(errors) => {
                let remedy = format!("--ior-tables DIR reads {name}.eta.spd and {name}.k.spd");
                assert!(errors.contains(&remedy), "{errors}");
                missing.push(name);
            }
        }
    }
    missing.retain(|name| !name.ends_with("_palik"));
    assert_eq!(missing, ["Cu2O", "CuO", "HgTe", "Se", "Se-e", "SnTe", "Ta"]);
}

#[test]
fn a_folders_tables_come_before_the_catalogues() {
    let scene = from_folder("Ta").unwrap();
    let [SpectrumKind::Irregular { nm, values, .. }, SpectrumKind::Irregular { values: k, .. }] =
        tables(&scene).unwrap()
    else {
        panic!("no tables")
    };
    assert_eq!((nm, values, k), (vec![400.0, 500.0, 700.0], vec![2.5, 2.0, 1.5], vec![3.0, 3.5, 4.0]));
    for told in ["those of the folder of --ior-tables", "400–700 nm; its end values are held"] {
        assert!(scene.assumptions.iter().any(|note| note.text.contains(told)), "{:?}", scene.assumptions);
    }
    let [SpectrumKind::Irregular { .. }, SpectrumKind::Constant(0.0)] =
        tables(&from_folder("Au").unwrap()).unwrap()
    else {
        panic!("not the folder's gold")
    };
    // What the folder lacks is the catalogue's.
    assert!(tables(&from_folder("Ag").unwrap()).is_none());
}

/// The hash tells one folder from another, and the JSON needs none.
#[test]
fn what_the_tables_say_is_part_of_the_scene() {
    let copy = std::env::temp_dir().join(format!("abbe-ior-{}", std::process::id()));
    std::fs::create_dir_all(&copy).unwrap();
    for file in ["Ta.eta.spd", "Ta.k.spd"] {
        let text = text_of(&Path::new(FOLDER).join(file));
        std::fs::write(copy.join(file), text.replace("3.5", "3.6")).unwrap();
    }
    let (one, other) = (from_folder("Ta").unwrap(), read("Ta", Some(&copy)).unwrap());
    std::fs::remove_dir_all(&copy).unwrap();
    assert_ne!(one.hash(), other.hash());
    for name in ["Ta", "Au"] {
        let scene = from_folder(name).unwrap();
        let features = compile(&scene, &CompileOptions::default()).unwrap().features();
        let again = super::read(&json(&scene, &features, None)).unwrap();
        assert_eq!(again.hash(), scene.hash(), "{name}");
    }
}

#[test]
fn wrong_tables_are_refused_with_their_place() {
    for (name, said) in [
        ("Ir", "There is no file tests/scenes/ior/Ir.k.spd"),
        ("Nb", "Nb.eta.spd cannot be read: line 2, column 5: expected a number, found 'one'"),
        ("Mo", "index \"k\" is -1 at 830 nm"),
        ("Cu2O", "There is no measured conductor \"Cu2O\""),
        ("Goldd", "did you mean"),
    ] {
        let errors = from_folder(name).unwrap_err();
        assert!(errors.contains(said), "{errors}");
    }
    let errors = read("Ta", Some(Path::new("tests/scenes/ior/nowhere"))).unwrap_err();
    assert!(errors.contains("cannot be read") && errors.contains("NAME.eta.spd"), "{errors}");
    let errors = read("Ta", Some(Path::new("tests/scenes"))).unwrap_err();
    assert!(errors.contains("has no tables of metals"), "{errors}");
}
