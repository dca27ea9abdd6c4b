//! `abbe explain`: what is told of a sample is what the film has of it.

use crate::common::folder::{Folder, of_repository, stderr, stdout};
use crate::common::{compiled, described, described_file, expose, settings};
use abbe::film::Film;
use abbe::integrator::{Estimator, Step};
use abbe::render::{Explained, Settings, Wanted, WavelengthCount, explain};
use abbe::scene::{CompileOptions, Scene};

fn sum(lists: impl Iterator<Item = Vec<f64>>, lanes: usize) -> Vec<f64> {
    lists.fold(vec![0.0; lanes], |sum, list| sum.iter().zip(list).map(|(a, b)| a + b).collect())
}

#[track_caller]
fn same(a: &[f64], b: &[f64], what: &str) {
    let size = b.iter().map(|value| value.abs()).fold(1e-300, f64::max);
    assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-9 * size), "{what}: {a:?} for {b:?}");
}

/// The light that the steps tell of.
fn told(explained: &Explained) -> Vec<f64> {
    let parts = explained.steps.iter().filter_map(|told| match &told.step {
        Step::Found { contribution } | Step::LightSample { contribution, .. } => Some(contribution.clone()),
        _ => None,
    });
    sum(parts, explained.wavelengths.len())
}

fn at(scene: &Scene, settings: &Settings, pixel: [u32; 2], wanted: Wanted) -> Explained {
    explain(scene, settings, pixel, wanted).unwrap_or_else(|problem| panic!("{problem}"))
}

/// Whether the samples that are told of a pixel make up what the film has of it.
#[track_caller]
fn same_as_film(told: &Explained, film: &Film, [x, y]: [u32; 2], what: &str) {
    let (found, exact) = (told.pixel_luminance, film.combined(x, y, [0.0, 1.0, 0.0]).mean);
    assert!((found - exact).abs() <= 1e-5 * exact.abs() + 1e-9, "{what}: {found}, not {exact}");
}

/// Pixels that share nothing are followed in lanes, several samples of each at a time. Each has the path that
/// it has alone, up to rounding. The lights of these scenes are sampled by their values alone: random lines,
/// by which others are, turn on their last bits.
#[test]
fn paths_that_are_followed_together_are_those_of_each_alone() {
    const SCENES: [&str; 15] = [
        "absorption",
        "brighter",
        "caustics",
        "chamber",
        "contact",
        "diffuse",
        "dispersion",
        "extentless",
        "frosted",
        "lamps",
        "lines",
        "metals",
        "motion",
        "solids",
        "veils",
    ];
    let settings = settings(8, WavelengthCount::Four, 3);
    for name in SCENES {
        let description = described_file(&format!("tests/scenes/agreement/{name}.xml"), &[]);
        let scene = compiled(&description, &CompileOptions::default());
        let film = expose(&scene, &settings);
        let [width, height] = scene.film.extent.whole;
        let mut lit = 0;
        for place in (0..width * height).step_by(3) {
            let pixel = [place % width, place / width];
            for number in [0, 7] {
                let what = format!("{name}, sample {number} of pixel {pixel:?}");
                let told = at(&scene, &settings, pixel, Wanted::Sample(number));
                same(&told.radiance, &told.path_radiance, &what);
                if scene.light_tracing().is_none() {
                    same_as_film(&told, &film, pixel, &what);
                }
                lit += usize::from(told.path_radiance.iter().any(|&value| value > 0.0));
            }
        }
        assert!(lit > 10, "{name}: {lit}");
    }
}

