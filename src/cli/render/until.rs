//! When a render ends before its last sample: at an error (`--until`) or a time (`--time`).

use super::super::Failure;
use super::super::progress::End;
use super::outcome::Outcome;
use abbe::film::Film;
use abbe::output::target::{Estimate, Target};
use abbe::render::{Schedule, Work};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// Samples of each pixel at which such a render ends where `--spp` does not say how many there are at most.
pub const MOST_SAMPLES: u32 = 1 << 20;

/// Options that end a render early.
#[derive(clap::Args)]
#[command(next_help_heading = "Long renders")]
pub struct UntilOptions {
    /// End when the error of the luminance (or of all responses of a specfilm) is below a bound with 95 %
    /// confidence: 'relmse<1e-3' (as abbe compare has it), 'error<1%' (mean standard error over mean) or, of
    /// the colours, 'de<0.5' (the mean over tiles of 8 × 8 pixels of their root mean square CIEDE2000, with
    /// the white of abbe compare). It is looked at four times for each doubling of the samples, first when
    /// each replicate has four (32 samples per pixel as a rule). --spp is then the most samples that are
    /// taken [default then: 1048576]. Sample values are laid out for that many: a picture that ends at N
    /// samples has up to 1.9 times the variance of one of --spp N alone
    #[arg(long, value_name = "TARGET")]
    until: Option<Target>,

    /// End after this time, such as 90s, 10m or 2h, but not before each pixel has a sample. --spp is then the
    /// most samples that are taken [default then: 1048576]. The variance is as with --until
    #[arg(long, value_name = "TIME", value_parser = parse_time, allow_hyphen_values = true)]
    time: Option<Duration>,
}

impl UntilOptions {
    /// Whether a render may end before it has the samples that are asked for.
    pub fn ends_early(&self) -> bool {
        self.until.is_some() || self.time.is_some()
    }

    /// An error that is never known is never small enough.
    pub fn refuse_without_errors(&self, schedule: Schedule) -> Result<(), Failure> {
        if self.until.is_none() || schedule.replicates > 1 {
            return Ok(());
        }
        Err(Failure::Input(
            "error: --until: the samples are one replicate, which tells no error\n\
             help: take more samples or replicates; the sampler regular has no errors"
                .to_owned(),
        ))
    }

    /// When a render ends that has `all` samples of each pixel at most, `total` in all.
    pub fn end(&self, all: u64, total: u64) -> End {
        match self.ends_early() && all >= u64::from(MOST_SAMPLES) {
            true => End::Open { time: self.time },
            false => End::Samples(total),
        }
    }

    fn estimate(&self, film: &Film) -> Option<Estimate> {
        self.until.and_then(|target| target.estimate(film))
    }
}

/// Why a render ended, if it was not for a signal or its last sample.
#[derive(Debug, Default)]
pub struct Decision(Mutex<Reasons>);

#[derive(Clone, Copy, Debug, Default)]
struct Reasons {
    is_met: bool,
    is_out_of_time: bool,
}

impl Decision {
    /// The error, at the numbers of samples at which it is looked at and where it is known. Remembers whether
    /// it is small enough.
    pub fn at_error(&self, options: &UntilOptions, work: &Work) -> Option<Look> {
        let is_due = work.samples_per_replicate().is_some_and(Target::decides_at);
        let target = options.until.filter(|_| is_due)?;
        let look = Look { target, estimate: target.estimate(work.film())? };
        if look.is_met() {
            self.reasons().is_met = true;
        }
        Some(look)
    }

    /// Whether its time is over. Remembers that it is.
    pub fn at_time(&self, options: &UntilOptions, elapsed: Duration) -> bool {
        let ends = options.time.is_some_and(|time| elapsed >= time);
        if ends {
            self.reasons().is_out_of_time = true;
        }
        ends
    }

    /// What became of the render.
    pub fn outcome(&self, options: &UntilOptions, work: &Work) -> Outcome {
        let reasons = *self.reasons();
        let estimate = options.estimate(work.film());
        let is_met = reasons.is_met
            || work.is_finished() && options.until.is_some_and(|target| target.is_met(estimate));
        Outcome { target: options.until, estimate, is_met, is_out_of_time: reasons.is_out_of_time }
    }

    fn reasons(&self) -> std::sync::MutexGuard<'_, Reasons> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The error at one of the numbers of samples at which it is looked at.
pub struct Look {
    target: Target,
    estimate: Estimate,
}

impl Look {
    pub fn is_met(&self) -> bool {
        self.target.is_met(Some(self.estimate))
    }

    pub fn told(&self) -> String {
        let Estimate { value, at_most } = self.estimate;
        format!("{}, at most {}", self.target.told(value), self.target.told(at_most))
    }
}

/// A time with its unit: s, m or h.
pub fn parse_time(text: &str) -> Result<Duration, String> {
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
    fn times_are_read() {
        let seconds = |text| parse_time(text).map(|time| time.as_secs_f64());
        assert_eq!([seconds("90"), seconds("90s"), seconds("1.5m")], [const { Ok(90.0) }; 3]);
        assert_eq!(seconds("2h"), Ok(7200.0));
        for wrong in ["", "m", "-1s", "0", "1d", "nan", "1e400s"] {
            assert!(parse_time(wrong).is_err(), "{wrong}");
        }
    }
}
