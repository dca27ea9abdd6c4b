//! Renders that take long: killed and resumed, split and put together, ended at an error.
#![cfg(unix)]

use crate::common::folder::{Folder, stderr};
use crate::common::stress;
use std::os::unix::process::CommandExt;
use std::process::{Command, Stdio};
use std::time::Duration;

/// A caustic, textures of noise in time, everything that a film can hold.
const SCENE: &str = r#"<scene version="3.0.0"><integrator type="path"/>
    <sensor type="perspective"><float name="fov" value="40"/>
        <transform name="to_world"><lookat origin="0 -5 2.5" target="0 0 0.4" up="0 0 1"/></transform>
        <film type="hdrfilm"><integer name="width" value="40"/><integer name="height" value="30"/>
            <rfilter type="gaussian"/><string name="pixel_format" value="rgba"/></film>
    </sensor>
    <shape type="rectangle"><bsdf type="diffuse"/></shape>
    <shape type="sphere"><point name="center" x="0" y="0" z="0.6"/><float name="radius" value="0.4"/>
        <bsdf type="dielectric"/></shape>
    <shape type="rectangle"><transform name="to_world"><scale value="0.3"/><rotate x="1" angle="180"/>
        <translate x="0.6" z="2"/></transform>
        <emitter type="area"><spectrum name="radiance" value="400:1, 700:3"/></emitter></shape></scene>"#;

/// What else is measured.
const MORE: [&str; 2] = ["--spectral=3", "--aov=albedo,shape_index"];

fn scene(name: &str) -> Folder {
    let folder = Folder::new(name);
    folder.write("made.xml", SCENE);
    folder
}

/// The arguments of a render of the scene.
fn rendering<'a>(arguments: &[&'a str]) -> Vec<&'a str> {
    [&["render", "made.xml"], &MORE[..], arguments].concat()
}

fn render(folder: &Folder, code: i32, arguments: &[&str]) -> String {
    folder.ends(code, &rendering(arguments))
}

/// Random numbers below a bound.
fn random(state: &mut u64, below: u64) -> u64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 33) % below
}

#[test]
fn what_is_killed_at_any_moment_goes_on_to_the_same_bits() {
    let folder = scene("killed");
    let spp = stress::count("--spp=512", "--spp=4096");
    render(&folder, 0, &[spp, "-o", "whole.exr", "--quiet"]);
    let mut state = 17;
    let (mut kills, mut went_on) = (0, 0);
    let most = stress::count(5, 50);
    loop {
        let threads = ["--threads=1", "--threads=2", "--threads=7"][kills % 3];
        let arguments = [spp, "-o", "cut.exr", "--resume", "--checkpoint-every=0.02s", "--quiet", threads];
        let mut child = folder.command(&rendering(&arguments)).spawn().expect("the program starts");
        if kills == most {
            assert!(child.wait().expect("it ends").success());
            break;
        }
        std::thread::sleep(Duration::from_millis(20 + random(&mut state, 400)));
        if let Some(status) = child.try_wait().expect("it can be waited for") {
            assert!(status.success(), "{status}");
            break;
        }
        child.kill().expect("it can be killed");
        child.wait().expect("it ends");
        kills += 1;
        went_on += usize::from(folder.exists("cut.checkpoint"));
    }
    println!("{kills} kills, {went_on} of them with a checkpoint");
    assert!(kills > 0 && went_on > 0, "{kills} kills, {went_on} with a checkpoint");
    assert!(folder.bytes("cut.exr") == folder.bytes("whole.exr"), "after {kills} kills");
    assert!(folder.bytes("cut.png") == folder.bytes("whole.png"));
    // What is finished is not rendered again.
    render(&folder, 0, &[spp, "-o", "cut.exr", "--resume", "--quiet"]);
    assert!(folder.bytes("cut.exr") == folder.bytes("whole.exr"));
}

