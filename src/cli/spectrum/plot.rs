//! A spectrum drawn: curves over a band of the spectrum's colours.

use super::Subject;
use abbe::plot::{Axis, Chart, Drawing, INKS, Ink, Point, Scale, Series, Strip};
use abbe::spectrum::catalogue::{Kind, Quantity};
use abbe::spectrum::colour::{Observer, srgb_encode, xyz_to_rec709};
use abbe::units::WavelengthRange;

const RANGE: WavelengthRange = WavelengthRange::VISIBLE;

struct Curve {
    name: &'static str,
    points: Vec<Point>,
}

pub(super) fn draw(subject: &Subject) -> Drawing {
    let curves = curves(subject);
    let mut y = Axis::new("", Scale::Linear);
    // An index says little near zero; everything else starts there.
    let floor = (!matches!(subject.quantity, Quantity::Index(_))).then_some(Point::new(RANGE.min, 0.0));
    // One curve is named by its axis, several by a legend.
    let several = curves.len() > 1;
    if let ([curve], false) = (curves.as_slice(), several) {
        y.title = curve.name.to_owned();
    }
    let series = |(curve, ink): (Curve, &Ink)| Series {
        name: if several { curve.name.to_owned() } else { String::new() },
        ink: *ink,
        points: curve.points,
        fitted: Vec::new(),
        marker: None,
        line: 1.8,
        dash: None,
    };
    let invisible = Series {
        name: String::new(),
        ink: Ink::TEXT,
        points: floor.into_iter().collect(),
        fitted: Vec::new(),
        marker: None,
        line: 0.0,
        dash: None,
    };
    Chart {
        title: subject.title.clone(),
        x: Axis {
            range: Some([RANGE.min, RANGE.max]),
            ticks: (8..=16).map(|i| 50.0 * f64::from(i)).collect(),
            ..Axis::new("wavelength, nm", Scale::Linear)
        },
        y,
        series: curves.into_iter().zip(&INKS).map(series).chain([invisible]).collect(),
        band: (360..830)
            .step_by(2)
            .map(|nm| Strip {
                from: f64::from(nm),
                to: f64::from(nm + 2),
                colour: band_colour(f64::from(nm + 1)),
            })
            .collect(),
    }
    .draw()
}

fn curves(subject: &Subject) -> Vec<Curve> {
    let curve = |name, at: &dyn Fn(f64) -> f64, nodes: Vec<f64>| {
        // Every half nanometre, and every node, so that no corner of a table is cut.
        let mut places: Vec<f64> = (0..=940).map(|i| 360.0 + 0.5 * f64::from(i)).chain(nodes).collect();
        places.retain(|&nm| RANGE.contains(nm));
        places.sort_by(f64::total_cmp);
        Curve { name, points: places.into_iter().map(|nm| Point::new(nm, at(nm))).collect() }
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

/// A displayable colour for one wavelength: its own colour clipped to the gamut, darker at the ends of the
/// visible range.
fn band_colour(nm: f64) -> Ink {
    let [x, y, z] = Observer::cie1931().at(nm);
    let linear = xyz_to_rec709([x, y, z].into()).map(|value| value.max(0.0));
    let top = linear.iter().copied().fold(1e-9, f64::max);
    let strength = (x + y + z).min(0.25) / 0.25;
    Ink::Rgb(linear.map(|value| (srgb_encode(value / top * strength) * 255.0).round() as u8))
}
