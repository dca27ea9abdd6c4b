//! Reports of a render: attributes of its file and lines on the terminal.

use super::super::print_message;
use super::super::progress::percent;
use super::Args;
use abbe::film::{BadValues, Film, Region};
use abbe::output::target::Target;
use abbe::render::Settings;
use abbe::scene::Scene;
use abbe::scene::description::{self, Description, FilmContent, Note, PixelFormat};
use abbe::spectrum::catalogue;
use abbe::spectrum::colour::{Observer, xyz_to_rec709};
use abbe::units::WavelengthRange;
use std::ops::RangeInclusive;
use std::path::Path;

/// Attribute with the samples per pixel that were asked for: fewer are taken where a render ends early.
pub(super) const ASKED_SAMPLES: &str = "abbe.askedSamplesPerPixel";

/// How the picture was made. Nothing that differs between equal renders: no time, no threads; and nothing
/// that differs between its parts: see [`counted`].
pub(super) fn attributes(
    args: &Args,
    range: WavelengthRange,
    description: &Description,
    scene: &Scene,
    settings: &Settings,
) -> Vec<(String, String)> {
    let lines = |notes: &[Note]| distinct(notes).join("\n");
    let text = [
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
        ("sceneHash", format!("{:016x}", description.hash())),
        ("seed", settings.seed.to_string()),
        ("sampler", settings.sampler.name().to_owned()),
        ("replicates", settings.schedule.replicates.to_string()),
        ("estimator", settings.estimator.name().to_owned()),
        ("wavelengthsPerPath", per_path(settings)),
        ("wavelengthRange", format!("{} nm to {} nm", range.min, range.max)),
        ("observer", args.sampling.observer.name().to_owned()),
        ("whitePoint", white_point(&description.sensor.film, args.sampling.observer)),
        ("assumptions", lines(&description.assumptions)),
        ("extensions", lines(&description.extensions)),
        ("needs", scene.features().to_string()),
    ];
    // First, for what else differs follows from it.
    let asked = (ASKED_SAMPLES.to_owned(), settings.schedule.samples().to_string());
    std::iter::once(asked).chain(named(text)).collect()
}

/// What white is in the colours of a film. Empty where it has none.
fn white_point(film: &description::Film, observer: &Observer) -> String {
    const REC709: &str = "D65, x = 0.3127, y = 0.3290 (linear Rec. 709)";
    let FilmContent::Colour { format, .. } = &film.content else { return String::new() };
    if *format != PixelFormat::Rgb {
        return format!("none: X, Y and Z are those of {}", observer.name());
    }
    let standard = Observer::cie1931();
    let is_standard = [standard, Observer::cie1931_5nm()].iter().any(|of| of.name() == observer.name());
    let Some(d65) = catalogue::illuminant("D65").ok().filter(|_| !is_standard) else {
        return REC709.to_owned();
    };
    let all = WavelengthRange::VISIBLE;
    let [r, g, b] = xyz_to_rec709(observer.xyz_of(&d65, all) / standard.xyz_of(&d65, all).y);
    format!(
        "{REC709}; X, Y and Z are those of {}, by which D65 of Y = 1 by {} has R = {r:.3}, G = {g:.3}, B = {b:.3}",
        observer.name(),
        standard.name()
    )
}

/// What the film itself says of how it was made.
pub(in crate::cli) fn counted(film: &Film) -> Vec<(String, String)> {
    named([
        ("samplesPerPixel", sample_count(&film.samples_per_pixel())),
        ("samples", film.total_samples().to_string()),
        ("badValues", film.bad.total().to_string()),
    ])
}

pub(super) fn named<const N: usize>(text: [(&str, String); N]) -> Vec<(String, String)> {
    text.into_iter()
        .filter(|(_, value)| !value.is_empty())
        .map(|(name, value)| (format!("abbe.{name}"), value))
        .collect()
}

