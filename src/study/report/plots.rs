use super::{Findings, Reached, Series, interval_factor, percent, short, slope};
use crate::plot::{Axis, Chart, Colours, Dash, Drawing, Ink, Panel, Panels, Point, Scale, Series as Curve};
use crate::sampling::SamplerKind;
use crate::stats::Estimate;
use crate::study::Spectrum;
use crate::study::fit::PowerLaw;
use crate::study::measure::EqualTime;

/// A plot with what it is called and what it says.
pub(super) struct ReportFigure {
    /// Name of its files.
    pub name: &'static str,
    pub drawing: Drawing,
    pub caption: String,
}

pub(super) fn figures(
    findings: &Findings,
    series: &[Series],
    target: f64,
    equal: &[EqualTime],
    patterns: &[(SamplerKind, Spectrum)],
) -> Vec<ReportFigure> {
    let mut figures =
        vec![error_against_samples(findings, series), error_against_time(findings, series, target)];
    figures.extend(errors_at_equal_time(series, equal));
    figures.extend(pattern_spectra(findings, series, patterns));
    figures.extend(error_spectra(findings, series));
    figures
}

/// Relative RMSE with its 95 % interval.
fn point(x: f64, relmse: Estimate) -> Point {
    let (y, factor) = (relmse.mean.max(0.0).sqrt(), interval_factor(relmse).sqrt());
    Point { x, y, low: y / factor, high: y * factor }
}

/// The best of several, with those that can't be told from it: `A (or, within the intervals, B; C)`.
fn with_ties<T>(best: &(&Series, T), all: &[(&Series, T)], is_tied: impl Fn(&T, &T) -> bool) -> String {
    let tied: Vec<&str> = all
        .iter()
        .filter(|(series, value)| series.label != best.0.label && is_tied(&best.1, value))
        .map(|(series, _)| series.label.as_str())
        .collect();
    match tied.as_slice() {
        [] => best.0.label.clone(),
        names => {
            format!("{} (or, within the intervals, {})", best.0.label, names.join("; "))
        }
    }
}

/// Measured points and the fitted line of each series. Where there are too few points for one, the line joins
/// them.
fn curves(series: &[Series], of: impl Fn(&Series) -> (Vec<Point>, Option<PowerLaw>, String)) -> Vec<Curve> {
    let curve = |series: &Series| {
        let (points, law, name) = of(series);
        let ends = [points.first(), points.last()].into_iter().flatten().map(|point| point.x);
        let fitted: Vec<Point> =
            law.map_or(Vec::new(), |law| ends.map(|x| Point::new(x, law.at(x))).collect());
        Curve {
            name,
            ink: series.ink,
            points,
            line: 1.4,
            fitted,
            marker: Some(series.marker),
            dash: series.dash,
        }
    };
    series.iter().map(curve).collect()
}

