//! What a spectrum is, in words and numbers.

use super::Subject;
use abbe::spectrum::catalogue::{self, Kind, Quantity, RefractiveIndex};
use abbe::spectrum::colour::{Observer, Xyz, srgb_hex, xyz_to_rec709};
use abbe::spectrum::normal_reflectance::reflectance_of_index;
use abbe::spectrum::{Extrapolation, Spectrum};
use abbe::units::{FRAUNHOFER_C, FRAUNHOFER_D, FRAUNHOFER_F, WavelengthRange, photons_per_joule};
use std::fmt::Write as _;

const RANGE: WavelengthRange = WavelengthRange::VISIBLE;

/// Illuminants under which colours are told: incandescent, two daylights, a broad and a three-band
/// fluorescent lamp, and equal energy.
const ILLUMINANTS: [&str; 6] = ["A", "D50", "D65", "FL2", "FL11", "E"];

/// Thicknesses through which absorbing media are shown, m.
const THICKNESSES: [(f64, &str); 5] =
    [(1e-4, "0.1 mm"), (1e-3, "1 mm"), (1e-2, "1 cm"), (0.1, "10 cm"), (1.0, "1 m")];

pub(super) fn report(subject: &Subject, at: &[f64], photons: bool) -> String {
    let mut text = format!("{}\n", subject.title);
    for (what, value) in &subject.facts {
        line(&mut text, what, value);
    }
    match &subject.quantity {
        Quantity::Spectrum(spectrum) => {
            sampling(&mut text, "sampling", spectrum);
            assumption(&mut text, catalogue::held_outside(spectrum, RANGE));
            if subject.kind == Some(Kind::Reflectance) {
                ends(&mut text, spectrum);
            }
            match photons {
                true => values(&mut text, at, &["value", "photons"], |nm| {
                    vec![spectrum.at(nm), spectrum.at(nm) * photons_per_joule(nm)]
                }),
                false => values(&mut text, at, &["value"], |nm| vec![spectrum.at(nm)]),
            }
            outside(&mut text, at, spectrum);
            match subject.kind {
                Some(Kind::Reflectance) => reflected(&mut text, spectrum),
                Some(Kind::Absorption) => transmitted(&mut text, spectrum),
                Some(Kind::Sensitivity) => {}
                Some(Kind::Illuminant) => emitted(&mut text, spectrum),
                Some(Kind::Conductor | Kind::Dielectric) | None => unknown(&mut text, spectrum),
            }
        }
        Quantity::Index(index) => {
            match index {
                RefractiveIndex::Formula(formula) => {
                    let stated = formula.stated();
                    let kind = format!("{:?}, stated for {}–{} nm", formula.kind(), stated.min, stated.max);
                    line(&mut text, "formula", &kind);
                }
                RefractiveIndex::Table(table) => sampling(&mut text, "sampling", table),
            }
            assumption(&mut text, index.assumption(RANGE));
            refraction(&mut text, index);
            let reflects = |nm| reflectance_of_index(index.at(nm), 0.0);
            values(&mut text, at, &["n", "reflectance"], |nm| vec![index.at(nm), reflects(nm)]);
        }
        Quantity::ComplexIndex { n, k } => {
            sampling(&mut text, "sampling", n);
            assumption(&mut text, catalogue::held_outside(n, RANGE));
            let reflects = |nm| reflectance_of_index(n.at(nm), k.at(nm));
            let row = |nm| vec![n.at(nm), k.at(nm), reflects(nm)];
            values(&mut text, at, &["n", "k", "reflectance"], row);
            outside(&mut text, at, n);
            reflected(&mut text, &derived(reflects));
        }
    }
    text
}

fn line(text: &mut String, what: &str, value: &str) {
    let _ = writeln!(text, "  {what:<10} {value}");
}

fn assumption(text: &mut String, sentence: Option<String>) {
    if let Some(sentence) = sentence {
        line(text, "assumption", &sentence);
    }
}

/// Says that a reflectance is black beyond its table, where that ends within what can be seen.
fn ends(text: &mut String, reflectance: &Spectrum) {
    let Some(known) = reflectance.domain().filter(|_| !reflectance.is_held_within(RANGE)) else { return };
    let is_black = [known.min, known.max].into_iter().all(|nm| reflectance.at(nm) == 0.0);
    if !is_black && (RANGE.min < known.min || RANGE.max > known.max) {
        line(text, "note", &format!("the table covers {}–{} nm; scenes take 0 beyond", known.min, known.max));
    }
}

/// Says which of the wavelengths that were asked for no table states.
fn outside(text: &mut String, at: &[f64], spectrum: &Spectrum) {
    let Some(known) = spectrum.domain() else { return };
    for &nm in at.iter().filter(|&&nm| nm < known.min || nm > known.max) {
        let here = WavelengthRange { min: nm, max: nm };
        let taken = if spectrum.is_held_within(here) { "its end value is held" } else { "it counts as 0" };
        let _ = writeln!(text, "  ({nm} nm is outside the table, {}–{} nm: {taken})", known.min, known.max);
    }
}

fn sampling(text: &mut String, what: &str, spectrum: &Spectrum) {
    let (Some(table), Some(known)) = (spectrum.table(), spectrum.domain()) else { return };
    let nodes = table.nodes();
    let steps = nodes.windows(2).map(|pair| pair[1] - pair[0]);
    let (least, greatest) =
        steps.fold((f64::INFINITY, 0.0), |(a, b): (f64, f64), step| (a.min(step), b.max(step)));
    let step = match greatest - least < 1e-9 {
        true => format!("{least:.4}").trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => format!("{least:.2} to {greatest:.2}"),
    };
    line(text, what, &format!("{} wavelengths, {}–{} nm, step {step} nm", nodes.len(), known.min, known.max));
}

