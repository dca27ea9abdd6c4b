//! `abbe compare`: a bias is told from noise, figures are as defined, conditions and mistakes end as they
//! should.

use crate::common::folder::{Folder, stderr, stdout};
use abbe::compare::{Options, compare};
use abbe::output::exr::{Channels, write_channels};
use serde_json::Value;
use std::slice::from_ref;

/// A diffuse floor under a lamp, seen past its edge: penumbra, interreflection and nothing rare.
const SCENE: &str = r#"<scene version="3.0.0">
    <default name="power" value="1"/>
    <integrator type="path"><integer name="max_depth" value="4"/></integrator>
    <sensor type="perspective">
        <float name="fov" value="50"/>
        <transform name="to_world"><lookat origin="0, -4, 2.5" target="0, 0, 0.3" up="0, 0, 1"/></transform>
        <film type="hdrfilm"><integer name="width" value="24"/><integer name="height" value="20"/><rfilter type="box"/></film>
    </sensor>
    <shape type="rectangle"><transform name="to_world"><scale value="6"/></transform></shape>
    <shape type="sphere"><point name="center" x="0" y="0" z="0.6"/><float name="radius" value="0.6"/></shape>
    <shape type="disk">
        <transform name="to_world"><scale value="1.2"/><rotate x="1" angle="180"/><translate x="-1.5" y="0" z="3"/></transform>
        <emitter type="area"><spectrum name="radiance" value="$power"/></emitter>
    </shape>
</scene>"#;

fn scene(name: &str) -> Folder {
    let folder = Folder::new(name);
    folder.write("scene.xml", SCENE);
    folder
}

fn render(folder: &Folder, to: &str, further: &[&str]) -> Channels {
    folder.ends(0, &[&["render", "scene.xml", "-q", "-o", to], further].concat());
    folder.picture(to)
}

/// One scene with two seeds differs by noise; made 1 % brighter it is found out, and what was found lies
/// within what the comparison says that it can find.
#[test]
fn a_bias_of_one_percent_is_told_from_noise() {
    let folder = scene("bias");
    let reference = render(&folder, "b.exr", &["--spp", "512", "--seed", "1"]);
    let options = Options::default();
    let other_seed = render(&folder, "a.exr", &["--spp", "512", "--seed", "2"]);
    let same =
        compare(from_ref(&other_seed), from_ref(&reference), &options).expect("files that can be compared");
    let verdict = same.verdict().expect("files with errors");
    assert!(verdict.p > 0.001, "{verdict:?}");
    assert!(same.notes.is_empty(), "{:?}", same.notes);
    assert!(verdict.detectable < 0.01 && verdict.detectable < verdict.detectable_tile, "{verdict:?}");

    let brighter = render(&folder, "c.exr", &["--spp", "512", "--seed", "3", "-D", "power=1.01"]);
    let planted =
        compare(from_ref(&brighter), from_ref(&reference), &options).expect("files that can be compared");
    let verdict = planted.verdict().expect("files with errors");
    assert!(verdict.p < 1e-6 && verdict.p_mean < 1e-6, "{verdict:?}");
    for channel in &planted.channels {
        let tests = channel.tests.as_ref().expect("a channel with errors");
        let expected = (channel.figures.bias - 0.01) / (tests.error / channel.figures.mean_b);
        assert!(expected.abs() < 4.0, "{}: {expected} standard errors from 1 %", channel.name);
    }

    // Without errors one picture counts as exact; without any there is no test.
    let mut bare = reference.clone();
    bare.channels.retain(|(name, _)| !name.starts_with("error."));
    let against_exact =
        compare(from_ref(&other_seed), from_ref(&bare), &options).expect("files that can be compared");
    assert!(
        against_exact.assumptions.iter().any(|note| note.contains("B is one picture that states no errors")),
        "{:?}",
        against_exact.assumptions
    );
    assert!(against_exact.verdict().is_some());
    assert!(
        compare(from_ref(&bare), from_ref(&bare), &options)
            .expect("files that can be compared")
            .verdict()
            .is_none()
    );
}