/// Scenes with glass that paths split at, dispersion, surfaces in contact, and media that scatter.
#[test]
fn the_samples_of_a_pixel_make_up_what_the_film_has_and_steps_make_up_a_sample() {
    let mut branches = 0;
    for file in [
        "scenes/box/scene.xml",
        "tests/scenes/agreement/caustics.xml",
        "tests/scenes/agreement/dispersion.xml",
        "tests/scenes/agreement/contact.xml",
        "tests/scenes/agreement/fog.xml",
    ] {
        let mut description = described_file(file, &[]);
        (description.sensor.film.width, description.sensor.film.height) = (16, 12);
        let scene = compiled(&description, &CompileOptions::default());
        let pixels = |estimator| if estimator == Estimator::Plain { 2 } else { 1 };
        for (count, estimator) in [
            (WavelengthCount::Four, Estimator::Plain),
            (WavelengthCount::Four, Estimator::Shared),
            (WavelengthCount::One, Estimator::Plain),
        ] {
            let settings = Settings { estimator, ..settings(8, count, 3) };
            let film = expose(&scene, &settings);
            let [width, height] = scene.film.extent.whole;
            let places = [[width / 2, height / 2], [width / 3, 2 * height / 3]];
            for pixel in places.into_iter().take(pixels(estimator)) {
                let what = format!("{file}, {estimator:?}, {count}, pixel {pixel:?}");
                let brightest = at(&scene, &settings, pixel, Wanted::Brightest);
                if scene.light_tracing().is_none() {
                    same_as_film(&brightest, &film, pixel, &what);
                }
                for number in [0, 5] {
                    let own = at(&scene, &settings, pixel, Wanted::Sample(number));
                    assert_eq!((own.pixel, own.sample, own.samples), (pixel, number, 8), "{what}");
                    let most = brightest.share_of_pixel.abs();
                    assert!(own.share_of_pixel.abs() <= most * (1.0 + 1e-9), "{what}: {number} is brighter");
                    same(&told(&own), &own.path_radiance, &what);
                    branches += own.steps.iter().filter(|t| matches!(t.step, Step::Branch { .. })).count();
                    match &own.shared {
                        None => {
                            assert_eq!(own.path_radiance, own.radiance, "{what}: not the sample's own path");
                            let begins = &own.steps[0].step;
                            assert!(!matches!(begins, Step::Scatter { .. } | Step::End { .. }), "{what}");
                            let ends =
                                own.steps.iter().filter(|t| matches!(t.step, Step::End { .. })).count();
                            assert!(ends >= 1, "{what}: no end is told");
                        }
                        Some(shared) => {
                            let parts = shared.parts.iter().map(|part| part.radiance.clone());
                            let all = sum(parts.chain([shared.own.clone()]), own.radiance.len());
                            same(&all, &own.radiance, &what);
                        }
                    }
                }
            }
        }
    }
    assert!(branches > 0, "no path splits: nothing is tested of branches");
}

