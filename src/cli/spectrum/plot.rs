//! A spectrum drawn as SVG: curves over a band of the spectrum's colours, axes with ticks and numbers.

use super::Subject;
use abbe::spectrum::catalogue::{Kind, Quantity};
use abbe::spectrum::colour::{Observer, srgb_encode, xyz_to_rec709};
use abbe::units::WavelengthRange;
use std::fmt::Write as _;

const RANGE: WavelengthRange = WavelengthRange::VISIBLE;

/// Size of the picture, pixels.
const WIDTH: f64 = 800.0;
const HEIGHT: f64 = 480.0;

/// The frame of the axes within it, and the height of the band of colours on its floor.
const LEFT: f64 = 84.0;
const RIGHT: f64 = 776.0;
const TOP: f64 = 48.0;
const BOTTOM: f64 = 420.0;
const BAND: f64 = 14.0;

/// Dark blue and dark orange: told apart by everybody, and on paper.
const INKS: [&str; 2] = ["#1b3a6b", "#b3541e"];

struct Curve {
    name: &'static str,
    points: Vec<(f64, f64)>,
}

pub(super) fn svg(subject: &Subject) -> String {
    let curves = curves(subject);
    let top = curves.iter().flat_map(|curve| &curve.points).map(|point| point.1).fold(f64::MIN, f64::max);
    let low = curves.iter().flat_map(|curve| &curve.points).map(|point| point.1).fold(f64::MAX, f64::min);
    // An index says little near zero; everything else starts there.
    let from = if matches!(subject.quantity, Quantity::Index(_)) { low } else { low.min(0.0) };
    let ticks = ticks(from, if top > from { top } else { from + 1.0 });
    let (from, to) = (ticks[0].min(from), ticks[ticks.len() - 1].max(top));
    let x = |nm: f64| LEFT + (RIGHT - LEFT) * (nm - RANGE.min) / RANGE.width();
    let y = |value: f64| BOTTOM - (BOTTOM - TOP) * (value - from) / (to - from);

    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" width=\"{WIDTH}\" height=\"{HEIGHT}\" \
         font-family=\"Helvetica, Arial, sans-serif\" font-size=\"13\" fill=\"#222\">\n\
         <rect width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"white\"/>\n"
    );
    let _ = writeln!(out, "<text x=\"{LEFT}\" y=\"30\" font-size=\"16\">{}</text>", escaped(&subject.title));
    for &tick in &ticks {
        let at = y(tick);
        let label = number(tick, ticks[1] - ticks[0]);
        let _ = writeln!(
            out,
            "<path d=\"M{LEFT} {at:.1}H{RIGHT}\" stroke=\"#ddd\"/><text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{label}</text>",
            LEFT - 8.0,
            at + 4.5
        );
    }
    for nm in (400..=800).step_by(50) {
        let at = x(f64::from(nm));
        let _ = writeln!(
            out,
            "<path d=\"M{at:.1} {BOTTOM}v{:.1}\" stroke=\"#222\"/><text x=\"{at:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{nm}</text>",
            BAND + 5.0,
            BOTTOM + BAND + 19.0
        );
    }
    for nm in (360..830).step_by(2) {
        let (left, right) = (x(f64::from(nm)), x(f64::from(nm + 2)));
        let _ = writeln!(
            out,
            "<rect x=\"{left:.2}\" y=\"{BOTTOM}\" width=\"{:.2}\" height=\"{BAND}\" fill=\"{}\" shape-rendering=\"crispEdges\"/>",
            right - left + 0.3,
            band_colour(f64::from(nm + 1))
        );
    }
    for (curve, ink) in curves.iter().zip(INKS) {
        let path: Vec<String> =
            curve.points.iter().map(|&(nm, value)| format!("{:.2} {:.2}", x(nm), y(value))).collect();
        let _ = writeln!(
            out,
            "<path d=\"M{}\" fill=\"none\" stroke=\"{ink}\" stroke-width=\"1.8\" stroke-linejoin=\"round\"/>",
            path.join("L")
        );
    }
    for (i, (curve, ink)) in curves.iter().zip(INKS).enumerate() {
        let _ = writeln!(
            out,
            "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\" fill=\"{ink}\">{}</text>",
            RIGHT - 6.0,
            TOP + 16.0 + 18.0 * i as f64,
            curve.name
        );
    }
    let _ = writeln!(
        out,
        "<path d=\"M{LEFT} {TOP}V{BOTTOM}H{RIGHT}\" fill=\"none\" stroke=\"#222\"/>\n\
         <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">wavelength, nm</text>\n</svg>",
        0.5 * (LEFT + RIGHT),
        HEIGHT - 6.0
    );
    out
}