#[allow(unsafe_code, reason = "a call of the operating system")]
#[test]
fn what_a_signal_stops_goes_on() {
    let folder = scene("signal");
    render(&folder, 0, &["--spp=256", "-o", "whole.exr", "--quiet"]);
    for (name, signal) in [("a", "-TERM"), ("b", "-HUP"), ("c", "-INT")] {
        let output = format!("{name}.exr");
        let arguments = ["--spp=256", "--threads=1", "-o", &output, "--checkpoint"];
        let mut command = folder.command(&rendering(&arguments));
        command.stderr(Stdio::piped());
        // SAFETY: to set a signal to what it does by default is allowed between fork and exec.
        unsafe {
            command.pre_exec(|| {
                libc::signal(libc::SIGHUP, libc::SIG_DFL);
                Ok(())
            })
        };
        let child = command.spawn().expect("the program starts");
        std::thread::sleep(Duration::from_millis(400));
        let status = Command::new("kill").args([signal, &child.id().to_string()]).status();
        assert!(status.expect("kill can be run").success());
        let ended = child.wait_with_output().expect("it ends");
        let told = String::from_utf8_lossy(&ended.stderr).into_owned();
        assert_eq!(ended.status.code(), Some(3), "{told}");
        assert!(told.contains("--resume goes on"), "{told}");
        render(&folder, 0, &["--spp=256", "-o", &output, "--resume", "--quiet"]);
        assert!(folder.bytes(&output) == folder.bytes("whole.exr"), "{signal}");
    }
}

/// Runs of samples in any order, in steps, and some of them twice.
#[test]
fn runs_of_samples_make_up_the_picture() {
    let folder = scene("runs");
    render(&folder, 0, &["--spp=64", "-o", "whole.exr", "--quiet"]);
    let count = stress::count(7, 64);
    let mut cuts: Vec<u64> = (0..=count).map(|i| i * 64 / count).collect();
    if !stress::is_full() {
        // Within the samples of an index, too.
        cuts[1..7].copy_from_slice(&[1, 13, 16, 30, 40, 63]);
    }
    let mut parts: Vec<String> = Vec::new();
    for (i, cut) in cuts.windows(2).enumerate() {
        let name = format!("part{i}.checkpoint");
        let samples = format!("--samples={}..{}", cut[0], cut[1]);
        let threads = ["--threads=1", "--threads=2", "--threads=7"][i % 3];
        render(&folder, 0, &["--spp=64", &samples, threads, "-o", &name, "--quiet"]);
        assert!(!folder.exists(&format!("part{i}.exr")));
        parts.push(name);
    }
    let mut state = 5;
    for i in (1..parts.len()).rev() {
        parts.swap(i, random(&mut state, i as u64 + 1) as usize);
    }
    let names: Vec<&str> = parts.iter().map(String::as_str).collect();
    folder.ends(0, &[&["merge", "-o", "all.exr", "--quiet"], names.as_slice()].concat());
    assert!(folder.bytes("all.exr") == folder.bytes("whole.exr"));
    assert!(folder.bytes("all.png") == folder.bytes("whole.png"));
    let (some, others) = names.split_at(3);
    folder.ends(3, &[&["merge", "-o", "some.checkpoint", "--quiet"], some].concat());
    let again = [&["merge", "-o", "all.exr", "--quiet", "some.checkpoint", some[1]], others].concat();
    let told = folder.ends(0, &again);
    assert!(told.is_empty(), "{told}");
    assert!(folder.bytes("all.exr") == folder.bytes("whole.exr"));
    // One missing: what to do is told, and does it.
    let told = folder.ends(3, &[&["merge", "-o", "all.exr"], &names[1..]].concat());
    let missing = told.lines().find_map(|line| line.strip_prefix("missing: ")).expect("it is told");
    let (option, samples) = missing.split_once(' ').expect("an option and its value");
    render(&folder, 0, &["--spp=64", option, samples, "-o", "missing.checkpoint", "--quiet"]);
    folder.ends(0, &[&["merge", "-o", "all.exr", "missing.checkpoint"], &names[1..]].concat());
    assert!(folder.bytes("all.exr") == folder.bytes("whole.exr"));
}

