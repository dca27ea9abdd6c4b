//! What a path is made of, piece by piece.
//!
//! `cargo bench --bench kernels` times all, `cargo bench --bench kernels -- bsdf` those of a group. An iteration is a batch of
//! [`BATCH`] operations, or a small picture where the items are samples.
//!
//! `-- --list-kernels` and `-- --once GROUP NAME` are for `validation/speed/instructions`, which counts the instructions of one
//! iteration.

mod bsdfs;
mod paths;
mod pieces;

use divan::Bencher;
use divan::counter::ItemsCount;
use std::hint::black_box;

/// Operations of an iteration.
const BATCH: usize = 256;

/// A piece of work that is the same each time.
struct Kernel {
    group: &'static str,
    name: String,
    items: usize,
    work: Box<dyn Fn()>,
}

impl Kernel {
    /// `operation` on each of the [`BATCH`] inputs, by their index.
    fn batch<T>(group: &'static str, name: impl Into<String>, operation: impl Fn(usize) -> T + 'static) -> Self {
        let work = move || (0..BATCH).for_each(|index| drop(black_box(operation(black_box(index)))));
        Self { group, name: name.into(), items: BATCH, work: Box::new(work) }
    }
}

fn kernels() -> Vec<Kernel> {
    [bsdfs::kernels(), pieces::kernels(), paths::kernels()].into_iter().flatten().collect()
}

/// The kernels of a group, as arguments of its benchmark.
fn names(group: &str) -> Vec<String> {
    kernels().into_iter().filter(|kernel| kernel.group == group).map(|kernel| kernel.name).collect()
}

fn find(group: &str, name: &str) -> Option<Kernel> {
    kernels().into_iter().find(|kernel| kernel.group == group && kernel.name == name)
}

fn time(bencher: Bencher, group: &str, name: &str) {
    let Some(kernel) = find(group, name) else { return };
    bencher.counter(ItemsCount::new(kernel.items)).bench_local(|| (kernel.work)());
}

#[divan::bench(args = names("sample"))]
fn bsdf_sample(bencher: Bencher, name: &str) {
    time(bencher, "sample", name);
}

#[divan::bench(args = names("evaluate"))]
fn bsdf_evaluate(bencher: Bencher, name: &str) {
    time(bencher, "evaluate", name);
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

/// What callgrind counts.
#[inline(never)]
fn counted(work: &dyn Fn()) {
    work();
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    match words[..] {
        ["--list-kernels", ..] => kernels().iter().for_each(|k| println!("{} {}", k.group, k.name)),
        ["--once", group, name, ..] => match find(group, name) {
            // What is made on first use is none of it.
            Some(kernel) => {
                (kernel.work)();
                counted(&kernel.work);
            }
            None => {
                eprintln!("error: no kernel {group} {name}");
                std::process::exit(2);
            }
        },
        _ => divan::main(),
    }
}
