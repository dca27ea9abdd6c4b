//! One page that stands on its own: text, tables, inline SVG and fonts, nothing from elsewhere and no
//! scripts.

use super::plots::ReportFigure;
use super::{Findings, Series, interval_factor, percent, short, slope};
use crate::plot::{FONTS, escaped};
use crate::sampling::SamplerKind;
use crate::stats::Estimate;
use crate::study::fit::student_95;
use crate::study::{ReferenceRequest, Run, reference};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use std::fmt::Write;

/// What is shown of one case.
pub(super) struct Section<'a> {
    pub case: usize,
    pub series: Vec<Series<'a>>,
    pub target: f64,
    pub figures: Vec<ReportFigure>,
}

const STYLE: &str = "\
body { font: 16px/1.55 Inter, Helvetica, Arial, sans-serif; color: #222; max-width: 920px; margin: 48px auto; padding: 0 20px; }
h1 { font-size: 30px; line-height: 1.2; margin: 0 0 8px; } h2 { font-size: 21px; margin: 44px 0 12px; } h3 { font-size: 17px; margin: 32px 0 8px; }
h1, h2, h3, th, b { font-weight: 600; }
.lead { font-size: 18px; color: #444; }
table { border-collapse: collapse; width: 100%; font-size: 13.5px; margin: 14px 0; font-variant-numeric: tabular-nums; }
th, td { padding: 6px 8px; text-align: right; border-bottom: 1px solid #e4e4e4; } tbody td { white-space: nowrap; } .facts td { white-space: normal; } thead th { border-bottom: 2px solid #222; vertical-align: bottom; }
th:first-child, td:first-child { text-align: left; } .facts td, .facts th { text-align: left; vertical-align: top; } .facts th { width: 190px; font-weight: 600; }
td .ink { display: inline-block; width: 11px; height: 11px; border-radius: 6px; margin-right: 8px; }
figure { margin: 30px 0 38px; } figure svg { width: 100%; height: auto; display: block; }
figcaption { font-size: 14px; color: #444; margin-top: 6px; } code { font-size: 13px; background: #f4f4f4; padding: 1px 4px; overflow-wrap: anywhere; }
details { margin: 20px 0; } summary { cursor: pointer; font-weight: 600; }
@media print { body { margin: 0; max-width: none; } figure { break-inside: avoid; } }
";

pub(super) fn page(findings: &Findings, sections: &[Section]) -> String {
    let title = format!("Noise study: {}", findings.context.scene);
    let fonts: String = FONTS
        .iter()
        .zip([400, 600])
        .map(|(font, weight)| {
            format!(
                "@font-face {{ font-family: Inter; font-weight: {weight}; src: url(data:font/otf;base64,{}) format('opentype'); }}\n",
                BASE64_STANDARD.encode(font)
            )
        })
        .collect();
    let mut out = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{0}</title>\n\
         <style>\n{fonts}{STYLE}</style>\n</head>\n<body>\n<h1>{0}</h1>\n",
        escaped(&title)
    );
    for section in sections {
        let _ = writeln!(out, "<p class=\"lead\">{}</p>", escaped(&summary(findings, section)));
    }
    asked(&mut out, findings);
    let mut number = 0;
    for section in sections {
        let label = case_label(findings, section.case);
        let heading = if label.is_empty() { "Results".to_owned() } else { format!("Results with {label}") };
        let _ = writeln!(out, "<h2>{}</h2>", escaped(&heading));
        results(&mut out, findings, section);
        for figure in &section.figures {
            number += 1;
            let _ = writeln!(
                out,
                "<figure id=\"{}-{}\">\n{}<figcaption><b>Figure {number}.</b> {}</figcaption>\n</figure>",
                figure.name,
                section.case,
                figure.drawing.svg(),
                escaped(&figure.caption)
            );
        }
    }
    method(&mut out, findings);
    all_runs(&mut out, findings);
    out + "</body>\n</html>\n"
}

fn case_label(findings: &Findings, case: usize) -> String {
    let request = findings.request;
    request.cases.get(case).map_or(String::new(), |id| id.label(&request.varied()))
}

/// What was found, in a sentence.
fn summary(findings: &Findings, section: &Section) -> String {
    let told: Vec<(&Series, &Run)> = section
        .series
        .iter()
        .filter_map(|series| Some((series, *series.runs.last()?)))
        .filter(|(_, run)| run.relmse.len() > 1 && run.efficiency().is_finite() && run.efficiency() > 0.0)
        .collect();
    let best = told.iter().max_by(|a, b| a.1.efficiency().total_cmp(&b.1.efficiency()));
    let label = case_label(findings, section.case);
    let with = if label.is_empty() { "At".to_owned() } else { format!("With {label}, at") };
    let Some(&(series, run)) = best else {
        let only = section.series.iter().find_map(|series| Some((series, *series.runs.last()?)));
        return match only {
            Some((series, run)) if run.relmse.len() == 1 => format!(
                "{with} {} samples per pixel, {} has a relative RMSE of {} in {} s of CPU time.",
                run.id.samples_per_pixel,
                series.label,
                percent(run.error().mean.max(0.0).sqrt()),
                short(run.cpu_seconds)
            ),
            _ => "No run has an error that can be told from 0.".to_owned(),
        };
    };
    let gain = series
        .of_sampler(&section.series, SamplerKind::Independent)
        .filter(|independent| independent.sampler != series.sampler)
        .and_then(|independent| independent.at(run.id.samples_per_pixel))
        .map_or(String::new(), |other| {
            format!(
                ", {} times as efficient as independent samples",
                short(run.efficiency() / other.efficiency())
            )
        });
    let tied: Vec<&str> = told
        .iter()
        .filter(|(other, _)| other.label != series.label)
        .filter(|(_, other)| run.efficiency() / other.efficiency() < ratio_factor(run, other))
        .map(|(other, _)| other.label.as_str())
        .collect();
    let tied = match tied.as_slice() {
        [] => String::new(),
        names => format!(" Within the noise of the errors as efficient: {}.", names.join("; ")),
    };
    format!(
        "{with} {} samples per pixel, {} is the most efficient of the random samplers{gain}: relative RMSE {} in {} s of CPU time.{tied}",
        run.id.samples_per_pixel,
        series.label,
        percent(run.error().mean.max(0.0).sqrt()),
        short(run.cpu_seconds)
    )
}

/// The factor to which the 95 % interval of the ratio of two runs' efficiencies reaches. It is of the errors:
/// times have none here.
fn ratio_factor(a: &Run, b: &Run) -> f64 {
    let [a, b] = [a, b].map(Run::error);
    let relative = |of: Estimate| of.error() / of.mean;
    (student_95(a.degrees + b.degrees) * relative(a).hypot(relative(b))).exp()
}

fn listed<T: ToString>(items: &[T]) -> String {
    items.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}

fn asked(out: &mut String, findings: &Findings) {
    let (request, context) = (findings.request, &findings.context);
    let reference = match &request.reference {
        ReferenceRequest::File { path, .. } => path.clone(),
        ReferenceRequest::Rendered { samples_per_pixel } => format!(
            "rendered: {samples_per_pixel} samples per pixel in {} replicates, sobol, with a seed of its own",
            reference::REPLICATES
        ),
    };
    let own: Vec<String> = findings
        .references
        .iter()
        .map(|reference| match reference.own_relmse {
            Some(own) => format!("adds {} to every relMSE, which is subtracted", short(own)),
            None => "states no error of Y: nothing is subtracted".to_owned(),
        })
        .collect();
    let parameters: Vec<String> = request
        .cases
        .iter()
        .map(|case| {
            let names: Vec<String> = case.parameters.iter().map(|(name, _)| name.clone()).collect();
            let label = case.label(&names);
            let separator = if label.is_empty() { "" } else { ": " };
            format!("{label}{separator}hash {}", case.scene_hash)
        })
        .collect();
    let code = |text: &str| format!("<code>{}</code>", escaped(text));
    let rows = [
        ("Scene", format!("{}<br>{}", escaped(&context.scene), escaped(&parameters.join("; ")))),
        ("Command", code(&context.command)),
        ("Samplers", escaped(&listed(&request.samplers))),
        ("Estimators", listed(&request.estimators)),
        ("Samples per pixel", listed(&request.samples_per_pixel)),
        ("Wavelengths per path", listed(&request.wavelengths_per_path)),
        ("Replicates of each run", request.replicates.to_string()),
        ("Picture", format!("{} × {} pixels", request.size[0], request.size[1])),
        ("Seed", request.seed.to_string()),
        ("Reference", escaped(&format!("{reference}; it {}", own.join("; ")))),
        ("Machine", escaped(&format!("{}, {} threads", context.machine, request.threads))),
        ("Program", format!("abbe {}", escaped(&request.version))),
    ];
    let _ = writeln!(out, "<h2>What was asked</h2>\n<table class=\"facts\">");
    for (name, value) in rows {
        let _ = writeln!(out, "<tr><th>{name}</th><td>{value}</td></tr>");
    }
    let _ = writeln!(out, "</table>");
}

/// Value and its 95 % interval, from replicates: ± half of it, or a factor where it is so wide that it is
/// not about even.
fn with_interval(run: &Run) -> String {
    let error = run.error();
    let factor = interval_factor(error);
    if error.variance <= 0.0 || !factor.is_finite() {
        return short(error.mean);
    }
    if factor > 1.25 {
        return format!("{} ×/÷ {}", short(error.mean), short(factor));
    }
    let half = student_95(error.degrees) * error.error();
    // As many decimals as the second digit of the interval asks for.
    let decimals = (1.0 - half.log10().floor()).clamp(0.0, 12.0) as usize;
    if (1e-4..1e4).contains(&error.mean.abs()) {
        format!("{:.decimals$} ± {half:.decimals$}", error.mean).replace('-', "−")
    } else {
        format!("{} ± {}", short(error.mean), short(half))
    }
}

fn results(out: &mut String, findings: &Findings, section: &Section) {
    let last = findings.request.samples_per_pixel.iter().max().copied().unwrap_or(1);
    let _ = writeln!(
        out,
        "<table>\n<thead><tr><th>Sampler</th><th>Slope against samples</th><th>Slope against time</th>\
         <th>relMSE at {last} spp</th><th>CPU time, s</th><th>Efficiency, s⁻¹</th><th>over independent</th><th>CPU s to {}</th></tr></thead>",
        percent(section.target)
    );
    for series in &section.series {
        let run = series.at(last);
        let independent = series
            .of_sampler(&section.series, SamplerKind::Independent)
            .filter(|independent| independent.sampler != series.sampler)
            .and_then(|independent| independent.at(last));
        let gain = run.zip(independent).map_or("–".to_owned(), |(run, other)| {
            let gain = short(run.efficiency() / other.efficiency());
            let factor = ratio_factor(run, other);
            if factor > 1.0 && factor.is_finite() { format!("{gain} ×/÷ {}", short(factor)) } else { gain }
        });
        let time = series.reached(section.target).map_or("–".to_owned(), |reached| {
            let mark = if reached.extrapolated { "*" } else { "" };
            format!("{} ×/÷ {}{mark}", short(reached.seconds), short(reached.factor))
        });
        let told = |value: Option<String>| value.unwrap_or_else(|| "–".to_owned());
        let _ = writeln!(
            out,
            "<tr><td><span class=\"ink\" style=\"background: {}\"></span>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{gain}</td><td>{time}</td></tr>",
            series.ink,
            escaped(&series.label),
            slope(series.against_samples.as_ref()),
            slope(series.against_time.as_ref()),
            told(run.map(with_interval)),
            told(run.map(|run| short(run.cpu_seconds))),
            told(run.map(|run| short(run.efficiency()))),
        );
    }
    let _ = writeln!(
        out,
        "</table>\n<p>Slopes are of log RMSE, ± half of the 95 % interval. Efficiency is 1/(relMSE × CPU seconds). \
         ×/÷ is the factor of a 95 % interval; that over independent samples is of the errors alone, as times are measured once. \
         * marks times beyond those that were measured.</p>"
    );
}

fn method(out: &mut String, findings: &Findings) {
    let r = findings.request.replicates;
    let paragraphs = [
        format!(
            "A run is one sampler with one number of samples per pixel, rendered {r} times over: each replicate is a picture of its own. By the \
             plain estimator it has one independent sequence of samples in each pixel; by the shared one it is made as abbe render makes it, \
             with pilots of its own, whose time counts. The regular grid knows no chance and is rendered once. Every run has its own seed \
             (in runs.csv), so runs are independent of one another."
        ),
        "The error of a replicate A is relMSE = mean((A − B)²/(B² + 0.01·mean(B)²)) of the luminance Y over all pixels, with the reference B; \
         relative RMSE is its square root. The reference has noise of its own, which adds its variance to every relMSE; that is known from the \
         reference's replicates and has been subtracted. What is told of a run is the mean over its replicates; its 95 % interval is from \
         their spread, by Student's t, of the logarithm to first order: where it is wide it is told as a factor (×/÷)."
            .to_owned(),
        "Slopes are fitted to log RMSE by least squares. The logarithm of a mean is too low by (σ/relMSE)²/2 on average, which is added. All points weigh the same, by the mean of their variances, which are (σ/relMSE)²/4 to \
         first order. Where the points scatter about the line by more than these say, the interval is enlarged by √(χ²/(n − 2)), with n − 2 \
         degrees of freedom. The regular grid has no variances: there the scatter alone tells."
            .to_owned(),
        "CPU time is what the operating system counts for the whole process while a run is rendered, user and system time of all threads, \
         over the number of replicates. It includes what a sampler prepares once for a render. The time to a target error is where the \
         line of log RMSE against log CPU time reaches it; its interval is to first order."
            .to_owned(),
        "Spectra of patterns are |Σ exp(−2πi f·x)|²/N of the N film positions in a pixel, at whole cycles per pixel, mean over pixels. Spectra \
         of image errors are the squared Fourier transform of the relative error, mean over replicates, divided by its mean over \
         frequencies; frequency 0 is left out."
            .to_owned(),
    ];
    let _ = writeln!(out, "<h2>Method</h2>");
    for paragraph in paragraphs {
        let _ = writeln!(out, "<p>{paragraph}</p>");
    }
}

fn all_runs(out: &mut String, findings: &Findings) {
    let _ = writeln!(
        out,
        "<details>\n<summary>All runs</summary>\n<table>\n<thead><tr><th>Case</th><th>Sampler</th><th>Estimator</th><th>C</th><th>Samples per pixel</th>\
         <th>relMSE</th><th>Relative RMSE</th><th>CPU time, s</th><th>Efficiency, s⁻¹</th></tr></thead>"
    );
    for run in &findings.runs {
        let id = &run.id;
        let label = case_label(findings, id.case);
        let _ = writeln!(
            out,
            "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
            escaped(if label.is_empty() { &findings.context.scene } else { &label }),
            id.sampler,
            id.estimator,
            id.wavelengths_per_path,
            id.samples_per_pixel,
            with_interval(run),
            percent(run.error().mean.max(0.0).sqrt()),
            short(run.cpu_seconds),
            short(run.efficiency())
        );
    }
    let bad: u64 = findings.runs.iter().map(|run| run.bad_values).sum();
    let _ = writeln!(out, "</table>\n</details>");
    if bad > 0 {
        let _ =
            writeln!(out, "<p>{bad} values were not finite, negative or too large and were left out.</p>");
    }
}
