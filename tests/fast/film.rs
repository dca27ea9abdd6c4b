//! Films with many spectral bins: how much memory they take, and that a film in a file is the same as one in
//! memory.
#![cfg(target_os = "linux")]

use crate::common::compiled;
use crate::common::folder::{Folder, of_repository, stderr};
use abbe::film::{SpectralBins, Storage};
use abbe::integrator::Estimator;
use abbe::output::checkpoint::{self, Description, Header};
use abbe::output::{self, Colour, Content, Picture};
use abbe::render::{NoProgress, Schedule, Settings, WavelengthCount, Work, go_on};
use abbe::sampling::SamplerKind;
use abbe::scene::{CompileOptions, ReadOptions, read_str};
use abbe::units::WavelengthRange;
use std::path::Path;

const MIB: u64 = 1 << 20;

/// 96 × 96 pixels, 8 replicates and 350 bins are 197 MiB of sums; the picture has 701 channels.
fn spectral<'a>(more: &[&'a str]) -> Vec<&'a str> {
    [&["--size=96x96", "--spectral=350", "--spp=8", "--max-depth=1", "--no-png", "--quiet"], more].concat()
}

#[test]
fn a_spectral_film_takes_little_memory() {
    let folder = Folder::new("film");
    let scene = of_repository("tests/scenes/agreement/dispersion.xml");
    let peak_of = |more: &[&str]| folder.peak_memory(&[&["render", &scene], &spectral(more)[..]].concat());
    let peak = peak_of(&["-o", "whole.exr"]);
    assert!(peak < 180 * MIB, "{} MiB", peak / MIB);
    for (samples, part) in [("0..3", "a.checkpoint"), ("3..8", "b.checkpoint")] {
        let peak = peak_of(&["--samples", samples, "-o", part]);
        assert!(peak < 180 * MIB, "{} MiB", peak / MIB);
    }
    let merge = ["merge", "b.checkpoint", "a.checkpoint", "-o", "all.exr", "--no-png", "--quiet"];
    let peak = folder.peak_memory(&merge);
    assert!(peak < 180 * MIB, "{} MiB", peak / MIB);
    assert!(folder.bytes("all.exr") == folder.bytes("whole.exr"));
    // The file of bins is gone.
    assert_eq!(folder.files(), ["a.checkpoint", "all.exr", "b.checkpoint", "whole.exr"]);
}

#[test]
fn memory_does_not_depend_on_the_number_of_samples() {
    let folder = Folder::new("samples");
    let scene = of_repository("tests/scenes/agreement/dispersion.xml");
    let peak = |spp: &str| {
        let options = ["--size=2x2", "--spectral=47", "--max-depth=1", "--no-png", "--quiet", "-o", "x.exr"];
        folder.peak_memory(&[&["render", &scene, "--spp", spp], &options[..]].concat())
    };
    let (few, many) = (peak("100"), peak("100000"));
    assert!(many < few + 8 * MIB, "{} and {} MiB", few / MIB, many / MIB);
}

/// Light subpaths bring something to this scene, and its filter reaches over the borders of blocks.
const CAUSTIC: &str = r#"<scene version="3.0.0"><integrator type="path"/>
    <sensor type="perspective"><float name="fov" value="40"/>
        <transform name="to_world"><lookat origin="0 -5 2.5" target="0 0 0.4" up="0 0 1"/></transform>
        <film type="hdrfilm"><integer name="width" value="30"/><integer name="height" value="20"/>
            <rfilter type="gaussian"/></film>
    </sensor>
    <shape type="rectangle"><bsdf type="diffuse"/></shape>
    <shape type="sphere"><point name="center" x="0" y="0" z="0.6"/><float name="radius" value="0.4"/>
        <bsdf type="dielectric"/></shape>
    <shape type="rectangle"><transform name="to_world"><scale value="0.3"/><rotate x="1" angle="180"/>
        <translate x="0.6" z="2"/></transform>
        <emitter type="area"><spectrum name="radiance" value="400:1, 700:3"/></emitter></shape></scene>"#;

#[test]
fn a_film_in_a_file_is_that_in_memory() {
    let folder = Folder::new("place");
    let description =
        read_str(CAUSTIC.to_owned(), Path::new("scene.xml"), &ReadOptions::default()).expect("a scene");
    let range = WavelengthRange::VISIBLE;
    let options = CompileOptions { range, spectral: true, ..CompileOptions::default() };
    let scene = compiled(&description, &options);
    assert!(scene.caustics().is_some());
    let settings = Settings {
        schedule: Schedule::new(16),
        seed: 3,
        sampler: SamplerKind::Sobol,
        wavelengths: Some(WavelengthCount::Four),
        estimator: Estimator::Shared,
        // 38 MB of sums, and as many of light subpaths.
        bins: Some(SpectralBins { range, count: 1000 }),
    };
    let path = |name: &str| folder.path(name);
    for (name, place) in [("memory", Storage::Memory), ("file", Storage::Folder(folder.as_ref()))] {
        let begun = Work::new_at(place, &scene, &settings, None).expect("there is room");
        let work = go_on(&scene, &settings, begun, &NoProgress::new());
        let film = work.film();
        let content = Content::Colour(Colour::Rec709);
        let description = Description { content: content.clone(), moments: None, attributes: Vec::new() };
        let header = Header::of(&work, &[], &description, 16, &[]);
        checkpoint::write(&path(&format!("{name}.checkpoint")), &header, film, &[], 2)
            .expect("it is written");
        let (auxiliary, attributes) = (Vec::new(), Vec::new());
        let picture = Picture { film, content, moments: None, auxiliary, attributes };
        output::exr::write(&path(&format!("{name}.exr")), &picture).expect("it is written");
    }
    for end in ["exr", "checkpoint"] {
        let bytes = |name: &str| folder.bytes(&format!("{name}.{end}"));
        assert!(bytes("memory") == bytes("file"), "{end}");
    }
}

