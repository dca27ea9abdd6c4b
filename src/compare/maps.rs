//! Pictures of the differences: as numbers for an EXR, and in colours for a PNG.

use super::{ChannelResult, Comparison, Tests};
use crate::spectrum::colour::{Lab, rec709_to_xyz, srgb_encode, xyz_to_rec709};

/// What a picture of the differences shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MapKind {
    /// A minus B.
    Difference,
    /// The difference over its standard error.
    Z,
    /// p-values of Welch's t-test.
    PValues,
    /// HDR-ꟻLIP.
    Flip,
}

/// A picture of the differences.
#[derive(Clone, Debug)]
pub struct Map {
    /// What it shows.
    pub kind: MapKind,
    /// Name and values of each channel; NaN where the pictures cannot be compared.
    pub channels: Vec<(String, Vec<f64>)>,
    /// The channel that the colours show.
    pub shown: usize,
}

impl Comparison {
    /// `None` where the files lack what it takes: errors, or colours.
    pub fn map(&self, kind: MapKind) -> Option<Map> {
        let of_tests = |values: fn(&Tests) -> &Vec<f64>| {
            let tested = |channel: &ChannelResult| {
                Some((channel.name.clone(), values(channel.tests.as_ref()?).clone()))
            };
            self.channels.iter().filter_map(tested).collect::<Vec<_>>()
        };
        let channels = match kind {
            MapKind::Difference => self
                .channels
                .iter()
                .map(|channel| (channel.name.clone(), channel.difference.clone()))
                .collect(),
            MapKind::Z => of_tests(|tests| &tests.z),
            MapKind::PValues => of_tests(|tests| &tests.p),
            MapKind::Flip => {
                self.seen.iter().map(|seen| ("flip".to_owned(), seen.hdr_flip_map.clone())).collect()
            }
        };
        let middle = &self.channels[self.middle].name;
        let shown = channels.iter().position(|(name, _)| name == middle).unwrap_or(0);
        (!channels.is_empty()).then_some(Map { kind, channels, shown })
    }
}

/// Standard errors at which the colours of z end.
const LARGEST_Z: f64 = 4.0;

/// Negative decimal logarithm of p at which its colours end.
const SMALLEST_P: f64 = 6.0;

impl Map {
    /// The value that the last colour stands for.
    fn end(&self) -> f64 {
        match self.kind {
            MapKind::Z => LARGEST_Z,
            MapKind::PValues => SMALLEST_P,
            MapKind::Flip => 1.0,
            MapKind::Difference => {
                // The largest but for the outermost hundredth, which would leave the rest white.
                let values = self.channels[self.shown].1.iter().filter(|value| value.is_finite());
                let mut sizes: Vec<f64> = values.map(|value| value.abs()).collect();
                sizes.sort_by(f64::total_cmp);
                let largest = sizes.get((0.99 * sizes.len() as f64) as usize).or(sizes.last()).copied();
                largest.filter(|&value| value > 0.0).unwrap_or(1.0)
            }
        }
    }

    /// sRGB code values of each pixel. Pixels that cannot be compared are green.
    pub fn colours(&self) -> Vec<[u8; 3]> {
        let end = self.end();
        let colour = |&value: &f64| match self.kind {
            _ if value.is_nan() => [0, 160, 0],
            MapKind::Difference | MapKind::Z => diverging(value / end),
            MapKind::PValues => sequential(-value.log10() / end),
            MapKind::Flip => sequential(value / end),
        };
        self.channels[self.shown].1.iter().map(colour).collect()
    }

    /// What the colours mean.
    pub fn legend(&self) -> String {
        let name = &self.channels[self.shown].0;
        match self.kind {
            MapKind::Difference => {
                format!("{name}: A − B, blue −{0:.3e}, white 0, red +{0:.3e}", self.end())
            }
            MapKind::Z => {
                format!("{name}: (A − B) / standard error, blue −{0}, white 0, red +{0}", LARGEST_Z)
            }
            MapKind::PValues => format!("{name}: p, black 1, white 1e-{SMALLEST_P} and below"),
            MapKind::Flip => "HDR-FLIP, black 0, white 1".to_owned(),
        }
    }
}

/// From black through violet, red and yellow to white, for 0 to 1. Lightness grows evenly, so that it reads
/// in grey too.
fn sequential(value: f64) -> [u8; 3] {
    let t = value.clamp(0.0, 1.0);
    coloured(100.0 * t, 75.0 * (std::f64::consts::PI * t).sin(), 285.0 + 170.0 * t)
}

/// From blue over white to red, for −1 to 1, both ends equally dark.
fn diverging(value: f64) -> [u8; 3] {
    let t = value.clamp(-1.0, 1.0);
    coloured(100.0 - 60.0 * t.abs(), 75.0 * t.abs(), if t < 0.0 { 280.0 } else { 35.0 })
}

/// A colour of CIELAB in sRGB, with as much of its chroma as fits.
fn coloured(lightness: f64, chroma: f64, degrees: f64) -> [u8; 3] {
    let white = rec709_to_xyz([1.0; 3]);
    let (sin, cos) = degrees.to_radians().sin_cos();
    let linear =
        |chroma: f64| xyz_to_rec709(Lab { l: lightness, a: chroma * cos, b: chroma * sin }.to_xyz(white));
    let fits = |chroma: f64| linear(chroma).iter().all(|value| (-1e-6..=1.0 + 1e-6).contains(value));
    let (mut inside, mut outside) = (0.0, chroma);
    for _ in 0..if fits(chroma) { 0 } else { 24 } {
        let middle = 0.5 * (inside + outside);
        if fits(middle) { inside = middle } else { outside = middle }
    }
    let chroma = if fits(chroma) { chroma } else { inside };
    linear(chroma).map(|value| (255.0 * srgb_encode(value.clamp(0.0, 1.0))).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_and_middles_of_the_maps() {
        assert_eq!([sequential(0.0), sequential(1.0), diverging(0.0)], [[0; 3], [255; 3], [255; 3]]);
        let ([r, g, b], [r2, g2, b2]) = (diverging(-1.0), diverging(1.0));
        assert!(b > r && b > g && r2 > g2 && r2 > b2, "{:?}", [[r, g, b], [r2, g2, b2]]);
        // Lightness grows all the way: no two values look alike in grey.
        let grey = |t: f64| {
            sequential(t)
                .iter()
                .zip([0.2126, 0.7152, 0.0722])
                .map(|(&v, w)| w * crate::spectrum::colour::srgb_decode(f64::from(v) / 255.0))
                .sum::<f64>()
        };
        assert!((0..50).all(|i| grey(f64::from(i) / 50.0) < grey(f64::from(i + 1) / 50.0)));
    }
}
