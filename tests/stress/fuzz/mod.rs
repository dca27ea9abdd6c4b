//! Files with mistakes that nobody thought of: what the repository has, changed at random, and scenes made of
//! everything that the reader knows. Nothing panics, nothing takes long, and memory stays within a small
//! factor of what is read. What is accepted is compiled, now and then rendered, and comes back from its own
//! JSON.
//!
//! The cases are numbered, and each is the same in every run. `ABBE_STRESS=full` tries a million.
//! `ABBE_FUZZ_CASES` sets how many are tried and `ABBE_FUZZ_START` from which on. A case runs on one thread,
//! so that its time and its memory are told from those of what else runs.

mod change;
mod grammar;
mod measure;
mod packed;

use crate::common::folder::Folder;
use crate::common::stress;
use abbe::integrator::Estimator;
use abbe::render::{NoProgress, Schedule, Settings, WavelengthCount, render};
use abbe::scene::{CompileOptions, ReadOptions, compile, json, read, read_str};
use change::{Random, change};
use grammar::Grammar;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// How many cases are tried where the environment does not say.
const CASES: u64 = 6000;
const ALL_CASES: u64 = 1_000_000;

/// Most CPU time for one case: what else the machine does is not its fault.
const LONGEST: Duration = Duration::from_secs(5);

/// Most memory for one case: what the program needs for any scene, and a multiple of what is read.
const LEAST_MEMORY: usize = 16 << 20;
const MEMORY_FACTOR: usize = 100;

/// An image of one colour may be a thousandth as long as its texels; these are held as bytes, as floats and
/// as spectra.
const IMAGE_FACTOR: usize = 1100 * (1 + 3 * 4);

/// A scene may ask for terrain of 2²² points in a word, which is computed in complex numbers.
const TERRAIN_MEMORY: usize = 48 << 22;

/// The texture of a lamp may have lines so fine that light samples are guided by 2²² cells, each of which
/// takes less than this while they are made.
const GUIDE_MEMORY: usize = 64 << 22;

/// And a mesh to be cut into 2²⁰ triangles, each of which takes less than this when it is ready to be
/// rendered.
const SUBDIVIDED_MEMORY: usize = 400 << 20;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Scene,
    Mesh(&'static str),
    Spectrum,
    /// With the extension of its name.
    Image(&'static str),
    Volume,
}

impl Kind {
    fn of(extension: &str) -> Option<Self> {
        const IMAGES: [&str; 9] = ["png", "jpg", "exr", "hdr", "pfm", "bmp", "tga", "ppm", "pgm"];
        Some(match extension {
            "xml" | "json" => Self::Scene,
            "ply" => Self::Mesh("ply"),
            "obj" => Self::Mesh("obj"),
            "serialized" => Self::Mesh("serialized"),
            "spd" => Self::Spectrum,
            "vol" => Self::Volume,
            _ => Self::Image(IMAGES.into_iter().find(|image| *image == extension)?),
        })
    }
}

/// A file to begin with, and the folder that its names refer to.
struct Original {
    kind: Kind,
    bytes: Vec<u8>,
    folder: PathBuf,
    is_broken: bool,
}

/// All files of the repository that a scene is made of, and each scene as JSON.
fn originals() -> Vec<Original> {
    let mut found = Vec::new();
    let mut folders: Vec<PathBuf> =
        ["scenes", "tests/scenes", "validation/mitsuba/scenes"].map(PathBuf::from).to_vec();
    let mut paths = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).expect("a folder of scenes") {
            let path = entry.expect("an entry").path();
            if path.is_dir() { folders.push(path) } else { paths.push(path) }
        }
    }
    paths.sort();
    for path in paths {
        let extension = path.extension().and_then(|extension| extension.to_str());
        let Some(kind) = extension.and_then(Kind::of) else { continue };
        let bytes = std::fs::read(&path).expect("a readable file");
        // Many small cases find more than few large ones.
        if bytes.len() > 100_000 {
            continue;
        }
        let folder = path.parent().expect("a folder").to_owned();
        let is_broken = path.components().any(|part| part.as_os_str() == "broken");
        if kind == Kind::Scene
            && let Ok(description) = read(&path, &ReadOptions::default())
            && let Ok(scene) = compile(&description, &CompileOptions::default())
        {
            let bytes = json(&description, &scene.features(), Some(&folder)).into_bytes();
            found.push(Original { kind, bytes, folder: folder.clone(), is_broken: false });
        }
        found.push(Original { kind, bytes, folder, is_broken });
    }
    found
}

