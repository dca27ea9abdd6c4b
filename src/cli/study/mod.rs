mod lists;

use super::progress::StudyProgress;
use super::render::{cannot_write, refuse_what_no_memory_holds, scene_name, thread_pool, warn};
use super::scene_options::{PictureOptions, SceneOptions};
use super::stop::stop_on_signal;
use super::whole::whole;
use super::{Failure, print_message};
use abbe::film::Region;
use abbe::integrator::Estimator;
use abbe::output::exr;
use abbe::render::WavelengthCount;
use abbe::sampling::SamplerKind;
use abbe::scene::{CompileOptions, compile};
use abbe::study::report::{Context, Findings};
use abbe::study::{
    Case, CaseId, Folder, ForeignStudy, Reference, ReferenceError, ReferenceRequest, Request, RunId, measure,
    reference,
};
use lists::{List, parse_estimators, parse_samplers, parse_spp, parse_target, parse_wavelengths};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

/// Study noise: how the error of a picture falls with samples and CPU time, for each sampler
///
/// Each run is rendered in replicates, short renders independent of one another, so that the error of the
/// error is known. The folder gets runs.csv, study.json, plots (SVG and PNG) and index.html, a page with all
/// of it. Ctrl-C, SIGTERM or SIGHUP end the study after the run under way, with exit code 3; the same command
/// continues it.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneOptions,

    /// Folder of the study: a new one, an empty one, or that of the same study
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,

    /// Samplers to compare, by name, or all
    #[arg(long, value_name = "NAMES", default_value = "all", value_parser = parse_samplers)]
    samplers: List<SamplerKind>,

    /// Samples per pixel: a list, or FIRST..LAST for the powers of two from one to the other
    #[arg(long, value_name = "N", default_value = "1..256", value_parser = parse_spp)]
    spp: List<u32>,

    /// Wavelengths that a path carries: 1, 4, 8 or several of them
    #[arg(long, value_name = "C", default_value = "4", value_parser = parse_wavelengths)]
    wavelengths: List<WavelengthCount>,

    /// Estimators to use the samplers with: plain (each pixel traces its own paths), shared (as render does
    /// unless told otherwise; each picture has pilots of its own, whose time counts), or plain,shared
    #[arg(long, value_name = "E", default_value = "plain", value_parser = parse_estimators)]
    estimator: List<Estimator>,

    /// Independent pictures of each run, whose spread tells the error of its error
    #[arg(long, value_name = "R", default_value = "16", value_parser = whole::<u32>(2..=1024))]
    replicates: u32,

    #[command(flatten)]
    picture: PictureOptions,

    /// Seed of the study
    #[arg(long, value_name = "N", default_value = "0", value_parser = whole::<u64>(0..=u64::MAX))]
    seed: u64,

    /// EXR file to measure errors against, with Y (and error.Y) or R, G, B [default: the study renders its
    /// own]
    #[arg(long, value_name = "FILE.exr", conflicts_with = "reference_spp")]
    reference: Option<PathBuf>,

    /// Samples per pixel of the reference that the study renders [default: 64 times the longest run's]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(16..=1 << 26))]
    reference_spp: Option<u32>,

    /// Relative RMSE to tell the CPU time to, 0.01 for 1 % [default: the smallest that all random samplers
    /// reach]
    #[arg(long, value_name = "ERROR", value_parser = parse_target)]
    target: Option<f64>,

    /// Threads to render with [default: as many as there are cores]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..=1024))]
    threads: Option<u32>,

    /// Print nothing but errors
    #[arg(short, long)]
    quiet: bool,
}

/// Most cases that a study has.
const MOST_CASES: usize = 64;

