//! Files with mistakes that nobody thought of: what the repository has, changed at random, and scenes made of everything that
//! the reader knows. Nothing panics, nothing takes long, and memory stays within a small factor of what is read. What is
//! accepted is compiled, now and then rendered, and comes back from its own JSON.
//!
//! The cases are numbered, and each is the same in every run. `ABBE_STRESS=full` tries a million, in about half an hour.
//! `ABBE_FUZZ_CASES` sets how many are tried and `ABBE_FUZZ_START` from which on.

mod grammar;
mod packed;

use abbe::integrator::Estimator;
use abbe::render::{Schedule, Settings, Unwatched, WavelengthCount, render};
use abbe::scene::{CompileOptions, ReadOptions, compile, json, read, read_str};
use cpu_time::ProcessTime;
use grammar::Grammar;
use std::alloc::{GlobalAlloc, Layout, System};
use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

/// How many cases are tried where the environment does not say.
const CASES: u64 = 8000;
const ALL_CASES: u64 = 1_000_000;

/// Most CPU time for one case: what else the machine does is not its fault.
const LONGEST: Duration = Duration::from_secs(5);

/// Most memory for one case: what the program needs for any scene, and a multiple of what is read.
const LEAST_MEMORY: usize = 16 << 20;
const MEMORY_FACTOR: usize = 100;

/// An image of one colour may be a thousandth as long as its texels; these are held as bytes, as floats and as spectra.
const IMAGE_FACTOR: usize = 1100 * (1 + 3 * 4);

/// A scene may ask for terrain of 2²² points in a word, which is computed in complex numbers.
const TERRAIN_MEMORY: usize = 48 << 22;

/// And a mesh to be cut into 2²⁰ triangles, each of which takes less than this when it is ready to be rendered.
const SUBDIVIDED_MEMORY: usize = 400 << 20;

/// Counts what is allocated, and the most that there was.
struct Counting;

static ALLOCATED: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

// SAFETY: every call goes to the system's allocator as it is.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let now = ALLOCATED.fetch_add(layout.size(), Ordering::Relaxed) + layout.size();
        PEAK.fetch_max(now, Ordering::Relaxed);
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        ALLOCATED.fetch_sub(layout.size(), Ordering::Relaxed);
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

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
            let bytes = json(&description, &scene.needs(), Some(&folder)).into_bytes();
            found.push(Original { kind, bytes, folder: folder.clone(), is_broken: false });
        }
        found.push(Original { kind, bytes, folder, is_broken });
    }
    found
}

/// Steele, Lea and Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, limit: usize) -> usize {
        (self.next() % limit.max(1) as u64) as usize
    }
}

/// Where a stretch of bytes that `belongs` begins and ends, around a random place.
fn stretch(bytes: &[u8], random: &mut Random, belongs: impl Fn(u8) -> bool) -> Option<(usize, usize)> {
    let from = random.below(bytes.len());
    let start = from + bytes[from..].iter().position(|&byte| belongs(byte))?;
    let length = bytes[start..].iter().position(|&byte| !belongs(byte)).unwrap_or(bytes.len() - start);
    Some((start, start + length))
}

fn line(bytes: &[u8], random: &mut Random) -> (usize, usize) {
    stretch(bytes, random, |byte| byte != b'\n').unwrap_or((0, 0))
}

