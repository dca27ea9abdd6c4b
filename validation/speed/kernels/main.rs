//! What a path is made of, piece by piece.
//!
//! `cargo bench --bench kernels` times all, `cargo bench --bench kernels -- bsdf` those of a group. An
//! iteration is a batch of [`BATCH`] operations, or a small picture where the items are samples.
//!
//! `-- --list-kernels` and `-- --repeat TIMES GROUP NAME` are for `validation/speed`, which counts the
//! instructions of an iteration and measures the processor time of many.

mod bsdfs;
mod paths;
mod pieces;
mod skips;

use divan::Bencher;
use divan::counter::ItemsCount;
use std::hint::black_box;
use std::process::ExitCode;

/// Operations of an iteration.
const BATCH: usize = 256;

/// A piece of work that is the same each time.
struct Kernel {
    name: String,
    items: usize,
    work: Box<dyn Fn()>,
}

impl Kernel {
    /// `operation` on each of the [`BATCH`] inputs, by their index.
    fn batch<T>(name: impl Into<String>, operation: impl Fn(usize) -> T + 'static) -> Self {
        let work = move || (0..BATCH).for_each(|index| drop(black_box(operation(black_box(index)))));
        Self { name: name.into(), items: BATCH, work: Box::new(work) }
    }
}

/// Makes the kernels of a group.
type Group = fn() -> Vec<Kernel>;

const GROUPS: [(&str, Group); 9] = [
    ("bsdf_sample", bsdfs::sampling),
    ("bsdf_evaluate", bsdfs::evaluation),
    ("sampler", pieces::samplers),
    ("spectrum", pieces::spectra),
    ("wavelengths", pieces::wavelengths),
    ("film", pieces::films),
    ("light", pieces::lights),
    ("path", paths::kernels),
    ("skip", skips::kernels),
];

fn kernels(group: &str) -> Vec<Kernel> {
    GROUPS.into_iter().find(|(name, _)| *name == group).map_or_else(Vec::new, |(_, make)| make())
}

/// The names of a group's kernels, as arguments of its benchmark.
fn names(group: &str) -> Vec<String> {
    kernels(group).into_iter().map(|kernel| kernel.name).collect()
}

fn find(group: &str, name: &str) -> Option<Kernel> {
    kernels(group).into_iter().find(|kernel| kernel.name == name)
}

fn time(bencher: Bencher, group: &str, name: &str) {
    let Some(kernel) = find(group, name) else { return };
    bencher.counter(ItemsCount::new(kernel.items)).bench_local(|| (kernel.work)());
}

#[divan::bench(args = names("bsdf_sample"))]
fn bsdf_sample(bencher: Bencher, name: &str) {
    time(bencher, "bsdf_sample", name);
}

#[divan::bench(args = names("bsdf_evaluate"))]
fn bsdf_evaluate(bencher: Bencher, name: &str) {
    time(bencher, "bsdf_evaluate", name);
}

#[divan::bench(args = names("sampler"))]
fn sampler(bencher: Bencher, name: &str) {
    time(bencher, "sampler", name);
}

#[divan::bench(args = names("spectrum"))]
fn spectrum(bencher: Bencher, name: &str) {
    time(bencher, "spectrum", name);
}

#[divan::bench(args = names("wavelengths"))]
fn wavelengths(bencher: Bencher, name: &str) {
    time(bencher, "wavelengths", name);
}

#[divan::bench(args = names("film"))]
fn film(bencher: Bencher, name: &str) {
    time(bencher, "film", name);
}

#[divan::bench(args = names("light"))]
fn light(bencher: Bencher, name: &str) {
    time(bencher, "light", name);
}

#[divan::bench(args = names("path"))]
fn path(bencher: Bencher, name: &str) {
    time(bencher, "path", name);
}

#[divan::bench(args = names("skip"))]
fn skip(bencher: Bencher, name: &str) {
    time(bencher, "skip", name);
}

/// What callgrind counts.
#[inline(never)]
fn counted(work: &dyn Fn()) {
    work();
}

fn main() -> ExitCode {
    // A picture's pixels are dealt to the threads of this pool: the only one is that which asks.
    if let Err(error) = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global() {
        eprintln!("error: no pool of threads: {error}");
        return ExitCode::FAILURE;
    }
    let words: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    match words[..] {
        ["--list-kernels", ..] => {
            for (group, _) in GROUPS {
                names(group).iter().for_each(|name| println!("{group} {name}"));
            }
        }
        ["--repeat", times, group, name, ..] => {
            let (Some(kernel), Ok(times)) = (find(group, name), times.parse::<u32>()) else {
                eprintln!("error: no kernel {group} {name}, or no number {times}");
                return ExitCode::FAILURE;
            };
            // What is made on first use is none of it.
            (kernel.work)();
            (0..times).for_each(|_| counted(&kernel.work));
        }
        _ => divan::main(),
    }
    ExitCode::SUCCESS
}
