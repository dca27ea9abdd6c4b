//! `abbe info --json` writes scene files: they mean the same as what they were made from, to the last bit.

use crate::common::described;
use abbe::integrator::Estimator;
use abbe::render::{NoProgress, Schedule, Settings, WavelengthCount, render};
use abbe::scene::{CompileOptions, Description, Features, ReadOptions, Scene, compile, json, read, read_str};
use std::path::{Path, PathBuf};

/// All scene files of the repository that are right.
fn scenes() -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders: Vec<PathBuf> =
        ["scenes", "tests/scenes", "validation/mitsuba/scenes"].map(PathBuf::from).to_vec();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).expect("a folder of scenes") {
            let path = entry.expect("an entry").path();
            if path.is_dir() && path.file_name().is_some_and(|name| name != "broken" && name != "parts") {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "xml") {
                found.push(path);
            }
        }
    }
    found.sort();
    assert!(found.len() >= 30, "only {} scenes were found", found.len());
    found
}

fn compiled(description: &Description) -> Scene {
    compile(description, &CompileOptions::default()).unwrap_or_else(|errors| panic!("{errors}"))
}

/// The scene as JSON, read again as a file in `folder`. The features that it states are not read.
fn again(description: &Description, folder: &Path) -> (String, Description) {
    let text = json(description, &Features::default(), Some(folder));
    let copy = read_str(text.clone(), &folder.join("scene.json"), &ReadOptions::default())
        .unwrap_or_else(|errors| panic!("{errors}"));
    (text, copy)
}

/// What a small render adds up to.
fn sums(mut description: Description) -> Vec<u8> {
    let film = &mut description.sensor.film;
    (film.width, film.height, film.crop) = (8, 8, None);
    let settings = Settings {
        schedule: Schedule::new(4),
        seed: 7,
        sampler: description.sensor.sampler.kind,
        wavelengths: Some(WavelengthCount::Four),
        estimator: Estimator::Shared,
        bins: None,
    };
    let film = render(&compiled(&description), &settings, &NoProgress::new());
    format!("{film:?}").into_bytes()
}

#[test]
fn every_scene_comes_back_from_json_as_it_was() {
    for path in scenes() {
        let description = read(&path, &ReadOptions::default()).unwrap_or_else(|errors| panic!("{errors}"));
        // Next to the scene and in another place: files are named from where the JSON is.
        for folder in [path.parent().expect("a folder"), Path::new("tests")] {
            let (text, copy) = again(&description, folder);
            assert_eq!(copy.hash(), description.hash(), "{}\n{text}", path.display());
            let (second, _) = again(&copy, folder);
            let scene = |text: &str| text.split("\"extensions\"").next().map(str::to_owned);
            assert_eq!(scene(&second), scene(&text), "{}", path.display());
        }
    }
}

#[test]
fn renders_from_json_have_the_same_bits() {
    for path in scenes() {
        let description = read(&path, &ReadOptions::default()).unwrap_or_else(|errors| panic!("{errors}"));
        let (_, copy) = again(&description, path.parent().expect("a folder"));
        assert!(sums(copy) == sums(description), "{}", path.display());
    }
}

/// As a `<volume>`, which Mitsuba takes, or in a texture; and what `abbe info --json` makes of it.
#[test]
fn a_blend_of_phases_is_the_same_however_its_grid_is_given() {
    let grid =
        r#"type="gridvolume"><string name="filename" value="tests/scenes/agreement/smoke.vol"/></volume>"#;
    let in_fog = |weight: &str| {
        described(&format!(
            r#"<sensor type="perspective"><film type="hdrfilm"/></sensor><emitter type="constant"/>
               <shape type="sphere">
                   <transform name="to_world"><translate x="0.5" y="0.5" z="2"/></transform><bsdf type="null"/>
                   <medium name="interior" type="homogeneous">
                       <phase type="blendphase">
                           {weight}<phase type="isotropic"/><phase type="hg"><float name="g" value="0.9"/></phase>
                       </phase>
                   </medium>
               </shape>"#
        ))
    };
    let own = in_fog(&format!(r#"<volume name="weight" {grid}"#));
    let in_texture =
        in_fog(&format!(r#"<texture name="weight" type="volume"><volume name="volume" {grid}</texture>"#));
    let (_, copy) = again(&own, Path::new("."));
    assert!([&in_texture, &copy].iter().all(|other| other.hash() == own.hash()));
    let expected = sums(own);
    assert!(sums(in_texture) == expected && sums(copy) == expected);
    assert!(sums(in_fog(r#"<float name="weight" value="0"/>"#)) != expected);
}

/// A whole number beyond integers is a number where one is wanted, and refused with a remedy where an integer
/// is. Messages about JSON name no tags of XML.
#[test]
fn integers_that_do_not_fit_are_told_as_in_xml() {
    let read = |radius: &str, width: &str, seed: &str| {
        let text = format!(
            r#"{{"type": "scene", "light": {{"type": "constant"}},
                "ball": {{"type": "sphere", "radius": {radius}}},
                "eye": {{"type": "perspective", "film": {{"type": "hdrfilm", "width": {width}}},
                        "sampler": {{"type": "independent", "seed": {seed}}}}}}}"#
        );
        let read = read_str(text, Path::new("scene.json"), &ReadOptions::default());
        read.err().map_or(String::new(), |errors| errors.to_string())
    };
    assert_eq!(read("99999999999999999999", "16", "1"), "");
    let told = read("1", "99999999999999999999", "18446744073709551615");
    for name in ["\"width\" of film \"hdrfilm\"", "\"seed\" of sampler \"independent\""] {
        assert!(told.contains(&format!("{name} does not fit an integer")), "{told}");
    }
    assert!(told.contains("expected one from -9223372036854775808 to 9223372036854775807"), "{told}");
    for (told, expected) in
        [(read("1", "1.5", "1"), "expected an integer"), (read("true", "16", "1"), "expected a number")]
    {
        assert!(told.contains("wrong type") && told.contains(expected), "{told}");
    }
}