/// One change.
fn change(bytes: &mut Vec<u8>, other: &[u8], random: &mut Random) {
    const NUMBERS: [&str; 16] = [
        "0",
        "-1",
        "1",
        "1e308",
        "-1e308",
        "1e-308",
        "nan",
        "inf",
        "4294967295",
        "4294967296",
        "99999999999",
        "-2147483649",
        "0.5",
        "1e9",
        "65536",
        "1e-12",
    ];
    const TOKENS: [&str; 20] = [
        "\"",
        "<",
        "/>",
        "$",
        ":",
        "\0",
        "{",
        "}",
        "[",
        "]",
        ",",
        "<!--",
        "-->",
        "type=\"null\"",
        "<ref id=\"a\"/>",
        "\r",
        "é",
        "&amp;",
        "\\u0000",
        "<include filename=\"scene.xml\"/>",
    ];
    let digit = |byte: u8| byte.is_ascii_digit() || byte == b'.';
    let at = random.below(bytes.len() + 1);
    let until = (at + random.below(9)).min(bytes.len());
    match random.below(12) {
        0 if at < bytes.len() => bytes[at] = random.next() as u8,
        1 => drop(bytes.drain(at..until)),
        2 => {
            let token = TOKENS[random.below(TOKENS.len())].bytes();
            drop(bytes.splice(at..until, token));
        }
        3 => {
            let (from, to) = line(bytes, random);
            drop(bytes.drain(from..to));
        }
        4 => {
            let (from, to) = line(bytes, random);
            let copy = bytes[from..to].to_vec();
            drop(bytes.splice(at..at, copy));
        }
        5 => {
            let (from, to) = line(other, random);
            drop(bytes.splice(at..at, other[from..to].iter().copied()));
        }
        6 => {
            // A line of another file in the place of one of this.
            let (from, to) = line(bytes, random);
            let (start, end) = line(other, random);
            drop(bytes.splice(from..to, other[start..end].iter().copied()));
        }
        7 => {
            let word = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'_';
            if let (Some((from, to)), Some((start, end))) =
                (stretch(bytes, random, word), stretch(other, random, word))
            {
                drop(bytes.splice(from..to, other[start..end].iter().copied()));
            }
        }
        8 if random.below(4) == 0 => bytes.truncate(at),
        _ => {
            if let Some((from, to)) = stretch(bytes, random, digit) {
                let ordinary = format!("{}", random.below(4000) as f64 / 1000.0);
                let number =
                    if random.below(2) == 0 { &ordinary } else { NUMBERS[random.below(NUMBERS.len())] };
                drop(bytes.splice(from..to, number.bytes()));
            }
        }
    }
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
            wavelengths: WavelengthCount::Four,
            estimator: Estimator::Shared,
            bins: None,
        };
        render(&scene, &settings, &Unwatched::new());
        let film = &mut description.sensor.film;
        (film.width, film.height, film.crop) = stated;
        let text = json(&description, &scene.needs(), Some(scratch));
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
}

/// One input, with everything measured.
fn try_one(case: u64, input: &Input, draw: bool, scratch: &Path, tally: &mut Tally) -> bool {
    let before = ALLOCATED.load(Ordering::Relaxed);
    PEAK.store(before, Ordering::Relaxed);
    let began = ProcessTime::now();
    let outcome =
        std::panic::catch_unwind(|| attempt(input.kind, &input.bytes, &input.folder, scratch, draw));
    let took = began.elapsed();
    let memory = PEAK.load(Ordering::Relaxed).saturating_sub(before);
    let factor = if matches!(input.kind, Kind::Image(_)) { IMAGE_FACTOR } else { MEMORY_FACTOR };
    let length = input.bytes.len();
    let count = |name: &[u8]| input.bytes.windows(name.len()).filter(|word| *word == name).count();
    let asked = count(b"terrain").min(1) * TERRAIN_MEMORY + count(b"subdivide") * SUBDIVIDED_MEMORY;
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
    let all = std::env::var("ABBE_STRESS").is_ok_and(|word| word == "full");
    let cases = number("ABBE_FUZZ_CASES", if all { ALL_CASES } else { CASES });
    (number("ABBE_FUZZ_START", 0), cases)
}

#[test]
fn nothing_does_harm() {
    let originals = originals();
    let scenes = originals.iter().filter(|original| original.kind == Kind::Scene && !original.is_broken);
    let texts =
        scenes.filter_map(|original| Some((std::str::from_utf8(&original.bytes).ok()?, &*original.folder)));
    let grammar = Grammar::learned(texts);
    let (start, cases) = cases();
    let scratch = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("fuzz-{start}"));
    std::fs::create_dir_all(&scratch).expect("a folder for temporary files");
    let mut tally = Tally::default();
    // How often each plugin was tried, and accepted.
    let mut tried = BTreeMap::<_, [u64; 2]>::new();
    for case in start..start + cases {
        let mut random = Random(case);
        let draw = random.below(8) == 0;
        if random.below(2) == 0 {
            try_one(case, &changed(&originals, &mut random), draw, &scratch, &mut tally);
        } else {
            let (text, plugin) = grammar.scene(&mut random);
            let mut bytes = text.into_bytes();
            if random.below(4) == 0 {
                let other = &originals[random.below(originals.len())].bytes;
                changes(Kind::Scene, &mut bytes, other, &mut random);
            }
            let folder = PathBuf::from("tests/scenes/textures");
            let input = Input { kind: Kind::Scene, bytes, folder };
            let accepted = try_one(case, &input, draw, &scratch, &mut tally);
            let counts = tried.entry(plugin).or_default();
            *counts = [counts[0] + 1, counts[1] + u64::from(accepted)];
        }
        if cases > 20_000 && case % 20_000 == 0 {
            say(&format!("case {case}: {}", tally.line(case - start)));
        }
        if tally.harm.len() > 20 {
            break;
        }
    }
    let never: Vec<String> = grammar
        .plugins()
        .filter(|plugin| tried.get(plugin).is_none_or(|counts| counts[1] == 0))
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
    std::fs::remove_dir_all(&scratch).expect("the temporary files can be removed");
}

impl Tally {
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
