//! Emitters side by side as the tree keeps them, and about what they bring to a place.

use super::bound::Bound;
use crate::geometry::{Bounds, Vec3};
use std::f64::consts::PI;
use wide::f32x8;

/// How many parts a node has at most.
pub const PARTS: usize = 8;

/// Where light is received.
#[derive(Clone, Copy, Debug)]
pub struct Viewpoint {
    pub position: Vec3,
    /// The side from which light counts; zero where all does.
    pub facing: Vec3,
}

/// Coordinates in which the emitters of a tree fill a unit ball around the origin.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    centre: Vec3,
    radius: f64,
    /// Intensity of all of them.
    pub whole: f64,
}

impl Frame {
    pub fn new(bounds: &Bounds, whole: f64) -> Self {
        let centre = bounds.centre();
        // Emitters that are all in one place have some extent by rounding.
        let least = (1e-6 * centre.abs().max_element()).max(1e-100);
        Self { centre, radius: (0.5 * bounds.diameter()).max(least), whole }
    }

    /// A place as the nodes see it.
    pub fn eye(&self, from: &Viewpoint) -> Eye {
        /// Farther away all emitters are in one direction, to the last digit.
        const FAR: f64 = 1e15;
        let away = (from.position - self.centre) / self.radius;
        let near = away * (FAR / away.length()).min(1.0);
        let numbers = |v: Vec3| v.to_array().map(|c| f32x8::splat(c as f32));
        Eye {
            position: numbers(near),
            facing: (from.facing != Vec3::ZERO).then(|| numbers(from.facing)),
            squared: f32x8::splat(near.length_squared().max(1.0) as f32),
        }
    }

    /// The square of the distance at which all the emitters are from a place, about.
    pub fn squared_distance(&self, from: &Viewpoint) -> f64 {
        from.position.distance_squared(self.centre).max(self.radius * self.radius)
    }
}

/// A [`Viewpoint`] in the coordinates of a [`Frame`].
#[derive(Clone, Copy, Debug)]
pub struct Eye {
    position: [f32x8; 3],
    facing: Option<[f32x8; 3]>,
    /// Squared distance from the middle of the emitters, 1 within them.
    squared: f32x8,
}

/// Parts, each of one emitter or more, side by side: a ball that holds them, and how they shine. Intensities
/// are relative to those of the whole tree. An empty part has none.
#[derive(Clone, Debug, Default)]
pub struct Node {
    centre: [f32x8; 3],
    radius_squared: f32x8,
    /// Intensity of what shines into all directions alike, and a little of all.
    even: f32x8,
    /// Half the sum of the directions that the others face, by intensity.
    facing: [f32x8; 3],
    /// Length of it times cosine and sine of how far single ones differ from it.
    cos_spread: f32x8,
    sin_spread: f32x8,
    /// What these directions vary by: see [`Self::importances`].
    variance: f32x8,
    /// The node below each part by how many nodes it comes later, or the emitter, marked with [`LEAF`].
    pub children: [u32; PARTS],
}

pub const LEAF: u32 = 1 << 31;

/// What the mean of the positive part of a number, ½ (μ + √(μ² + k σ²)), has for k: exact at μ = 0 where
/// numbers are normally distributed. A ball that holds a box has nine times its variance in the square of its
/// radius.
const OF_BALL: f32 = (2.0 / PI / 9.0) as f32;

impl Node {
    pub fn put(&mut self, part: usize, bound: &Bound, child: u32, frame: &Frame) {
        /// Least intensity kept: what emits at all stays above zero.
        const LEAST: f64 = 1e-20;
        /// Whatever rounding does, what can be seen has an importance.
        const RESERVE: f64 = 1e-4;
        let centre = (bound.bounds.centre() - frame.centre) / frame.radius;
        let radius = 0.5 * bound.bounds.diameter() / frame.radius + 2.0 * f64::from(f32::EPSILON);
        let intensity = (bound.intensity / frame.whole).max(LEAST);
        let one_sided = intensity * bound.one_sided / bound.intensity;
        let mean = bound.facing / bound.one_sided.max(f64::MIN_POSITIVE);
        let length = mean.length().min(1.0);
        let (sin_spread, cos_spread) = (bound.spread + RESERVE).min(PI).sin_cos();
        let set = |row: &mut f32x8, value: f64| row.as_mut_array()[part] = value as f32;
        for axis in 0..3 {
            set(&mut self.centre[axis], centre[axis]);
            set(&mut self.facing[axis], 0.5 * one_sided * mean[axis]);
        }
        set(&mut self.radius_squared, radius * radius);
        set(&mut self.even, intensity - one_sided + RESERVE * intensity);
        set(&mut self.cos_spread, 0.5 * one_sided * length * cos_spread);
        set(&mut self.sin_spread, 0.5 * one_sided * length * sin_spread);
        // They vary across the axis as directions do that are even over a cap and have the same sum.
        let variance = 0.25 * (1.0 - length) * (1.0 + 2.0 * length);
        set(&mut self.variance, (0.5 * one_sided).powi(2) * variance);
        self.children[part] = child;
    }

    /// About the irradiance that each part brings to a place, up to a factor common to all nodes. Zero only
    /// where there is none.
    ///
    /// The cosines at both ends vary over a part. Where their mean is about zero the mean of their positive
    /// part isn't, and ½ (μ + √(μ² + k σ²)) is about that.
    #[inline]
    pub fn importances(&self, eye: &Eye) -> [f32; PARTS] {
        let dot = |a: &[f32x8; 3], b: &[f32x8; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let (zero, one) = (f32x8::ZERO, f32x8::ONE);
        let tiny = f32x8::splat(1e-30);
        let away: [f32x8; 3] = std::array::from_fn(|axis| self.centre[axis] - eye.position[axis]);
        let squared = dot(&away, &away).fast_max(tiny);
        let inverse = one / squared.sqrt();
        let direction = away.map(|c| c * inverse);
        let sin_squared = (self.radius_squared / squared).fast_min(one);
        let outside = self.radius_squared.simd_lt(squared);
        let sin = sin_squared.sqrt();
        let cos = (one - sin_squared).sqrt();
        let spread = f32x8::splat(OF_BALL) * sin_squared;

        let away_from = dot(&direction, &self.facing);
        // All of them show their backs, as seen from anywhere in the ball.
        let narrow = self.cos_spread * cos - self.sin_spread * sin;
        let back = self.sin_spread * cos + self.cos_spread * sin;
        let mut hidden = narrow.simd_gt(zero) & away_from.simd_ge(back);
        let squared_length = self.cos_spread * self.cos_spread + self.sin_spread * self.sin_spread;
        let varying = self.variance + spread * squared_length;
        let leaving = self.even - away_from + (away_from * away_from + varying).sqrt();
        let mut importance = leaving / squared;
        if let Some(facing) = &eye.facing {
            let cos = dot(&direction, facing);
            hidden |= (cos + sin).simd_lt(f32x8::splat(-1e-5));
            let received = f32x8::HALF * (cos + (cos * cos + spread).sqrt());
            importance *= received.fast_max(f32x8::splat(1e-4));
        }
        // Directions mean nothing within the ball.
        let all_around = self.even + squared_length.sqrt() + self.variance.sqrt();
        let within = all_around / self.radius_squared.fast_max(tiny);
        let importance = hidden.bitselect(zero, importance);
        (outside.bitselect(importance, within) * eye.squared).to_array()
    }
}
