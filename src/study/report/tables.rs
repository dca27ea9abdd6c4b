use super::page::Section;
use super::{Findings, Series};
use serde_json::{Value, json};
use std::io;

/// A field of a CSV file (RFC 4180).
fn field(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

/// One row a replicate of a run. Names have the unit after the last underscore where there is one.
pub(super) fn csv(findings: &Findings) -> String {
    let request = findings.request;
    let names: Vec<&String> =
        request.cases.first().map_or(&[][..], |case| &case.parameters).iter().map(|(name, _)| name).collect();
    let mut header: Vec<String> = names.iter().map(|name| field(&format!("parameter.{name}"))).collect();
    header.extend(
        [
            "sampler",
            "estimator",
            "samples_per_pixel",
            "wavelengths_per_path",
            "replicate",
            "seed",
            "relmse",
            "bad_values_of_run",
            "cpu_time_per_replicate_s",
        ]
        .map(str::to_owned),
    );
    let mut text = header.join(",") + "\n";
    for id in request.runs() {
        let Some(run) = findings.runs.iter().find(|run| run.id == id) else { continue };
        let case = &findings.cases[id.case];
        let seeds = request.seeds(case, &id);
        for (replicate, (relmse, seed)) in run.relmse.iter().zip(seeds).enumerate() {
            let parameters = case.id.parameters.iter().map(|(_, value)| field(value));
            let names = [id.sampler.to_string(), id.estimator.to_string()];
            let numbers = [
                id.samples_per_pixel.to_string(),
                id.wavelengths_per_path.to_string(),
                replicate.to_string(),
                seed.to_string(),
                relmse.to_string(),
                run.bad_values.to_string(),
                run.cpu_seconds.to_string(),
            ];
            let row: Vec<String> = parameters.chain(names).chain(numbers).collect();
            text += &(row.join(",") + "\n");
        }
    }
    text
}

/// Everything: what was asked, where, each run and what was fitted.
pub(super) fn json(findings: &Findings, sections: &[Section]) -> io::Result<Vec<u8>> {
    let references: Vec<Value> = findings
        .references
        .iter()
        .enumerate()
        .map(|(case, reference)| json!({"case": case, "own_relmse_subtracted": reference.own_relmse}))
        .collect();
    let runs: Vec<Value> = findings
        .runs
        .iter()
        .map(|run| {
            let error = run.error();
            json!({
                "case": run.id.case,
                "sampler": run.id.sampler,
                "estimator": run.id.estimator,
                "samples_per_pixel": run.id.samples_per_pixel,
                "wavelengths_per_path": run.id.wavelengths_per_path,
                "relmse_of_each_replicate": run.relmse,
                "relmse": error.mean,
                "relmse_standard_error": error.error(),
                "relative_rmse": error.mean.max(0.0).sqrt(),
                "cpu_time_per_replicate_s": run.cpu_seconds,
                "efficiency_per_s": run.efficiency(),
                "bad_values": run.bad_values,
                "spectrum_of_image_error": run.spectrum.radial,
            })
        })
        .collect();
    let series = |section: &Section, series: &Series| {
        let reached = series.reached(section.target);
        json!({
            "case": series.case,
            "sampler": series.sampler,
            "estimator": series.estimator,
            "wavelengths_per_path": series.wavelengths,
            "log_rmse_against_log_samples": series.against_samples,
            "log_rmse_against_log_cpu_time": series.against_time,
            "target_relative_rmse": section.target,
            "cpu_time_to_target_s": reached.map(|reached| reached.seconds),
            "cpu_time_to_target_factor_95": reached.map(|reached| reached.factor),
            "cpu_time_to_target_is_extrapolated": reached.map(|reached| reached.extrapolated),
        })
    };
    let fits: Vec<Value> =
        sections.iter().flat_map(|section| section.series.iter().map(|s| series(section, s))).collect();
    let whole = json!({
        "study": findings.request,
        "scene": findings.context.scene,
        "command": findings.context.command,
        "machine": findings.context.machine,
        "references": references,
        "runs": runs,
        "series": fits,
    });
    Ok(serde_json::to_vec_pretty(&whole)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_with_commas_are_quoted() {
        assert_eq!(field("0.1"), "0.1");
        assert_eq!(field("a, \"b\""), "\"a, \"\"b\"\"\"");
    }
}