#[test]
fn rectangles_and_runs_make_up_the_picture() {
    let folder = scene("crops");
    render(&folder, 0, &["--spp=32", "-o", "whole.exr", "--quiet"]);
    let mut names = Vec::new();
    for (i, crop) in ["0,0,17,13", "17,0,23,13", "0,13,17,17", "17,13,23,17"].iter().enumerate() {
        for (j, samples) in ["0..20", "20..32"].iter().enumerate() {
            let name = format!("part{i}{j}.exr");
            render(
                &folder,
                0,
                &["--spp=32", "--samples", samples, "--crop", crop, "-o", &name, "--quiet", "--no-png"],
            );
            names.push(format!("part{i}{j}.checkpoint"));
        }
    }
    assert!(folder.exists("part00.exr") && !folder.exists("part00.png"));
    names.reverse();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    folder.ends(0, &[&["merge", "-o", "all.exr", "--quiet"], names.as_slice()].concat());
    assert!(folder.bytes("all.exr") == folder.bytes("whole.exr"));
    // A rectangle without some of its samples: light subpaths are counted for all.
    let told = folder.ends(3, &[&["merge", "-o", "none.exr"], &names[1..]].concat());
    assert!(
        told.contains("--samples 20..32 --crop 17,13,23,17") && told.contains("nothing is written"),
        "{told}"
    );
    assert!(!folder.exists("none.exr"));
    // Without a rectangle there is a picture with a hole.
    let output = folder.run(&[&["merge", "-o", "hole.exr", "--json"], &names[2..]].concat());
    assert_eq!(output.status.code(), Some(3));
    let told: serde_json::Value = serde_json::from_slice(&output.stdout).expect("it is JSON");
    assert_eq!(told["missing"], serde_json::json!([{ "samples": [0, 32], "crop": [17, 13, 23, 17] }]));
    let hole = folder.picture("hole.exr");
    let whole = folder.picture("whole.exr");
    let [hole, whole] = [&hole, &whole].map(|file| file.channel("G").expect("it is there").to_vec());
    assert!(hole[..40 * 13] == whole[..40 * 13] && hole[40 * 30 - 1] == 0.0);
    // A rectangle by itself is complete.
    folder.ends(0, &["merge", "-o", "corner.exr", "part00.checkpoint", "part01.checkpoint", "--quiet"]);
    render(&folder, 0, &["--spp=32", "--crop=0,0,17,13", "-o", "cropped.exr", "--quiet"]);
    assert!(folder.bytes("corner.exr") == folder.bytes("cropped.exr"));
}

#[test]
fn what_does_not_belong_together_is_refused() {
    let folder = scene("refused");
    let part = |name: &str, more: &[&str]| {
        render(&folder, 0, &[&["--spp=16", "-o", name, "--quiet", "--size=8x6"], more].concat());
    };
    part("a.checkpoint", &["--samples=0..8"]);
    part("seed.checkpoint", &["--samples=8..16", "--seed=9"]);
    part("over.checkpoint", &["--samples=4..12"]);
    part("depth.checkpoint", &["--samples=8..16", "--max-depth=3"]);
    part("plain.checkpoint", &["--samples=8..16", "--estimator=plain"]);
    part("b.exr", &["--samples=8..16"]);
    for (other, told) in [
        ("seed.checkpoint", "seed is 0 and 9"),
        ("over.checkpoint", "overlap: both hold --samples 4..8"),
        ("depth.checkpoint", "scene is"),
        ("plain.checkpoint", "estimator is shared and plain"),
        ("b.exr", "b.checkpoint"),
        ("made.xml", "no checkpoint of this version of abbe\nhelp: render this part again"),
        ("none.checkpoint", "cannot read"),
    ] {
        let found = folder.ends(2, &["merge", "-o", "all.exr", "a.checkpoint", other]);
        assert!(found.contains(told), "{other}: {found}");
        assert!(!folder.exists("all.exr"));
    }
    let resumed = |more: &[&str]| {
        let asked = ["--spp=16", "-o", "a.checkpoint", "--size=8x6", "--resume", "--quiet"];
        render(&folder, 2, &[&asked, more].concat())
    };
    for (more, told) in [
        (&["--samples=0..8", "--seed=4"][..], "seed is 0 there and 4 here"),
        (&["--samples=0..8", "--spp=32"][..], "cannot be used multiple times"),
        (&["--samples=8..16"][..], "the part is --samples 0..8"),
        (&["--samples=8..17"][..], "a pixel has 16 samples"),
        (&["--samples=0..8", "--sampler=jittered"][..], "sampler is sobol there and jittered here"),
    ] {
        let found = resumed(more);
        assert!(found.contains(told), "{more:?}: {found}");
    }
    // Nothing that is there is begun anew unasked.
    let found = render(&folder, 2, &["--spp=16", "-o", "b.exr", "--size=8x6", "--checkpoint"]);
    assert!(found.contains("--resume goes on"), "{found}");
    // Damaged in the middle.
    let mut bytes = folder.bytes("a.checkpoint");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    folder.write("a.checkpoint", &bytes);
    let found = resumed(&["--samples=0..8"]);
    assert!(found.contains("damaged") && found.contains("help: remove it to begin anew"), "{found}");
    let found = folder.ends(2, &["merge", "-o", "all.exr", "a.checkpoint"]);
    assert!(found.contains("damaged") && found.contains("help: render this part again"), "{found}");
}

