mod long;
mod report;

use super::png_options::PngOptions;
use super::scene_options::{PictureOptions, SceneOptions};
use super::stop::stop_on_signal;
use super::view::{self, Page};
use super::{Failure, print_message};
use abbe::film::{Film, Place, SpectralBins};
use abbe::integrator::Estimator;
use abbe::output::{self, Colour, Content, Picture, checkpoint};
use abbe::render::{Schedule, Settings, WavelengthCount, Work, auxiliary, go_on};
use abbe::sampling::SamplerKind;
use abbe::scene::description::{self, Aov, Description, FilmContent, Moments, PixelFormat};
use abbe::scene::{CompileOptions, Scene, compile};
use abbe::spectrum::colour::Observer;
use abbe::units::WavelengthRange;
pub(super) use long::cannot_read;
use long::{Kept, LongOptions, Viewers, Watching};
use report::distinct;
pub(super) use report::{counted, sample_count};
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

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

    /// Samples per pixel, the mean over the picture: a pilot gives more to pixels that err more. They are
    /// dealt into replicates whose spread gives the error [default: what the scene says]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1 << 24))]
    spp: Option<u32>,

    /// Independent replicates that the samples are dealt into. Few make a picture less noisy, for its samples
    /// are spread better together, and its error bars less sure; 1 has none [default: 4 to 16, by the number
    /// of samples]
    #[arg(long, value_name = "R", value_parser = clap::value_parser!(u32).range(1..=1024))]
    replicates: Option<u32>,

    /// Seed of the sample values [default: what the scene says]
    #[arg(long, value_name = "N")]
    seed: Option<u64>,

    /// Threads to render with [default: as many as there are cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    threads: Option<u32>,

    /// Sampler: regular (no error bars), independent, jittered, poisson, sobol (Owen-scrambled) or bluenoise
    /// [default: what the scene says, else sobol]
    #[arg(long, value_name = "S", value_parser = parse_sampler)]
    sampler: Option<SamplerKind>,

    /// Wavelengths that a path carries: 1, 4 or 8. The expectation is the same, noise and time are not
    #[arg(long, value_name = "C", default_value = "4", value_parser = parse_wavelengths)]
    wavelengths: WavelengthCount,

    /// Estimator: shared (pixels share the suffixes of their paths, and samples go where pixels err) or plain
    /// (each pixel traces its own paths, all the same number). The expectation is the same, noise and time
    /// are not
    #[arg(long, value_name = "E", default_value = "shared", value_parser = parse_estimator)]
    estimator: Estimator,

    #[command(flatten)]
    picture: PictureOptions,

    /// Also write N spectral bins (47 without N) over the range of wavelengths, each with its standard error
    #[arg(long, value_name = "N", num_args = 0..=1, default_missing_value = "47", value_parser = clap::value_parser!(u32).range(1..=4096))]
    spectral: Option<u32>,

    /// Wavelengths that are simulated, in nm [default: 360:830 and whatever else a specfilm responds to]
    #[arg(long, value_name = "MIN:MAX", value_parser = parse_range)]
    range: Option<WavelengthRange>,

    /// Colour matching functions: cie1931, cie1931-5nm (as Mitsuba tabulates it), cie1964, cie2015-2 or
    /// cie2015-10
    #[arg(long, value_name = "NAME", default_value = "cie1931", value_parser = parse_observer)]
    observer: &'static Observer,

    /// Also write images of what the camera sees first, each with its standard error: albedo, depth,
    /// position, uv, geo_normal, sh_normal, dp_du, dp_dv, prim_index, shape_index, material_index. NAME:TYPE
    /// gives the channels another name
    #[arg(long, value_name = "TYPES", value_delimiter = ',', value_parser = Aov::of_word)]
    aov: Vec<Aov>,

    #[command(flatten)]
    long: LongOptions,

    #[command(flatten)]
    png: PngOptions,

    /// Print nothing but errors
    #[arg(short, long)]
    quiet: bool,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    run_shown(args, None)
}

