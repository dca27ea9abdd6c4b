mod frames;
mod long;
mod outcome;
mod report;
mod stats;
mod until;

use super::png_options::PngOptions;
use super::sampling_options::SamplingOptions;
use super::scene_options::SceneOptions;
use super::stop::stop_on_signal;
use super::view::{self, Page};
use super::whole::whole;
use super::{Failure, print_message};
use abbe::film::{Film, Storage};
use abbe::output::{self, Colour, Content, Picture, checkpoint};
use abbe::render::{Settings, Work, auxiliary, go_on};
use abbe::scene::description::{self, Aov, AovKind, Description, FilmContent, Moments, PixelFormat};
use abbe::scene::{Scene, compile};
use abbe::units::WavelengthRange;
use frames::FrameOptions;
use long::{Kept, LongOptions, Viewers, Watching};
pub(super) use long::{cannot_read, cannot_read_content};
use report::distinct;
pub(super) use report::{counted, sample_count};
use stats::{Report, Statistics};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Render a scene to an EXR with error bars, and a PNG to look at
///
/// Without -o the files land in the current folder under the name of the scene's folder. The picture depends
/// on the scene, the seed and the number of samples alone: threads change only how long it takes. Ctrl-C,
/// SIGTERM or SIGHUP end the render and write what is done, with exit code 3; nothing is written before every
/// pixel has a sample. The second ends the program at once.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneOptions,

    /// Where to write the picture; a PNG of the same name lands beside it. OUT.checkpoint: no picture, but
    /// what abbe merge makes one from
    #[arg(short, long, value_name = "OUT.exr|checkpoint")]
    output: Option<PathBuf>,

    #[command(flatten)]
    sampling: SamplingOptions,

    /// Threads to render with [default: as many as there are cores]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..=1024))]
    threads: Option<u32>,

    /// Also write images of what the camera sees first, each with its standard error: albedo, depth,
    /// position, uv, geo_normal, sh_normal, dp_du, dp_dv, prim_index, shape_index, material_index;
    /// cost is what a path takes: nodes visited, packets of four triangles and other surfaces tested.
    /// NAME:TYPE gives the channels another name
    #[arg(long, value_name = "TYPES", value_delimiter = ',', value_parser = Aov::of_word)]
    aov: Vec<Aov>,

    #[command(flatten)]
    frames: FrameOptions,

    #[command(flatten)]
    long: LongOptions,

    #[command(flatten)]
    png: PngOptions,

    /// Also print what the render did: rays by kind and what they took, how paths end, the share of the time
    /// in ray queries, memory and times. The file has what of it is the same for equal renders. The picture
    /// is the same and takes longer
    #[arg(long)]
    stats: bool,

    /// Print the statistics as JSON
    #[arg(long, requires = "stats")]
    json: bool,

    /// Print nothing but errors, and what the picture lacks
    #[arg(short, long)]
    quiet: bool,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    run_shown(args, None, || Ok(()))
}

/// Renders, and shows on a page what is done so far and then the finished picture, until a signal comes.
/// `serve` begins to show the page, once the scene is read.
pub(super) fn run_shown(
    args: &Args,
    page: Option<&Page>,
    serve: impl FnOnce() -> Result<(), Failure>,
) -> Result<(), Failure> {
    let began = Instant::now();
    let mut description = args.scene.read()?;
    let read = began.elapsed();
    let most = args.long.until.ends_early().then_some(until::MOST_SAMPLES);
    args.sampling.apply_to(&mut description, most)?;
    let range = args.sampling.range(&description);
    let description = description.over(range);
    // Told before the first frame is rendered.
    if let (Some(frames), Some(output)) = (&args.frames.frames, &args.output) {
        frames::path_of_frame(output, frames.start)?;
    }
    let output = args.output_path()?;
    args.png.refuse_without_png(!has_extension(&output, checkpoint::EXTENSION))?;
    args.long.refuse_without_checkpoint(&output, args.frames.frames.is_some())?;
    let Some(frames) = args.frames.frames.clone() else {
        serve()?;
        return picture(
            args,
            &Request {
                description: &description,
                range,
                read,
                output,
                frame: None,
                stop: &stop_on_signal()?,
                page,
            },
        );
    };
    if page.is_some() {
        return Err(Failure::Input(
            "error: --frames makes several pictures, and a page shows one\n\
             help: render them with abbe render, then show one of them with abbe view"
                .to_owned(),
        ));
    }
    let stop = stop_on_signal()?;
    for frame in frames.clone() {
        let output = frames::path_of_frame(&output, frame)?;
        if !args.quiet {
            print_message(&format!("frame {frame}, to {}: {}", frames.end - 1, output.display()));
        }
        let description = &args.frames.of_frame(frame, description.clone());
        picture(
            args,
            &Request { description, range, read, output, frame: Some(frame), stop: &stop, page: None },
        )?;
    }
    Ok(())
}

