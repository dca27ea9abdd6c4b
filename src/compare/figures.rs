//! Figures of difference: of one quantity, and as an observer sees it.

use super::flip::{self, Exposures, Rgb};
use super::pair::{Pair, rec709};
use super::{Options, flip::hdr_flip};
use crate::spectrum::colour::{Xyz, assumed_white, delta_e_2000, rec709_to_xyz};
use crate::stats::relmse_scale;

/// How two images of one quantity differ, over the pixels that can be compared.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Figures {
    /// Mean of A, in the unit of the file.
    pub mean_a: f64,
    /// Mean of the reference B, in the unit of the file.
    pub mean_b: f64,
    /// √mean((A − B)²), in the unit of the files.
    pub rmse: f64,
    /// mean((A − B)² / (B² + 0.01·mean(B)²)).
    pub relmse: f64,
    /// mean(|A − B| / (|A| + |B|)), 0 to 1; equal values count as 0.
    pub smape: f64,
    /// mean(A)/mean(B) − 1.
    pub bias: f64,
}

impl Figures {
    pub(super) fn of(a: &[f64], b: &[f64], good: &[bool]) -> Self {
        let pairs = || a.iter().zip(b).zip(good).filter(|(_, good)| **good).map(|((&a, &b), _)| (a, b));
        let count = pairs().count().max(1) as f64;
        let mean = |value: &dyn Fn((f64, f64)) -> f64| pairs().map(value).sum::<f64>() / count;
        // Without a difference there is none relative to nothing either.
        let over = |difference: f64, scale: f64| if difference == 0.0 { 0.0 } else { difference / scale };
        let (mean_a, mean_b) = (mean(&|(a, _)| a), mean(&|(_, b)| b));
        let square = |(a, b): (f64, f64)| (a - b) * (a - b);
        Self {
            mean_a,
            mean_b,
            rmse: mean(&square).sqrt(),
            relmse: mean(&|(a, b)| over(square((a, b)), relmse_scale(b, mean_b))),
            smape: mean(&|(a, b)| over((a - b).abs(), a.abs() + b.abs())),
            bias: over(mean_a - mean_b, mean_b),
        }
    }

    /// The mean of each figure over several quantities.
    pub(super) fn mean<'a>(all: impl ExactSizeIterator<Item = &'a Self> + Clone) -> Self {
        let count = all.len().max(1) as f64;
        let mean = |figure: fn(&Self) -> f64| all.clone().map(figure).sum::<f64>() / count;
        Self {
            mean_a: mean(|f| f.mean_a),
            mean_b: mean(|f| f.mean_b),
            rmse: mean(|f| f.rmse),
            relmse: mean(|f| f.relmse),
            smape: mean(|f| f.smape),
            bias: mean(|f| f.bias),
        }
    }
}

/// How different two pictures look to an observer.
///
/// Scene values become colours as on a display that shows the luminance `white` as its white, D65, for both
/// pictures alike.
#[derive(Clone, Debug)]
pub struct PerceivedDifference {
    /// Luminance of white, in the unit of the files.
    pub white: f64,
    /// Mean CIEDE2000. CIELAB is relative to D65 with luminance `white`; nothing is clipped, brighter colours
    /// have L* above 100.
    pub delta_e: f64,
    /// Mean ꟻLIP of value/`white`, clipped to 0 to 1.
    pub flip: f64,
    /// Mean HDR-ꟻLIP, which chooses its own exposures and does not ask for `white`.
    pub hdr_flip: f64,
    /// The exposures at which HDR-FLIP looks at the pictures.
    pub exposures: Exposures,
    /// Resolution at which the pictures are looked at.
    pub pixels_per_degree: f64,
    /// HDR-ꟻLIP of each pixel; NaN where the pictures cannot be compared.
    pub hdr_flip_map: Vec<f64>,
}

impl PerceivedDifference {
    pub(super) fn of(pair: &Pair, good: &[bool], options: &Options) -> Option<Self> {
        // What cannot be compared is black in both.
        let both: Vec<[Xyz; 2]> = (0..good.len())
            .map(|i| if good[i] { pair.xyz(i) } else { Some([Xyz::default(); 2]) })
            .collect::<Option<_>>()?;
        let luminance = both.iter().zip(good).filter(|(_, good)| **good).map(|(both, _)| both[1].y.max(0.0));
        let white = options.white.unwrap_or_else(|| assumed_white(luminance.collect()));
        let d65 = rec709_to_xyz([1.0; 3]) * white;
        let count = good.iter().filter(|good| **good).count().max(1) as f64;
        let delta_e =
            both.iter().map(|[a, b]| delta_e_2000(b.to_lab(d65), a.to_lab(d65))).sum::<f64>() / count;
        let side = |side: usize| both.iter().map(|both| rec709(both[side])).collect::<Vec<Rgb>>();
        let (a, b) = (side(0), side(1));
        let displayed =
            |picture: &[Rgb]| picture.iter().map(|rgb| rgb.map(|v| v / white)).collect::<Vec<Rgb>>();
        let mean = |map: &[f64]| {
            map.iter().zip(good).filter(|(_, good)| **good).map(|(v, _)| v).sum::<f64>() / count
        };
        let ppd = options.pixels_per_degree;
        let low = flip::flip(&displayed(&b), &displayed(&a), pair.width, ppd);
        let exposures = Exposures::of(&b);
        let mut high = hdr_flip(&b, &a, pair.width, ppd, exposures);
        let (flip, hdr_flip) = (mean(&low), mean(&high));
        high.iter_mut().zip(good).filter(|(_, good)| !**good).for_each(|(value, _)| *value = f64::NAN);
        Some(Self { white, delta_e, flip, hdr_flip, exposures, pixels_per_degree: ppd, hdr_flip_map: high })
    }
}
