//! The documents: what they name exists, the front page stays short, and the scenes of the tutorial can be
//! read.

use crate::common::text_of;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The pages in a folder.
fn pages_in(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("the folder exists");
    let paths = entries.map(|entry| entry.expect("an entry").path());
    paths.filter(|path| path.extension().is_some_and(|end| end == "md")).collect()
}

/// The pages that the project is described by.
fn pages() -> Vec<PathBuf> {
    let mut pages = pages_in(&root().join("docs"));
    pages.extend(["README.md", "CONTRIBUTING.md", "validation/README.md"].map(|page| root().join(page)));
    pages.sort();
    pages
}

/// A page's text without its blocks of code.
fn prose(page: &str) -> String {
    page.split("```").step_by(2).collect()
}

/// The targets of Markdown links and of HTML images.
fn links(prose: &str) -> Vec<&str> {
    let until = |start: &str, end: char| -> Vec<&str> {
        let found = prose.match_indices(start);
        found.filter_map(|(at, _)| prose[at + start.len()..].split(end).next()).collect()
    };
    [until("](", ')'), until("src=\"", '"')].concat()
}

/// The heading's name in links: as GitHub makes it.
fn anchor(heading: &str) -> String {
    let text = heading.trim_start_matches('#').trim().to_lowercase();
    let kept = text.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
    kept.map(|c| if c == ' ' { '-' } else { c }).collect()
}

fn anchors(page: &str) -> BTreeSet<String> {
    prose(page).lines().filter(|line| line.starts_with('#')).map(anchor).collect()
}

#[test]
fn every_relative_link_leads_somewhere() {
    let mut broken = Vec::new();
    for path in pages() {
        let page = text_of(&path);
        for link in links(&prose(&page)).into_iter().filter(|link| !link.contains("://")) {
            let (file, heading) = link.split_once('#').unwrap_or((link, ""));
            let target =
                if file.is_empty() { path.clone() } else { path.parent().expect("a folder").join(file) };
            let found =
                target.exists() && (heading.is_empty() || anchors(&text_of(&target)).contains(heading));
            if !found {
                broken.push(format!("{}: {link}", path.display()));
            }
        }
    }
    assert!(broken.is_empty(), "{broken:#?}");
}

/// The folders of the repository whose files the documents name by their paths from its root.
const ROOMS: [&str; 6] = ["src", "tests", "validation", "scenes", "data", "docs"];

/// Whether words between backticks are a path from the root of the repository.
fn is_path(code: &str) -> bool {
    let plain = |c: char| c.is_ascii_alphanumeric() || "/._-".contains(c);
    code.split_once('/').is_some_and(|(first, _)| ROOMS.contains(&first)) && code.chars().all(plain)
}

/// What stands between backticks in a page.
fn code(prose: &str) -> impl Iterator<Item = &str> {
    prose.lines().flat_map(|line| line.split('`').skip(1).step_by(2))
}

#[test]
fn every_path_that_a_document_names_exists() {
    let mut missing = Vec::new();
    let mut count = 0;
    for path in pages() {
        for name in code(&prose(&text_of(&path))).filter(|name| is_path(name)) {
            count += 1;
            if !root().join(name).exists() {
                missing.push(format!("{}: {name}", path.display()));
            }
        }
    }
    assert!(missing.is_empty(), "{missing:#?}");
    assert!(count > 80, "only {count} paths were found");
}

/// The glossary names rooms of the code in italics, by their paths below `src`.
#[test]
fn every_room_that_the_glossary_names_exists() {
    let page = text_of(&root().join("docs/glossary.md"));
    let cells = page.lines().filter_map(|line| line.strip_prefix("| ")?.rsplit('|').nth(1));
    let outside_code = cells.flat_map(|cell| cell.split('`').step_by(2));
    let rooms: BTreeSet<&str> = outside_code.flat_map(|text| text.split('*').skip(1).step_by(2)).collect();
    assert!(rooms.len() > 15, "{rooms:?}");
    for room in rooms {
        let found = ["", ".rs"].iter().any(|end| root().join(format!("src/{room}{end}")).exists());
        assert!(found, "the glossary names {room}");
    }
}