fn error_against_samples(findings: &Findings, series: &[Series]) -> ReportFigure {
    let request = findings.request;
    let mut x = Axis::new("samples per pixel", Scale::Log);
    // Not more numbers than there is room for.
    let every = request.samples_per_pixel.len().div_ceil(9);
    x.ticks = request.samples_per_pixel.iter().step_by(every).map(|&n| f64::from(n)).collect();
    let of = |series: &Series| {
        let points =
            series.runs.iter().map(|run| point(f64::from(run.id.samples_per_pixel), run.error())).collect();
        let name = format!("{}: {}", series.label, slope(series.against_samples.as_ref()));
        (points, series.against_samples, name)
    };
    let drawing = Chart {
        title: "Error against samples".to_owned(),
        x,
        y: Axis::new("relative RMSE of Y", Scale::Log),
        series: curves(series, of),
        band: Vec::new(),
    }
    .draw();
    let random = |series: &&Series| request.replicates_of(series.sampler) > 1;
    let laws: Vec<(&Series, PowerLaw)> =
        series.iter().filter(random).filter_map(|s| Some((s, s.against_samples?))).collect();
    let steepest = laws.iter().min_by(|a, b| a.1.slope.total_cmp(&b.1.slope));
    let seen = steepest.map_or(String::new(), |best| {
        let is_tied =
            |a: &PowerLaw, b: &PowerLaw| b.slope - a.slope < a.slope_half_width.hypot(b.slope_half_width);
        format!(
            " The steepest line is that of {}, with a slope of {}; independent samples have −0.5 in theory.",
            with_ties(best, &laws, is_tied),
            slope(Some(&best.1))
        )
    });
    let curved: Vec<&str> = laws
        .iter()
        .filter(|(_, law)| law.reduced_chi_square > 4.0)
        .map(|(series, _)| series.label.as_str())
        .collect();
    let curved = match curved.as_slice() {
        [] => String::new(),
        names => format!(
            " The points of {} scatter about the line by more than twice what the replicates explain: their law is not one power.",
            names.join(", ")
        ),
    };
    let intervals = if laws.is_empty() && series.iter().all(|series| !random(&series)) {
        String::new()
    } else {
        format!("with 95 % intervals from {} replicates, ", request.replicates)
    };
    ReportFigure {
        name: "error-samples",
        drawing,
        caption: format!(
            "Relative RMSE of the luminance against samples per pixel, {intervals}the fitted power laws and, in the legend, their \
             slopes.{seen}{curved}"
        ),
    }
}

fn error_against_time(findings: &Findings, series: &[Series], target: f64) -> ReportFigure {
    let of = |series: &Series| {
        let points = series.runs.iter().map(|run| point(run.cpu_seconds, run.error())).collect();
        let name = format!("{}: {}", series.label, slope(series.against_time.as_ref()));
        (points, series.against_time, name)
    };
    let mut all = curves(series, of);
    let times = || series.iter().flat_map(|series| &series.runs).map(|run| run.cpu_seconds);
    let ends = [times().fold(f64::MAX, f64::min), times().fold(0.0, f64::max)];
    all.push(Curve {
        name: format!("{} is the target", percent(target)),
        ink: Ink::Grey(8),
        points: ends.map(|x| Point::new(x, target)).to_vec(),
        fitted: Vec::new(),
        marker: None,
        line: 1.0,
        dash: Some(Dash(3.0, 3.0)),
    });
    let drawing = Chart {
        title: "Error against CPU time".to_owned(),
        x: Axis::new("CPU time of one picture, s", Scale::Log),
        y: Axis::new("relative RMSE of Y", Scale::Log),
        series: all,
        band: Vec::new(),
    }
    .draw();
    let reached: Vec<(&Series, Reached)> =
        series.iter().filter_map(|series| Some((series, series.reached(target)?))).collect();
    let first = reached.iter().min_by(|a, b| a.1.seconds.total_cmp(&b.1.seconds));
    let seen = first.map_or(String::new(), |best| {
        let how = if best.1.extrapolated { ", extrapolated" } else { "" };
        let is_tied =
            |a: &Reached, b: &Reached| (b.seconds / a.seconds).ln() < a.factor.ln().hypot(b.factor.ln());
        format!(
            " The first line to reach the target of {} is that of {}, after {} s{how}.",
            percent(target),
            with_ties(best, &reached, is_tied),
            short(best.1.seconds)
        )
    });
    ReportFigure {
        name: "error-time",
        drawing,
        caption: format!(
            "The same errors against the CPU time of one replicate: user and system time of {} threads together.{seen}",
            findings.request.threads
        ),
    }
}

/// 1, 2 or 5 times a power of ten, at or above the number.
fn round_up(value: f64) -> f64 {
    let power = 10f64.powf(value.max(1e-300).log10().floor());
    [1.0, 2.0, 5.0]
        .map(|digit| digit * power)
        .into_iter()
        .find(|&round| round >= value)
        .unwrap_or(10.0 * power)
}

/// Longest edge of a picture of errors: of larger ones the middle is shown, so that the page stays light.
const LONGEST_EDGE: usize = 400;

