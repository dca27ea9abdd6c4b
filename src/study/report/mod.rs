//! What a study shows: tables, plots and one page, from the runs that it has measured.

mod page;
mod plots;
mod tables;

use super::fit::{Measurement, PowerLaw, student_95};
use super::measure::{EqualTime, equal_time};
use super::{Case, Folder, Reference, Request, Run, RunId, Spectrum, spectra};
use crate::integrator::Estimator;
use crate::plot::{Dash, INKS, Ink, Marker};
use crate::render::{Progress, WavelengthCount};
use crate::sampling::SamplerKind;
use crate::stats::Estimate;
use std::io;

/// A finished study with what it was asked and where.
pub struct Findings<'a> {
    /// What was asked for.
    pub request: &'a Request,
    /// The scenes, in the order of the request.
    pub cases: &'a [Case],
    /// Their references, in the same order.
    pub references: &'a [Reference],
    /// What each run has found.
    pub runs: Vec<Run>,
    /// Where and how it was measured.
    pub context: Context,
}

/// What the page says beside the numbers.
#[derive(Clone, Debug)]
pub struct Context {
    /// The scene's name.
    pub scene: String,
    /// The command line.
    pub command: String,
    /// Processor and number of cores.
    pub machine: String,
    /// Relative RMSE whose time is asked for.
    pub target: Option<f64>,
}

/// The runs of one sampler over all numbers of samples, everything else being the same.
struct Series<'a> {
    case: usize,
    sampler: SamplerKind,
    estimator: Estimator,
    wavelengths: WavelengthCount,
    label: String,
    ink: Ink,
    marker: Marker,
    dash: Option<Dash>,
    /// Runs in the order of samples per pixel.
    runs: Vec<&'a Run>,
    against_samples: Option<PowerLaw>,
    against_time: Option<PowerLaw>,
}

/// One for each technique: two estimators with three numbers of wavelengths.
const DASHES: [Option<Dash>; 6] = [
    None,
    Some(Dash(6.0, 3.0)),
    Some(Dash(2.0, 3.0)),
    Some(Dash(10.0, 4.0)),
    Some(Dash(5.0, 7.0)),
    Some(Dash(1.0, 4.0)),
];

/// How often a picture that takes too long is made again.
const AGAIN: u32 = 2;

/// When a series reaches the target.
#[derive(Clone, Copy)]
struct Reached {
    seconds: f64,
    /// The 95 % interval goes from this factor less to this factor more.
    factor: f64,
    /// Outside of the times that were measured.
    extrapolated: bool,
}

impl Series<'_> {
    fn reached(&self, target: f64) -> Option<Reached> {
        let (seconds, factor) = self.against_time?.reaches(target)?;
        let times = || self.runs.iter().map(|run| run.cpu_seconds);
        let (shortest, longest) = (times().fold(f64::MAX, f64::min), times().fold(0.0, f64::max));
        Some(Reached { seconds, factor, extrapolated: !(shortest..=longest).contains(&seconds) })
    }

    /// The series of a sampler that has all else in common with this one.
    fn of_sampler<'a>(&self, all: &'a [Self], sampler: SamplerKind) -> Option<&'a Self> {
        let technique = (self.estimator, self.wavelengths);
        all.iter().find(|other| other.sampler == sampler && (other.estimator, other.wavelengths) == technique)
    }

    fn at(&self, samples: u32) -> Option<&Run> {
        self.runs.iter().find(|run| run.id.samples_per_pixel == samples).copied()
    }
}

