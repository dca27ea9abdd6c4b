//! Renders that take long: what is kept of them on the way, where they go on, and when they are good enough.

mod kept;
mod outcome;
mod watching;

use super::super::Failure;
use super::super::tev::Tev;
use super::{cannot_write, has_extension};
use abbe::output::checkpoint;
use abbe::output::target::Target;
use abbe::output::{self};
use abbe::render::Schedule;
pub use kept::{Kept, cannot_read};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Duration;
pub use watching::{Viewers, Watching};

/// Samples of each pixel at which a render ends that is to end at an error or a time, and is not told
/// otherwise.
pub const MOST_SAMPLES: u32 = 1 << 20;

/// Options of renders that take long.
#[derive(clap::Args)]
#[command(next_help_heading = "Long renders")]
pub struct LongOptions {
    /// Keep what is done in OUT.checkpoint, every minute and when the render is stopped. --resume goes on
    /// from it, to the same bits as without a break; abbe merge puts several of them together. It stays
    /// beside the picture
    #[arg(long)]
    checkpoint: bool,

    /// Go on from OUT.checkpoint, if there is one. Implies --checkpoint
    #[arg(long)]
    resume: bool,

    /// Time between checkpoints, such as 30s, 10m or 2h. They take a twentieth of the time at most
    #[arg(long, value_name = "TIME", default_value = "1m", value_parser = parse_time)]
    checkpoint_every: Duration,

    /// Render samples A to B − 1 of each pixel alone, counted from 0, of all that --spp says: a part for abbe
    /// merge. Implies --checkpoint
    #[arg(long, value_name = "A..B", value_parser = parse_samples, conflicts_with_all = ["until", "time"])]
    samples: Option<Range<u64>>,

    /// End when the error of the luminance (or of all responses of a specfilm) is below a bound with 95 %
    /// confidence: 'relmse<1e-3' (as abbe compare has it), 'error<1%' (mean standard error over mean) or, of
    /// the colours, 'de<0.5' (the mean of each pixel's root mean square CIEDE2000, with the white of abbe
    /// compare). It is looked at four times for each doubling of the samples. --spp is then the most samples
    /// that are taken [default then: 1048576]
    #[arg(long, value_name = "TARGET")]
    until: Option<Target>,

    /// End after this time, such as 90s, 10m or 2h, but not before each pixel has a sample. --spp is then the
    /// most samples that are taken [default then: 1048576]
    #[arg(long, value_name = "TIME", value_parser = parse_time)]
    time: Option<Duration>,

    /// Show the picture in the making in tev, an image viewer that listens at this address, such as
    /// 127.0.0.1:14158
    #[arg(long, value_name = "HOST:PORT")]
    tev: Option<String>,
}

/// Where the files go.
pub struct Places {
    pub picture: Option<PathBuf>,
    pub png: Option<PathBuf>,
    pub checkpoint: Option<PathBuf>,
}

impl Places {
    /// Refused before the render rather than after it.
    pub fn refuse_unwritable(&self) -> Result<(), Failure> {
        for path in [&self.picture, &self.png, &self.checkpoint].into_iter().flatten() {
            output::refuse_unwritable(path).map_err(|error| cannot_write(path, &error))?;
        }
        Ok(())
    }
}

impl LongOptions {
    /// Whether a render may end before it has the samples that are asked for.
    pub fn ends_early(&self) -> bool {
        self.until.is_some() || self.time.is_some()
    }

    pub fn resumes(&self) -> bool {
        self.resume
    }

    /// The viewer that is asked for.
    pub fn viewer(&self, name: &str) -> Result<Option<Tev>, Failure> {
        let connect = |address: &String| {
            Tev::new(address, name).map_err(|error| {
                Failure::Input(format!(
                    "error: --tev {address}: {error}\nhelp: start tev there; by default it listens at 127.0.0.1:14158"
                ))
            })
        };
        self.tev.as_ref().map(connect).transpose()
    }

    /// Where the files go, by the name of one. Frames of an animation are always kept on the way.
    pub fn places(&self, output: &Path, with_png: bool, is_frame: bool) -> Places {
        if has_extension(output, checkpoint::EXTENSION) {
            return Places { picture: None, png: None, checkpoint: Some(output.to_owned()) };
        }
        let is_kept = self.checkpoint || self.resume || self.samples.is_some() || is_frame;
        Places {
            picture: Some(output.to_owned()),
            png: with_png.then(|| output.with_extension("png")),
            checkpoint: is_kept.then(|| output.with_extension(checkpoint::EXTENSION)),
        }
    }

    /// The samples of each pixel that are asked for, where not all are.
    pub fn samples(&self, schedule: Schedule) -> Result<Option<Range<u64>>, Failure> {
        let all = schedule.samples();
        match &self.samples {
            Some(samples) if samples.end > all => Err(Failure::Input(format!(
                "error: --samples {}..{}: a pixel has {all} samples\nhelp: --spp says how many there are in all parts together",
                samples.start, samples.end
            ))),
            samples => Ok(samples.clone()),
        }
    }
}

fn parse_samples(text: &str) -> Result<Range<u64>, String> {
    let ends =
        text.split_once("..").and_then(|(a, b)| Some((a.trim().parse().ok()?, b.trim().parse().ok()?)));
    match ends {
        Some((start, end)) if start < end => Ok(start..end),
        _ => Err("expected A..B, samples A to B − 1, for example 0..64 and 64..128".to_owned()),
    }
}

/// A time with its unit: s, m or h.
fn parse_time(text: &str) -> Result<Duration, String> {
    let wrong = || "expected a time such as 90s, 10m or 1.5h".to_owned();
    let (number, unit) = match text.trim().char_indices().last() {
        Some((at, 's')) => (&text[..at], 1.0),
        Some((at, 'm')) => (&text[..at], 60.0),
        Some((at, 'h')) => (&text[..at], 3600.0),
        _ => (text, 1.0),
    };
    let seconds = unit * number.trim().parse::<f64>().map_err(|_| wrong())?;
    Duration::try_from_secs_f64(seconds).ok().filter(|time| !time.is_zero()).ok_or_else(wrong)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_and_ranges_are_read() {
        let seconds = |text| parse_time(text).map(|time| time.as_secs_f64());
        assert_eq!([seconds("90"), seconds("90s"), seconds("1.5m")], [const { Ok(90.0) }; 3]);
        assert_eq!(seconds("2h"), Ok(7200.0));
        for wrong in ["", "m", "-1s", "0", "1d", "nan", "1e400s"] {
            assert!(parse_time(wrong).is_err(), "{wrong}");
        }
        assert_eq!(parse_samples("64..128"), Ok(64..128));
        for wrong in ["64", "4..4", "5..4", "..4", "a..b"] {
            assert!(parse_samples(wrong).is_err(), "{wrong}");
        }
    }
}