/// A body before a black background, with a border of black pixels whose errors are those of their
/// neighbours.
const IN_THE_DARK: &str = r#"<scene version="3.0.0">
    <default name="power" value="1"/>
    <integrator type="path"><integer name="max_depth" value="4"/></integrator>
    <sensor type="perspective">
        <float name="fov" value="50"/>
        <transform name="to_world"><lookat origin="0, -4, 0.5" target="0, 0, 0.3" up="0, 0, 1"/></transform>
        <film type="hdrfilm"><integer name="width" value="48"/><integer name="height" value="48"/><rfilter type="box"/></film>
    </sensor>
    <shape type="sphere"><point name="center" x="0" y="0" z="0.3"/><float name="radius" value="0.6"/></shape>
    <shape type="rectangle">
        <transform name="to_world"><scale value="0.5"/><rotate x="1" angle="180"/><translate x="-1.5" y="0" z="3"/></transform>
        <emitter type="area"><spectrum name="radiance" value="$power"/></emitter>
    </shape>
</scene>"#;

/// What `abbe compare --json` prints, and what it says on standard error.
fn compared(folder: &Folder, arguments: &[&str]) -> (Value, String) {
    let output = folder.run(&[&["compare", "--json"], arguments].concat());
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    (serde_json::from_slice(&output.stdout).expect("it is JSON"), stderr(&output))
}

fn number(found: &Value, path: &str) -> f64 {
    found.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("{path} in {found}"))
}

/// Pixels that are black in both pictures say nothing about the law of the p-values: they are counted and
/// left out. Replicates are independent, since the errors that runs of one net tell are a little too wide.
#[test]
fn a_black_background_leaves_the_p_values_uniform() {
    let folder = scene("dark");
    folder.write("scene.xml", IN_THE_DARK);
    render(&folder, "a.exr", &["--spp", "256", "--replicates", "8", "--seed", "1"]);
    render(&folder, "b.exr", &["--spp", "256", "--replicates", "8", "--seed", "2"]);
    let (found, _) = compared(&folder, &["a.exr", "b.exr"]);
    let p = number(&found, "/figures/p_uniform");
    assert!(p > 1e-4, "p = {p}: {found}");
    let of_green = |name: &str| number(&found, &format!("/channels/G/{name}"));
    let histogram = found["channels"]["G"]["p_histogram"].as_array().expect("a histogram");
    let counted: f64 = histogram.iter().filter_map(Value::as_f64).sum();
    assert!(of_green("noiseless") > 1000.0 && of_green("borrowed") > 20.0, "{found}");
    assert_eq!(counted + of_green("noiseless") + of_green("borrowed"), 48.0 * 48.0, "{found}");
    let told = stdout(&folder.run(&["compare", "a.exr", "b.exr"]));
    assert!(told.contains("without noise") && told.contains("equal on both sides or black"), "{told}");

    // A bias is found all the same.
    render(&folder, "c.exr", &["--spp", "256", "--seed", "3", "-D", "power=1.2"]);
    let (found, _) = compared(&folder, &["c.exr", "b.exr"]);
    assert!(number(&found, "/figures/p_mean") < 1e-6, "{found}");
    assert!(number(&found, "/figures/p_uniform") < 1e-6, "{found}");
}