/// A film for which the disk has no room is refused before the first sample; where files may grow up to a
/// limit alone, the system would end the program by a signal.
#[test]
#[allow(unsafe_code, reason = "a call of the operating system")]
fn a_film_without_room_is_refused_before_the_render() {
    use std::os::unix::process::CommandExt;
    let folder = Folder::new("room");
    let scene = of_repository("tests/scenes/agreement/dispersion.xml");
    let mut command = folder.command(&[&["render", &scene, "-o", "x.exr"], &spectral(&[])[..]].concat());
    // SAFETY: between fork and exec nothing but one system call is made.
    unsafe {
        command.pre_exec(|| {
            let limit = libc::rlimit { rlim_cur: 150 * MIB, rlim_max: 150 * MIB };
            match libc::setrlimit(libc::RLIMIT_FSIZE, &raw const limit) {
                0 => Ok(()),
                _ => Err(std::io::Error::last_os_error()),
            }
        });
    }
    let output = command.output().expect("the program starts");
    let told = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{told}");
    assert!(told.contains("cannot keep the spectral bins of the film") && told.contains("help: "), "{told}");
    assert!(folder.files().is_empty(), "{:?}", folder.files());
}

/// A disk may fail, or turn out to be full, when the film is under way: then the system sends a signal, as is
/// done here. What was kept before goes on to the same picture.
#[test]
#[allow(unsafe_code, reason = "a call of the operating system")]
fn a_disk_that_fails_ends_the_render_with_a_message() {
    let folder = Folder::new("fails");
    let scene = of_repository("tests/scenes/agreement/dispersion.xml");
    let options = |more: &[&'static str]| {
        let own = ["--size=32x32", "--spectral=47", "--max-depth=3", "--spp=512", "--no-png", "--quiet"];
        [&["render", scene.as_str()], &own[..], more].concat()
    };
    folder.ends(0, &options(&["-o", "whole.exr"]));
    let mut command = folder.command(&options(&["-o", "x.exr", "--resume", "--checkpoint-every=0.01s"]));
    let child = command.stderr(std::process::Stdio::piped()).spawn().expect("the program starts");
    let began = std::time::Instant::now();
    while !folder.exists("x.checkpoint") {
        assert!(began.elapsed().as_secs() < 60, "{:?}", folder.files());
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    // SAFETY: the process is a child that nobody has waited for yet.
    unsafe { libc::kill(child.id() as i32, libc::SIGBUS) };
    let output = child.wait_with_output().expect("it ends");
    let told = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{told}");
    assert!(told.contains("its disk is full or has failed") && told.contains("--resume"), "{told}");
    assert!(!folder.exists("x.exr"));
    folder.ends(0, &options(&["-o", "x.exr", "--resume"]));
    assert!(folder.bytes("x.exr") == folder.bytes("whole.exr"));
}

/// A point light a nanometre above a floor makes it 10¹⁸ times as bright as the light is elsewhere: more
/// than the film's integers hold. It is left out, counted and told, and never wraps around.
#[test]
fn what_is_too_large_for_the_film_is_told() {
    let folder = Folder::new("large");
    let scene = |z: f64| {
        format!(
            r#"<scene version="3.0.0"><sensor type="perspective"><float name="fov" value="1e-7"/>
            <transform name="to_world"><lookat origin="0, -3, 3" target="0, 0, 0" up="0, 0, 1"/></transform>
            <film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="8"/></film></sensor>
            <emitter type="point"><point name="position" x="0" y="0" z="{z:e}"/></emitter>
            <shape type="rectangle"/></scene>"#
        )
    };
    for (z, is_told) in [(1e-9, true), (1e-3, false), (1.0, false)] {
        folder.write("scene.xml", scene(z));
        let output = folder.run(&["render", "scene.xml", "--spp=16", "--no-png", "-o", "x.exr"]);
        let told = stderr(&output);
        assert_eq!(output.status.code(), Some(0), "{told}");
        let too_large = told
            .split_once("negative, ")
            .map_or(0, |(_, rest)| rest.split(' ').next().and_then(|word| word.parse().ok()).unwrap_or(0));
        assert_eq!(too_large > 0, is_told, "{told}");
        let picture = folder.picture("x.exr");
        let bad =
            picture.attributes.iter().find(|(name, _)| name == "abbe.badValues").expect("it is counted");
        assert_eq!(bad.1, too_large.to_string());
        assert!(picture.channel("G").expect("a channel").iter().all(|&value| value >= 0.0));
    }
}