impl Findings<'_> {
    fn series(&self, case: usize) -> Vec<Series<'_>> {
        let mut all = Vec::new();
        for (technique, (estimator, wavelengths)) in self.request.techniques().enumerate() {
            for &sampler in &self.request.samplers {
                let mut runs: Vec<&Run> = self
                    .runs
                    .iter()
                    .filter(|run| {
                        let id = &run.id;
                        (id.case, id.sampler) == (case, sampler)
                            && (id.estimator, id.wavelengths_per_path) == (estimator, wavelengths)
                    })
                    .collect();
                runs.sort_by_key(|run| run.id.samples_per_pixel);
                // A sampler has the same ink in every study.
                let place = SamplerKind::NAMES.iter().position(|&(_, kind)| kind == sampler).unwrap_or(0);
                let mut label = sampler.to_string();
                if self.request.estimators.len() > 1 {
                    label += &format!(", {estimator}");
                }
                if self.request.wavelengths_per_path.len() > 1 {
                    label += &format!(", C = {wavelengths}");
                }
                let law = |x: fn(&Run) -> f64| {
                    let point = |run: &&Run| Measurement { x: x(run), relmse: run.error() };
                    PowerLaw::fit(&runs.iter().map(point).collect::<Vec<_>>())
                };
                all.push(Series {
                    case,
                    sampler,
                    estimator,
                    wavelengths,
                    label,
                    ink: INKS[place % INKS.len()],
                    marker: Marker::ALL[(place + technique) % Marker::ALL.len()],
                    dash: DASHES[technique % DASHES.len()],
                    against_samples: law(|run| f64::from(run.id.samples_per_pixel)),
                    against_time: law(|run| run.cpu_seconds),
                    runs,
                });
            }
        }
        all
    }

    /// The relative RMSE that times are told for: what was asked for, or the smallest that every series
    /// reaches.
    fn target(&self, series: &[Series]) -> f64 {
        let best = |series: &Series| {
            let errors = series.runs.iter().map(|run| run.error().mean.max(0.0).sqrt());
            errors.filter(|error| *error > 0.0).fold(f64::INFINITY, f64::min)
        };
        let random = series.iter().filter(|series| self.request.replicates_of(series.sampler) > 1);
        let reached = random.map(best).filter(|error| error.is_finite()).fold(0.0, f64::max);
        self.context.target.unwrap_or(if reached > 0.0 { reached } else { 0.01 })
    }

    /// One picture of every sampler in about the time that the fastest takes for the shown number of samples.
    /// What a sampler prepares doesn't grow with the samples: a picture that takes longer for it is made
    /// again with fewer.
    fn equal_times(&self, series: &[Series], progress: &dyn Progress) -> Vec<EqualTime> {
        let shown = self.request.shown_samples();
        let seconds = |series: &Series| series.at(shown).map(|run| run.cpu_seconds).filter(|s| *s > 0.0);
        let budget = series.iter().filter_map(seconds).fold(f64::INFINITY, f64::min);
        series
            .iter()
            .filter_map(|series| {
                let fraction = budget / seconds(series)?;
                let (case, reference) = (self.cases.get(series.case)?, self.references.get(series.case)?);
                let picture = |samples: f64| {
                    let samples_per_pixel = (samples.round() as u32).max(1);
                    let id = RunId { samples_per_pixel, ..series.at(shown)?.id.clone() };
                    Some(equal_time(self.request, case, id, reference, progress))
                };
                let mut made = picture(f64::from(shown) * fraction)?;
                for _ in 0..AGAIN {
                    if made.cpu_seconds < 1.3 * budget || made.id.samples_per_pixel == 1 {
                        break;
                    }
                    made = picture(f64::from(made.id.samples_per_pixel) * budget / made.cpu_seconds)?;
                }
                Some(made)
            })
            .collect()
    }

    /// Writes tables, plots and page into the folder. Renders the pictures at equal time, on the current
    /// rayon thread pool.
    pub fn write(&self, folder: &Folder, progress: &dyn Progress) -> io::Result<()> {
        folder.write("runs.csv", tables::csv(self).as_bytes())?;
        let patterns = self.patterns();
        let mut sections = Vec::new();
        for case in 0..self.cases.len() {
            let series = self.series(case);
            let target = self.target(&series);
            let equal = self.equal_times(&series, progress);
            let figures = plots::figures(self, &series, target, &equal, &patterns);
            for figure in &figures {
                let suffix = if self.cases.len() > 1 { format!("-case{case}") } else { String::new() };
                for ending in ["svg", "png"] {
                    let name = format!("plots/{}{suffix}.{ending}", figure.name);
                    let bytes = figure.drawing.file(name.as_ref()).map_err(io::Error::other)?;
                    folder.write(&name, &bytes)?;
                }
            }
            sections.push(page::Section { case, series, target, figures });
        }
        folder.write("study.json", &tables::json(self, &sections)?)?;
        folder.write("index.html", page::page(self, &sections).as_bytes())
    }

    /// What each sampler does within a pixel: the same for all scenes.
    fn patterns(&self) -> Vec<(SamplerKind, Spectrum)> {
        let of = |&kind: &SamplerKind| {
            (kind, spectra::pattern(kind, self.request.seed, self.request.shown_samples()))
        };
        self.request.samplers.iter().map(of).collect()
    }
}

/// Three significant digits, as print has them.
fn short(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return if value == 0.0 { "0".to_owned() } else { "–".to_owned() };
    }
    let power = value.abs().log10().floor() as i32;
    let text = if (-3..=4).contains(&power) {
        let step = 10f64.powi(power - 2);
        format!("{:.*}", (2 - power).max(0) as usize, (value / step).round() * step)
    } else {
        let digits = format!("{value:.2e}");
        let (mantissa, exponent) = digits.split_once('e').unwrap_or((&digits, "0"));
        let exponent: String = exponent.chars().map(superscript).collect();
        format!("{mantissa}·10{exponent}")
    };
    text.replace('-', "−")
}

fn superscript(c: char) -> char {
    "-0123456789".find(c).and_then(|at| "⁻⁰¹²³⁴⁵⁶⁷⁸⁹".chars().nth(at)).unwrap_or(c)
}

/// The factor to which the 95 % interval of an error reaches up and down: that of its logarithm, to first
/// order.
fn interval_factor(of: Estimate) -> f64 {
    if of.variance > 0.0 { (student_95(of.degrees) * of.error() / of.mean).exp() } else { 1.0 }
}

fn percent(fraction: f64) -> String {
    if fraction.is_finite() { format!("{} %", short(100.0 * fraction)) } else { "–".to_owned() }
}

/// `−0.50 ± 0.02`.
fn slope(law: Option<&PowerLaw>) -> String {
    law.map_or("–".to_owned(), |law| {
        format!("{:.2} ± {:.2}", law.slope, law.slope_half_width).replace('-', "−")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_told_in_three_digits() {
        let told = [0.0, 1.0, 0.012345, 123.4, 56789.0, 1.2345e-5, -0.5, 1e9].map(short);
        assert_eq!(told, ["0", "1.00", "0.0123", "123", "56800", "1.23·10⁻⁵", "−0.500", "1.00·10⁹"]);
        assert_eq!(percent(0.05), "5.00 %");
        assert_eq!(percent(f64::INFINITY), "–");
    }
}