fn curves(subject: &Subject) -> Vec<Curve> {
    let curve = |name, at: &dyn Fn(f64) -> f64, nodes: Vec<f64>| {
        // Every half nanometre, and every node, so that no corner of a table is cut.
        let mut places: Vec<f64> = (0..=940).map(|i| 360.0 + 0.5 * f64::from(i)).chain(nodes).collect();
        places.retain(|&nm| RANGE.contains(nm));
        places.sort_by(f64::total_cmp);
        Curve { name, points: places.into_iter().map(|nm| (nm, at(nm))).collect() }
    };
    match &subject.quantity {
        Quantity::Spectrum(spectrum) => {
            let name = match subject.kind {
                Some(Kind::Illuminant) => "relative spectral power",
                Some(Kind::Reflectance) => "reflectance",
                Some(Kind::Absorption) => "absorption, 1/m",
                Some(Kind::Sensitivity) => "response",
                Some(Kind::Conductor | Kind::Dielectric) | None => "value",
            };
            vec![curve(name, &|nm| spectrum.at(nm), spectrum.nodes())]
        }
        Quantity::Index(index) => vec![curve("refractive index n", &|nm| index.at(nm), Vec::new())],
        Quantity::ComplexIndex { n, k } => {
            vec![curve("n", &|nm| n.at(nm), n.nodes()), curve("k", &|nm| k.at(nm), k.nodes())]
        }
    }
}

/// About seven round numbers from at or below `from` to at or above `to`.
fn ticks(from: f64, to: f64) -> Vec<f64> {
    let rough = (to - from) / 6.0;
    let power = 10f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 2.5, 5.0, 10.0].into_iter().map(|m| m * power).find(|step| *step >= rough);
    let step = step.unwrap_or(10.0 * power);
    let (first, last) = ((from / step).floor() as i64, (to / step).ceil() as i64);
    (first..=last).map(|i| i as f64 * step).collect()
}

/// A tick's number with as many decimals as its step needs.
fn number(value: f64, step: f64) -> String {
    if value != 0.0 && !(1e-4..1e6).contains(&value.abs()) {
        return format!("{value:.2e}");
    }
    let decimals =
        (0..9).find(|&d| (step * 10f64.powi(d)).fract().min(1.0 - (step * 10f64.powi(d)).fract()) < 1e-6);
    format!("{value:.*}", decimals.unwrap_or(9) as usize)
}

/// A displayable colour for one wavelength: its own colour clipped to the gamut, darker at the ends of the visible range.
fn band_colour(nm: f64) -> String {
    let [x, y, z] = Observer::cie1931().at(nm);
    let linear = xyz_to_rec709([x, y, z].into()).map(|value| value.max(0.0));
    let top = linear.iter().copied().fold(1e-9, f64::max);
    let strength = (x + y + z).min(0.25) / 0.25;
    let [r, g, b] = linear.map(|value| (srgb_encode(value / top * strength) * 255.0).round() as u8);
    format!("#{r:02x}{g:02x}{b:02x}")
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_enclose() {
        assert_eq!(ticks(0.0, 1.0), [0.0, 0.2, 0.4, 0.6000000000000001, 0.8, 1.0]);
        let wide = ticks(3.7, 118.0);
        assert!(wide[0] <= 3.7 && *wide.last().unwrap() >= 118.0 && wide.len() < 10, "{wide:?}");
        assert_eq!(number(0.6000000000000001, 0.2), "0.6");
        assert_eq!(number(1.525, 0.0025), "1.5250");
        assert_eq!(number(2e7, 5e6), "2.00e7");
    }

    #[test]
    fn titles_cannot_break_the_picture() {
        assert_eq!(escaped("a<b & c"), "a&lt;b &amp; c");
    }
}
