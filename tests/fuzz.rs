//! Files with mistakes that nobody thought of: what the repository has, changed at random. Nothing panics, nothing takes
//! long, and memory stays within a small factor of what is read.
//!
//! The cases are numbered, and each is the same in every run. `ABBE_FUZZ_CASES` sets how many are tried and
//! `ABBE_FUZZ_START` from which on; a million take hours.

use abbe::render::{Schedule, Settings, Unwatched, WavelengthCount, render};
use abbe::scene::{CompileOptions, ReadOptions, compile, json, read, read_str};
use std::alloc::{GlobalAlloc, Layout, System};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// How many cases are tried where the environment does not say.
const CASES: u64 = 2000;

/// Longest time for one case.
const LONGEST: Duration = Duration::from_secs(5);

/// Most memory for one case: what the program needs for any scene, and a multiple of what is read.
const LEAST_MEMORY: usize = 16 << 20;
const MEMORY_FACTOR: usize = 100;

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
        let kind = match path.extension().and_then(|extension| extension.to_str()) {
            Some("xml" | "json") => Kind::Scene,
            Some("ply") => Kind::Mesh("ply"),
            Some("obj") => Kind::Mesh("obj"),
            Some("spd") => Kind::Spectrum,
            _ => continue,
        };
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
    };
    let mut description = match description {
        Ok(description) => description,
        Err(errors) => {
            assert!(!errors.to_string().is_empty());
            return false;
        }
    };
    let film = &mut description.sensor.film;
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
            bins: None,
        };
        render(&scene, &settings, &Unwatched::new());
    }
    true
}

fn number(name: &str, default: u64) -> u64 {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(default)
}

#[test]
fn changed_files_do_no_harm() {
    let originals = originals();
    let (start, cases) = (number("ABBE_FUZZ_START", 0), number("ABBE_FUZZ_CASES", CASES));
    let scratch = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("fuzz-{start}"));
    std::fs::create_dir_all(&scratch).expect("a folder for temporary files");
    let (mut accepted, mut slowest, mut largest) = (0, Duration::ZERO, 0);
    for case in start..start + cases {
        let mut random = Random(case);
        let mut original = &originals[random.below(originals.len())];
        // What is wrong already mostly stays so.
        while original.is_broken && random.below(8) > 0 {
            original = &originals[random.below(originals.len())];
        }
        let other = &originals[random.below(originals.len())].bytes;
        let mut bytes = original.bytes.clone();
        let changes = if random.below(2) == 0 { 1 } else { 1 + random.below(4) };
        for _ in 0..changes {
            if !bytes.is_empty() {
                change(&mut bytes, other, &mut random);
            }
        }
        let draw = random.below(8) == 0;
        let before = ALLOCATED.load(Ordering::Relaxed);
        PEAK.store(before, Ordering::Relaxed);
        let began = Instant::now();
        let outcome =
            std::panic::catch_unwind(|| attempt(original.kind, &bytes, &original.folder, &scratch, draw));
        let took = began.elapsed();
        let memory = PEAK.load(Ordering::Relaxed).saturating_sub(before);
        let is_well =
            outcome.is_ok() && took < LONGEST && memory < LEAST_MEMORY + MEMORY_FACTOR * bytes.len();
        if !is_well {
            let kept = scratch.join(format!("case-{case}"));
            std::fs::write(&kept, &bytes).expect("a file can be written");
            panic!(
                "case {case} ({:?} in {}): panic {}, {took:?}, {memory} bytes of memory for {} bytes; kept as {}",
                original.kind,
                original.folder.display(),
                outcome.is_err(),
                bytes.len(),
                kept.display()
            );
        }
        accepted += u64::from(outcome.unwrap_or(false));
        slowest = slowest.max(took);
        largest = largest.max(memory);
        if cases > 20_000 && case % 20_000 == 0 {
            println!("case {case}: {accepted} accepted, slowest {slowest:?}, most memory {largest} bytes");
        }
    }
    println!("{cases} cases, {accepted} accepted, slowest {slowest:?}, most memory {largest} bytes");
    // Cases that are all refused at the first word would show nothing.
    assert!(accepted * 20 > cases, "only {accepted} of {cases} cases were accepted");
    std::fs::remove_dir_all(&scratch).expect("the temporary files can be removed");
}
