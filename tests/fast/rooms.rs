//! The rooms of `src/`, what they know of each other, and the pieces of them that planted faults replace.

use crate::common::text_of;
use std::path::{Path, PathBuf};

fn files_in(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("the folder exists");
    let paths = entries.map(|entry| entry.expect("an entry").path());
    paths.flat_map(|path| if path.is_dir() { files_in(&path) } else { vec![path] }).collect()
}

/// The rooms in the order of `src/lib.rs`.
fn rooms(src: &Path) -> Vec<String> {
    let listed = text_of(&src.join("lib.rs"));
    listed
        .lines()
        .filter_map(|line| line.strip_prefix("pub mod ")?.strip_suffix(';').map(Into::into))
        .collect()
}

/// The rooms that a file names, but for what is there for tests alone.
fn known_to(file: &Path) -> Vec<String> {
    let text = text_of(file);
    let program = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    let code = program.lines().filter(|line| !line.trim_start().starts_with("//"));
    let named = code.flat_map(|line| line.split("crate::").skip(1).collect::<Vec<_>>());
    let end = |name: &str| name.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(name.len());
    named.map(|name| name[..end(name)].to_owned()).collect()
}

#[test]
fn a_room_knows_only_those_before_it() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let rooms = rooms(&src);
    assert!(rooms.len() > 20);
    let mut wrong = Vec::new();
    for (index, room) in rooms.iter().enumerate() {
        let before = &rooms[..=index];
        let (folder, alone) = (src.join(room), src.join(format!("{room}.rs")));
        for file in if folder.is_dir() { files_in(&folder) } else { vec![alone] } {
            let is_test = file
                .components()
                .any(|part| ["tests", "tests.rs"].map(AsRef::as_ref).contains(&part.as_os_str()));
            if is_test {
                continue;
            }
            let known = known_to(&file);
            let strange = known.iter().filter(|known| !before.contains(known));
            wrong.extend(strange.map(|known| format!("{} knows {known}", file.display())));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn the_map_has_every_room_in_its_order() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = text_of(&root.join("CONTRIBUTING.md"));
    let rows = page.lines().skip_while(|line| !line.starts_with("| room |")).skip(2);
    let rows = rows.take_while(|line| line.starts_with('|'));
    let first = rows.filter_map(|row| row.split('|').nth(1)).collect::<String>();
    let mapped: Vec<String> = first.split('`').skip(1).step_by(2).map(Into::into).collect();
    let src = root.join("src");
    let mut expected = rooms(&src);
    expected.extend(["lib", "cli", "main", "processor"].map(String::from));
    assert_eq!(mapped, expected);
    let mut there: Vec<String> = std::fs::read_dir(&src)
        .expect("the folder exists")
        .filter_map(|entry| entry.expect("an entry").path().file_stem()?.to_str().map(Into::into))
        .collect();
    there.sort();
    expected.sort();
    assert_eq!(there, expected);
}

/// The strings of a TOML file that `key` is given, each with where it stands. Those of `validation/controls`
/// are JSON's strings too.
fn strings_of(toml: &str, key: &str) -> Vec<(usize, String)> {
    let given = format!("{key} = \"");
    let places = toml.match_indices(&given).map(|(place, _)| place);
    let string = |place: usize| {
        let text = &toml[place + given.len() - 1..];
        let mut strings = serde_json::Deserializer::from_str(text).into_iter::<String>();
        strings.next().expect("a string").expect("a string without escapes of TOML alone")
    };
    places.map(|place| (place, string(place))).collect()
}

#[test]
fn what_a_planted_fault_replaces_stands_once_in_its_file() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let (mut wrong, mut pieces) = (Vec::new(), 0);
    for list in files_in(&root.join("validation/controls")) {
        let toml = text_of(&list);
        let files = strings_of(&toml, "file");
        for (place, old) in strings_of(&toml, "old") {
            let (_, file) = files.iter().rev().find(|(start, _)| *start < place).expect("a file before it");
            let times = text_of(&root.join(file)).matches(&old).count();
            pieces += 1;
            if times != 1 {
                wrong.push(format!("{}: {old:?} stands {times} times in {file}", list.display()));
            }
        }
    }
    assert!(pieces > 20, "{pieces} pieces");
    assert!(wrong.is_empty(), "name a piece that stands once:\n{}", wrong.join("\n"));
}