/// What all parts of a picture have in common, and what makes another picture of it where it differs.
pub(super) fn identity(
    args: &Args,
    range: WavelengthRange,
    description: &Description,
    settings: &Settings,
    images: &[String],
) -> Vec<(String, String)> {
    let schedule = settings.schedule();
    let film = &description.sensor.film;
    let bins = settings.bins.map_or("none".to_owned(), |bins| bins.count.to_string());
    let text = [
        ("build", format!("{} of sources {}", env!("CARGO_PKG_VERSION"), env!("ABBE_SOURCES"))),
        ("size", format!("{}×{}", film.width, film.height)),
        ("seed", settings.seed.to_string()),
        ("samples per pixel", schedule.samples().to_string()),
        ("sampler", settings.sampler.name().to_owned()),
        ("replicates", format!("{} in {} nets", schedule.replicates, schedule.nets())),
        ("estimator", settings.estimator.name().to_owned()),
        ("wavelengths per path", per_path(settings)),
        ("range of wavelengths", format!("{}:{}", range.min, range.max)),
        ("observer", args.sampling.observer.name().to_owned()),
        ("spectral bins", bins),
        ("images", images.join(", ")),
        ("scene", format!("{:016x}", description.hash())),
    ];
    text.map(|(name, value)| (name.to_owned(), value)).to_vec()
}

/// How many wavelengths a path carries, as far as the settings say.
fn per_path(settings: &Settings) -> String {
    settings.wavelengths.map_or("4 or 8, by a pilot".to_owned(), |count| count.to_string())
}

/// What notes say, each once and with the number of places that it is said of.
pub(super) fn distinct(notes: &[Note]) -> Vec<String> {
    let mut texts: Vec<(&str, usize)> = Vec::new();
    for note in notes {
        match texts.iter_mut().find(|(text, _)| *text == note.text) {
            Some((_, times)) => *times += 1,
            None => texts.push((&note.text, 1)),
        }
    }
    let text =
        |(text, times)| if times == 1 { String::from(text) } else { format!("{text} ({times} places)") };
    texts.into_iter().map(text).collect()
}

/// A number of samples as text, or a range, which a stopped render has.
pub(in crate::cli) fn sample_count(samples: &RangeInclusive<u64>) -> String {
    let (fewest, most) = (samples.start(), samples.end());
    if fewest == most { fewest.to_string() } else { format!("{fewest} to {most}") }
}

/// What was rendered, of which so many samples were there before, and the time that the others took, s.
pub(super) fn print(path: &Path, png: Option<&Path>, film: &Film, before: u64, seconds: f64) {
    let done = film.total_samples();
    let Region { size: [width, height], .. } = film.extent.shown;
    let pixels = film.extent.shown.pixel_count();
    // Pixels that err more may have more than others.
    let per_pixel = (10.0 * done as f64 / pixels as f64).round() / 10.0;
    let error = Target::mean_error(film).map_or("its error is not known".to_owned(), |error| {
        let of = if film.extras.responses.is_empty() { "luminance" } else { "response" };
        format!("error {} of the mean {of}", percent(error))
    });
    let speed = match done - before {
        0 => "nothing left to do".to_owned(),
        taken => format!("{seconds:.1} s, {:.2} million samples/s", taken as f64 / seconds.max(1e-9) / 1e6),
    };
    print_message(&format!(
        "{}{}: {}×{}, {} samples per pixel in {} replicates, {error}, {speed}",
        path.display(),
        png.map_or_else(String::new, |png| format!(" and {}", png.display())),
        width,
        height,
        per_pixel,
        film.replicates,
    ));
}

/// Says what the picture lacks, also where little else is printed: it is darker for it.
pub(super) fn warn_of_bad_values(bad: BadValues) {
    if bad.total() > 0 {
        print_message(&format!(
            "warning: left out {} values: {} not a number, {} infinite, {} negative, {} too large",
            bad.total(),
            bad.not_a_number,
            bad.infinite,
            bad.negative,
            bad.overflow
        ));
    }
}