#[test]
fn the_program_tells_and_draws_a_sample() {
    let folder = Folder::new("explain");
    let scene = of_repository("scenes/box/scene.xml");
    let ask = |more: &[&str]| {
        let common = ["explain", &scene, "--size=40x30", "--spp=8", "--estimator=plain"];
        folder.run(&[&common[..], more].concat())
    };
    let output = ask(&["--pixel=20,15", "--svg=path.svg"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let told = stdout(&output);
    for part in ["pixel ", "hero", "surface: shape", "throughput", "light sample", "ends: "] {
        assert!(told.contains(part), "{part}: {told}");
    }
    let svg = folder.text("path.svg");
    assert!(svg.contains("<svg") && svg.matches("<circle").count() >= 2, "{svg}");
    let output = ask(&["--pixel=20,15", "--sample=3", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&stdout(&output)).expect("valid JSON");
    assert_eq!(json["sample"], 3);
    assert_eq!(json["wavelengths"].as_array().map(Vec::len), Some(4));
    assert!(json["steps"].as_array().is_some_and(|steps| steps.iter().any(|step| step["step"] == "end")));
    for (wrong, expected) in [
        (vec!["--pixel=40,0"], "no pixel 40,0"),
        (vec!["--pixel=20,15", "--sample=8"], "8 samples"),
        (vec!["--pixel=20"], "X,Y"),
        (vec!["--pixel=20,15", "--svg=path.txt"], ".svg"),
    ] {
        let output = ask(&wrong);
        assert_eq!(output.status.code(), Some(2), "{wrong:?}");
        assert!(stderr(&output).contains(expected), "{wrong:?}: {}", stderr(&output));
    }
}

/// A triangle in the plane z = 0 whose vertices say that it is tilted, and a flat floor beside it.
#[test]
fn a_shading_normal_is_told_where_it_is_another() {
    let folder = Folder::new("shading-normal");
    folder.write("t.obj", "v -9 -9 0\nv 0 -9 0\nv 0 9 0\nv -9 9 0\nvn 0.6 0 0.8\nf 1//1 2//1 3//1 4//1\n");
    folder.write(
        "made.xml",
        r#"<scene version="3.0.0"><integrator type="path"/>
    <sensor type="orthographic">
        <transform name="to_world"><lookat origin="0, 0, 4" target="0, 0, 0" up="0, 1, 0"/></transform>
        <film type="hdrfilm"><integer name="width" value="16"/><integer name="height" value="16"/></film>
    </sensor>
    <shape type="obj"><string name="filename" value="t.obj"/></shape>
    <shape type="rectangle"><transform name="to_world"><scale value="9"/><translate z="-1"/></transform></shape>
    <emitter type="constant"/></scene>"#,
    );
    let ask = |pixel: &str, more: &[&str]| {
        let common = ["explain", "made.xml", "--spp=4", "--estimator=plain", "--sample=0", pixel];
        let output = folder.run(&[&common[..], more].concat());
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        stdout(&output)
    };
    let seen = |pixel: &str| {
        let json: serde_json::Value = serde_json::from_str(&ask(pixel, &["--json"])).expect("valid JSON");
        let steps = json["steps"].as_array().expect("steps").clone();
        let first = steps.into_iter().find(|step| step["step"] == "surface").expect("a surface");
        assert_eq!(first["normal"], serde_json::json!([0.0, 0.0, 1.0]));
        first["shading_normal"].clone()
    };
    let (tilted, flat) = ("--pixel=3,8", "--pixel=12,8");
    assert!(
        ask(tilted, &[])
            .contains("normal (0.00000, 0.00000, 1.00000), shading normal (0.60000, 0.00000, 0.80000)")
    );
    assert!(!ask(flat, &[]).contains("shading"), "{}", ask(flat, &[]));
    let axes: Vec<f64> = serde_json::from_value(seen(tilted)).expect("three numbers");
    assert!((axes[0] - 0.6).abs() < 1e-6 && (axes[2] - 0.8).abs() < 1e-6, "{axes:?}");
    assert!(seen(flat).is_null());
}

#[test]
fn of_a_black_pixel_its_own_sample_is_told() {
    let scene = {
        let mut description = described(r#"<sensor type="perspective"/>"#);
        (description.sensor.film.width, description.sensor.film.height) = (16, 12);
        compiled(&description, &CompileOptions::default())
    };
    let pixel = [5, 3];
    let told = at(&scene, &settings(8, WavelengthCount::Four, 3), pixel, Wanted::Brightest);
    assert_eq!((told.pixel, told.sample, told.pixel_luminance), (pixel, 0, 0.0));
}

/// What `docs/counting-and-explaining.md` shows: the pixel that `abbe compare` names is mostly one sample,
/// which saw the lamp in the polished ring.
#[test]
fn a_firefly_is_explained() {
    let folder = Folder::new("firefly");
    let scene = of_repository("tests/scenes/firefly.xml");
    let run = |arguments: &[&str]| {
        let output = folder.run(arguments);
        assert!(output.status.success(), "{}", stderr(&output));
        stdout(&output)
    };
    let noisy = ["--seed", "1", "--estimator", "plain"];
    run(&[&["render", &scene, "--no-png", "-q", "-o", "noisy.exr"], &noisy[..]].concat());
    run(&["render", &scene, "--no-png", "-q", "--seed", "2", "--spp", "128", "-o", "reference.exr"]);
    let told = run(&["compare", "noisy.exr", "reference.exr"]);
    let (_, named) = told.split_once("at pixels ").expect("compare names pixels");
    let (pixel, _) = named.split_once(' ').expect("the brightest");
    let text = run(&[&["explain", &scene, "--pixel", pixel], &noisy[..]].concat());
    let (_, makes) = text.split_once("it makes ").expect("a share of the pixel");
    let percent: f64 = makes.split(' ').next().and_then(|word| word.parse().ok()).expect("a number");
    assert!(percent > 50.0, "{text}");
    // The ring is the file's third shape.
    let (_, at_ring) = text.split_once("surface: shape 3").expect("it met the ring");
    let (_, brings) = at_ring.split_once("brings ").expect("the lamp is seen from there");
    let brings: f64 = brings.split_whitespace().next().and_then(|word| word.parse().ok()).expect("a number");
    assert!(brings > 1.0, "{text}");
}
