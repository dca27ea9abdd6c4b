//! `abbe study` as its users meet it: a folder that can be continued, tables that parse, slopes that theory
//! knows, and a page that a browser shows.

use crate::common::browser;
use crate::common::folder::{Folder, of_repository, stderr, stdout};
use abbe::output::exr;
use abbe::spectrum::colour::rec709_to_xyz;
use abbe::study::Reference;
use image::DynamicImage;
use image::codecs::png::PngDecoder;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

fn command(folder: &Folder, more: &[&str]) -> Command {
    let scene = of_repository("tests/scenes/study/scene.xml");
    folder.command(&[&["study", &scene, "-o", ".", "--threads", "2"], more].concat())
}

fn study(folder: &Folder, more: &[&str]) -> Output {
    command(folder, more).output().expect("the program starts")
}

/// Rows of a table by column name.
fn table(folder: &Folder) -> Vec<BTreeMap<String, String>> {
    let text = folder.text("runs.csv");
    let mut lines = text.lines().map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
    let names = lines.next().expect("a header");
    lines
        .map(|row| {
            assert_eq!(row.len(), names.len());
            names.iter().cloned().zip(row).collect()
        })
        .collect()
}

/// What does not depend on the machine: all but CPU times.
fn without_times(folder: &Folder) -> Vec<BTreeMap<String, String>> {
    let mut rows = table(folder);
    for row in &mut rows {
        assert!(row.remove("cpu_time_per_replicate_s").is_some_and(|time| time.parse::<f64>().is_ok()));
    }
    rows
}

fn json(folder: &Folder) -> serde_json::Value {
    serde_json::from_slice(&folder.bytes("study.json")).expect("it is JSON")
}

const SMALL: [&str; 6] =
    ["--samplers=independent,sobol", "--spp=1,4,16", "--replicates=16", "--size=16x16", "--seed=3", "-q"];

const FIGURES: [&str; 7] = [
    "error-samples",
    "error-time",
    "errors-at-equal-time",
    "pattern-spectra-radial",
    "pattern-spectra",
    "error-spectra-radial",
    "error-spectra",
];

#[test]
fn a_study_has_tables_plots_and_a_page() {
    let folder = Folder::new("study-small");
    let output = study(&folder, &SMALL);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(output.stderr.is_empty(), "quiet is quiet");
    for name in FIGURES {
        for ending in ["svg", "png"] {
            assert!(folder.exists(&format!("plots/{name}.{ending}")), "{name}.{ending}");
        }
    }
    let page = folder.text("index.html");
    assert!(!page.contains("<script") && !page.contains("src=\"http") && !page.contains("url(http"));
    assert!(!page.contains(">NaN") && !page.contains("\"NaN") && !page.contains(">inf"));

    // Two samplers, three numbers of samples, sixteen replicates.
    let rows = table(&folder);
    assert_eq!(rows.len(), 2 * 3 * 16);
    let relmse = |row: &BTreeMap<String, String>| row["relmse"].parse::<f64>().expect("a number");
    assert!(rows.iter().all(|row| relmse(row).is_finite() && row["bad_values_of_run"] == "0"));
    let mean = |sampler: &str, samples: &str| {
        let of: Vec<f64> = rows
            .iter()
            .filter(|row| row["sampler"] == sampler && row["samples_per_pixel"] == samples)
            .map(relmse)
            .collect();
        of.iter().sum::<f64>() / of.len() as f64
    };
    assert!(mean("sobol", "16") < 0.5 * mean("independent", "16"));

    // The error of independent samples falls by the square root. Two half intervals are about four standard
    // errors.
    let json = json(&folder);
    let series = json["series"].as_array().expect("a list");
    let law = &series.iter().find(|s| s["sampler"] == "independent").expect("it was asked for")["log_rmse_against_log_samples"];
    let [slope, half] = ["slope", "slope_half_width"].map(|name| law[name].as_f64().expect("a number"));
    assert!((slope + 0.5).abs() < 2.0 * half && half < 0.1, "{slope} ± {half}");
    assert!(json["references"][0]["own_relmse_subtracted"].as_f64().is_some_and(|own| own > 0.0));
}