/// Renders of another program state no errors. The spread of several is their error; of one, it is told that
/// none was assumed.
#[test]
fn the_spread_of_several_pictures_is_their_error() {
    let folder = scene("several");
    let seeds: Vec<String> = (1..=8).map(|seed| format!("b{seed}.exr")).collect();
    let names: Vec<&str> = seeds.iter().map(String::as_str).collect();
    for (seed, name) in names.iter().enumerate() {
        render(&folder, name, &["--spp", "16", "--replicates", "1", "--seed", &(seed + 10).to_string()]);
    }
    render(&folder, "a.exr", &["--spp", "64", "--replicates", "8", "--seed", "1"]);
    render(&folder, "brighter.exr", &["--spp", "64", "--seed", "2", "-D", "power=1.05"]);

    // One alone: loudly exact, and its noise passes for bias.
    let (found, warned) = compared(&folder, &["a.exr", "b1.exr"]);
    assert!(warned.starts_with("warning: B is one picture that states no errors"), "{warned}");
    let note = found["notes"][0].as_str().expect("a note");
    assert!(warned.contains(note) && note.contains("several renders"), "{note}");
    assert!(number(&found, "/figures/p_uniform") < 1e-6, "{found}");
    assert_eq!(found["b"]["errors"], Value::Null);

    let against = |pictures: &[&str], references: &[&str]| {
        let (found, warned) = compared(&folder, &[pictures, &["--reference"], references].concat());
        assert_eq!((warned.as_str(), found["notes"].as_array().map(Vec::len)), ("", Some(0)), "{found}");
        found
    };
    let found = against(&["a.exr"], &names);
    assert!(number(&found, "/figures/p") > 1e-3, "{found}");
    assert!(number(&found, "/figures/p_uniform") > 1e-4, "{found}");
    assert_eq!((&found["b"]["errors"], &found["b"]["replicates"]), (&"spread".into(), &8.into()));
    assert_eq!(found["b"]["files"].as_array().map(Vec::len), Some(8));
    let found = against(&["brighter.exr"], &names);
    assert!(number(&found, "/figures/p_mean") < 1e-3, "{found}");
    // On both sides, too.
    let found = against(&names[..4], &names[4..]);
    assert!(number(&found, "/figures/p") > 1e-3, "{found}");
    let (_, warned) = compared(&folder, &[&names[..4], &["--reference", "a.exr"]].concat());
    assert_eq!(warned, "");

    for (arguments, expected) in [
        (vec!["a.exr"], "nothing to compare it with"),
        (vec!["a.exr", "b1.exr", "b2.exr"], "--reference"),
        (
            vec!["a.exr", "--reference", "b1.exr", "b2.exr", "b1.exr"],
            "picture 1 of B and picture 3 of B are equal",
        ),
    ] {
        let output = folder.run(&[&["compare"], arguments.as_slice()].concat());
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(stderr(&output).contains(expected), "{arguments:?}: {}", stderr(&output));
    }
}

/// How often a bias of the size that is called detectable is found: in 90 % of trials.
#[test]
fn what_is_called_detectable_is_found_in_nine_of_ten() {
    use rand_pcg::{Pcg64, rand_core::Rng};
    let mut generator = Pcg64::new(7, 0);
    let mut normal = || -> f64 {
        // Twelve uniform numbers are normal enough for the middle of the distribution.
        (0..12).map(|_| (generator.next_u64() >> 11) as f64 / (1u64 << 53) as f64).sum::<f64>() - 6.0
    };
    // 64 pixels, each measured by 4 replicates of mean 1 and standard deviation 0.2.
    let mut file = |mean: f64| -> Channels {
        let (mut values, mut errors) = (Vec::new(), Vec::new());
        for _ in 0..64 {
            let drawn: Vec<f64> = (0..4).map(|_| mean + 0.2 * normal()).collect();
            let centre = drawn.iter().sum::<f64>() / 4.0;
            let variance = drawn.iter().map(|v| (v - centre).powi(2)).sum::<f64>() / 12.0;
            values.push(centre as f32);
            errors.push(variance.sqrt() as f32);
        }
        Channels {
            width: 8,
            height: 8,
            channels: vec![("Y".to_owned(), values), ("error.Y".to_owned(), errors)],
            attributes: vec![("abbe.replicates".to_owned(), "4".to_owned())],
            ..Channels::default()
        }
    };
    let options = Options { pixels_per_degree: 1.0, ..Options::default() };
    let (trials, mut found, mut false_alarms) = (400, 0, 0);
    let mut detectable = None;
    for _ in 0..trials {
        let b = file(1.0);
        let compared =
            |a: &Channels| compare(from_ref(a), from_ref(&b), &options).expect("files that can be compared");
        let verdict = compared(&file(1.0)).verdict().expect("files with errors");
        false_alarms += u32::from(verdict.p_mean < 0.05);
        let bias = *detectable.get_or_insert(verdict.detectable);
        found += u32::from(compared(&file(1.0 + bias)).verdict().expect("files with errors").p_mean < 0.05);
    }
    // Four standard errors of a share of 400 trials: 0.06 at 90 %, 0.044 at 5 %. The bias itself is known to
    // 5 %.
    let share = |count: u32| f64::from(count) / f64::from(trials);
    assert!((share(found) - 0.9).abs() < 0.08, "{}", share(found));
    assert!((share(false_alarms) - 0.05).abs() < 0.044, "{}", share(false_alarms));
}

/// A file of 2 × 2 pixels.
fn small(channels: &[(&str, [f32; 4])]) -> Channels {
    let channels = channels.iter().map(|(name, values)| ((*name).to_owned(), values.to_vec())).collect();
    Channels { width: 2, height: 2, channels, ..Channels::default() }
}

