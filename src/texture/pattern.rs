//! Patterns: functions of space with values from 0 to 1.

use super::noise::{Field, Octaves};
use crate::geometry::Vec3;
use std::f64::consts::TAU;

/// How values from 0 to 1 are spread over space, in units of the pattern's period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pattern {
    /// Fractional Brownian motion around ½; cells of size 1. Mean ½.
    Noise(Octaves),
    /// The sum of |noise| over the octaves: 0 along creases, seldom above ½.
    Turbulence(Octaves),
    /// Veins across x, as far apart as they are in phase with x plus a turbulence (Perlin, "An Image
    /// Synthesizer", 1985).
    Marble(Veins),
    /// Rings around z, whose radius wavers by a noise that is long along z. Within a ring the value rises
    /// slowly to the late wood of autumn and falls fast to the next spring. Mean ½.
    Wood(Veins),
    /// Across x: waves, or stripes where colours are not mixed. Mean ½.
    Bands,
}

/// What bends veins and rings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Veins {
    /// The noise that bends the veins.
    pub octaves: Octaves,
    /// By how many periods they are displaced where the noise is greatest.
    pub strength: f64,
}

/// The fraction of a ring in which wood darkens.
const LATE: f64 = 0.85;

/// Rings waver over so many of their widths, across and along the trunk.
const WAVER: Vec3 = Vec3::new(4.0, 4.0, 24.0);

/// The size of the cells of marble's turbulence, in periods: the golden ratio, so that they never keep step
/// with the veins.
const STRIDE: f64 = 1.618_033_988_749_895;

impl Pattern {
    /// From 0 to 1. `mixed` tells whether colours are mixed: where they are not, each has an equal part of a
    /// band, in their order.
    pub fn at(&self, p: Vec3, mixed: bool) -> Field {
        match self {
            Self::Noise(octaves) => {
                let noise = octaves.fractal(p);
                Field { value: 0.5 + 0.5 * noise.value, slope: 0.5 * noise.slope }
            }
            Self::Turbulence(octaves) => octaves.turbulence(p),
            Self::Marble(Veins { octaves, strength }) => {
                let turbulence = octaves.turbulence(p / STRIDE);
                wave(p.x + strength * turbulence.value, Vec3::X + *strength * turbulence.slope / STRIDE)
            }
            Self::Wood(Veins { octaves, strength }) => {
                let wavering = octaves.fractal(p / WAVER);
                let radius = p.x.hypot(p.y);
                let outward = Vec3::new(p.x, p.y, 0.0) / radius;
                let outward = if outward.is_finite() { outward } else { Vec3::ZERO };
                ring(radius + strength * wavering.value, outward + *strength * wavering.slope / WAVER)
            }
            Self::Bands if mixed => wave(p.x, Vec3::X),
            Self::Bands => Field { value: fraction(p.x), slope: Vec3::ZERO },
        }
    }
}

/// A wave from 0 to 1 and back in each period.
fn wave(phase: f64, slope: Vec3) -> Field {
    let (sin, cos) = (TAU * fraction(phase)).sin_cos();
    Field { value: 0.5 - 0.5 * cos, slope: slope * (0.5 * TAU * sin) }
}

/// Slowly from 0 to 1 and fast back in each period.
fn ring(phase: f64, slope: Vec3) -> Field {
    let within = fraction(phase);
    let (x, rate) = if within < LATE {
        (within / LATE, 1.0 / LATE)
    } else {
        ((1.0 - within) / (1.0 - LATE), -1.0 / (1.0 - LATE))
    };
    Field { value: x * x * (3.0 - 2.0 * x), slope: slope * (6.0 * x * (1.0 - x) * rate) }
}