/// A disk that is full is one on which files cannot grow.
#[allow(unsafe_code, reason = "a call of the operating system")]
#[test]
fn a_full_disk_leaves_the_last_good_checkpoint() {
    let folder = scene("full");
    render(&folder, 0, &["--spp=256", "-o", "whole.checkpoint", "--quiet", "--samples=0..8"]);
    let small = folder.bytes("whole.checkpoint").len() as u64;
    std::fs::rename(folder.path("whole.checkpoint"), folder.path("cut.checkpoint")).expect("it is there");
    let before = folder.bytes("cut.checkpoint");
    let arguments =
        ["--spp=256", "-o", "cut.checkpoint", "--resume", "--checkpoint-every=0.01s", "--samples=0..8"];
    let mut command = folder.command(&rendering(&arguments));
    // SAFETY: to ignore a signal and to limit the sizes of files is allowed between fork and exec.
    unsafe {
        command.pre_exec(move || {
            libc::signal(libc::SIGXFSZ, libc::SIG_IGN);
            let limit = libc::rlimit { rlim_cur: small / 2, rlim_max: small / 2 };
            libc::setrlimit(libc::RLIMIT_FSIZE, &limit);
            Ok(())
        })
    };
    let output = command.output().expect("the program starts");
    let told = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{told}");
    assert!(told.contains("cannot write cut.checkpoint"), "{told}");
    assert!(folder.bytes("cut.checkpoint") == before && !folder.exists("cut.checkpoint.unfinished"));
    // A folder that is none.
    let told = render(&folder, 2, &["-o", "none/x.checkpoint"]);
    assert!(told.contains("there is no folder none"), "{told}");
}

#[test]
fn a_render_ends_when_its_error_is_small() {
    let folder = scene("until");
    let until = |code: i32, name: &str, more: &[&str]| {
        let told = render(&folder, code, &[&["-o", name, "--size=32x24", "--no-png"], more].concat());
        (told, folder.picture(name))
    };
    let (told, file) = until(0, "reached.exr", &["--until=error<5%"]);
    assert!(told.contains("error<5% is reached") && told.contains("95 % confidence"), "{told}");
    let at_most = file.attribute("abbe.reachedAtMost").expect("it is stated");
    let percent: f64 = at_most.split(' ').nth(1).and_then(|number| number.parse().ok()).expect("a number");
    assert!(percent < 5.0 && percent > 1.0, "{at_most}");
    assert_eq!(file.attribute("abbe.asked"), Some("error<5%"));
    assert_eq!(file.attribute("abbe.confidence"), Some("0.95"));
    let samples: f64 = file.attribute("abbe.samplesPerPixel").and_then(|n| n.parse().ok()).expect("a number");
    assert!(samples < 4096.0, "{samples}");
    // What ends later begins the same: a smaller error goes on from there.
    let further = ["--until=error<2%", "--spp=65536", "--checkpoint"];
    until(0, "direct.exr", &further);
    until(0, "steps.exr", &["--until=error<5%", "--spp=65536", "--checkpoint"]);
    until(0, "steps.exr", &["--until=error<2%", "--spp=65536", "--resume"]);
    assert!(folder.bytes("steps.exr") == folder.bytes("direct.exr"));
    // Too few samples, or too little time.
    let (told, _) = until(3, "few.exr", &["--until=relmse<1e-9", "--spp=64"]);
    assert!(told.contains("not reached within --spp"), "{told}");
    let (told, _) = until(3, "short.exr", &["--until=relmse<1e-9", "--time=0.5s"]);
    assert!(told.contains("not reached within --time"), "{told}");
    until(0, "time.exr", &["--time=0.5s"]);
}