/// Renders, and shows on a page what is done so far and then the finished picture, until a signal comes.
pub(super) fn run_shown(args: &Args, page: Option<&Page>) -> Result<(), Failure> {
    let mut description = args.scene.read()?;
    args.apply_to(&mut description);
    let range = args.range.unwrap_or_else(|| description.sensor.film.wavelength_range());
    let description = description.over(range);
    let options = CompileOptions {
        range,
        observer: args.observer,
        spectral: args.spectral.is_some(),
        part: args.picture.part(output::MARGIN, output::SQUARE),
    };
    let scene = compile(&description, &options).map_err(|errors| Failure::Input(errors.to_string()))?;
    let output = args.output_path()?;
    let sampler = &description.sensor.sampler;
    let settings = Settings {
        schedule: match args.replicates {
            Some(replicates) if sampler.kind.is_random() => {
                Schedule::with_replicates(sampler.sample_count, replicates)
            }
            _ => Schedule::of(sampler.kind, sampler.sample_count),
        },
        seed: sampler.seed,
        sampler: sampler.kind,
        wavelengths: args.wavelengths,
        estimator: args.estimator,
        bins: args.spectral.map(|count| SpectralBins { range, count: count as usize }),
    };
    if !args.quiet {
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
        warn(&scene);
    }
    refuse_what_no_memory_holds(&scene, &settings)?;
    let aovs = [description.integrator.aovs.clone(), args.aov.clone()].concat();
    let content = content(&description.sensor.film);
    let moments = description.integrator.moments.as_ref().map(Moments::stems);
    refuse_repeated_names(&content, moments.as_ref(), &aovs)?;
    let pool = thread_pool(args.threads)?;
    let places = args.long.places(&output, args.png.is_wanted());
    let names: Vec<String> = aovs.iter().flat_map(Aov::channels).collect();
    let kept = Kept {
        path: places.checkpoint.clone(),
        identity: report::identity(args, range, &description, &settings, &names),
        picture: checkpoint::Description {
            content,
            moments,
            attributes: report::attributes(args, range, &description, &scene, &settings),
        },
        samples_per_pixel: settings.schedule().samples(),
        threads: pool.current_num_threads(),
    };
    let samples = args.long.samples(settings.schedule())?;
    let folder = output::folder_of(&output);
    let work = Work::new_at(Place::Folder(folder), &scene, &settings, samples)
        .map_err(|error| no_room_for_bins(folder, &error))?;
    let work = kept.begin(work, &args.long, args.quiet)?;
    places.refuse_unwritable()?;
    let viewer = args.long.viewer(&output.to_string_lossy())?;
    let stop = stop_on_signal()?;
    let long =
        Watching::new(&kept, &args.long, &work, args.quiet, Viewers { tev: viewer, page }, stop.clone());
    let work = pool.install(|| go_on(&scene, &settings, work, &long));
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
        let attributes = [attributes, report::counted(film), outcome.attributes()].concat();
        let picture = Picture { film, content, moments, auxiliary: images, attributes };
        output::exr::write(path, &picture).map_err(|error| cannot_write(path, &error))?;
        if let Some(png) = &places.png {
            output::png::write(png, &picture, args.png.exposure)
                .map_err(|error| cannot_write(png, &error))?;
        }
        if !args.quiet {
            report::print(path, places.png.as_deref(), film, seconds);
        }
    }
    kept_all?;
    if !args.quiet {
        outcome.print(places.checkpoint.as_deref());
    }
    if let Some(page) = page {
        let written = places.picture.as_deref().filter(|_| is_shown);
        let picture = written.map(|path| output::exr::read(path).map_err(|error| cannot_read(path, &error)));
        page.finished(picture.transpose()?);
        // Where it was no signal that ended the render, one is still to come.
        if outcome.is_by_itself(&work) {
            stop.store(false, Ordering::Relaxed);
        }
        view::wait(&stop);
    }
    outcome.end(&work, is_shown, places.checkpoint.as_deref())
}

impl Args {
    pub(super) fn scene_path(&self) -> &Path {
        &self.scene.scene
    }

    /// What the command line says goes over what the file says.
    fn apply_to(&self, description: &mut Description) {
        let sensor = &mut description.sensor;
        sensor.sampler.sample_count = self.spp.unwrap_or(match self.long.ends_early() {
            true => long::MOST_SAMPLES,
            false => sensor.sampler.sample_count,
        });
        sensor.sampler.seed = self.seed.unwrap_or(sensor.sampler.seed);
        sensor.sampler.kind = self.sampler.unwrap_or(sensor.sampler.kind);
        self.picture.apply_to(description);
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
            Err(Failure::Input(format!("error: {}: there is no folder {}", path.display(), folder.display())))
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

fn refuse_repeated_names(
    content: &Content,
    moments: Option<&[String; 2]>,
    aovs: &[Aov],
) -> Result<(), Failure> {
    let names: Vec<String> = aovs.iter().flat_map(Aov::channels).collect();
    match Picture::repeated_name(content, moments, &names) {
        None => Ok(()),
        Some(name) => Err(Failure::Input(format!(
            "error: the picture would have two channels \"{name}\"\n\
             help: give each image a name of its own, for instance --aov second:depth"
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
    Failure::Other(format!("error: cannot write {}: {error}", path.display()))
}

/// What the scene's author should know before waiting for it.
pub(super) fn warn(scene: &Scene) {
    for warning in distinct(&scene.warnings) {
        print_message(&format!("warning: {warning}"));
    }
}

fn parse_sampler(text: &str) -> Result<SamplerKind, String> {
    SamplerKind::named(text).ok_or_else(|| {
        let names: Vec<_> = SamplerKind::NAMES.iter().map(|&(name, _)| name).collect();
        format!("expected one of {}", names.join(", "))
    })
}

fn parse_estimator(text: &str) -> Result<Estimator, String> {
    Estimator::named(text).ok_or_else(|| "expected shared or plain".to_owned())
}

pub(super) fn parse_wavelengths(text: &str) -> Result<WavelengthCount, String> {
    let count: u32 = text.parse().map_err(|_| "expected 1, 4 or 8")?;
    Ok(count.try_into()?)
}

fn parse_range(text: &str) -> Result<WavelengthRange, String> {
    let ends = text.split_once(':').and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)));
    match ends {
        Some((min, max))
            if WavelengthRange::WIDEST.min <= min && min < max && max <= WavelengthRange::WIDEST.max =>
        {
            Ok(WavelengthRange { min, max })
        }
        _ => {
            Err("expected MIN:MAX in nm, from 1 to 100000 and with MIN below MAX, for example 380:780"
                .to_owned())
        }
    }
}

fn parse_observer(text: &str) -> Result<&'static Observer, String> {
    match text {
        "cie1931" => Ok(Observer::cie1931()),
        "cie1931-5nm" => Ok(Observer::cie1931_5nm()),
        "cie1964" => Ok(Observer::cie1964()),
        "cie2015-2" => Ok(Observer::cie2015_2deg()),
        "cie2015-10" => Ok(Observer::cie2015_10deg()),
        _ => Err("expected cie1931, cie1931-5nm, cie1964, cie2015-2 or cie2015-10".to_owned()),
    }
}