/// The commands of the front page and of the tutorial name scenes of the repository.
#[test]
fn every_scene_of_the_tour_exists() {
    let page = text_of(&root().join("README.md"));
    let words = page.split_whitespace();
    let scenes: Vec<&str> = words.filter(|word| word.ends_with(".xml") && word.contains('/')).collect();
    assert!(scenes.len() >= 5, "{scenes:?}");
    for scene in scenes {
        assert!(root().join(scene).is_file(), "{scene}");
    }
}

#[test]
fn the_front_page_is_short() {
    let lines = text_of(&root().join("README.md")).lines().count();
    assert!(lines <= 200, "README.md has {lines} lines");
}

/// Stands before what is generated in the scene format.
const MARK: &str = "<!-- What follows is generated from the declarations in src/scene/plugins. -->\n";

/// The reference of the scene format follows from the declarations of the plugins.
#[test]
fn the_reference_of_the_scene_format_is_current() {
    let page = text_of(&root().join("docs/scene-format.md"));
    let (written_by_hand, _) = page.split_once(MARK).expect("the mark");
    let current = format!("{written_by_hand}{MARK}\n{}", abbe::scene::reference());
    if page != current {
        let made = Path::new(env!("CARGO_TARGET_TMPDIR")).join("scene-format.md");
        std::fs::write(&made, current).expect("a file");
        panic!("docs/scene-format.md is not current: copy {} to docs", made.display());
    }
}

/// The index of the documentation and the front page lead to every page.
#[test]
fn no_page_is_hidden() {
    let index = text_of(&root().join("docs/README.md"));
    for page in pages_in(&root().join("docs")) {
        let name = page.file_name().expect("a name").to_string_lossy().into_owned();
        assert!(name == "README.md" || links(&index).contains(&name.as_str()), "docs/README.md lacks {name}");
    }
}

/// The first scene of the tutorial, which its reader saves as first.xml.
fn first_scene(tutorial: &str) -> &str {
    let (_, blocks) = tutorial.split_once("```xml\n").expect("a scene");
    blocks.split("```").next().expect("its end").trim_end()
}

#[test]
fn the_tutorial_shows_what_abbe_says_of_its_first_scene() {
    let page = text_of(&root().join("docs/tutorial.md"));
    let scene = first_scene(&page);
    let read = |scene: String| abbe::scene::read_str(scene, Path::new("first.xml"), &Default::default());
    let description = read(scene.to_owned()).unwrap_or_else(|errors| panic!("{errors}"));
    let outline = abbe::scene::outline(&description);
    let (_, remarks) = outline.split_once("remarks\n").expect("a remark");
    assert!(page.contains(remarks.trim_end()), "{remarks}");
    let wrong = scene.replacen("type=\"sphere\"", "type=\"spher\"", 1);
    let errors = read(wrong).expect_err("there is no such shape").to_string();
    assert!(page.contains(errors.trim()), "{errors}");
}

/// The source files below a folder.
fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("the folder exists") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|end| end == "rs") {
            found.push(path);
        }
    }
}

/// A comment has at most 110 columns, and none begins with a genitive that waits for its noun.
#[test]
fn comments_are_short_and_begin_with_what_they_are_about() {
    let mut files = Vec::new();
    for folder in ["src", "tests", "validation"] {
        sources(&root().join(folder), &mut files);
    }
    assert!(files.len() > 150, "only {} files were found", files.len());
    let mut wrong = Vec::new();
    for file in files {
        for (number, line) in (1..).zip(text_of(&file).lines()) {
            let Some(words) = line.trim_start().strip_prefix("//") else { continue };
            let words = words.trim_start_matches(['/', '!', ' ']);
            // The row of a table cannot be wrapped.
            let long = line.chars().count() > 110 && !words.starts_with('|');
            if long || words.starts_with("Of ") {
                wrong.push(format!("{}:{number}", file.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// What is written by hand in the pages has at most 110 columns, too. Rows of tables, headings, pictures and
/// links by themselves cannot be wrapped.
#[test]
fn pages_can_be_read_as_they_are_written() {
    let mut wrong = Vec::new();
    for path in pages().into_iter().chain([root().join("CHANGELOG.md"), root().join("data/README.md")]) {
        let page = text_of(&path);
        let by_hand = page.split(MARK).next().unwrap_or_default();
        let can_wrap = |line: &&str| !line.trim_start().starts_with(['|', '#', '!', '[', '<']);
        let long = prose(by_hand).lines().filter(can_wrap).filter(|line| line.chars().count() > 110).count();
        if long > 0 {
            wrong.push(format!("{}: {long}", path.display()));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
