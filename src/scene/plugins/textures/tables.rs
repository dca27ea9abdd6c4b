//! What tables of a spectrum, and the ranges of formulas, have to be.

use super::Plugin;
use crate::scene::read::{Query, spd, spectra};
use crate::scene::source::SceneError;
use crate::spectrum::{Extrapolation, Spectrum};

/// Mitsuba 3 reads and ignores the range.
pub fn everywhere(query: &Query<'_>, plugin: Plugin) -> Option<Plugin> {
    for name in ["wavelength_min", "wavelength_max"] {
        if query.has(name) {
            let text = format!("{name} of \"uniform\" changes nothing, as in Mitsuba 3");
            query.reader.remark(&query.place(name), text);
        }
    }
    Some(plugin)
}

pub fn equally_spaced(query: &Query<'_>, plugin: Plugin) -> Option<Plugin> {
    let Plugin::Regular { min_nm, max_nm, values } = &plugin else { return Some(plugin) };
    match Spectrum::regular(*min_nm, *max_nm, values, Extrapolation::Zero) {
        Ok(_) => is_table(query, "wavelength_max", [*min_nm, *max_nm], values).then_some(plugin),
        Err(error) => refuse_table(query, "values", &error.to_string()),
    }
}

pub fn table(query: &Query<'_>, plugin: Plugin) -> Option<Plugin> {
    let Plugin::Irregular { nm, values } = &plugin else { return Some(plugin) };
    match Spectrum::irregular(nm, values, Extrapolation::Zero) {
        Ok(_) => is_table(query, "wavelengths", [nm[0], nm[nm.len() - 1]], values).then_some(plugin),
        Err(error) => refuse_table(query, "wavelengths", &error.to_string()),
    }
}

fn refuse_table<T>(query: &Query<'_>, name: &'static str, expected: &str) -> Option<T> {
    query.error(spd::wrong_table(&query.place(name), expected));
    None
}

/// Refuses a table of zeros, as Mitsuba 3 does, and one whose wavelengths, which `name` gives, are not in nm.
fn is_table(query: &Query<'_>, name: &'static str, ends: [f64; 2], values: &[f64]) -> bool {
    let dark = values.iter().all(|&value| value == 0.0);
    if dark {
        query.error(spectra::all_zero(&query.place("values")));
    }
    let in_nanometres = spd::in_nanometres(ends, &query.place(name)).map_err(|error| query.error(error));
    !dark && in_nanometres.is_ok()
}

pub fn a_range(query: &Query<'_>, plugin: Plugin) -> Option<Plugin> {
    let Plugin::Blackbody { min_nm, max_nm, .. } = &plugin else { return Some(plugin) };
    if min_nm >= max_nm {
        let problem = format!("The range from {min_nm} to {max_nm} nm is empty");
        query.error(SceneError::at(
            &query.object.place,
            problem,
            "expected wavelength_min below wavelength_max",
        ));
        return None;
    }
    Some(plugin)
}