pub fn run(args: &Args) -> Result<(), Failure> {
    let pool = thread_pool(args.threads)?;
    let cases = cases(args)?;
    let (request, given) = request(args, &cases, pool.current_num_threads() as u32)?;
    let folder = Folder::open(&args.output, &request).map_err(|foreign| refused(&args.output, &foreign))?;
    for (index, case) in cases.iter().enumerate() {
        if let ReferenceRequest::Rendered { samples_per_pixel } = request.reference {
            refuse_what_no_memory_holds(
                &case.scene,
                &reference::settings(&request, index, samples_per_pixel),
            )?;
        }
    }
    let cannot = |error: &std::io::Error| cannot_write(&args.output, error);
    folder.prepare(&request).map_err(|error| cannot(&error))?;
    if !args.quiet {
        cases.iter().for_each(|case| warn(&case.scene));
    }
    let stop = stop_on_signal()?;
    let mut progress = StudyProgress::new(args.quiet, stop.clone());

    let pixels = u64::from(request.size[0]) * u64::from(request.size[1]);
    let mut runs: Vec<(RunId, Option<_>)> =
        request.runs().into_iter().map(|id| (id.clone(), folder.run(&id))).collect();
    let samples_of =
        |id: &RunId| pixels * u64::from(id.samples_per_pixel) * u64::from(request.replicates_of(id.sampler));
    let missing: Vec<bool> = (0..cases.len()).map(|case| !folder.reference(case).exists()).collect();
    let of_references = match request.reference {
        ReferenceRequest::Rendered { samples_per_pixel } => {
            pixels * u64::from(samples_per_pixel) * missing.iter().filter(|missing| **missing).count() as u64
        }
        ReferenceRequest::File { .. } => 0,
    };
    let left: u64 = runs.iter().filter(|(_, run)| run.is_none()).map(|(id, _)| samples_of(id)).sum();
    progress.begin(left + of_references, &format!("{} runs", runs.len()));

    let mut references = Vec::new();
    for (index, case) in cases.iter().enumerate() {
        if let Some(given) = &given {
            references.push(given.clone());
            continue;
        }
        let path = folder.reference(index);
        if missing[index]
            && let ReferenceRequest::Rendered { samples_per_pixel } = request.reference
        {
            progress.says("reference");
            let settings = reference::settings(&request, index, samples_per_pixel);
            pool.install(|| reference::write(&path, case, &settings, &progress))
                .map_err(|error| cannot(&error))?;
        }
        references.push(read_reference(&path, request.size, "remove it, and the study renders it again")?);
        stopped(&stop, &runs).inspect_err(|_| progress.finish())?;
    }
    for index in 0..runs.len() {
        if runs[index].1.is_some() {
            continue;
        }
        let id = runs[index].0.clone();
        progress.says(&id.name());
        let run =
            pool.install(|| measure(&request, &cases[id.case], id.clone(), &references[id.case], &progress));
        folder.keep(&run).map_err(|error| cannot(&error))?;
        progress.run_done(index + 1, runs.len(), &id.name(), run.error().mean.max(0.0).sqrt());
        runs[index].1 = Some(run);
        if index + 1 < runs.len() {
            stopped(&stop, &runs).inspect_err(|_| progress.finish())?;
        }
    }
    progress.says("plots and page");
    let findings = Findings {
        request: &request,
        cases: &cases,
        references: &references,
        runs: runs.into_iter().filter_map(|(_, run)| run).collect(),
        context: Context {
            scene: scene_name(&args.scene.scene),
            command: std::env::args().map(|word| shown(&word)).collect::<Vec<_>>().join(" "),
            machine: machine(),
            target: args.target,
        },
    };
    pool.install(|| findings.write(&folder, &progress)).map_err(|error| cannot(&error))?;
    progress.finish();
    if !args.quiet {
        print_message(&folder.file("index.html").display().to_string());
    }
    Ok(())
}

/// After a signal, says how far the study has come.
fn stopped<T>(stop: &AtomicBool, runs: &[(RunId, Option<T>)]) -> Result<(), Failure> {
    if !stop.load(Ordering::Relaxed) {
        return Ok(());
    }
    let done = runs.iter().filter(|(_, run)| run.is_some()).count();
    Err(Failure::Stopped(format!(
        "stopped: {done} of {} runs are done; the same command continues",
        runs.len()
    )))
}

fn machine() -> String {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    format!("{} {}, {cores} cores", std::env::consts::OS, std::env::consts::ARCH)
}