/// The mean error does not change with what it is measured against: the reference's own is subtracted.
#[test]
fn a_noisy_reference_does_not_raise_the_error() {
    let mean = |folder: &Folder| {
        let values: Vec<f64> =
            table(folder).iter().map(|row| row["relmse"].parse().expect("a number")).collect();
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0) / n;
        (mean, variance)
    };
    let (good, noisy) = (Folder::new("study-good-reference"), Folder::new("study-noisy-reference"));
    let settings = ["--samplers=independent", "--spp=64", "--replicates=32", "-q"];
    for (folder, samples) in [(&good, "--reference-spp=4096"), (&noisy, "--reference-spp=64")] {
        let output = study(folder, &[&settings[..], &[samples]].concat());
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    }
    let own = json(&noisy)["references"][0]["own_relmse_subtracted"].as_f64().expect("a number");
    let ((a, variance_a), (b, variance_b)) = (mean(&good), mean(&noisy));
    // The noise of the reference, of which there is one, is averaged over 256 pixels: its variance is
    // uncertain by √(2/256), and so is, within the product of both errors, what it has in common with the
    // replicates.
    let common = own * own * 2.0 / 256.0 + 4.0 * own * a / 256.0;
    let z = (a - b) / (variance_a + variance_b + common).sqrt();
    assert!(z.abs() < 4.0, "{a} and {b}: z = {z}");
    assert!(own > 0.1 * a, "nothing to subtract: {own} of {a}");
}

#[test]
fn every_value_of_a_parameter_is_a_case() {
    let folder = Folder::new("study-cases");
    let more = [&SMALL[..], &["-D", "albedo=0.2,0.8", "--wavelengths=1,4"]].concat();
    let output = study(&folder, &more);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let rows = table(&folder);
    assert_eq!(rows.len(), 4 * 96);
    for (albedo, wavelengths) in [("0.2", "1"), ("0.2", "4"), ("0.8", "1"), ("0.8", "4")] {
        let of = rows
            .iter()
            .filter(|row| row["parameter.albedo"] == albedo && row["wavelengths_per_path"] == wavelengths);
        assert_eq!(of.count(), 96);
    }
    assert!(folder.exists("plots/error-samples-case1.svg"));
}

/// A replicate by the shared estimator is the picture that `abbe render` makes with the seed in the table.
#[test]
fn the_shared_estimator_is_studied_as_it_renders() {
    let folder = Folder::new("study-estimators");
    let picture = ["--spp=16", "--size=16x16"];
    let more = ["--samplers=sobol", "--estimator=plain,shared", "--replicates=4", "--seed=3", "-q"];
    let output = study(&folder, &[&picture[..], &more].concat());
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let rows = table(&folder);
    let of =
        |estimator: &str| -> Vec<_> { rows.iter().filter(|row| row["estimator"] == estimator).collect() };
    assert_eq!((of("plain").len(), of("shared").len()), (4, 4));

    let channels = |name: &str| exr::read(&folder.path(name)).expect("it can be read");
    let reference = Reference::from_channels(&channels("reference-case0.exr"), [16; 2]).expect("it is one");
    let relmse = |row: &BTreeMap<String, String>| row["relmse"].parse::<f64>().expect("a number");
    let mut found = Vec::new();
    for row in of("shared") {
        let scene = of_repository("tests/scenes/study/scene.xml");
        let seed = ["--seed", &row["seed"], "--wavelengths=4", "-q", "-o", "replicate.exr"];
        let rendered = folder.command(&[&["render", &scene][..], &picture, &seed].concat()).output();
        let rendered = rendered.expect("the program starts");
        assert_eq!(rendered.status.code(), Some(0), "{}", stderr(&rendered));
        let file = channels("replicate.exr");
        let [r, g, b] = ["R", "G", "B"].map(|name| file.channel(name).expect("it is there"));
        let y: Vec<f64> = (0..r.len()).map(|i| rec709_to_xyz([r[i], g[i], b[i]].map(f64::from)).y).collect();
        found.push((relmse(row), reference.relmse(&y)));
    }
    let agree = |told: f64, found: f64| (found / told - 1.0).abs() < 0.01;
    assert!(found.iter().all(|&(told, found)| agree(told, found)), "{found:?}");
    // Those of another seed are told from it.
    assert!((1..4).all(|i| !agree(found[0].0, found[i].1)), "{found:?}");
}