/// Reads, compiles and now and then renders what a case gives. Whether the scene was accepted.
fn attempt(kind: Kind, bytes: &[u8], folder: &Path, scratch: &Path, draw: bool) -> bool {
    let options = ReadOptions::default();
    let description = match kind {
        Kind::Scene => {
            // Texts come from files and strings; what is no text is refused by the former.
            let text = String::from_utf8_lossy(bytes).into_owned();
            read_str(text, &folder.join("scene.xml"), &options)
        }
        Kind::Mesh(plugin) => {
            let name = format!("mesh.{plugin}");
            std::fs::write(scratch.join(&name), bytes).expect("a file can be written");
            let text = format!(
                "<scene version=\"3.0.0\"><sensor type=\"perspective\"/><emitter type=\"constant\"/>\
                 <shape type=\"{plugin}\"><string name=\"filename\" value=\"{name}\"/></shape></scene>"
            );
            read_str(text, &scratch.join("scene.xml"), &options)
        }
        Kind::Spectrum => {
            std::fs::write(scratch.join("table.spd"), bytes).expect("a file can be written");
            let text = "<scene version=\"3.0.0\"><sensor type=\"perspective\"/>\
                        <emitter type=\"constant\"><spectrum name=\"radiance\" filename=\"table.spd\"/></emitter></scene>";
            read_str(text, &scratch.join("scene.xml"), &options)
        }
        Kind::Image(extension) => {
            let name = format!("image.{extension}");
            std::fs::write(scratch.join(&name), bytes).expect("a file can be written");
            let text = format!(
                "<scene version=\"3.0.0\"><sensor type=\"perspective\"/>\
                 <emitter type=\"envmap\"><string name=\"filename\" value=\"{name}\"/></emitter><shape type=\"sphere\">\
                 <bsdf type=\"diffuse\"><texture type=\"bitmap\" name=\"reflectance\">\
                 <string name=\"filename\" value=\"{name}\"/></texture></bsdf></shape></scene>"
            );
            read_str(text, &scratch.join("scene.xml"), &options)
        }
        Kind::Volume => {
            std::fs::write(scratch.join("grid.vol"), bytes).expect("a file can be written");
            let text = "<scene version=\"3.0.0\"><sensor type=\"perspective\"/><emitter type=\"constant\"/>\
                        <shape type=\"sphere\"><bsdf type=\"diffuse\"><texture type=\"volume\" name=\"reflectance\">\
                        <volume type=\"gridvolume\" name=\"volume\"><string name=\"filename\" value=\"grid.vol\"/>\
                        </volume></texture></bsdf></shape></scene>";
            read_str(text, &scratch.join("scene.xml"), &options)
        }
    };
    let mut description = match description {
        Ok(description) => description,
        Err(errors) => {
            assert!(!errors.to_string().is_empty());
            return false;
        }
    };
    let film = &mut description.sensor.film;
    let stated = (film.width, film.height, film.crop);
    (film.width, film.height, film.crop) = (2, 2, None);
    let scene = match compile(&description, &CompileOptions::default()) {
        Ok(scene) => scene,
        Err(errors) => {
            assert!(!errors.to_string().is_empty());
            return false;
        }
    };
    if draw {
        let settings = Settings {
            schedule: Schedule::new(4),
            seed: 1,
            sampler: description.sensor.sampler.kind,
            wavelengths: Some(WavelengthCount::Four),
            estimator: Estimator::Shared,
            bins: None,
        };
        render(&scene, &settings, &NoProgress::new());
        let film = &mut description.sensor.film;
        (film.width, film.height, film.crop) = stated;
        let text = json(&description, &scene.features(), Some(scratch));
        if let Err(errors) = read_str(text, &scratch.join("scene.json"), &options) {
            panic!("its own JSON is refused: {errors}");
        }
    }
    true
}

fn number(name: &str, default: u64) -> u64 {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(default)
}

/// A case that did harm, or seemed to.
struct Harm {
    case: u64,
    what: String,
}

