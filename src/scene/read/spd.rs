//! Spectra written in place (`value="..."`) or in an `.spd` file (`filename="..."`).

use super::super::source::{Place, SceneError, Sources};
use super::attributes::{Attribute, number};
use super::files::{self, Search};
use super::tree::Value;
use crate::spectrum::text::{TO_NANOMETRES, TextProblem, demand_nanometres, parse_list, parse_spd};
use crate::spectrum::{Extrapolation, Spectrum};

/// A larger file is not a table of one spectrum.
pub(super) const LARGEST_FILE: u64 = 16 << 20;

/// `0.5`, or `400:0.1, 700:0.9`.
pub(super) fn value(attribute: &Attribute) -> Result<Value, SceneError> {
    if let Some(flat) = number(&attribute.text) {
        return Ok(Value::Flat(flat));
    }
    if !attribute.text.contains(':') {
        return Err(SceneError::at(
            &attribute.place,
            format!("\"{}\" is not a spectrum", attribute.text),
            "expected one finite number, or pairs such as 400:0.1, 700:0.9",
        ));
    }
    match parse_list(&attribute.text) {
        Ok(columns) => Ok(Value::List { nm: columns.nodes, values: columns.values, file: None }),
        Err(error) => {
            let rest = &attribute.text[error.offset..];
            let length = rest.find([',', ' ', ':']).unwrap_or(rest.len());
            let place = match error.problem {
                TextProblem::TooFew(_) | TextProblem::NotNanometres(_) => attribute.place.clone(),
                _ => attribute.part(error.offset, length),
            };
            let remedy = match error.problem {
                TextProblem::NotANumber(_) => "write numbers as 0.1 or 1e-3, with nothing behind them",
                TextProblem::NoColon(_) => {
                    "write pairs of wavelength and value, as in 400:0.1, 700:0.9; a colour is an <rgb>"
                }
                _ => "write pairs without blanks around the colon: 400:0.1, 700:0.9",
            };
            Err(wrong(&place, &error.problem, remedy))
        }
    }
}

/// Wavelengths (nm) and values, which stand at a place.
pub(super) fn list(nm: Vec<f64>, values: Vec<f64>, place: &Place) -> Result<Value, SceneError> {
    Spectrum::irregular(&nm, &values, Extrapolation::Zero)
        .map_err(|error| wrong_table(place, &error.to_string()))?;
    in_nanometres([nm[0], nm[nm.len() - 1]], place)?;
    Ok(Value::List { nm, values, file: None })
}

/// Refuses a table whose ends cannot be in nm.
pub(in crate::scene) fn in_nanometres(ends: [f64; 2], place: &Place) -> Result<(), SceneError> {
    demand_nanometres(ends)
        .map_err(|problem| wrong_table(place, &problem.to_string()).with_remedy(TO_NANOMETRES))
}

/// The message about numbers that make no table.
pub(in crate::scene) fn wrong_table(place: &Place, expected: &str) -> SceneError {
    SceneError::at(place, "The table of the spectrum is wrong", expected)
}

/// A file of lines `wavelength value`.
pub(super) fn file(
    attribute: &Attribute,
    search: &Search,
    sources: &mut Sources,
) -> Result<Value, SceneError> {
    let path = search.find(&attribute.text);
    let text = files::read(&path, LARGEST_FILE, &attribute.place)?;
    let text = String::from_utf8(text).map_err(|_| {
        SceneError::at(
            &attribute.place,
            format!("{} is not text", path.display()),
            "expected a text file with lines of wavelength and value",
        )
    })?;
    parse_spd(&text)
        .map(|columns| Value::List { nm: columns.nodes, values: columns.values, file: Some(path.clone()) })
        .map_err(|error| {
            let line = text.split_inclusive('\n').nth(error.line - 1).unwrap_or("");
            let line_start: usize = text.split_inclusive('\n').take(error.line - 1).map(str::len).sum();
            let offset =
                line.char_indices().nth(error.column - 1).map_or(line.trim_end().len(), |(at, _)| at);
            let start = line_start + offset;
            let length = line[offset..].find(char::is_whitespace).unwrap_or(line.len() - offset);
            let place = Place { file: sources.add(&path, text), span: start..start + length };
            wrong(&place, &error.problem, "write a wavelength and a value on each line, separated by blanks")
        })
}

/// `grammar` says how pairs are written.
fn wrong(place: &Place, problem: &TextProblem, grammar: &str) -> SceneError {
    let error = SceneError::at(place, "The spectrum cannot be read", problem.to_string());
    match problem {
        TextProblem::NotIncreasing { .. } => {
            error.with_remedy("sort the pairs by wavelength, each wavelength once")
        }
        TextProblem::TooFew(_) => {
            error.with_remedy("for a constant write a single number without wavelength")
        }
        TextProblem::NotPositive(_) => error.with_remedy("wavelengths are in nanometres"),
        TextProblem::NotNanometres(_) => error.with_remedy(TO_NANOMETRES),
        _ => error.with_remedy(grammar),
    }
}
