//! What abbe says about wrong scene files. Each file in `tests/scenes/broken` has the whole message beside
//! it, as a text of the same name. After a change on purpose, run with `ABBE_UPDATE_MESSAGES=1` and read what
//! has changed.

use abbe::scene::{ReadOptions, read};
use std::fs;
use std::path::{Path, PathBuf};

/// Relative, so that messages do not depend on where the project lies.
const FOLDER: &str = "tests/scenes/broken";

fn broken_scenes() -> Vec<PathBuf> {
    let entries = fs::read_dir(FOLDER).expect("the folder of broken scenes is there");
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("an entry").path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "xml" || extension == "json"));
    paths.sort();
    paths
}

fn message(path: &Path) -> String {
    match read(path, &ReadOptions::default()) {
        Ok(_) => "accepted\n".to_owned(),
        Err(errors) => errors.to_string(),
    }
}

#[test]
fn messages_stay_as_they_were_approved() {
    let update = std::env::var_os("ABBE_UPDATE_MESSAGES").is_some();
    let scenes = broken_scenes();
    assert!(scenes.len() >= 80, "only {} broken scenes were found", scenes.len());
    let mut changed = Vec::new();
    for path in scenes {
        let message = message(&path);
        let approved = path.with_extension("txt");
        if update {
            fs::write(&approved, message).expect("the message can be written");
        } else if fs::read_to_string(&approved).ok().as_deref() != Some(&message) {
            changed.push(format!("{} now says:\n{message}", path.display()));
        }
    }
    assert!(changed.is_empty(), "{}", changed.join("\n"));
}

#[test]
fn every_broken_scene_is_refused_with_a_place() {
    for path in broken_scenes() {
        let Err(errors) = read(&path, &ReadOptions::default()) else {
            panic!("{} was accepted", path.display());
        };
        for error in &errors.errors {
            let sentence = error.problem.chars().next().is_some_and(|c| !c.is_lowercase());
            assert!(sentence, "{}: {}", path.display(), error.problem);
            assert!(!error.expected.is_empty(), "{}: {}", path.display(), error.problem);
            let place = error.place.as_ref().unwrap_or_else(|| panic!("{} has no place", path.display()));
            assert!(errors.sources.line(place) > 0, "{}: {}", path.display(), error.problem);
        }
    }
}

#[test]
fn a_scene_that_is_not_there_is_refused() {
    let errors = read(Path::new("tests/scenes/broken/nothing.xml"), &ReadOptions::default()).unwrap_err();
    assert!(errors.to_string().contains("cannot be read"), "{errors}");
    let errors = read(Path::new(FOLDER), &ReadOptions::default()).unwrap_err();
    assert!(errors.to_string().contains("is not a file"), "{errors}");
}

#[test]
fn a_parameter_that_the_scene_does_not_use_is_refused() {
    let text = "<scene version=\"3.0.0\"><default name=\"spp\" value=\"4\"/><sensor type=\"perspective\">\
                <sampler type=\"independent\"><integer name=\"sample_count\" value=\"$spp\"/></sampler></sensor></scene>";
    let with = |name: &str, value: &str| {
        let options =
            ReadOptions { defines: vec![(name.to_owned(), value.to_owned())], ..ReadOptions::default() };
        abbe::scene::read_str(text, Path::new("scene.xml"), &options)
    };
    assert_eq!(with("spp", "9").unwrap().sensor.sampler.sample_count, 9);
    let message = with("sp", "9").unwrap_err().to_string();
    assert!(message.contains("never uses $sp") && message.contains("did you mean -D spp"), "{message}");
}