#[test]
fn figures_are_those_of_their_definitions() {
    let a = small(&[("Y", [1.0, 2.0, 0.0, 6.0])]);
    let b = small(&[("Y", [1.0, 1.0, 0.0, 2.0])]);
    let found =
        compare(from_ref(&a), from_ref(&b), &Options::default()).expect("files that can be compared").figures;
    assert!((found.rmse - (17.0f64 / 4.0).sqrt()).abs() < 1e-12, "{found:?}");
    // mean(B) = 1, so 0.01 is added to each B².
    assert!((found.relmse - (1.0 / 1.01 + 16.0 / 4.01) / 4.0).abs() < 1e-12, "{found:?}");
    assert!((found.smape - (1.0 / 3.0 + 4.0 / 8.0) / 4.0).abs() < 1e-12, "{found:?}");
    assert!((found.bias - 1.25).abs() < 1e-12, "{found:?}");

    // The same colours as RGB and as XYZ differ by the same. A grey of 18 % and one of 20 %, if white is 1:
    // ΔL* = 2.34, whose ΔE2000 is that over S_L.
    let grey = |value: f32| small(&[("R", [value; 4]), ("G", [value; 4]), ("B", [value; 4])]);
    let options = Options { white: Some(1.0), ..Options::default() };
    let seen = compare(&[grey(0.2)], &[grey(0.18)], &options)
        .expect("files that can be compared")
        .seen
        .expect("colours");
    let l = |y: f64| 116.0 * y.cbrt() - 16.0;
    let (difference, middle) = (l(0.2) - l(0.18), 0.5 * (l(0.2) + l(0.18)) - 50.0);
    let expected = difference / (1.0 + 0.015 * middle * middle / (20.0 + middle * middle).sqrt());
    assert!((seen.delta_e - expected).abs() < 1e-5, "{}, expected {expected}", seen.delta_e);
    // Left alone, white makes the reference's mean a middle grey.
    let seen =
        compare(&[grey(4.0)], &[grey(3.6)], &Options::default()).expect("comparable").seen.expect("colours");
    assert!((seen.white - 20.0).abs() < 1e-5 && (seen.delta_e - expected).abs() < 1e-5, "{seen:?}");
}

/// The pixels where A is too bright, the brightest first: not those where it is too dark, nor where it is the
/// same.
#[test]
fn the_brightest_outliers_are_named() {
    let a = small(&[("Y", [1.5, 2.0, 0.0, 6.0])]);
    let b = small(&[("Y", [1.0, 2.0, 9.0, 2.0])]);
    let found = compare(from_ref(&a), from_ref(&b), &Options::default()).expect("comparable");
    let outliers: Vec<_> = found.outliers.iter().map(|outlier| (outlier.pixel, outlier.values)).collect();
    assert_eq!(outliers, [([1, 1], [6.0, 2.0]), ([0, 0], [1.5, 1.0])]);
    let files: [&[String]; 2] = [&["a.exr".to_owned()], &["b.exr".to_owned()]];
    let table = found.table(files);
    assert!(
        table.contains("at pixels 1,1 (6.00 for 2.00), 0,0") && table.contains("abbe explain"),
        "{table}"
    );
    let json: Value = serde_json::from_str(&found.json(files)).expect("it is JSON");
    assert_eq!(json["outliers"][0]["pixel"], serde_json::json!([1, 1]));
    assert_eq!(json["outliers"][1]["a"], 1.5);
}