/// One picture, and what it is made from.
struct Request<'a> {
    description: &'a Description,
    range: WavelengthRange,
    /// How long it took to read the scene.
    read: Duration,
    output: PathBuf,
    /// Which of an animation it is.
    frame: Option<u32>,
    stop: &'a Arc<AtomicBool>,
    /// Where it is shown meanwhile.
    page: Option<&'a Page>,
}

fn picture(args: &Args, request: &Request) -> Result<(), Failure> {
    let Request { description, range, read, ref output, frame, stop, page } = *request;
    let places = args.long.places(output, args.png.is_wanted(), frame.is_some());
    places.refuse_files_of(description)?;
    let options = args.sampling.compile_options(range);
    let began = Instant::now();
    let scene = compile(description, &options).map_err(|errors| Failure::Input(errors.to_string()))?;
    let compiled = began.elapsed();
    let sampler = &description.sensor.sampler;
    let settings = args.sampling.settings(description, range);
    // Once for all frames.
    let is_first = frame.is_none_or(|frame| args.frames.frames.as_ref().is_none_or(|all| all.start == frame));
    if !args.quiet && is_first {
        for assumption in distinct(&description.assumptions) {
            print_message(&format!("assumed: {assumption}"));
        }
        if settings.schedule.samples() != u64::from(sampler.sample_count) {
            print_message(&format!(
                "{} samples per pixel cannot be dealt into replicates of equal length: taking {}",
                sampler.sample_count,
                settings.schedule.samples()
            ));
        }
    }
    if is_first {
        warn(&scene);
    }
    refuse_what_no_memory_holds(&scene, &settings)?;
    args.long.until.refuse_without_errors(settings.schedule())?;
    let aovs = [description.integrator.aovs.clone(), args.aov.clone()].concat();
    let content = content(&description.sensor.film);
    let moments = description.integrator.moments.as_ref().map(Moments::stems);
    refuse_names(&content, moments.as_ref(), &aovs)?;
    let counts = args.stats || aovs.iter().any(|aov| aov.kind == AovKind::Cost);
    let scene = if counts { scene.counting() } else { scene };
    let pool = thread_pool(args.threads)?;
    let names: Vec<String> = aovs.iter().flat_map(Aov::channels).collect();
    let kept = Kept {
        path: places.checkpoint.clone(),
        identity: report::identity(args, range, description, &settings, &names),
        picture: checkpoint::Description {
            content,
            moments,
            attributes: report::attributes(args, range, description, &scene, &settings),
        },
        samples_per_pixel: settings.schedule().samples(),
        threads: pool.current_num_threads(),
    };
    if frame.is_some()
        && frames::is_complete(
            args,
            output,
            &kept.picture.attributes,
            places.png.as_deref(),
            places.checkpoint.as_deref(),
        )?
    {
        if !args.quiet {
            print_message(&format!("{} is complete", output.display()));
        }
        return Ok(());
    }
    let samples = args.long.samples(settings.schedule())?;
    let folder = output::folder_of(output);
    let work = Work::new_at(Storage::Folder(folder), &scene, &settings, samples)
        .map_err(|error| no_room_for_bins(folder, &error))?;
    let work = kept.begin(work, &args.long, args.quiet)?;
    places.refuse_unwritable()?;
    let viewer = args.long.viewer(&output.to_string_lossy())?;
    let before = work.film().total_samples();
    let long =
        Watching::new(&kept, &args.long, &work, args.quiet, Viewers { tev: viewer, page }, stop.clone());
    let (work, statistics) = match args.stats {
        true => {
            let statistics = Statistics::new(&scene, &long);
            let work = pool.install(|| go_on(&scene, &settings, work, &statistics));
            let report = statistics.report(work.film(), &settings, [read, compiled]);
            (work, Some(report))
        }
        false => (pool.install(|| go_on(&scene, &settings, work, &long)), None),
    };
    let (outcome, seconds) = long.finish(&work);
    let done = work.film().samples_per_pixel();
    let is_shown = places.picture.is_some() && *done.start() > 0;
    // The part with the first sample of a pixel brings the images of it.
    let brings_images = work.is_finished() && work.samples().start == 0 && places.checkpoint.is_some();
    let images = match is_shown || brings_images {
        true => pool.install(|| auxiliary(&scene, &aovs, range, settings.schedule(), settings.seed)),
        false => Vec::new(),
    };
    let kept_all = kept.write(&work, if brings_images { &images } else { &[] });
    if let (true, Some(path)) = (is_shown, &places.picture) {
        let film = work.film();
        let checkpoint::Description { content, moments, attributes } = kept.picture.clone();
        let statistics = statistics.as_ref().map_or_else(Vec::new, Report::attributes);
        let attributes = [attributes, report::counted(film), outcome.attributes(), statistics].concat();
        let picture = Picture { film, content, moments, auxiliary: images, attributes };
        output::exr::write(path, &picture).map_err(|error| cannot_write(path, &error))?;
        if let Some(png) = &places.png {
            args.png.write(png, &picture).map_err(|error| cannot_write(png, &error))?;
        }
        if !args.quiet {
            report::print(path, places.png.as_deref(), film, before, seconds);
        }
        report::warn_of_bad_values(film.bad);
    }
    kept_all?;
    if let Some(report) = statistics {
        super::print(&if args.json { report.json() } else { report.text() })?;
    }
    let ended = outcome.end(&work, is_shown, places.checkpoint.as_deref());
    let mut checkpoint = places.checkpoint.as_deref();
    if let (Some(_), Ok(()), Some(path)) = (frame, &ended, checkpoint) {
        // The picture says that it is complete.
        std::fs::remove_file(path)
            .map_err(|error| Failure::Other(format!("error: cannot remove {}: {error}", path.display())))?;
        checkpoint = None;
        // A frame that is good enough ends, and the next one begins.
        if outcome.has_decided() {
            stop.store(false, Ordering::Relaxed);
        }
    }
    if !args.quiet {
        outcome.print(checkpoint);
    }
    if let Some(page) = page {
        let written = places.picture.as_deref().filter(|_| is_shown);
        let open = |path| output::exr::Stored::open(path).map_err(|error| cannot_read(path, &error));
        let picture = written.map(open);
        page.finished(picture.transpose()?);
        // Where it was no signal that ended the render, one is still to come.
        if outcome.is_by_itself(&work) {
            stop.store(false, Ordering::Relaxed);
        }
        view::wait(stop);
    }
    ended
}