/// In [0, 1); 0 for what is no number.
fn fraction(x: f64) -> f64 {
    let fraction = x - x.floor();
    // A tiny negative number is rounded up to 1.
    if (0.0..1.0).contains(&fraction) { fraction } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::mix;
    use crate::stats::Moments;

    const OCTAVES: Octaves = Octaves { count: 4, gain: 0.5, seed: 0 };

    fn all() -> [Pattern; 5] {
        let veins = Veins { octaves: OCTAVES, strength: 2.5 };
        [
            Pattern::Noise(OCTAVES),
            Pattern::Turbulence(OCTAVES),
            Pattern::Marble(veins),
            Pattern::Wood(veins),
            Pattern::Bands,
        ]
    }

    fn places(count: u64) -> impl Iterator<Item = Vec3> {
        let number = |i: u64| (mix(i) >> 11) as f64 / (1u64 << 53) as f64;
        (0..count).map(move |i| Vec3::new(number(3 * i), number(3 * i + 1), number(3 * i + 2)) * 2e4 - 1e4)
    }

    #[test]
    fn values_are_from_0_to_1_and_slopes_are_theirs() {
        let step = 1e-6;
        for pattern in all() {
            let mut least = f64::INFINITY;
            let mut most = f64::NEG_INFINITY;
            for p in places(20_000) {
                let here = pattern.at(p, true);
                assert!((0.0..=1.0).contains(&here.value), "{pattern:?} {p}: {here:?}");
                (least, most) = (least.min(here.value), most.max(here.value));
                for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
                    let [before, after] = [-step, step].map(|step| pattern.at(p + axis * step, true));
                    let found = (after.value - before.value) / (2.0 * step);
                    // Creases of the turbulence, and the year's end of wood.
                    let crease = (after.slope - before.slope).dot(axis).abs() > 1e-2;
                    assert!(crease || (found - here.slope.dot(axis)).abs() < 1e-3, "{pattern:?} {p}");
                }
            }
            let expected = match pattern {
                Pattern::Noise(_) => (0.25, 0.75),
                Pattern::Turbulence(_) => (0.05, 0.5),
                _ => (0.001, 0.999),
            };
            assert!(least < expected.0 && most > expected.1, "{pattern:?}: {least} to {most}");
        }
    }

    /// Far apart, as places are here, phases are as good as random: those of rings and waves are equally
    /// likely.
    #[test]
    fn means_are_known() {
        for pattern in all().into_iter().filter(|pattern| !matches!(pattern, Pattern::Turbulence(_))) {
            for mixed in [true, false] {
                let values: Moments = places(100_000).map(|p| pattern.at(p, mixed).value).collect();
                let found = values.estimate();
                let deviation = (found.mean - 0.5) / found.error();
                assert!(deviation.abs() < 4.0, "{pattern:?}: {} ± {}", found.mean, found.error());
            }
        }
    }

    /// Without turbulence veins and rings are where they are said to be.
    #[test]
    fn rings_and_veins_have_the_period() {
        let veins = Veins { octaves: OCTAVES, strength: 0.0 };
        for n in 0..5 {
            let n = f64::from(n);
            let at = |pattern: Pattern, x, y| pattern.at(Vec3::new(x, y, 0.3), true).value;
            for (pattern, crest) in
                [(Pattern::Marble(veins), 0.5), (Pattern::Wood(veins), LATE), (Pattern::Bands, 0.5)]
            {
                assert!(
                    at(pattern, n, 0.0) < 1e-12 && at(pattern, n + crest, 0.0) > 1.0 - 1e-12,
                    "{pattern:?} {n}"
                );
            }
            assert!(at(Pattern::Wood(veins), 0.6 * n, 0.8 * n) < 1e-12);
            assert!((Pattern::Bands.at(Vec3::X * (n + 0.25), false).value - 0.25).abs() < 1e-12);
        }
    }

    #[test]
    fn places_that_are_no_numbers_do_no_harm() {
        for pattern in all() {
            for x in [f64::NAN, f64::INFINITY, -1e300, -1e-300, 0.0] {
                let field = pattern.at(Vec3::splat(x), true);
                assert!((0.0..=1.0).contains(&field.value), "{pattern:?} {x}: {field:?}");
            }
        }
    }
}