/// Pixels that are not finite are counted and left out; files of responses have no colours but figures of
/// each channel; layers and half floats of other programs are understood.
#[test]
fn odd_files_are_compared_as_far_as_they_go() {
    let a = small(&[("Y", [1.0, f32::NAN, 2.0, 3.0])]);
    let b = small(&[("Y", [1.0, 2.0, f32::INFINITY, 3.0])]);
    let compared =
        compare(from_ref(&a), from_ref(&b), &Options::default()).expect("files that can be compared");
    assert_eq!((compared.bad, compared.figures.rmse), ([1, 1], 0.0));
    assert!(compared.notes.iter().any(|note| note.contains("1 of 4 pixels of A")), "{:?}", compared.notes);

    let responses = small(&[("green", [1.0; 4]), ("red", [2.0; 4]), ("samples", [64.0; 4])]);
    let compared = compare(from_ref(&responses), from_ref(&responses), &Options::default())
        .expect("files that can be compared");
    assert!(compared.seen.is_none() && compared.channels.len() == 2);

    let mut layered =
        small(&[("beauty.R", [0.5; 4]), ("beauty.G", [0.5; 4]), ("beauty.B", [0.5; 4]), ("dn.X", [0.0; 4])]);
    layered.half = layered.channels.iter().map(|(name, _)| name.clone()).collect();
    let compared = compare(from_ref(&layered), from_ref(&layered), &Options::default())
        .expect("files that can be compared");
    assert!(compared.seen.as_ref().is_some_and(|seen| seen.delta_e == 0.0 && seen.hdr_flip == 0.0));
    assert_eq!(compared.notes[0], "the colours are those of the layer beauty");

    // Colours are compared whatever layer they are of.
    let plain = small(&[("R", [0.5; 4]), ("G", [0.5; 4]), ("B", [0.25; 4])]);
    let compared = compare(from_ref(&layered), from_ref(&plain), &Options::default())
        .expect("files that can be compared");
    let names: Vec<&str> = compared.channels.iter().map(|channel| channel.name.as_str()).collect();
    assert_eq!(names, ["R", "G", "B"]);
    assert_eq!(compared.channels[2].figures.bias, 1.0);
    let told = [
        "the colours of A are those of the layer beauty, of B those of no layer",
        "only A has dn.X: left out",
    ];
    assert!(told.iter().all(|told| compared.notes.iter().any(|note| note == told)), "{:?}", compared.notes);
    let other_kind = small(&[("other.X", [0.5; 4]), ("other.Y", [0.5; 4]), ("other.Z", [0.25; 4])]);
    let refused = compare(from_ref(&layered), from_ref(&other_kind), &Options::default());
    let refused = refused.expect_err("nothing is converted").to_string();
    let told = "A has beauty.R, beauty.G, beauty.B, and B has other.X, other.Y, other.Z";
    assert!(refused.contains(told) && refused.contains("xyz (X, Y, Z)"), "{refused}");
    // Files of others: what is named as an image of the scene, alpha or depth is not light.
    let beside = [("A", [1.0; 4]), ("Layer.Normal.X", [0.0; 4]), ("Z", [3.0; 4]), ("albedo.R", [0.5; 4])];
    let colours = [("R", [0.5; 4]), ("G", [0.5; 4]), ("B", [0.25; 4])];
    let errors = ["error.R", "error.G", "error.B", "error.Z"].map(|name| (name, [0.1; 4]));
    let others = small(&[&beside[..], &colours[..], &errors[..]].concat());
    let compared = compare(from_ref(&others), from_ref(&others), &Options::default())
        .expect("files that can be compared");
    let tested = compared.channels.iter().filter(|channel| channel.tests.is_some());
    assert_eq!(tested.map(|channel| channel.name.as_str()).collect::<Vec<_>>(), ["R", "G", "B"]);
    assert_eq!(
        compared.notes[0],
        "not of light, and so compared but not tested: A, Layer.Normal.X, Z, albedo.R"
    );
}

/// Spectral bins come before colours in a file, and do not hide them where these are of two kinds.
#[test]
fn colours_of_two_kinds_are_told_without_what_is_beside_them() {
    let with_bins = |colours: [&'static str; 3]| {
        let bins = (0..20).map(|bin| format!("S0.{bin},000000nm"));
        let names: Vec<String> = bins.chain(colours.map(str::to_owned)).collect();
        small(&names.iter().map(|name| (name.as_str(), [0.5; 4])).collect::<Vec<_>>())
    };
    let [a, b] = [with_bins(["X", "Y", "Z"]), with_bins(["B", "G", "R"])];
    let refused = compare(&[a], &[b], &Options::default()).expect_err("nothing is converted").to_string();
    assert!(refused.contains("A has X, Y, Z, and B has R, G, B\n"), "{refused}");
}

