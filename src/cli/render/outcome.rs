use super::super::{Failure, print_message};
use super::report;
use abbe::output::target::{self, Estimate, Target};
use abbe::render::Work;
use std::path::Path;

/// What became of a render that may have ended before its last sample.
pub struct Outcome {
    pub(super) target: Option<Target>,
    pub(super) estimate: Option<Estimate>,
    pub(super) is_met: bool,
    pub(super) is_out_of_time: bool,
}

impl Outcome {
    /// What was asked for and reached, where an error was asked for.
    pub fn attributes(&self) -> Vec<(String, String)> {
        let Some(target) = self.target else { return Vec::new() };
        let reached = |value: fn(Estimate) -> f64| {
            self.estimate.map_or_else(String::new, |estimate| target.told(value(estimate)))
        };
        report::named([
            ("asked", target.to_string()),
            ("reached", reached(|estimate| estimate.value)),
            ("reachedAtMost", reached(|estimate| estimate.at_most)),
            ("confidence", target::CONFIDENCE.to_string()),
        ])
    }

    /// Whether it ended because it was good enough or out of time, and not for a signal.
    pub fn has_decided(&self) -> bool {
        self.is_met || self.is_out_of_time
    }

    /// Whether no signal ended the render.
    pub fn is_by_itself(&self, work: &Work) -> bool {
        self.has_decided() || work.is_finished()
    }

    /// Says whether what was asked for is reached.
    pub fn print(&self, checkpoint: Option<&Path>) {
        if let Some(target) = self.target {
            print_message(&format!(
                "{target} is {}reached: {}",
                if self.is_met { "" } else { "not " },
                self.told(target)
            ));
        }
        if let Some(path) = checkpoint {
            print_message(&format!("{}: all that is done, for --resume and abbe merge", path.display()));
        }
    }

    fn told(&self, target: Target) -> String {
        match self.estimate {
            Some(Estimate { value, at_most }) => {
                let percent = 100.0 * target::CONFIDENCE;
                format!(
                    "{}, at most {} with {percent} % confidence",
                    target.told(value),
                    target.told(at_most)
                )
            }
            None => "its error is not known".to_owned(),
        }
    }

    /// Whether the render is what was asked for.
    pub fn end(&self, work: &Work, is_shown: bool, checkpoint: Option<&Path>) -> Result<(), Failure> {
        let asked = work.samples().end - work.samples().start;
        let goes_on = checkpoint.map_or("", |_| "; --resume goes on");
        match self.target {
            Some(target) if !self.is_met && (work.is_finished() || self.is_out_of_time) => {
                let limit = if self.is_out_of_time { "--time" } else { "--spp" };
                Err(Failure::Stopped(format!(
                    "{target} is not reached within {limit}: what is done is written"
                )))
            }
            _ if self.is_met || self.is_out_of_time || work.is_finished() => Ok(()),
            _ if is_shown || checkpoint.is_some() => Err(Failure::Stopped(format!(
                "stopped: {} of {asked} samples per pixel were done, and are written{goes_on}",
                report::sample_count(&work.film().samples_per_pixel())
            ))),
            _ => Err(Failure::Stopped(
                "stopped: not every pixel had a sample yet, so nothing is written".to_owned(),
            )),
        }
    }
}
