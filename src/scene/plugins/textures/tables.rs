//! What tables of a spectrum, and the ranges of formulas, have to be.

use super::Plugin;
use crate::scene::read::{Query, spectra};
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
        Ok(_) => lit(query, "values", values).then_some(plugin),
        Err(error) => refuse_table(query, "values", &error.to_string()),
    }
}

pub fn table(query: &Query<'_>, plugin: Plugin) -> Option<Plugin> {
    let Plugin::Irregular { nm, values } = &plugin else { return Some(plugin) };
    match Spectrum::irregular(nm, values, Extrapolation::Zero) {
        Ok(_) => lit(query, "values", values).then_some(plugin),
        Err(error) => refuse_table(query, "wavelengths", &error.to_string()),
    }
}

fn refuse_table<T>(query: &Query<'_>, name: &'static str, expected: &str) -> Option<T> {
    query.error(SceneError::at(&query.place(name), "The table of the spectrum is wrong", expected));
    None
}

/// Refuses a table of zeros, as Mitsuba 3 does.
fn lit(query: &Query<'_>, name: &'static str, values: &[f64]) -> bool {
    let dark = values.iter().all(|&value| value == 0.0);
    if dark {
        query.error(spectra::all_zero(&query.place(name)));
    }
    !dark
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