#[test]
fn observers_and_ranges_that_differ_are_told() {
    let made = |observer: &str, range: &str| {
        let attributes = [("abbe.observer", observer), ("abbe.wavelengthRange", range)];
        let attributes = attributes.map(|(name, value)| (name.to_owned(), value.to_owned())).to_vec();
        Channels { attributes, ..small(&[("R", [0.5; 4]), ("G", [0.5; 4]), ("B", [0.25; 4])]) }
    };
    let notes = |a: Channels, b: Channels| {
        compare(&[a], &[b], &Options::default()).expect("files that can be compared").notes.join("\n")
    };
    let all = "360 nm to 830 nm";
    let told = notes(made("CIE 1931 2°", all), made("CIE 1964 10°", all));
    assert!(told.contains("the observers differ (A: CIE 1931 2°, B: CIE 1964 10°)"), "{told}");
    assert!(!told.contains("ranges"), "{told}");
    let told = notes(made("CIE 1931 2°", all), made("CIE 1931 2°", "400 nm to 700 nm"));
    assert!(told.contains("the ranges of wavelengths differ (A: 360 nm to 830 nm, B: 400 nm"), "{told}");
    assert!(!told.contains("observers"), "{told}");
}

/// Images beside the picture, whatever they are called, change neither the number of tests nor what they
/// find.
#[test]
fn only_light_is_tested() {
    let folder = scene("light");
    let images = "--aov=a:albedo,depth,position,uv,geo_normal,sh_normal,dp_du,prim_index,shape_index";
    for (seed, plain, with_images) in [("1", "a.exr", "c.exr"), ("2", "b.exr", "d.exr")] {
        render(&folder, plain, &["--spp", "16", "--seed", seed, "--spectral", "2"]);
        render(&folder, with_images, &["--spp", "16", "--seed", seed, "--spectral", "2", images]);
    }
    let (plain, _) = compared(&folder, &["a.exr", "b.exr"]);
    let (with_images, _) = compared(&folder, &["c.exr", "d.exr"]);
    let tests = |found: &Value| -> Vec<String> {
        let channels = found["channels"].as_object().expect("channels").iter();
        channels.filter(|(_, of)| of["p_mean"].is_number()).map(|(name, _)| name.clone()).collect()
    };
    assert_eq!(tests(&plain).len(), 5, "{plain}");
    assert_eq!(tests(&plain), tests(&with_images));
    assert_eq!(plain["figures"], with_images["figures"]);
    assert!(with_images["channels"]["a.R"]["rmse"].is_number(), "{with_images}");
    assert!(with_images["notes"][0].as_str().is_some_and(|note| note.contains("not tested: a.B")));
    let table = stdout(&folder.run(&["compare", "c.exr", "d.exr"]));
    assert!(!table.contains("NaN") && !table.contains("inf"), "{table}");
}

/// A part of a film and a whole film of its size may show different things.
#[test]
fn pictures_of_different_parts_are_told() {
    let folder = scene("parts");
    render(&folder, "part.exr", &["--spp", "4", "--crop", "8,4,8,8"]);
    render(&folder, "same.exr", &["--spp", "4", "--crop", "8,4,8,8", "--seed", "2"]);
    render(&folder, "whole.exr", &["--spp", "4", "--size", "8x8", "--seed", "2"]);
    let (found, warned) = compared(&folder, &["part.exr", "whole.exr"]);
    let note = "A begins at pixel 8,4 of its film and B at 0,0 (their data windows differ)";
    assert!(warned.contains(note), "{warned}");
    assert!(found["notes"][0].as_str().is_some_and(|told| told.contains(note)), "{found}");
    assert_eq!(compared(&folder, &["part.exr", "same.exr"]).1, "");
    let mut first = folder.picture("part.exr");
    first.layout.other_parts = ["depth", "diffuse"].map(str::to_owned).to_vec();
    let found = compare(&[first], &[folder.picture("same.exr")], &Options::default())
        .expect("files that can be compared");
    assert_eq!(found.notes, ["A is the first part of its file; it also has depth, diffuse"]);
    assert!(found.assumptions.is_empty(), "{:?}", found.assumptions);
}

