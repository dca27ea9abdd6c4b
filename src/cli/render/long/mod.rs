//! Renders that take long: what is kept of them on the way, and where they go on.

mod kept;
mod watching;

use super::super::tev::Tev;
use super::super::{Failure, refuse_to_replace};
use super::until::{UntilOptions, parse_time};
use super::{cannot_write, has_extension};
use abbe::output::checkpoint;
use abbe::output::{self};
use abbe::render::Schedule;
use abbe::scene::Description;
pub use kept::{Kept, cannot_read, cannot_read_content};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Duration;
pub use watching::{Viewers, Watching};

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
    /// [default: 1m]
    #[arg(long, value_name = "TIME", value_parser = parse_time, allow_hyphen_values = true)]
    checkpoint_every: Option<Duration>,

    /// Render samples A to B − 1 of each pixel alone, counted from 0, of all that --spp says: a part for abbe
    /// merge. Implies --checkpoint
    #[arg(long, value_name = "A..B", value_parser = parse_samples, allow_hyphen_values = true, conflicts_with_all = ["until", "time"])]
    samples: Option<Range<u64>>,

    #[command(flatten)]
    pub until: UntilOptions,

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
    /// Refuses to write over what the scene is read from.
    pub fn refuse_files_of(&self, description: &Description) -> Result<(), Failure> {
        let name = "give the picture another name with -o";
        let png = "give the picture another name with -o, or leave out the PNG with --no-png";
        for (path, remedy) in [(&self.picture, name), (&self.png, png), (&self.checkpoint, name)] {
            if let Some(path) = path {
                refuse_to_replace(description, path, remedy)?;
            }
        }
        Ok(())
    }

    /// Refused before the render rather than after it.
    pub fn refuse_unwritable(&self) -> Result<(), Failure> {
        for path in [&self.picture, &self.png, &self.checkpoint].into_iter().flatten() {
            output::refuse_unwritable(path).map_err(|error| cannot_write(path, &error))?;
        }
        Ok(())
    }
}

impl LongOptions {
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

    /// Refuses a time between checkpoints where there are none.
    pub fn refuse_without_checkpoint(&self, output: &Path, with_frames: bool) -> Result<(), Failure> {
        let is_kept = self.places(output, false, with_frames).checkpoint.is_some();
        match self.checkpoint_every {
            Some(_) if !is_kept => Err(Failure::Input(
                "error: --checkpoint-every: no checkpoint is kept\n\
                 help: add --checkpoint, or --resume to go on from one, or leave it out"
                    .to_owned(),
            )),
            _ => Ok(()),
        }
    }

    /// The time between checkpoints.
    fn between_checkpoints(&self) -> Duration {
        self.checkpoint_every.unwrap_or(Duration::from_secs(60))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_read() {
        assert_eq!(parse_samples("64..128"), Ok(64..128));
        for wrong in ["64", "4..4", "5..4", "..4", "a..b"] {
            assert!(parse_samples(wrong).is_err(), "{wrong}");
        }
    }
}