/// A wall under a lamp takes up a third of the picture, and the rest is black: its pixels have half of the
/// samples that a picture of even samples has when its replicates have four.
#[test]
fn an_error_is_looked_at_by_the_samples_of_the_whole_picture() {
    let folder = Folder::new("allocated");
    folder.write(
        "made.xml",
        r#"<scene version="3.0.0"><integrator type="path"/>
    <sensor type="orthographic">
        <transform name="to_world"><lookat origin="0, 0, 4" target="0, 0, 0" up="0, 1, 0"/></transform>
        <film type="hdrfilm"><integer name="width" value="96"/><integer name="height" value="96"/></film>
    </sensor>
    <shape type="rectangle"><transform name="to_world"><scale y="2"/><translate x="1.345"/></transform></shape>
    <shape type="sphere"><point name="center" x="0.7" y="0.5" z="0.5"/><float name="radius" value="0.1"/>
        <emitter type="area"><spectrum name="radiance" value="10"/></emitter></shape></scene>"#,
    );
    // A pilot of several finds that it pays to allocate samples.
    let allocated = (1..8).find_map(|seed| {
        let seed = format!("--seed={seed}");
        let arguments = ["render", "made.xml", "-o", "x.exr", "--no-png", "--until=error<90%", &seed];
        folder.ends(0, &arguments);
        let samples = folder.picture("x.exr").attribute("abbe.samplesPerPixel").map(str::to_owned);
        samples.filter(|samples| samples.contains(" to "))
    });
    let allocated = allocated.expect("a pilot of several");
    assert!(allocated.starts_with("16 to "), "{allocated}");
}

/// Takes packets apart as tev's protocol has them: length, kind, and what each kind says.
#[test]
fn a_viewer_is_shown_the_picture() {
    let folder = scene("tev");
    let listener = std::net::TcpListener::bind("127.0.0.1:0").expect("a port is free");
    let address = listener.local_addr().expect("it has one").to_string();
    let viewer = std::thread::spawn(move || {
        let (mut stream, _) = listener.accept().expect("the render connects");
        let mut bytes = Vec::new();
        std::io::Read::read_to_end(&mut stream, &mut bytes).expect("all is sent");
        bytes
    });
    render(&folder, 0, &["--spp=16", "-o", "x.exr", "--quiet", "--tev", &address]);
    let bytes = viewer.join().expect("it ends");
    let mut rest = bytes.as_slice();
    let (mut shown, mut created) = (std::collections::BTreeMap::new(), 0);
    while !rest.is_empty() {
        let length = u32::from_le_bytes(rest[..4].try_into().expect("four bytes")) as usize;
        let (kind, mut content) = (rest[4], &rest[6..length]);
        let text = |content: &mut &[u8]| {
            let end = content.iter().position(|&byte| byte == 0).expect("it ends");
            let text = String::from_utf8_lossy(&content[..end]).into_owned();
            *content = &content[end + 1..];
            text
        };
        let number = |content: &mut &[u8]| {
            let number = i32::from_le_bytes(content[..4].try_into().expect("four bytes"));
            *content = &content[4..];
            number
        };
        assert_eq!(text(&mut content), "x.exr");
        match kind {
            4 => {
                assert_eq!([(); 3].map(|()| number(&mut content)), [40, 30, 3]);
                assert_eq!([(); 3].map(|()| text(&mut content)), ["R", "G", "B"]);
                assert!(content.is_empty());
                created += 1;
            }
            6 => {
                assert_eq!(number(&mut content), 1);
                let channel = text(&mut content);
                assert_eq!([(); 4].map(|()| number(&mut content)), [0, 0, 40, 30]);
                assert_eq!(content[..16], [[0u8; 8], 1u64.to_le_bytes()].concat());
                let values = content[16..].chunks_exact(4);
                let values: Vec<f32> =
                    values.map(|value| f32::from_le_bytes(value.try_into().expect("four bytes"))).collect();
                assert_eq!(values.len(), 40 * 30);
                shown.insert(channel, values);
            }
            _ => panic!("packets of kind {kind}"),
        }
        rest = &rest[length..];
    }
    let file = folder.picture("x.exr");
    assert_eq!((created, shown.len()), (1, 3));
    for (channel, values) in &shown {
        assert!(Some(values.as_slice()) == file.channel(channel), "{channel}");
    }
    // Nobody is there.
    let told = render(&folder, 2, &["--spp=16", "-o", "x.exr", "--tev", &address]);
    assert!(told.contains("--tev"), "{told}");
}