/// What a run found.
#[derive(Default)]
struct Tally {
    accepted: u64,
    slowest: Duration,
    most_memory: usize,
    /// Bytes of memory to a byte of input, beyond what any scene needs.
    highest_ratio: f64,
    harm: Vec<Harm>,
    /// How often each plugin was tried, and accepted.
    tried: BTreeMap<(&'static str, String), [u64; 2]>,
}

/// One input, with everything measured.
fn try_one(case: u64, input: &Input, draw: bool, scratch: &Path, tally: &mut Tally) -> bool {
    let (outcome, took, memory) = measure::measured(|| {
        std::panic::catch_unwind(|| attempt(input.kind, &input.bytes, &input.folder, scratch, draw))
    });
    let factor = if matches!(input.kind, Kind::Image(_)) { IMAGE_FACTOR } else { MEMORY_FACTOR };
    let length = input.bytes.len();
    let count = |name: &[u8]| input.bytes.windows(name.len()).filter(|word| *word == name).count();
    let lamps = if count(b"checkerboard") + count(b"bitmap") > 0 { count(b"emitter") } else { 0 };
    let asked = count(b"terrain").min(1) * TERRAIN_MEMORY
        + count(b"subdivide") * SUBDIVIDED_MEMORY
        + lamps * GUIDE_MEMORY;
    let most = LEAST_MEMORY + factor * length + asked;
    let is_well = outcome.is_ok() && took < LONGEST && memory < most;
    if !is_well {
        let kept = scratch.join(format!("case-{case}"));
        std::fs::write(&kept, &input.bytes).expect("a file can be written");
        let panicked = if outcome.is_err() { "panicked" } else { "ended" };
        tally.harm.push(Harm {
            case,
            what: format!(
                "{:?} in {} {panicked} after {took:?}, with {memory} bytes of memory for {length} bytes; kept as {}",
                input.kind,
                input.folder.display(),
                kept.display()
            ),
        });
    }
    tally.slowest = tally.slowest.max(took);
    tally.most_memory = tally.most_memory.max(memory);
    tally.highest_ratio =
        tally.highest_ratio.max(memory.saturating_sub(LEAST_MEMORY) as f64 / length.max(1) as f64);
    let accepted = outcome.unwrap_or(false);
    tally.accepted += u64::from(accepted);
    accepted
}

/// What is read, as what, and where the files are that it names.
struct Input {
    kind: Kind,
    bytes: Vec<u8>,
    folder: PathBuf,
}

/// A file of the repository, changed.
fn changed(originals: &[Original], random: &mut Random) -> Input {
    // As many files of meshes, images and spectra as scenes, of which there are more.
    let of_scene = random.below(2) == 0;
    let original = loop {
        let original = &originals[random.below(originals.len())];
        // What is wrong already mostly stays so.
        if (original.kind == Kind::Scene) == of_scene && (!original.is_broken || random.below(8) == 0) {
            break original;
        }
    };
    let other = &originals[random.below(originals.len())].bytes;
    let mut bytes = original.bytes.clone();
    changes(original.kind, &mut bytes, other, random);
    Input { kind: original.kind, bytes, folder: original.folder.clone() }
}

fn changes(kind: Kind, bytes: &mut Vec<u8>, other: &[u8], random: &mut Random) {
    let count = if random.below(2) == 0 { 1 } else { 1 + random.below(4) };
    let of_text = matches!(kind, Kind::Scene | Kind::Spectrum | Kind::Mesh("obj")) || random.below(4) == 0;
    let packed = if random.below(2) == 0 { packed::open(kind, bytes) } else { None };
    let inner = packed.as_ref().map_or_else(|| bytes.clone(), |packed| packed.content.clone());
    let mut content = inner;
    for _ in 0..count {
        if content.is_empty() {
            break;
        }
        if of_text { change(&mut content, other, random) } else { packed::change(&mut content, random) }
    }
    *bytes = match packed {
        Some(packed) => packed.close(&content),
        None => content,
    };
}

fn cases() -> (u64, u64) {
    let cases = number("ABBE_FUZZ_CASES", stress::count(CASES, ALL_CASES));
    (number("ABBE_FUZZ_START", 0), cases)
}

/// Files to change, and what scenes are made of.
struct Seeds {
    originals: Vec<Original>,
    grammar: Grammar,
}

/// Tries the cases that other threads leave, all of them on this thread.
fn try_some(seeds: &Seeds, next: &AtomicU64, until: u64, scratch: &Path) -> Tally {
    let Seeds { originals, grammar } = seeds;
    let mut tally = Tally::default();
    loop {
        let case = next.fetch_add(1, Ordering::Relaxed);
        if case >= until || tally.harm.len() > 20 {
            return tally;
        }
        if case > 0 && case.is_multiple_of(20_000) {
            say(&format!("case {case}"));
        }
        let mut random = Random(case);
        let draw = random.below(8) == 0;
        if random.below(2) == 0 {
            try_one(case, &changed(originals, &mut random), draw, scratch, &mut tally);
        } else {
            let (text, plugin) = grammar.scene(&mut random);
            let mut bytes = text.into_bytes();
            if random.below(4) == 0 {
                let other = &originals[random.below(originals.len())].bytes;
                changes(Kind::Scene, &mut bytes, other, &mut random);
            }
            let folder = PathBuf::from("tests/scenes/textures");
            let input = Input { kind: Kind::Scene, bytes, folder };
            let accepted = try_one(case, &input, draw, scratch, &mut tally);
            let (element, name) = plugin;
            let counts = tally.tried.entry((element, name.to_owned())).or_default();
            *counts = [counts[0] + 1, counts[1] + u64::from(accepted)];
        }
    }
}

#[test]
fn nothing_does_harm() {
    let originals = originals();
    let scenes = originals.iter().filter(|original| original.kind == Kind::Scene && !original.is_broken);
    let texts =
        scenes.filter_map(|original| Some((std::str::from_utf8(&original.bytes).ok()?, &*original.folder)));
    let grammar = Grammar::learned(texts);
    let seeds = Seeds { originals, grammar };
    let (start, cases) = cases();
    let next = AtomicU64::new(start);
    let work = |number: usize| {
        // What does harm is kept there.
        let scratch = Folder::kept(&format!("fuzz-{start}-{number}"));
        // What a scene does on all threads it does on this one.
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
        pool.install(|| try_some(&seeds, &next, start + cases, scratch.as_ref()))
    };
    let work = &work;
    let tally = std::thread::scope(|scope| {
        let count = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        let workers: Vec<_> = (0..count).map(|number| scope.spawn(move || work(number))).collect();
        let ended = workers.into_iter().map(|worker| worker.join().expect("harm is caught"));
        ended.fold(Tally::default(), Tally::and)
    });
    let grammar = &seeds.grammar;
    let never: Vec<String> = grammar
        .plugins()
        .filter(|&(element, name)| {
            tally.tried.get(&(element, name.to_owned())).is_none_or(|counts| counts[1] == 0)
        })
        .map(|(element, name)| format!("{element} {name}"))
        .collect();
    say(&format!(
        "Files changed at random and scenes made up\n  {}\n  {} plugins with {} properties; never accepted: {}",
        tally.line(cases),
        grammar.plugins().count(),
        grammar.properties(),
        if never.is_empty() { "none".to_owned() } else { never.join(", ") }
    ));
    let harm: Vec<String> =
        tally.harm.iter().map(|harm| format!("case {}: {}", harm.case, harm.what)).collect();
    assert!(harm.is_empty(), "{}", harm.join("\n"));
    // Cases that are all refused at the first word would show nothing.
    assert!(tally.accepted * 10 > cases, "only {} of {cases} cases were accepted", tally.accepted);
    assert!(never.len() * 4 < grammar.plugins().count(), "too few plugins were ever accepted");
}

impl Tally {
    fn and(mut self, other: Self) -> Self {
        self.accepted += other.accepted;
        self.slowest = self.slowest.max(other.slowest);
        self.most_memory = self.most_memory.max(other.most_memory);
        self.highest_ratio = self.highest_ratio.max(other.highest_ratio);
        self.harm.extend(other.harm);
        for (plugin, [tried, accepted]) in other.tried {
            let counts = self.tried.entry(plugin).or_default();
            *counts = [counts[0] + tried, counts[1] + accepted];
        }
        self
    }

    fn line(&self, cases: u64) -> String {
        format!(
            "{cases} inputs, {} accepted, {} did harm; slowest {:.3} s, most memory {} bytes, at most {:.0} bytes to a byte of input",
            self.accepted,
            self.harm.len(),
            self.slowest.as_secs_f64(),
            self.most_memory,
            self.highest_ratio
        )
    }
}

/// Prints also where the test runner keeps what is printed to itself.
fn say(text: &str) {
    let _ = std::io::stdout().lock().write_all(format!("\n{text}\n").as_bytes());
}
