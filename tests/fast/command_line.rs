//! The program as its users meet it: files, messages, exit codes, interruption.

use crate::common::folder::{Folder, of_repository, stderr, stdout};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

#[test]
fn a_render_lands_under_the_name_of_the_scenes_folder() {
    let folder = Folder::new("names");
    let box_scene = of_repository("scenes/box/scene.xml");
    let output = folder.run(&["render", &box_scene, "--spp", "16", "--size", "20x10"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(folder.files(), ["box.exr", "box.png"]);
    assert!(output.stdout.is_empty());
    // Not a terminal: lines with what a bar would show, and a last one of what was measured.
    let told = stderr(&output);
    assert!(told.contains("100 %") && told.contains("s left") && told.contains("error"), "{told}");
    assert!(told.contains("20×10") && told.contains("16 samples per pixel"), "{told}");
    let channels = folder.picture("box.exr");
    let names: Vec<&str> = channels.channels.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["B", "G", "R", "error.B", "error.G", "error.R", "samples"]);
    assert!(channels.channels.iter().flat_map(|(_, values)| values).all(|value| value.is_finite()));
}

#[test]
fn what_is_asked_for_besides_is_in_the_file() {
    let folder = Folder::new("besides");
    let box_scene = of_repository("scenes/box/scene.xml");
    let arguments = [
        "render",
        &box_scene,
        "--spp=16",
        "--size=8x8",
        "--spectral=2",
        "--aov=depth,nn:sh_normal,shape_index",
        "-q",
        "-o",
        "x.exr",
    ];
    let output = folder.run(&arguments);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(output.stderr.is_empty(), "quiet is quiet");
    let channels = folder.picture("x.exr");
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
    let (good, missing) = (of_repository("scenes/box/scene.xml"), of_repository("scenes/none.xml"));
    folder.write("bad.xml", "<scene version=\"3.0.0\"><sensor type=\"perspectve\"/></scene>");
    for (arguments, expected) in [
        (vec!["render", "bad.xml"], "did you mean \"perspective\"?"),
        (vec!["render", &missing], "none.xml"),
        (vec!["render", &good, "-o", "picture.jpg"], "*.exr"),
        (vec!["render", &good, "-o", "no/such/folder.exr"], "no folder no/such\nhelp: make it first"),
        (vec!["render", &good, "--time", "-3s"], "expected a time such as 90s"),
        (vec!["render", &good, "--checkpoint-every", "-3s"], "expected a time such as 90s"),
        (
            vec!["render", &good, "--size", "16x16", "--crop", "0,0,17,17"],
            "error: --crop: the part to render",
        ),
        (vec!["render", &good, "--spp", "0"], "--spp"),
        (vec!["render", &good, "--size", "12"], "WIDTHxHEIGHT"),
        (vec!["render", &good, "--wavelengths", "3"], "1, 4 or 8"),
        (vec!["render", &good, "--max-depth", "-2"], "or -1 for any number"),
        (vec!["render", &good, "--aov", "normal"], "sh_normal or geo_normal"),
        (vec!["render", &good, "--aov", "depth,depth"], "two channels \"depth.T\""),
        (vec!["render", &good, "--size", "65536x65536", "--spectral"], "GiB"),
        (vec!["render", &good, "-D", "sp=3"], "sp"),
        (vec!["render", &good, "--spp", "-3"], "from 1 to 16777216"),
        (vec!["render", &good, "--seed", "-1"], "from 0 to 18446744073709551615"),
        (vec!["render", &good, "--seed", "99999999999999999999"], "from 0 to 18446744073709551615"),
        (vec!["render", &good, "--threads", "-1"], "from 1 to 1024"),
        (vec!["render", &good, "--size", "-1x5"], "WIDTHxHEIGHT"),
        (vec!["render", &good, "--crop", "-1,0,4,4"], "X,Y,WIDTH,HEIGHT"),
        (vec!["render", &good, "--spp", "4", "--replicates", "1024"], "take --replicates 4 or fewer"),
        (vec!["explain", &good, "--pixel=0,0", "--spp", "4", "--replicates", "5"], "or --spp 5 or more"),
        (vec!["study", &good, "-o", "noise", "--seed", "-1"], "from 0 to 18446744073709551615"),
        (vec!["spectrum", "N-SF111"], "error: there is no spectrum named 'N-SF111'\nhelp: did you mean"),
        (vec!["spectrum", "none.spd"], "error: cannot read none.spd"),
        (vec!["spectrum", "D65", "--at", "0"], "from 1 to 100000 nm"),
        (vec!["spectrum", "D65", "--at", "-5"], "from 1 to 100000 nm"),
        (vec!["spectrum", "D65", "--at", "nan"], "from 1 to 100000 nm"),
        (vec!["spectrum", "BK7", "--plot", "x.svg"], "error: the name means several things"),
        (vec!["spectrum", "Au", "--plot", "x.pdf"], ".svg or .png"),
        (vec!["spectrum", "Au", "--kind", "reflectance"], "take --kind conductor"),
        (vec!["render", &good, "--spp", "4194305", "--replicates", "1"], "take --replicates 2 or more"),
        (vec!["render", &good, "--spp", "4194305", "--sampler", "regular"], "regular has one replicate"),
        (vec!["render", &good, "--checkpoint-every", "5s"], "add --checkpoint, or --resume"),
        (vec!["render", &good, "--no-png", "--tone", "aces"], "--tone is of the PNG, and --no-png leaves"),
        (vec!["render", &good, "-o", "x.checkpoint", "--exposure", "1"], "a checkpoint has none beside it"),
        (vec!["merge", "a.checkpoint", "-o", "x.checkpoint", "--tone", "aces"], "name the output *.exr"),
        (vec!["draw"], "draw"),
    ] {
        let output = folder.run(&arguments);
        let told = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {told}");
        assert!(told.contains(expected), "{arguments:?}: {told}");
        assert_eq!(stdout(&output), "", "{arguments:?}");
    }
    assert_eq!(folder.files(), ["bad.xml"]);
}

#[test]
fn what_is_no_scene_is_called_so() {
    let folder = Folder::new("no-scene");
    folder.write("picture.png", b"\x89PNG\r\n\x1a\n\0\0");
    folder.write("latin.xml", b"<scene version=\"3.0.0\"><!-- caf\xe9 --></scene>");
    let told = folder.ends(2, &["info", "picture.png"]);
    assert!(
        told.contains("picture.png is not a scene") && told.contains("Mitsuba 3's XML or JSON"),
        "{told}"
    );
    let told = folder.ends(2, &["info", "latin.xml"]);
    assert!(told.contains("not text in UTF-8 (at byte 31)"), "{told}");
    folder.write("wide.xml", b"\xff\xfe<\0s\0c\0e\0n\0e\0");
    let told = folder.ends(2, &["info", "wide.xml"]);
    assert!(told.contains("not text in UTF-8 (at byte 0)"), "{told}");
    folder.write("pointer.ply", "version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 9\n");
    folder.write(
        "clone.xml",
        r#"<scene version="3.0.0"><shape type="ply"><string name="filename" value="pointer.ply"/></shape></scene>"#,
    );
    let told = folder.ends(2, &["info", "clone.xml"]);
    assert!(told.contains("pointer.ply only tells Git LFS") && told.contains("git lfs pull"), "{told}");
}

#[test]
fn a_table_with_a_byte_order_mark_is_read_and_one_in_micrometres_refused() {
    let folder = Folder::new("tables");
    folder.write("marked.spd", "\u{feff}400 0.1\n700 0.2\n");
    folder.write("marked.csv", "\u{feff}wavelength_nm,a\n400,0.1\n700,0.2\n");
    folder.ends(0, &["spectrum", "marked.spd"]);
    folder.ends(0, &["spectrum", "marked.csv"]);
    folder.write("small.spd", "0.4 0.1\n0.7 0.2\n");
    let told = folder.ends(2, &["spectrum", "small.spd"]);
    assert!(told.starts_with("error: small.spd: line 1, column 1") && told.contains("by 1000"), "{told}");
}

#[test]
fn what_a_table_leaves_open_is_told() {
    let folder = Folder::new("open-tables");
    let told = |arguments: &[&str]| stdout(&folder.run(&[&["spectrum"], arguments].concat()));
    let told_outside = "(2000 nm is outside the table, 300–830 nm: it counts as 0)";
    assert!(told(&["D65", "--at", "500", "--at", "2000"]).contains(told_outside));
    assert!(!told(&["D65", "--at", "500"]).contains("outside"));
    // A reflectance in per cent.
    folder.write("percent.csv", "wavelength_nm,a\n400,10\n700,20\n");
    let refused = folder.ends(2, &["spectrum", "percent.csv", "--kind", "reflectance"]);
    assert!(refused.contains("is 10 at 400 nm") && refused.contains("divided by 100"), "{refused}");
    folder.ends(0, &["spectrum", "percent.csv"]);
    folder.write("x.csv", "nm,a\n400,1\n700,1\n");
    assert!(folder.ends(2, &["spectrum", "x.csv"]).contains("such as wavelength_nm,reflectance"));
    // One that ends within what can be seen, unless it ends in black.
    folder.write("short.spd", "400 0.1\n700 0.2\n");
    folder.write("black.spd", "400 0\n500 0.2\n700 0\n");
    let note = "the table covers 400–700 nm; scenes take 0 beyond";
    assert!(told(&["short.spd", "--kind", "reflectance"]).contains(note));
    assert!(!told(&["short.spd"]).contains(note));
    assert!(!told(&["black.spd", "--kind", "reflectance"]).contains(note));
    let info = |table: &str, film: &str| {
        folder.write(
            "x.xml",
            format!(
                r#"<scene version="3.0.0"><sensor type="perspective">{film}</sensor><emitter type="constant"/>
    <shape type="sphere"><bsdf type="diffuse"><spectrum name="reflectance" filename="{table}"/></bsdf></shape></scene>"#
            ),
        );
        stdout(&folder.run(&["info", "x.xml"]))
    };
    let remark = "The reflectance: the table covers 400–700 nm; it is 0 beyond";
    assert!(info("short.spd", "").contains(remark), "{}", info("short.spd", ""));
    assert!(!info("black.spd", "").contains("covers"));
}

#[test]
fn white_is_stated_for_what_colours_a_picture_has() {
    let folder = Folder::new("white");
    let white = |format: &str, observer: &str| {
        folder.write(
            "x.xml",
            format!(
                r#"<scene version="3.0.0"><emitter type="constant"/><sensor type="perspective">
    <film type="hdrfilm"><string name="pixel_format" value="{format}"/></film></sensor></scene>"#
            ),
        );
        let observer = format!("--observer={observer}");
        folder.ends(0, &["render", "x.xml", "-o", "x.exr", "--spp=1", "--size=4x4", "-q", &observer]);
        folder.picture("x.exr").attribute("abbe.whitePoint").map(str::to_owned).unwrap_or_default()
    };
    let standard = "D65, x = 0.3127, y = 0.3290 (linear Rec. 709)";
    assert_eq!(white("rgb", "cie1931"), standard);
    assert_eq!(white("rgb", "cie1931-5nm"), standard);
    let other = white("rgb", "cie1964");
    assert!(other.starts_with(standard) && other.ends_with("R = 1.100, G = 1.101, B = 1.081"), "{other}");
    assert_eq!(white("xyz", "cie1964"), "none: X, Y and Z are those of CIE 1964 10°");
}

#[test]
fn a_folder_in_the_place_of_a_picture_is_refused_before_the_render() {
    let folder = Folder::new("unwritable");
    std::fs::create_dir(folder.path("x.exr")).expect("a folder can be made");
    std::fs::create_dir(folder.path("y.png")).expect("a folder can be made");
    let box_scene = of_repository("scenes/box/scene.xml");
    for name in ["x.exr", "y.exr"] {
        // So many samples take days: it is found before the first.
        let child = folder
            .command(&["render", &box_scene, "--spp=16777216", "--size=256x256", "-o", name])
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        let output = soon(child);
        let told = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{told}");
        assert!(told.contains("there is a folder of this name\nhelp: give the output another"), "{told}");
    }
    assert_eq!(folder.files(), ["x.exr", "y.png"], "nothing unfinished is left");
}

/// A disk without room.
#[cfg(target_os = "linux")]
#[test]
fn a_place_that_cannot_be_written_is_1() {
    let folder = Folder::new("full");
    std::os::unix::fs::symlink("/dev/full", folder.path("x.svg")).expect("a link");
    let told = folder.ends(1, &["spectrum", "D65", "--plot", "x.svg"]);
    assert!(told.contains("cannot write x.svg"), "{told}");
}

/// What a program has to say that ends within a minute.
fn soon(mut child: Child) -> Output {
    let begun = Instant::now();
    while child.try_wait().expect("the program can be waited for").is_none() {
        if begun.elapsed() > Duration::from_secs(60) {
            child.kill().expect("the program can be ended");
            panic!("it does not end: {}", stderr(&child.wait_with_output().expect("it was ended")));
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    child.wait_with_output().expect("the program ends")
}

/// What the scene is read from stays: its own file, and an image that has the name of the PNG.
#[test]
fn nothing_is_written_over_the_files_of_a_scene() {
    let folder = Folder::new("own-files");
    folder.ends(
        0,
        &["render", &of_repository("scenes/box/scene.xml"), "--spp=1", "--size=4x4", "-o", "tile.exr", "-q"],
    );
    let scene = r#"<scene version="3.0.0"><sensor type="perspective"/><emitter type="constant"/>
        <shape type="sphere"><bsdf type="diffuse"><texture name="reflectance" type="bitmap">
        <string name="filename" value="tile.png"/></texture></bsdf></shape></scene>"#;
    folder.write("tile.xml", scene);
    let before = folder.files();
    let tile = folder.bytes("tile.png");
    let small = ["tile.xml", "--spp=1", "--size=4x4", "-q"];
    for wrong in [
        &["info", "tile.xml", "-o", "tile.xml"][..],
        &["info", "tile.xml", "--json", "-o", "./tile.png"],
        &[&["render"], &small[..]].concat(),
        &["explain", "tile.xml", "--pixel=1,1", "--svg", "tile.png"],
    ] {
        let told = folder.ends(2, wrong);
        assert!(told.contains("the scene is read from this file") && told.contains("help: "), "{told}");
    }
    assert!(folder.text("tile.xml") == scene && folder.bytes("tile.png") == tile);
    assert_eq!(folder.files(), before);
    folder.ends(0, &[&["render"], &small[..], &["--no-png", "--max-depth", "-1"]].concat());
    assert!(folder.bytes("tile.png") == tile);
}

/// A link stays and leads to the picture.
#[cfg(unix)]
#[test]
fn a_picture_lands_where_a_link_leads_to() {
    let folder = Folder::new("links");
    std::fs::create_dir(folder.path("disk")).expect("a folder");
    folder.write("disk/real.exr", "");
    std::os::unix::fs::symlink("disk/real.exr", folder.path("link.exr")).expect("a link");
    let scene = of_repository("scenes/box/scene.xml");
    folder.ends(0, &["render", &scene, "--spp=1", "--size=4x4", "--no-png", "-q", "-o", "link.exr"]);
    assert!(folder.path("link.exr").is_symlink());
    assert!(!folder.picture("disk/real.exr").channels.is_empty());
}

/// What could never be written or reached is refused before the render.
#[test]
fn what_cannot_come_about_is_refused_at_once() {
    let folder = Folder::new("never");
    let scene = of_repository("scenes/box/scene.xml");
    let long = format!("--aov={}:depth", "n".repeat(250));
    for (wrong, problem) in [
        (&["--until=error<1%", "--replicates=1"][..], "one replicate"),
        (&["--until=error<1%", "--sampler=regular"], "one replicate"),
        (&[long.as_str()], "a channel whose name has 252 bytes"),
    ] {
        let told = folder.ends(2, &[&["render", &scene, "--size=4x4", "-q"], wrong].concat());
        assert!(told.contains(problem), "{told}");
    }
    let far = r#"<scene version="3.0.0"><sensor type="perspective"/><emitter type="constant"/><shape type="sphere"/>
        <shape type="rectangle"><transform name="to_world"><translate x="1e36"/></transform></shape></scene>"#;
    folder.write("far.xml", far);
    let told = folder.ends(2, &["render", "far.xml", "--size=4x4", "--spp=1", "-q"]);
    assert!(told.contains("far.xml:2") && told.contains("farther than 1e18"), "{told}");
    assert_eq!(folder.files(), ["far.xml"]);
}

#[test]
fn a_lamp_without_area_is_told_before_the_render() {
    let folder = Folder::new("no_area");
    folder.write("line.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    folder.write("part.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 4\n");
    for (mesh, expected) in [("line.obj", true), ("part.obj", false)] {
        let scene = format!(
            r#"<scene version="3.0.0">
                <sensor type="perspective"/><shape type="sphere"/>
                <shape type="obj"><string name="filename" value="{mesh}"/><emitter type="area"/></shape>
            </scene>"#
        );
        folder.write("lamp.xml", &scene);
        let render = folder.run(&["render", "lamp.xml", "--spp=1", "--size=4x4", "-q"]);
        assert_eq!(render.status.code(), Some(0), "{}", stderr(&render));
        for told in [stderr(&render), stdout(&folder.run(&["info", "lamp.xml"]))] {
            assert_eq!(told.contains("the lamp has no area, so it gives no light"), expected, "{told}");
        }
    }
}

#[test]
fn a_scene_without_light_is_told_before_the_render() {
    let folder = Folder::new("dark");
    let with = |light: &str| {
        format!(r#"<scene version="3.0.0"><shape type="sphere"/><sensor type="perspective"/>{light}</scene>"#)
    };
    let light = |values: &str| {
        format!(r#"<emitter type="constant"><spectrum name="radiance" value="{values}"/></emitter>"#)
    };
    for (scene, expected) in [
        (with(""), Some("the scene has no light")),
        (with(&light("0")), Some("no light shines at a wavelength")),
        (with(&light("200:1, 300:1")), Some("no light shines at a wavelength")),
        (with(&light("1")), None),
    ] {
        folder.write("dark.xml", &scene);
        let render = folder.run(&["render", "dark.xml", "--spp=1", "--size=4x4"]);
        assert_eq!(render.status.code(), Some(0), "{}", stderr(&render));
        let quiet = folder.run(&["render", "dark.xml", "--spp=1", "--size=4x4", "-q"]);
        assert_eq!(stderr(&quiet).contains("the picture is black"), expected.is_some(), "{}", stderr(&quiet));
        let [told, listed] = [&["info", "dark.xml"][..], &["info", "dark.xml", "--json"]]
            .map(|arguments| stdout(&folder.run(arguments)));
        let said = [stderr(&render), told, listed];
        match expected {
            Some(expected) => {
                assert!(said.iter().all(|said| said.contains(expected)), "{said:?}");
                assert!(said[0].contains("warning: "), "{said:?}");
            }
            None => assert!(said.iter().all(|said| !said.contains("black")), "{said:?}"),
        }
    }
}

#[test]
fn nobody_need_read_what_a_render_says() {
    let folder = Folder::new("unread");
    let box_scene = of_repository("scenes/box/scene.xml");
    let mut child = folder
        .command(&["render", &box_scene, "--spp=16", "--size=64x64"])
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    drop(child.stderr.take());
    assert_eq!(soon(child).status.code(), Some(0));
    assert_eq!(folder.files(), ["box.exr", "box.png"]);
}

#[test]
fn info_says_what_is_used_and_what_is_skipped() {
    let folder = Folder::new("info");
    let caustic = of_repository("scenes/caustic/scene.xml");
    let output = folder.run(&["info", &caustic]);
    let told = stdout(&output);
    assert_eq!(output.status.code(), Some(0));
    assert!(
        told.contains("N-SF11") && told.contains("used: dispersion") && told.contains("skipped: "),
        "{told}"
    );
}

#[test]
fn one_replicate_has_no_error_bars() {
    let folder = Folder::new("replicates");
    let box_scene = of_repository("scenes/box/scene.xml");
    let render = |replicates: &str| {
        let arguments = ["render", &box_scene, "--spp=16", "--size=8x8", "-o", "x.exr"];
        let output = folder.run(&[&arguments[..], &["--replicates", replicates]].concat());
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let channels = folder.picture("x.exr").channels;
        (channels.iter().any(|(name, _)| name.starts_with("error.")), stderr(&output))
    };
    let (has_errors, told) = render("1");
    assert!(!has_errors && told.contains("its error is not known,"), "{told}");
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
    let scene = of_repository("validation/mitsuba/scenes/meshes.xml");
    let told = folder.run(&["info", &scene, "--json", "-o", "told.json"]);
    assert_eq!(told.status.code(), Some(0), "{}", stderr(&told));
    // Without a file to be relative to, names are whole.
    let printed = folder.run(&["info", &scene, "--json"]);
    std::fs::create_dir(folder.path("elsewhere")).expect("a folder can be made");
    folder.write("elsewhere/printed.json", &printed.stdout);
    for (from, to) in
        [(scene.as_str(), "xml.exr"), ("told.json", "told.exr"), ("elsewhere/printed.json", "printed.exr")]
    {
        let output = folder.run(&["render", from, "-q", "--spp=16", "--size=12x9", "-o", to]);
        assert_eq!(output.status.code(), Some(0), "{from}: {}", stderr(&output));
    }
    let file = |name: &str| folder.bytes(name);
    assert!(file("xml.exr") == file("told.exr") && file("xml.exr") == file("printed.exr"));
    let unused = folder.run(&["info", "told.json", "-D", "spp=4"]);
    assert_eq!(unused.status.code(), Some(2));
}

/// Completions and manual pages follow the declaration of the command line, so they know every command.
#[test]
fn shells_complete_and_the_manual_has_a_page_for_each_command() {
    let folder = Folder::new("manual");
    let printed = |arguments: &[&str]| {
        let output = folder.run(arguments);
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", stderr(&output));
        String::from_utf8(output.stdout).expect("text")
    };
    let commands = ["render", "merge", "view", "compare", "info", "spectrum", "study", "completions", "man"];
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = printed(&["completions", shell]);
        for word in commands.iter().chain(&["spp", "fail-if", "reference"]) {
            assert!(script.contains(word), "{shell} does not know {word}");
        }
    }
    // bash itself completes with it, where there is one.
    let script = printed(&["completions", "bash"])
        + "\nCOMP_WORDS=(abbe com); COMP_CWORD=1; _abbe abbe com abbe; echo \"${COMPREPLY[@]}\"";
    if let Ok(output) = Command::new("bash").args(["--norc", "-c", &script]).output() {
        assert_eq!(
            String::from_utf8_lossy(&output.stdout).trim(),
            "compare completions",
            "{}",
            stderr(&output)
        );
    }
    let page = printed(&["man"]);
    for command in commands {
        assert!(page.contains(&format!("abbe\\-{command}(1)")), "{command} in {page}");
        let own = printed(&["man", command]);
        assert!(own.starts_with(".ie") && own.contains(&format!("abbe\\-{command}")), "{own}");
    }
    assert!(printed(&["man", "render"]).contains("\\-\\-spp"));
    for (arguments, expected) in [(["man", "rendr"], "render"), (["completions", "basch"], "bash")] {
        let output = folder.run(&arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(stderr(&output).contains(expected), "{}", stderr(&output));
    }
}

/// A processor without AVX2 hears what it lacks, where "Illegal instruction" is all it heard. Needs
/// qemu-user.
#[test]
#[cfg(all(target_os = "linux", target_arch = "x86_64", target_feature = "avx2"))]
fn an_old_processor_is_told_what_it_lacks() {
    let arguments = ["-cpu", "Nehalem", env!("CARGO_BIN_EXE_abbe"), "--version"];
    let old = match Command::new("qemu-x86_64").args(arguments).output() {
        Ok(output) => output,
        Err(error) => return eprintln!("not tried, as qemu-x86_64 does not start: {error}"),
    };
    assert_eq!(old.status.code(), Some(1), "{}", stderr(&old));
    assert!(stderr(&old).contains("lacks") && stderr(&old).contains("AVX2"), "{}", stderr(&old));
    assert!(stderr(&old).contains("target-cpu=native"), "{}", stderr(&old));
}

/// A metal that abbe has no table of is read from a folder, by every command that reads scenes; the message
/// about it says so.
#[test]
fn metals_come_from_a_folder_of_tables() {
    let folder = Folder::new("metals");
    let text = r#"<scene version="3.0.0"><sensor type="perspective"><film type="hdrfilm"><integer name="width" value="4"/>
        <integer name="height" value="4"/></film></sensor><emitter type="constant"/><shape type="sphere">
        <transform name="to_world"><translate z="4"/></transform>
        <bsdf type="conductor"><string name="material" value="Ta"/></bsdf></shape></scene>"#;
    folder.write("ball.xml", text);
    let tables = of_repository("tests/scenes/ior");
    for command in [
        &["info", "ball.xml"][..],
        &["render", "ball.xml", "--spp", "4", "-o", "ball.exr"],
        &["study", "ball.xml", "-o", "noise", "--samplers", "independent", "--spp", "1", "--replicates", "2"],
    ] {
        let without = folder.run(command);
        assert_eq!(without.status.code(), Some(2), "{command:?}");
        let said = stderr(&without);
        assert!(said.contains("ball.xml:4:") && said.contains("--ior-tables DIR reads Ta.eta.spd"), "{said}");
    }
    let told = folder.run(&["info", "ball.xml", "--ior-tables", &tables]);
    assert_eq!(told.status.code(), Some(0), "{}", stderr(&told));
    let outline = stdout(&told);
    assert!(outline.contains("eta: 3 values from 400 to 700 nm, Ta.eta.spd"), "{outline}");
    let rendered =
        folder.run(&["render", "ball.xml", "--spp", "4", "-o", "ball.exr", "--ior-tables", &tables]);
    assert_eq!(rendered.status.code(), Some(0), "{}", stderr(&rendered));
    let nowhere = folder.run(&["info", "ball.xml", "--ior-tables", "nowhere"]);
    assert_eq!(nowhere.status.code(), Some(2));
    assert!(stderr(&nowhere).contains("nowhere cannot be read"), "{}", stderr(&nowhere));
}