#[test]
fn conditions_decide_the_exit_code_and_mistakes_are_2() {
    let folder = scene("conditions");
    render(&folder, "a.exr", &["--spp", "16", "--seed", "1"]);
    render(&folder, "b.exr", &["--spp", "16", "--seed", "2"]);
    render(&folder, "small.exr", &["--spp", "4", "--size", "4x4"]);
    render(&folder, "spectral.exr", &["--spp", "16", "--seed", "3", "--spectral", "2"]);
    let bare =
        [("R", 0.5), ("G", 0.5), ("B", 0.25)].map(|(name, value)| (name.to_owned(), vec![value; 24 * 20]));
    write_channels(&folder.path("bare.exr"), [24, 20], &bare).expect("a file can be written");
    let y = [("Y".to_owned(), vec![0.5; 24 * 20])];
    write_channels(&folder.path("y.exr"), [24, 20], &y).expect("a file can be written");
    folder.write("broken.exr", b"v/1\x01 and no more");

    // Equal files: every figure of difference is zero.
    let output = folder.run(&[
        "compare",
        "a.exr",
        "a.exr",
        "--json",
        "--fail-if",
        "relmse>0",
        "--fail-if",
        "hdr_flip>0",
        "--fail-if",
        "p<1",
    ]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let told = stdout(&output);
    assert!(
        told.contains("\"delta_e\": 0.0")
            && told.contains("\"p\": 1.0")
            && told.contains("share their noise"),
        "{told}"
    );

    for (arguments, code, expected) in [
        (vec!["a.exr", "b.exr", "--fail-if", "R.rmse>0"], 1, "failed: R.rmse > 0"),
        (vec!["a.exr", "b.exr", "--fail-if", "p<1e-6", "--fail-if", "flip>=0"], 1, "failed: flip >= 0"),
        (vec!["spectral.exr", "b.exr", "--fail-if", "p<1e-6"], 0, ""),
        (vec!["a.exr", "b.exr", "--fail-if", "relmes>1"], 2, "relmse"),
        (vec!["a.exr", "b.exr", "--fail-if", "relmse=1"], 2, "relmse>1e-3"),
        (vec!["bare.exr", "bare.exr", "--fail-if", "p<0.1"], 2, "error.*"),
        (vec!["bare.exr", "bare.exr", "--z", "z.png"], 2, "error.*"),
        (vec!["a.exr", "y.exr"], 2, "pixel_format"),
        (vec!["a.exr", "small.exr"], 2, "--size"),
        (
            vec!["a.exr", "--reference", "b.exr", "small.exr"],
            2,
            "picture 1 of B has 24×20 pixels, picture 2 of B 4×4",
        ),
        (vec!["a.exr", "--reference", "b.exr", "y.exr"], 2, "pixel_format"),
        (vec!["a.exr", "none.exr"], 2, "none.exr"),
        (vec!["a.exr", "broken.exr"], 2, "OpenEXR"),
        (vec!["a.exr", "scene.xml"], 2, "OpenEXR"),
        (vec!["a.exr", "b.exr", "--z", "z.jpg"], 2, "*.png"),
        (vec!["a.exr", "b.exr", "--z", "b.exr"], 2, "another name"),
        (vec!["a.exr", "b.exr", "--flip", "no/such/f.png"], 2, "folder"),
        (vec!["a.exr", "b.exr", "--flip", "d.exr", "--difference", "d.exr"], 2, "into one file"),
        (vec!["a.exr", "b.exr", "--z", "./d.exr", "--p-values", "d.exr"], 2, "into one file"),
        (vec!["a.exr", "b.exr", "--difference", "d.exr", "--fail-if", "what>1"], 2, "what"),
    ] {
        let output = folder.run(&[&["compare"], arguments.as_slice()].concat());
        let told = stderr(&output);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {told}");
        assert!(told.contains(expected), "{arguments:?}: {told}");
    }
    let written = folder.files().len();
    assert_eq!(written, 12, "no picture of a comparison that failed");

    let maps = ["--difference", "d.exr", "--z", "z.exr", "--p-values", "p.png", "--flip", "f.png"];
    let output = folder.run(&[&["compare", "a.exr", "b.exr"], maps.as_slice()].concat());
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let [a, b, d, z] = ["a.exr", "b.exr", "d.exr", "z.exr"].map(|name| folder.picture(name));
    let value =
        |file: &Channels, name: &str| f64::from(file.channel(name).expect("the channel is there")[100]);
    let difference = value(&a, "G") - value(&b, "G");
    let error = value(&a, "error.G").hypot(value(&b, "error.G"));
    assert!((value(&d, "G") - difference).abs() < 1e-6 * difference.abs());
    assert!((value(&z, "G") - difference / error).abs() < 1e-5 * (difference / error).abs());
    for name in ["p.png", "f.png"] {
        assert!(folder.bytes(name).starts_with(b"\x89PNG"));
    }
}
