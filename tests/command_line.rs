//! The program as its users meet it: files, messages, exit codes, interruption.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Duration;

/// A folder of this test's own, removed at its end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("abbe-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).expect("a folder for temporary files");
        Self(path)
    }

    fn files(&self) -> Vec<String> {
        let names = std::fs::read_dir(&self.0).expect("the folder exists");
        let mut names: Vec<String> =
            names.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // Whatever is left over lies among the system's temporary files.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn scene(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

fn abbe(folder: &Folder, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_abbe"))
        .args(arguments)
        .current_dir(&folder.0)
        .output()
        .expect("the program starts")
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn a_render_lands_under_the_name_of_the_scenes_folder() {
    let folder = Folder::new("names");
    let box_scene = scene("scenes/box/scene.xml");
    let output = abbe(&folder, &["render", box_scene.to_str().unwrap(), "--spp", "16", "--size", "20x10"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(folder.files(), ["box.exr", "box.png"]);
    assert!(output.stdout.is_empty());
    // Not a terminal: lines with what a bar would show, and a last one of what was measured.
    let told = stderr(&output);
    assert!(told.contains("100 %") && told.contains("s left") && told.contains("error"), "{told}");
    assert!(told.contains("20×10") && told.contains("16 samples per pixel"), "{told}");
    let channels = abbe::output::exr::read(&folder.0.join("box.exr")).expect("a readable file");
    let names: Vec<&str> = channels.channels.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["B", "G", "R", "error.B", "error.G", "error.R", "samples"]);
    assert!(channels.channels.iter().flat_map(|(_, values)| values).all(|value| value.is_finite()));
}

#[test]
fn what_is_asked_for_besides_is_in_the_file() {
    let folder = Folder::new("besides");
    let box_scene = scene("scenes/box/scene.xml");
    let arguments = [
        "render",
        box_scene.to_str().unwrap(),
        "--spp=16",
        "--size=8x8",
        "--spectral=2",
        "--aov=depth,nn:sh_normal,shape_index",
        "-q",
        "-o",
        "x.exr",
    ];
    let output = abbe(&folder, &arguments);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(output.stderr.is_empty(), "quiet is quiet");
    let channels = abbe::output::exr::read(&folder.0.join("x.exr")).expect("a readable file");
    let has = |name: &str| channels.channels.iter().any(|(known, _)| known == name);
    for name in [
        "S0.477,500000nm",
        "error.S0.712,500000nm",
        "depth.T",
        "error.depth.T",
        "nn.X",
        "error.nn.Z",
        "shape_index.I",
    ] {
        assert!(has(name), "{name} is missing");
    }
}

#[test]
fn wrong_input_is_2_and_leaves_nothing_behind() {
    let folder = Folder::new("wrong");
    let (good, missing) = (scene("scenes/box/scene.xml"), scene("scenes/none.xml"));
    let good = good.to_str().unwrap();
    std::fs::write(
        folder.0.join("bad.xml"),
        "<scene version=\"3.0.0\"><sensor type=\"perspectve\"/></scene>",
    )
    .expect("a file can be written");
    for (arguments, expected) in [
        (vec!["render", "bad.xml"], "did you mean \"perspective\"?"),
        (vec!["render", missing.to_str().unwrap()], "none.xml"),
        (vec!["render", good, "-o", "picture.jpg"], "*.exr"),
        (vec!["render", good, "-o", "no/such/folder.exr"], "folder"),
        (vec!["render", good, "--spp", "0"], "--spp"),
        (vec!["render", good, "--size", "12"], "WIDTHxHEIGHT"),
        (vec!["render", good, "--wavelengths", "3"], "1, 4 or 8"),
        (vec!["render", good, "--aov", "normal"], "sh_normal or geo_normal"),
        (vec!["render", good, "--aov", "depth,depth"], "two channels \"depth.T\""),
        (vec!["render", good, "--size", "65536x65536", "--spectral"], "GiB"),
        (vec!["render", good, "-D", "sp=3"], "sp"),
        (vec!["spectrum", "N-SF111"], "N-SF11"),
        (vec!["draw"], "draw"),
    ] {
        let output = abbe(&folder, &arguments);
        let told = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {told}");
        assert!(told.contains(expected), "{arguments:?}: {told}");
    }
    assert_eq!(folder.files(), ["bad.xml"]);
}

#[test]
fn a_place_that_cannot_be_written_is_1() {
    let folder = Folder::new("unwritable");
    // A folder in the place of the file.
    std::fs::create_dir(folder.0.join("x.exr")).expect("a folder can be made");
    let box_scene = scene("scenes/box/scene.xml");
    let output =
        abbe(&folder, &["render", box_scene.to_str().unwrap(), "--spp=1", "--size=4x4", "-o", "x.exr"]);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    assert_eq!(folder.files(), ["x.exr"], "nothing unfinished is left");
}

#[cfg(unix)]
#[test]
fn an_interrupted_render_keeps_what_was_done() {
    let folder = Folder::new("interrupted");
    let box_scene = scene("scenes/box/scene.xml");
    let child = Command::new(env!("CARGO_BIN_EXE_abbe"))
        .args(["render", box_scene.to_str().unwrap(), "--spp", "1000000", "--size", "64x64"])
        .current_dir(&folder.0)
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    std::thread::sleep(Duration::from_secs(2));
    let signalled = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(signalled.expect("kill can be run").success());
    let output = child.wait_with_output().expect("the program ends");
    let told = stderr(&output);
    assert_eq!(output.status.code(), Some(0), "{told}");
    assert!(told.contains("stopped: "), "{told}");
    assert_eq!(folder.files(), ["box.exr", "box.png"]);
}

#[test]
fn info_says_what_is_used_and_what_is_skipped() {
    let folder = Folder::new("info");
    let caustic = scene("scenes/caustic/scene.xml");
    let output = abbe(&folder, &["info", caustic.to_str().unwrap()]);
    let told = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(output.status.code(), Some(0));
    assert!(
        told.contains("N-SF11") && told.contains("used: dispersion") && told.contains("skipped: "),
        "{told}"
    );
}

#[test]
fn one_replicate_has_no_error_bars() {
    let folder = Folder::new("replicates");
    let box_scene = scene("scenes/box/scene.xml");
    let render = |replicates: &str| {
        let arguments = ["render", box_scene.to_str().unwrap(), "--spp=16", "--size=8x8", "-o", "x.exr"];
        let output = abbe(&folder, &[&arguments[..], &["--replicates", replicates]].concat());
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let channels = abbe::output::exr::read(&folder.0.join("x.exr")).expect("a readable file").channels;
        (channels.iter().any(|(name, _)| name.starts_with("error.")), stderr(&output))
    };
    let (has_errors, told) = render("1");
    assert!(!has_errors && told.contains("error not known"), "{told}");
    let (has_errors, told) = render("2");
    assert!(has_errors && told.contains("in 2 replicates"), "{told}");
}

#[test]
fn a_reader_that_has_had_enough_is_no_failure() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_abbe"))
        .args(["spectrum", "--list"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("the program ends");
    assert_eq!((output.status.code(), stderr(&output).as_str()), (Some(0), ""));
}

#[test]
fn a_scene_told_in_json_renders_to_the_same_file() {
    let folder = Folder::new("json");
    let scene = scene("validation/mitsuba/scenes/meshes.xml");
    let scene = scene.to_str().unwrap();
    let told = abbe(&folder, &["info", scene, "--json", "-o", "told.json"]);
    assert_eq!(told.status.code(), Some(0), "{}", stderr(&told));
    // Without a file to be relative to, names are whole.
    let printed = abbe(&folder, &["info", scene, "--json"]);
    std::fs::create_dir(folder.0.join("elsewhere")).expect("a folder can be made");
    std::fs::write(folder.0.join("elsewhere/printed.json"), &printed.stdout).expect("a file can be written");
    for (from, to) in
        [(scene, "xml.exr"), ("told.json", "told.exr"), ("elsewhere/printed.json", "printed.exr")]
    {
        let output = abbe(&folder, &["render", from, "-q", "--spp=16", "--size=12x9", "-o", to]);
        assert_eq!(output.status.code(), Some(0), "{from}: {}", stderr(&output));
    }
    let file = |name: &str| std::fs::read(folder.0.join(name)).expect("the picture is there");
    assert!(file("xml.exr") == file("told.exr") && file("xml.exr") == file("printed.exr"));
    let unused = abbe(&folder, &["info", "told.json", "-D", "spp=4"]);
    assert_eq!(unused.status.code(), Some(2));
}