/// The middle of a picture: its width and values.
fn middle(width: usize, values: &[f64]) -> (usize, Vec<f64>) {
    let height = values.len() / width.max(1);
    let [columns, rows] = [width, height].map(|edge| edge.min(LONGEST_EDGE));
    let (left, top) = ((width - columns) / 2, (height - rows) / 2);
    let row = |y: usize| &values[(top + y) * width + left..][..columns];
    (columns, (0..rows).flat_map(row).copied().collect())
}

fn errors_at_equal_time(series: &[Series], equal: &[EqualTime]) -> Option<ReportFigure> {
    let mut sizes: Vec<f64> = equal.iter().flat_map(|picture| &picture.errors).map(|e| e.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let end = round_up(*sizes.get(sizes.len().checked_sub(1)? * 95 / 100)?);
    let label = |picture: &EqualTime| {
        let same = |series: &&Series| {
            let id = &picture.id;
            (series.sampler, series.estimator, series.wavelengths)
                == (id.sampler, id.estimator, id.wavelengths_per_path)
        };
        series.iter().find(same).map_or(picture.id.sampler.to_string(), |series| series.label.clone())
    };
    let panel = |picture: &EqualTime| {
        let (width, values) = middle(picture.width, &picture.errors);
        Panel {
            title: label(picture),
            note: format!(
                "{} spp, {} s, RMSE {}",
                picture.id.samples_per_pixel,
                short(picture.cpu_seconds),
                percent(picture.relmse.max(0.0).sqrt())
            ),
            width,
            values,
        }
    };
    let picture = equal.first()?;
    let part = if picture.errors.len() > middle(picture.width, &picture.errors).1.len() {
        " Of each picture the middle is shown."
    } else {
        ""
    };
    let drawing = Panels {
        title: "Errors of pictures made in equal time".to_owned(),
        panels: equal.iter().map(panel).collect(),
        quantity: "relative error".to_owned(),
        range: [-end, end],
        scale: Scale::Linear,
        colours: Colours::Diverging,
    }
    .draw();
    Some(ReportFigure {
        name: "errors-at-equal-time",
        drawing,
        caption: format!(
            "Signed error of each pixel, relative to the reference, in one picture of each sampler made in about the CPU time that \
             the fastest takes for its number of samples; above each stands what it took, all that a sampler prepares included. Red is \
             too bright, blue too dark; the scale is the same for all.{part} One picture is one throw of the dice: the table says which \
             sampler errs less."
        ),
    })
}

/// Less than this is drawn as this.
const LEAST_POWER: f64 = 1e-3;

/// Radial powers of several spectra.
fn radial(title: &str, x: &str, all: &[(&Series, String, &Spectrum)]) -> Drawing {
    let curve = |(series, name, spectrum): &(&Series, String, &Spectrum)| Curve {
        name: name.clone(),
        ink: series.ink,
        points: spectrum
            .radial
            .frequency
            .iter()
            .zip(&spectrum.radial.power)
            .map(|(&x, &y)| Point::new(x, y.max(LEAST_POWER)))
            .collect(),
        fitted: Vec::new(),
        marker: None,
        line: 1.8,
        dash: series.dash,
    };
    Chart {
        title: title.to_owned(),
        x: Axis::new(x, Scale::Linear),
        y: Axis::new("power, relative to white noise", Scale::Log),
        series: all.iter().map(curve).collect(),
        band: Vec::new(),
    }
    .draw()
}

fn planes(title: &str, all: &[(&Series, String, &Spectrum)], note: &str) -> Drawing {
    let panel = |(_, name, spectrum): &(&Series, String, &Spectrum)| Panel {
        title: name.clone(),
        note: note.to_owned(),
        width: spectrum.width,
        values: spectrum.power.iter().map(|&power| if power < 0.0 { f64::NAN } else { power }).collect(),
    };
    Panels {
        title: title.to_owned(),
        panels: all.iter().filter(|(_, _, spectrum)| spectrum.width > 0).map(panel).collect(),
        quantity: "power".to_owned(),
        range: [0.01, 10.0],
        scale: Scale::Log,
        colours: Colours::Sequential,
    }
    .draw()
}

fn pattern_spectra(
    findings: &Findings,
    series: &[Series],
    patterns: &[(SamplerKind, Spectrum)],
) -> Vec<ReportFigure> {
    let samples = findings.request.shown_samples();
    let all: Vec<(&Series, String, &Spectrum)> = patterns
        .iter()
        .filter_map(|(kind, spectrum)| {
            Some((series.iter().find(|series| series.sampler == *kind)?, kind.to_string(), spectrum))
        })
        .collect();
    let below = |spectrum: &Spectrum| {
        let low: Vec<f64> = spectrum
            .radial
            .frequency
            .iter()
            .zip(&spectrum.radial.power)
            .filter(|(f, _)| **f < 0.5)
            .map(|(_, power)| *power)
            .collect();
        low.iter().sum::<f64>() / low.len().max(1) as f64
    };
    let told: Vec<String> =
        all.iter().map(|(_, name, spectrum)| format!("{name} {:.3}", below(spectrum))).collect();
    vec![
        ReportFigure {
            name: "pattern-spectra-radial",
            drawing: radial(
                &format!("Spectra of the sampling patterns, {samples} points"),
                "frequency × mean distance of the points",
                &all,
            ),
            caption: format!(
                "Power of the film positions within a pixel by frequency, mean over pixels and directions; 1 is white noise. What is low \
                 below 0.5 turns little of a smooth picture into noise. Mean power there: {}.",
                told.join(", ")
            ),
        },
        ReportFigure {
            name: "pattern-spectra",
            drawing: planes(&format!("Spectra of the sampling patterns, {samples} points"), &all, "−2 to 2 over the mean distance"),
            caption: "The same in the plane, frequency 0 in the middle: whether a pattern prefers directions. Frequency 0 itself is left \
                      out (grey)."
                .to_owned(),
        },
    ]
}

fn error_spectra(findings: &Findings, series: &[Series]) -> Vec<ReportFigure> {
    let samples = findings.request.shown_samples();
    let all: Vec<(&Series, String, &Spectrum)> = series
        .iter()
        .filter_map(|series| Some((series, series.label.clone(), &series.at(samples)?.spectrum)))
        .collect();
    vec![
        ReportFigure {
            name: "error-spectra-radial",
            drawing: radial(
                &format!("Spectra of the image errors, {samples} samples per pixel"),
                "frequency, cycles per pixel",
                &all,
            ),
            caption: "Power of the relative error over the picture by frequency, mean over replicates and directions; 1 is white noise, \
                      which pixels with independent errors have. Less at low frequencies is noise that the eye averages out more easily; \
                      more there is error that neighbouring pixels share."
                .to_owned(),
        },
        ReportFigure {
            name: "error-spectra",
            drawing: planes(&format!("Spectra of the image errors, {samples} samples per pixel"), &all, "−½ to ½ cycles per pixel"),
            caption: "The same in the plane, frequency 0 in the middle.".to_owned(),
        },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_end_at_round_numbers() {
        assert_eq!([0.012, 0.2, 0.31, 7.0].map(round_up), [0.02, 0.2, 0.5, 10.0]);
    }

    #[test]
    fn of_large_pictures_the_middle_is_shown() {
        let values: Vec<f64> = (0..3).flat_map(|y| (0..602).map(move |x| f64::from(1000 * y + x))).collect();
        let (width, shown) = middle(602, &values);
        assert_eq!((width, shown.len(), shown[0], shown[1199]), (400, 1200, 101.0, 2500.0));
        assert_eq!(middle(2, &[1.0, 2.0]), (2, vec![1.0, 2.0]));
    }

    #[test]
    fn an_error_bar_is_the_interval_of_the_root() {
        let point = point(4.0, Estimate { mean: 0.04, variance: 1e-6, degrees: 1e9 });
        assert!((point.y - 0.2).abs() < 1e-12);
        let factor = (1.959_964e-3f64 / 0.04 / 2.0).exp();
        assert!((point.high - 0.2 * factor).abs() < 1e-6 && (point.low - 0.2 / factor).abs() < 1e-6);
    }
}