#[cfg(unix)]
#[test]
fn an_interrupted_study_is_continued() {
    // Long enough at the end that the signal comes in time.
    let longer = |word: &&'static str| match *word {
        "--spp=1,4,16" => "--spp=1,4,256",
        word => word,
    };
    let settings: Vec<&str> = SMALL.iter().map(longer).chain(["--reference-spp=256"]).collect();
    let (whole, broken) = (Folder::new("study-whole"), Folder::new("study-broken"));
    assert_eq!(study(&whole, &settings).status.code(), Some(0));

    let loud: Vec<&str> = settings.iter().copied().filter(|word| *word != "-q").collect();
    let child = command(&broken, &loud).stderr(Stdio::piped()).spawn().expect("the program starts");
    let runs = || -> Vec<(PathBuf, std::time::SystemTime)> {
        let Ok(entries) = std::fs::read_dir(broken.path("runs")) else { return Vec::new() };
        let finished =
            entries.flatten().filter(|entry| entry.path().extension().is_some_and(|e| e == "json"));
        let mut runs: Vec<_> = finished
            .filter_map(|entry| Some((entry.path(), entry.metadata().ok()?.modified().ok()?)))
            .collect();
        runs.sort();
        runs
    };
    let begun = Instant::now();
    while runs().is_empty() && begun.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(2));
    }
    let signalled = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(signalled.expect("kill can be run").success());
    let output = child.wait_with_output().expect("the program ends");
    assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
    assert!(stderr(&output).contains("the same command continues"), "{}", stderr(&output));
    let before = runs();
    assert!(!before.is_empty() && before.len() < 6, "{} runs", before.len());
    assert!(!broken.exists("index.html"));

    let output = study(&broken, &settings);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let after = runs();
    assert_eq!(after.len(), 6);
    assert!(before.iter().all(|run| after.contains(run)), "a finished run was repeated");
    assert_eq!(without_times(&whole), without_times(&broken));
    assert!(broken.exists("index.html"));
}

#[test]
fn wrong_input_is_2_before_anything_is_rendered() {
    let mine = Folder::new("study-mine");
    let tiny = ["--samplers=sobol", "--spp=1", "--replicates=2", "--size=4x4", "-q"];
    assert_eq!(study(&mine, &tiny).status.code(), Some(0));
    let foreign = Folder::new("study-foreign");
    foreign.write("diary.txt", "dear");
    let fresh = Folder::new("study-fresh");
    let reference = mine.path("reference-case0.exr");
    let reference = format!("--reference={}", reference.display());
    let of_reference = ["--size=5x4", &reference];
    let cases: [(&Folder, &[&str], &str); 9] = [
        (&mine, &["--samplers=sobol", "--spp=1", "--replicates=2", "--size=4x4", "--seed=1"], "seed"),
        (&foreign, &tiny, "empty folder"),
        (&fresh, &["--samplers=sobol,halton"], "bluenoise"),
        (&fresh, &["--spp=5..7"], "powers of two"),
        (&fresh, &["--wavelengths=3"], "1, 4 or 8"),
        (&fresh, &["--replicates=1"], "replicates"),
        (&fresh, &["-D", "colour=1,2"], "colour"),
        (&fresh, &["--reference=none.exr"], "none.exr"),
        (&fresh, &of_reference, "--size"),
    ];
    for (folder, words, expected) in cases {
        let output = study(folder, words);
        assert_eq!(output.status.code(), Some(2), "{words:?}: {}", stderr(&output));
        assert!(stderr(&output).contains(expected), "{words:?}: {}", stderr(&output));
    }
    // What was kept is damaged.
    std::fs::write(mine.path("reference-case0.exr"), "cut").expect("a file can be written");
    let found = stderr(&study(&mine, &tiny));
    assert!(found.contains("reference-case0.exr") && found.contains("help: remove it"), "{found}");
    std::fs::write(mine.path("study.json"), "{").expect("a file can be written");
    let found = stderr(&study(&mine, &tiny));
    assert!(found.contains("study.json is damaged") && found.contains("help: name a new folder"), "{found}");
    assert_eq!(fresh.files().len(), 0);
    assert_eq!(foreign.files().len(), 1);
}