/// A table of values at the wavelengths asked for, or every 20 nm.
fn values(text: &mut String, at: &[f64], heads: &[&str], row: impl Fn(f64) -> Vec<f64>) {
    let usual: Vec<f64> = (0..=23).map(|i| 360.0 + 20.0 * f64::from(i)).chain([830.0]).collect();
    let _ = write!(text, "\n  {:>9}", "nm");
    heads.iter().for_each(|head| {
        let _ = write!(text, " {head:>13}");
    });
    for &nm in if at.is_empty() { &usual } else { at } {
        let _ = write!(text, "\n  {nm:>9}");
        for value in row(nm) {
            let _ = match value != 0.0 && !(1e-3..1e6).contains(&value.abs()) {
                true => write!(text, " {value:>13.5e}"),
                false => write!(text, " {value:>13.6}"),
            };
        }
    }
    text.push('\n');
}

/// A function as a table of 1 nm: for showing its colour, not for rendering.
fn derived(function: impl Fn(f64) -> f64) -> Spectrum {
    let values: Vec<f64> = (360..=830).map(|nm| function(f64::from(nm))).collect();
    Spectrum::regular(RANGE.min, RANGE.max, &values, Extrapolation::Zero).unwrap_or(Spectrum::ZERO)
}

fn colour_head(text: &mut String, first: &str) {
    let _ = writeln!(
        text,
        "\n  {first:<10} {:>8} {:>8} {:>8}  {:>7} {:>7}  {:>7} {:>7} {:>7}  sRGB",
        "X", "Y", "Z", "x", "y", "L*", "a*", "b*"
    );
}

/// One colour, with Lab against `white`.
fn colour_line(text: &mut String, name: &str, colour: Xyz, white: Xyz) {
    shown_colour_line(text, name, colour, white, colour);
}

/// The same, where `shown` stands for the colour on a display.
fn shown_colour_line(text: &mut String, name: &str, colour: Xyz, white: Xyz, shown: Xyz) {
    let (x, y) = colour.chromaticity().unwrap_or((0.0, 0.0));
    let lab = colour.to_lab(white);
    let _ = writeln!(
        text,
        "  {name:<10} {:>8.5} {:>8.5} {:>8.5}  {x:>7.5} {y:>7.5}  {:>7.2} {:>7.2} {:>7.2}  {}",
        colour.x,
        colour.y,
        colour.z,
        lab.l,
        lab.a,
        lab.b,
        srgb_hex(shown)
    );
}

fn reflected(text: &mut String, reflectance: &Spectrum) {
    let observer = Observer::cie1931();
    colour_head(text, "under");
    for name in ILLUMINANTS {
        if let Ok(light) = catalogue::illuminant(name) {
            let colour = observer.reflected(&light, reflectance, RANGE);
            colour_line(text, name, colour, observer.white(&light, RANGE));
        }
    }
    let _ = writeln!(
        text,
        "  ({}; a perfect white has Y = 1; Lab against the illuminant, sRGB without adaptation)",
        observer.name()
    );
}

fn transmitted(text: &mut String, absorption: &Spectrum) {
    let Ok(light) = catalogue::illuminant("D65") else { return };
    let observer = Observer::cie1931();
    colour_head(text, "through");
    for (thickness, name) in THICKNESSES {
        let transmittance = derived(|nm| (-absorption.at(nm) * thickness).exp());
        colour_line(
            text,
            name,
            observer.reflected(&light, &transmittance, RANGE),
            observer.white(&light, RANGE),
        );
    }
    let _ = writeln!(text, "  ({} under D65; internal transmittance, surfaces not counted)", observer.name());
}

fn emitted(text: &mut String, emission: &Spectrum) {
    let (observer, total) = (Observer::cie1931(), emission.integral(RANGE));
    let colour = observer.xyz_of(emission, RANGE);
    if colour.y > 0.0 {
        let white = Xyz::from_chromaticity(0.3127, 0.3290, 1.0);
        colour_head(text, "emitted");
        // Shown as bright as the display's gamut allows.
        let brightest = xyz_to_rec709(colour / colour.y).into_iter().fold(1.0, f64::max);
        shown_colour_line(text, "Y = 1", colour / colour.y, white, colour / (colour.y * brightest));
        let _ =
            writeln!(text, "  ({}; Lab against D65, sRGB as bright as the gamut allows)", observer.name());
        let _ = writeln!(
            text,
            "  integral over {}–{} nm: {total:.6}; of luminous efficiency: {:.6}",
            RANGE.min, RANGE.max, colour.y
        );
    }
}

/// A file says nothing of its use: what could be a reflectance is shown as both.
fn unknown(text: &mut String, spectrum: &Spectrum) {
    emitted(text, spectrum);
    let (least, greatest) = spectrum.bounds(RANGE);
    if least >= 0.0 && greatest <= 1.0 {
        reflected(text, spectrum);
    }
}

fn refraction(text: &mut String, index: &RefractiveIndex) {
    for (name, nm) in [("n_F", FRAUNHOFER_F), ("n_d", FRAUNHOFER_D), ("n_C", FRAUNHOFER_C)] {
        line(text, name, &format!("{:.6}  at {nm} nm", index.at(nm)));
    }
    let abbe = index.abbe_number();
    if abbe.is_finite() {
        line(text, "Abbe V_d", &format!("{abbe:.3}"));
    }
    line(
        text,
        "R_d",
        &format!("{:.6}  at normal incidence", reflectance_of_index(index.at(FRAUNHOFER_D), 0.0)),
    );
}