impl Args {
    pub(super) fn scene_path(&self) -> &Path {
        &self.scene.scene
    }

    /// Where the EXR goes. Refused before the render rather than after it.
    fn output_path(&self) -> Result<PathBuf, Failure> {
        let path = match &self.output {
            Some(path) if ["exr", checkpoint::EXTENSION].iter().any(|end| has_extension(path, end)) => {
                path.clone()
            }
            Some(path) => {
                return Err(Failure::Input(format!(
                    "error: {}: the output is an EXR file: name it *.exr, or *.{} to have the sums alone",
                    path.display(),
                    checkpoint::EXTENSION
                )));
            }
            None => PathBuf::from(format!("{}.exr", scene_name(&self.scene.scene))),
        };
        let folder = output::folder_of(&path);
        if folder.is_dir() {
            Ok(path)
        } else {
            Err(Failure::Input(format!(
                "error: {}: there is no folder {}\nhelp: make it first",
                path.display(),
                folder.display()
            )))
        }
    }
}

pub(super) fn has_extension(path: &Path, wanted: &str) -> bool {
    path.extension().is_some_and(|extension| extension == wanted)
}

/// The name of a scene: its folder's if the file is called `scene`, else the file's own.
pub(super) fn scene_name(scene: &Path) -> String {
    let stem = scene.file_stem().map_or_else(|| "scene".into(), |stem| stem.to_string_lossy().into_owned());
    if stem != "scene" {
        return stem;
    }
    let folder = scene.canonicalize().ok().and_then(|path| Some(path.parent()?.file_name()?.to_owned()));
    folder.map_or(stem, |folder| folder.to_string_lossy().into_owned())
}

