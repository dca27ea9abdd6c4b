use super::progress::{Progress, percent};
use super::scene_options::{PictureOptions, SceneOptions};
use super::stop::stop_on_signal;
use super::{Failure, tell};
use abbe::film::{Film, Region, SpectralBins};
use abbe::integrator::Estimator;
use abbe::output::{self, Colour, Content, Picture};
use abbe::render::{Schedule, Settings, WavelengthCount, auxiliary, render};
use abbe::sampling::SamplerKind;
use abbe::scene::description::{self, Aov, Description, FilmContent, Moments, Note, PixelFormat};
use abbe::scene::{CompileOptions, Scene, compile};
use abbe::spectrum::colour::Observer;
use abbe::units::WavelengthRange;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

/// Render a scene to an EXR with error bars, and a PNG to look at
///
/// Without -o the files land in the current folder under the name of the scene's folder. The picture depends on
/// the scene, the seed and the number of samples alone: threads change only how long it takes. Ctrl-C, SIGTERM or
/// SIGHUP end the render and write what is done, with exit code 3; nothing is written before every pixel has a sample.
/// The second ends the program at once.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneOptions,

    /// Where to write the picture; a PNG of the same name lands beside it
    #[arg(short, long, value_name = "OUT.exr")]
    output: Option<PathBuf>,

    /// Samples per pixel, dealt into replicates whose spread gives the error [default: what the scene says]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1 << 24))]
    spp: Option<u32>,

    /// Independent replicates that the samples are dealt into. Few make a picture less noisy, for its samples are spread
    /// better together, and its error bars less sure; 1 has none [default: 4 to 16, by the number of samples]
    #[arg(long, value_name = "R", value_parser = clap::value_parser!(u32).range(1..=1024))]
    replicates: Option<u32>,

    /// Seed of the sample values [default: what the scene says]
    #[arg(long, value_name = "N")]
    seed: Option<u64>,

    /// Threads to render with [default: as many as there are cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    threads: Option<u32>,

    /// Sampler: regular (no error bars), independent, jittered, poisson, sobol (Owen-scrambled) or bluenoise [default: what
    /// the scene says, else sobol]
    #[arg(long, value_name = "S", value_parser = parse_sampler)]
    sampler: Option<SamplerKind>,

    /// Wavelengths that a path carries: 1, 4 or 8. The expectation is the same, noise and time are not
    #[arg(long, value_name = "C", default_value = "4", value_parser = parse_wavelengths)]
    wavelengths: WavelengthCount,

    /// Estimator: shared (pixels share the suffixes of their paths) or plain (each pixel traces its own). The expectation is
    /// the same, noise and time are not
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

    /// Colour matching functions: cie1931, cie1931-5nm (as Mitsuba tabulates it), cie1964, cie2015-2 or cie2015-10
    #[arg(long, value_name = "NAME", default_value = "cie1931", value_parser = parse_observer)]
    observer: &'static Observer,

    /// Also write images of what the camera sees first, each with its standard error: albedo, depth,
    /// position, uv, geo_normal, sh_normal, dp_du, dp_dv, prim_index, shape_index, material_index. NAME:TYPE
    /// gives the channels another name
    #[arg(long, value_name = "TYPES", value_delimiter = ',', value_parser = Aov::of_word)]
    aov: Vec<Aov>,

    /// Print nothing but errors
    #[arg(short, long)]
    quiet: bool,
}

