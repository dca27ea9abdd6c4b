//! What decides the samples of a picture, but for the scene.

use super::Failure;
use super::scene_options::PictureOptions;
use super::whole::whole;
use abbe::film::SpectralBins;
use abbe::integrator::Estimator;
use abbe::output;
use abbe::render::{Schedule, Settings, WavelengthCount};
use abbe::sampling::SamplerKind;
use abbe::scene::description::Sampler;
use abbe::scene::{CompileOptions, Description};
use abbe::spectrum::colour::Observer;
use abbe::units::WavelengthRange;

/// What decides the samples of a picture, in place of what its scene says: what is given the same takes the
/// same ones.
#[derive(clap::Args)]
pub struct SamplingOptions {
    /// Samples per pixel in the mean over the picture, or a little fewer: a pilot gives more to pixels that
    /// err more. They are dealt into replicates whose spread gives the error [default: what the scene says]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..=1 << 24))]
    pub spp: Option<u32>,

    /// Independent replicates that the samples are dealt into. Few make a picture less noisy, for its samples
    /// are spread better together, and its error bars less sure; 1 has none [default: 4 to 16, by the number
    /// of samples]
    #[arg(long, value_name = "R", value_parser = whole::<u32>(1..=1024))]
    pub replicates: Option<u32>,

    /// Seed of the sample values [default: what the scene says]
    #[arg(long, value_name = "N", value_parser = whole::<u64>(0..=u64::MAX))]
    pub seed: Option<u64>,

    /// Sampler: regular (no error bars), independent, jittered, poisson, sobol (Owen-scrambled) or bluenoise
    /// [default: what the scene says, else sobol]
    #[arg(long, value_name = "S", value_parser = parse_sampler)]
    pub sampler: Option<SamplerKind>,

    /// Wavelengths that a path carries: 1, 4 or 8. The expectation is the same, noise and time are not
    /// [default: 4 or 8, as a pilot finds best]
    #[arg(long, value_name = "C", value_parser = parse_wavelengths)]
    pub wavelengths: Option<WavelengthCount>,

    /// Estimator: shared (pixels share the suffixes of their paths, and samples go where pixels err) or plain
    /// (each pixel traces its own paths, all the same number). The expectation is the same, noise and time
    /// are not
    #[arg(long, value_name = "E", default_value = "shared", value_parser = parse_estimator)]
    pub estimator: Estimator,

    #[command(flatten)]
    pub picture: PictureOptions,

    /// Also write N spectral bins (47 without N) over the range of wavelengths, each with its standard error
    #[arg(long, value_name = "N", num_args = 0..=1, default_missing_value = "47", value_parser = whole::<u32>(1..=4096))]
    pub spectral: Option<u32>,

    /// Wavelengths that are simulated, in nm [default: 360:830 and whatever else a specfilm responds to]
    #[arg(long, value_name = "MIN:MAX", value_parser = parse_range, allow_hyphen_values = true)]
    pub range: Option<WavelengthRange>,

    /// Colour matching functions: cie1931, cie1931-5nm (as Mitsuba tabulates it), cie1964, cie2015-2 or
    /// cie2015-10
    #[arg(long, value_name = "NAME", default_value = "cie1931", value_parser = parse_observer)]
    pub observer: &'static Observer,
}

impl SamplingOptions {
    /// What the command line says goes over what the file says. `most`: samples per pixel where a render ends
    /// for another reason. Refused where there are more replicates than samples, or
    /// more samples in a replicate than its sums hold.
    pub fn apply_to(&self, description: &mut Description, most: Option<u32>) -> Result<(), Failure> {
        let sampler = &mut description.sensor.sampler;
        sampler.sample_count = self.spp.or(most).unwrap_or(sampler.sample_count);
        sampler.seed = self.seed.unwrap_or(sampler.seed);
        sampler.kind = self.sampler.unwrap_or(sampler.kind);
        self.picture.apply_to(description);
        let sampler = &description.sensor.sampler;
        let samples = sampler.sample_count;
        if let Some(replicates) = self.replicates.filter(|&replicates| replicates > samples)
            && sampler.kind.is_random()
        {
            return Err(Failure::Input(format!(
                "error: --replicates {replicates}: there are more than the samples per pixel, {samples}\n\
                 help: take --replicates {samples} or fewer, or --spp {replicates} or more"
            )));
        }
        let most = Schedule::LONGEST_REPLICATE;
        if self.schedule(sampler).samples_per_replicate > most {
            let remedy = match sampler.kind.is_random() {
                true => format!("take --replicates {} or more", samples.div_ceil(most)),
                false => format!("take another sampler: {} has one replicate", sampler.kind),
            };
            return Err(Failure::Input(format!(
                "error: {samples} samples per pixel: a replicate holds at most {most}\nhelp: {remedy}"
            )));
        }
        Ok(())
    }

    fn schedule(&self, sampler: &Sampler) -> Schedule {
        match self.replicates {
            Some(replicates) if sampler.kind.is_random() => {
                Schedule::with_replicates(sampler.sample_count, replicates)
            }
            _ => Schedule::of(sampler.kind, sampler.sample_count),
        }
    }

    pub fn range(&self, description: &Description) -> WavelengthRange {
        self.range.unwrap_or_else(|| description.sensor.film.wavelength_range())
    }

    pub fn compile_options(&self, range: WavelengthRange) -> CompileOptions {
        CompileOptions {
            range,
            observer: self.observer,
            spectral: self.spectral.is_some(),
            part: self.picture.part(output::MARGIN, output::SQUARE),
        }
    }

    pub fn settings(&self, description: &Description, range: WavelengthRange) -> Settings {
        let sampler = &description.sensor.sampler;
        Settings {
            schedule: self.schedule(sampler),
            seed: sampler.seed,
            sampler: sampler.kind,
            wavelengths: self.wavelengths,
            estimator: self.estimator,
            bins: self.spectral.map(|count| SpectralBins { range, count: count as usize }),
        }
    }
}

fn parse_sampler(text: &str) -> Result<SamplerKind, String> {
    SamplerKind::named(text).ok_or_else(|| {
        let names: Vec<_> = SamplerKind::NAMES.iter().map(|&(name, _)| name).collect();
        format!("expected one of {}", names.join(", "))
    })
}

pub fn parse_estimator(text: &str) -> Result<Estimator, String> {
    Estimator::named(text).ok_or_else(|| "expected shared or plain".to_owned())
}

pub fn parse_wavelengths(text: &str) -> Result<WavelengthCount, String> {
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