fn content(film: &description::Film) -> Content {
    match &film.content {
        FilmContent::Colour { format, .. } => Content::Colour(match format {
            PixelFormat::Rgb => Colour::Rec709,
            PixelFormat::Xyz => Colour::Xyz,
            PixelFormat::Luminance => Colour::Luminance,
        }),
        FilmContent::Responses(channels) => {
            Content::Responses(channels.iter().map(|channel| channel.name.clone()).collect())
        }
    }
}

fn refuse_names(content: &Content, moments: Option<&[String; 2]>, aovs: &[Aov]) -> Result<(), Failure> {
    let names: Vec<String> = aovs.iter().flat_map(Aov::channels).collect();
    match Picture::refused_name(content, moments, &names) {
        None => Ok(()),
        Some(problem) => Err(Failure::Input(format!(
            "error: the picture would have {problem}\n\
             help: give each image a name of its own, for instance --aov second:depth; OpenEXR takes 255 bytes, error. included"
        ))),
    }
}

/// Largest film that is begun, bytes in memory.
const LARGEST_FILM: u128 = 32 << 30;

pub(super) fn refuse_what_no_memory_holds(scene: &Scene, settings: &Settings) -> Result<(), Failure> {
    let [width, height] = scene.film.extent.measured.size;
    let replicates = settings.schedule.replicates;
    // Spectral bins need no memory.
    let [_, bytes] = Film::bytes(width, height, replicates, &settings.extras(scene));
    if bytes <= LARGEST_FILM {
        return Ok(());
    }
    Err(Failure::Input(format!(
        "error: {width}×{height} pixels and {replicates} replicates take {} GiB of memory\n\
         help: render parts of it with --crop, or fewer replicates",
        bytes >> 30
    )))
}

/// Where the file that spectral bins are kept in cannot be made.
pub(super) fn no_room_for_bins(folder: &Path, error: &std::io::Error) -> Failure {
    Failure::Other(format!(
        "error: cannot keep the spectral bins of the film in {}: {error}\n\
         help: write to a folder on another disk, render parts of the picture with --crop, or measure fewer bins",
        folder.display()
    ))
}

pub(super) fn thread_pool(threads: Option<u32>) -> Result<rayon::ThreadPool, Failure> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads.unwrap_or(0) as usize)
        .build()
        .map_err(|error| Failure::Other(format!("error: cannot start threads: {error}")))
}

pub(super) fn cannot_write(path: &Path, error: &std::io::Error) -> Failure {
    match error.kind() {
        ErrorKind::IsADirectory => Failure::Input(format!(
            "error: cannot write {}: there is a folder of this name\n\
             help: give the output another name, or remove the folder",
            path.display()
        )),
        _ => Failure::Other(format!("error: cannot write {}: {error}", path.display())),
    }
}

/// What the scene's author should know before waiting for it.
pub(super) fn warn(scene: &Scene) {
    for warning in distinct(&scene.warnings) {
        print_message(&format!("warning: {warning}"));
    }
}