pub fn run(args: &Args) -> Result<(), Failure> {
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
    let path = args.output_path()?;
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
            tell(&format!("assumed: {assumption}"));
        }
        if settings.schedule.samples() != u64::from(sampler.sample_count) {
            tell(&format!(
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
    let png = path.with_extension("png");
    for path in [&path, &png] {
        output::refuse_unwritable(path).map_err(|error| cannot_write(path, &error))?;
    }
    let stop = stop_on_signal()?;
    let pixels = scene.film.extent.measured.pixel_count();
    let mut progress = Progress::new(pixels, settings.schedule, args.quiet, stop);
    let film = pool.install(|| render(&scene, &settings, &progress));
    let seconds = progress.elapsed().as_secs_f64();
    progress.finish();
    let done = film.samples_per_pixel();
    if *done.start() == 0 {
        return Err(Failure::Stopped(
            "stopped: not every pixel had a sample yet, so nothing is written".to_owned(),
        ));
    }
    let picture = Picture {
        film: &film,
        content,
        moments,
        auxiliary: pool.install(|| auxiliary(&scene, &aovs, range, settings.schedule(), settings.seed)),
        attributes: attributes(args, range, &description, &scene, &settings, &film),
    };
    output::exr::write(&path, &picture).map_err(|error| cannot_write(&path, &error))?;
    output::png::write(&png, &picture).map_err(|error| cannot_write(&png, &error))?;
    if !args.quiet {
        report(&path, &png, &film, &settings, seconds);
    }
    if *done.start() < settings.schedule.samples() {
        return Err(Failure::Stopped(format!(
            "stopped: {} of {} samples per pixel were done, and are written",
            told(&done),
            settings.schedule.samples()
        )));
    }
    Ok(())
}

impl Args {
    /// What the command line says goes over what the file says.
    fn apply_to(&self, description: &mut Description) {
        let sensor = &mut description.sensor;
        sensor.sampler.sample_count = self.spp.unwrap_or(sensor.sampler.sample_count);
        sensor.sampler.seed = self.seed.unwrap_or(sensor.sampler.seed);
        sensor.sampler.kind = self.sampler.unwrap_or(sensor.sampler.kind);
        self.picture.apply_to(description);
    }

    /// Where the EXR goes. Refused before the render rather than after it.
    fn output_path(&self) -> Result<PathBuf, Failure> {
        let path = match &self.output {
            Some(path) if path.extension().is_some_and(|extension| extension == "exr") => path.clone(),
            Some(path) => {
                return Err(Failure::Input(format!(
                    "error: {}: the output is an EXR file: name it *.exr",
                    path.display()
                )));
            }
            None => PathBuf::from(format!("{}.exr", scene_name(&self.scene.scene))),
        };
        let folder = match path.parent() {
            Some(folder) if folder != Path::new("") => folder,
            _ => Path::new("."),
        };
        if folder.is_dir() {
            Ok(path)
        } else {
            Err(Failure::Input(format!("error: {}: there is no folder {}", path.display(), folder.display())))
        }
    }
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

/// Largest film that is begun, bytes.
const LARGEST_FILM: u128 = 32 << 30;

pub(super) fn refuse_what_no_memory_holds(scene: &Scene, settings: &Settings) -> Result<(), Failure> {
    let [width, height] = scene.film.extent.measured.size;
    let replicates = settings.schedule.replicates;
    let bytes = Film::bytes(width, height, replicates, &settings.extras(scene));
    if bytes <= LARGEST_FILM {
        return Ok(());
    }
    let bins = settings.bins.map_or(0, |bins| bins.count);
    Err(Failure::Input(format!(
        "error: {width}×{height} pixels, {replicates} replicates and {bins} spectral bins take {} GiB of memory\n\
         help: render parts of it with --crop, or fewer bins",
        bytes >> 30
    )))
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

/// How the picture was made. Nothing that differs between equal renders: no time, no threads.
fn attributes(
    args: &Args,
    range: WavelengthRange,
    description: &Description,
    scene: &Scene,
    settings: &Settings,
    film: &Film,
) -> Vec<(String, String)> {
    let lines = |notes: &[Note]| distinct(notes).join("\n");
    let text = [
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
        ("sceneHash", format!("{:016x}", description.hash())),
        ("seed", settings.seed.to_string()),
        ("sampler", settings.sampler.name().to_owned()),
        ("samplesPerPixel", told(&film.samples_per_pixel())),
        ("samples", film.total_samples().to_string()),
        ("replicates", settings.schedule.replicates.to_string()),
        ("estimator", settings.estimator.name().to_owned()),
        ("wavelengthsPerPath", settings.wavelengths.get().to_string()),
        ("wavelengthRange", format!("{} nm to {} nm", range.min, range.max)),
        ("observer", args.observer.name().to_owned()),
        ("whitePoint", "D65, x = 0.3127, y = 0.3290 (linear Rec. 709)".to_owned()),
        ("badValues", film.bad.total().to_string()),
        ("assumptions", lines(&description.assumptions)),
        ("extensions", lines(&description.extensions)),
        ("needs", scene.needs().to_string()),
    ];
    text.into_iter()
        .filter(|(_, value)| !value.is_empty())
        .map(|(name, value)| (format!("abbe.{name}"), value))
        .collect()
}

/// What notes say, each once and with the number of places that it is said of.
fn distinct(notes: &[Note]) -> Vec<String> {
    let mut texts: Vec<(&str, usize)> = Vec::new();
    for note in notes {
        match texts.iter_mut().find(|(text, _)| *text == note.text) {
            Some((_, times)) => *times += 1,
            None => texts.push((&note.text, 1)),
        }
    }
    let told =
        |(text, times)| if times == 1 { String::from(text) } else { format!("{text} ({times} places)") };
    texts.into_iter().map(told).collect()
}

/// What the scene's author should know before waiting for it.
pub(super) fn warn(scene: &Scene) {
    for warning in distinct(&scene.warnings) {
        tell(&format!("warning: {warning}"));
    }
}

/// Numbers of samples, of which a stopped render has several.
fn told(samples: &RangeInclusive<u64>) -> String {
    let (fewest, most) = (samples.start(), samples.end());
    if fewest == most { fewest.to_string() } else { format!("{fewest} to {most}") }
}

fn report(path: &Path, png: &Path, film: &Film, settings: &Settings, seconds: f64) {
    let done = film.total_samples();
    let Region { size: [width, height], .. } = film.extent.shown;
    let pixels = film.extent.shown.pixel_count();
    let error =
        film.relative_error().map_or("error not known".to_owned(), |e| format!("error {}", percent(e)));
    tell(&format!(
        "{} and {}: {}×{}, {:.0} samples per pixel in {} replicates, {error} of the mean luminance, {:.1} s, {:.2} million samples/s",
        path.display(),
        png.display(),
        width,
        height,
        done as f64 / pixels as f64,
        settings.schedule.replicates,
        seconds,
        done as f64 / seconds.max(1e-9) / 1e6,
    ));
    let bad = film.bad;
    if bad.total() > 0 {
        tell(&format!(
            "warning: left out {} values: {} not a number, {} infinite, {} negative, {} too large",
            bad.total(),
            bad.not_a_number,
            bad.infinite,
            bad.negative,
            bad.overflow
        ));
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