/// Reports where each figure is drawn, in pixels of the page. Only in the copy that is looked at.
const MEASURE: &str = "<script>addEventListener('load', () => { document.body.dataset.figures = \
    [...document.querySelectorAll('figure')].map(f => { const r = f.querySelector('svg').getBoundingClientRect(); \
    return [f.id, r.x, r.y, r.width, r.height].join(' ') }).join(';') })</script>";

fn browse(browser: &Path, folder: &Folder, more: &[&str], page: &str) -> Output {
    browser::headless(browser, &folder.path("profile"))
        .arg("--window-size=1000,8000")
        .args(more)
        .arg(format!("file://{}", folder.path(page).display()))
        .output()
        .expect("the browser starts")
}

/// The page in headless Chromium: every plot has the inks of its curves, every picture the colours of its
/// values.
#[test]
fn a_browser_shows_the_page() {
    let Some(browser) = browser::find() else {
        eprintln!("left out: no chromium on the PATH (validation/study/run installs one)");
        return;
    };
    let folder = Folder::kept("study-page");
    let output = study(&folder, &[&SMALL[..], &["--samplers=all"][..]].concat()[1..]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let page = folder.text("index.html");
    folder.write("measured.html", page.replace("</body>", &format!("{MEASURE}</body>")));
    let dumped = browse(&browser, &folder, &["--dump-dom"], "measured.html");
    let dumped = stdout(&dumped);
    let places = dumped.split_once("data-figures=\"").and_then(|(_, rest)| rest.split_once('"'));
    let places = places.expect("the page tells its figures").0;
    let screenshot = folder.path("page.png");
    let shot = browse(&browser, &folder, &[&format!("--screenshot={}", screenshot.display())], "index.html");
    let file = File::open(&screenshot).unwrap_or_else(|error| panic!("{error}: {}", stderr(&shot)));
    let decoder = PngDecoder::new(BufReader::new(file)).expect("a PNG");
    let image = DynamicImage::from_decoder(decoder).expect("a picture").to_rgb8();

    let mut found = Vec::new();
    for place in places.split(';') {
        let (id, numbers) = place.split_once(' ').expect("a name and numbers");
        let numbers: Vec<f64> = numbers.split(' ').map(|n| n.parse().expect("a number")).collect();
        let [x, y, width, height] = numbers.as_slice() else { panic!("{place}") };
        assert!(
            *x >= 0.0 && y + height <= f64::from(image.height()) && *width > 600.0 && *height > 150.0,
            "{place}"
        );
        let pixels: Vec<[u8; 3]> = (*y as u32..(y + height) as u32)
            .flat_map(|row| (*x as u32..(x + width) as u32).map(move |column| (column, row)))
            .map(|(column, row)| image.get_pixel(column, row).0)
            .collect();
        let share = |of: &dyn Fn(&[u8; 3]) -> bool| {
            pixels.iter().filter(|pixel| of(pixel)).count() as f64 / pixels.len() as f64
        };
        let coloured = |pixel: &[u8; 3]| pixel.iter().max().unwrap() - pixel.iter().min().unwrap() > 25;
        let name = id.rsplit_once('-').expect("a name and a case").0;
        if ["errors-at-equal-time", "pattern-spectra", "error-spectra"].contains(&name) {
            // Six panels fill most of the picture, and not with one colour. No colour of the scales is the
            // paper's white.
            let mut colours: Vec<[u8; 3]> = pixels.iter().filter(|pixel| coloured(pixel)).copied().collect();
            colours.sort_unstable();
            colours.dedup();
            let painted = share(&|pixel| *pixel != [255; 3]);
            assert!(painted > 0.4 && colours.len() > 100, "{id}: {painted} {}", colours.len());
        } else {
            for ink in &abbe::plot::INKS[..6] {
                let near = |pixel: &[u8; 3]| pixel.iter().zip(ink.rgb()).all(|(a, b)| a.abs_diff(b) < 16);
                assert!(share(&near) * pixels.len() as f64 > 25.0, "{id} has no ink {ink}");
            }
        }
        found.push(name.to_owned());
    }
    assert_eq!(found, FIGURES);
}