/// A word of a command line as one types it.
fn shown(word: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./=:,%+@".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

/// A case for every combination of the parameters' values.
fn cases(args: &Args) -> Result<Vec<Case>, Failure> {
    let mut combinations: Vec<Vec<(String, String)>> = vec![Vec::new()];
    for (name, values) in &args.scene.defines {
        combinations = combinations
            .into_iter()
            .flat_map(|chosen| {
                values.split(',').map(move |value| {
                    let mut chosen = chosen.clone();
                    chosen.push((name.clone(), value.trim().to_owned()));
                    chosen
                })
            })
            .collect();
        if combinations.len() > MOST_CASES {
            return Err(Failure::Input(format!(
                "error: the values of -D make more than {MOST_CASES} cases\nhelp: make several studies of fewer"
            )));
        }
    }
    combinations
        .into_iter()
        .map(|parameters| {
            let mut description = args.scene.read_with(&parameters)?;
            args.picture.apply_to(&mut description);
            let range = description.sensor.film.wavelength_range();
            // Pixels around the part would cost time that is not the runs'.
            let options =
                CompileOptions { range, part: args.picture.part(0, 1), ..CompileOptions::default() };
            let scene =
                compile(&description, &options).map_err(|errors| Failure::Input(errors.to_string()))?;
            let id = CaseId { parameters, scene_hash: format!("{:016x}", description.hash()) };
            Ok(Case { id, scene })
        })
        .collect()
}

/// What is asked, and the reference where it is a file.
fn request(args: &Args, cases: &[Case], threads: u32) -> Result<(Request, Option<Reference>), Failure> {
    let Region { offset, size } = cases[0].scene.film.extent.shown;
    if cases.iter().any(|case| case.scene.film.extent.shown != cases[0].scene.film.extent.shown) {
        return Err(Failure::Input(
            "error: the cases have pictures of different sizes or parts of the film\nhelp: give all of them one with --size"
                .to_owned(),
        ));
    }
    let longest = args.spp.0.iter().max().copied().unwrap_or(1);
    let (wanted, given) = match &args.reference {
        Some(_) if cases.len() > 1 => {
            return Err(Failure::Input(
                "error: one reference cannot stand for several cases\n\
                 help: leave --reference out and let the study render its own, or study one case at a time"
                    .to_owned(),
            ));
        }
        Some(path) => {
            let reference = read_reference(path, size, "expected an OpenEXR file, as abbe render writes it")?;
            let file = ReferenceRequest::File {
                path: path.display().to_string(),
                hash: format!("{:016x}", reference.hash()),
            };
            (file, Some(reference))
        }
        None => {
            let samples_per_pixel = args.reference_spp.unwrap_or(longest.saturating_mul(64)).max(16);
            (ReferenceRequest::Rendered { samples_per_pixel: samples_per_pixel.next_multiple_of(16) }, None)
        }
    };
    let request = Request {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        cases: cases.iter().map(|case| case.id.clone()).collect(),
        samplers: args.samplers.0.clone(),
        estimators: args.estimator.0.clone(),
        samples_per_pixel: args.spp.0.clone(),
        wavelengths_per_path: args.wavelengths.0.clone(),
        replicates: args.replicates,
        size,
        offset,
        seed: args.seed,
        reference: wanted,
        threads,
    };
    Ok((request, given))
}

/// `remedy`: what to do about a file that cannot be read.
fn read_reference(path: &Path, size: [u32; 2], remedy: &str) -> Result<Reference, Failure> {
    let place = path.display();
    let channels = exr::read(path)
        .map_err(|error| Failure::Input(format!("error: cannot read {place}: {error}\nhelp: {remedy}")))?;
    Reference::from_channels(&channels, size).map_err(|error| {
        Failure::Input(match error {
            ReferenceError::Size([width, height]) => format!(
                "error: {place} has {width}×{height} pixels, the pictures of the study {}×{}\n\
                 help: give the study that size with --size, or render another reference",
                size[0], size[1]
            ),
            ReferenceError::NoLuminance(names) => format!(
                "error: {place} has the channels {}\nhelp: a reference needs Y, or R, G and B",
                names.join(", ")
            ),
            ReferenceError::Black => format!(
                "error: {place} is black\nhelp: errors relative to nothing mean nothing: see that light reaches the camera"
            ),
            ReferenceError::NotFinite => {
                format!("error: {place} has values that are not finite\nhelp: render the reference again")
            }
        })
    })
}

fn refused(path: &Path, foreign: &ForeignStudy) -> Failure {
    let place = path.display();
    match foreign {
        ForeignStudy::NotAStudy => Failure::Input(format!(
            "error: {place} has files in it, and they are not a study's\nhelp: name a new or an empty folder"
        )),
        ForeignStudy::Damaged(file) => Failure::Input(format!(
            "error: {} is damaged, which says what is studied in the folder\n\
             help: name a new folder, or remove this one to begin the study anew",
            file.display()
        )),
        ForeignStudy::Another(differences) => {
            let mut text = format!("error: {place} is the folder of another study");
            for difference in differences {
                let _ = write!(text, "\n  {difference}");
            }
            text.push_str("\nhelp: name another folder, or ask for the same study to continue it");
            Failure::Input(text)
        }
        ForeignStudy::Io(error) => Failure::Other(format!("error: cannot read {place}: {error}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_is_told_as_one_types_it() {
        assert_eq!(["a.xml", "-D", "x=1 2", "it's"].map(shown), ["a.xml", "-D", "'x=1 2'", "'it'\\''s'"]);
    }
}
