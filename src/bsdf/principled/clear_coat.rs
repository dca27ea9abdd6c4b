//! The clear coat's highlight.

use crate::bsdf::microfacet::{Distribution, Microfacets};
use crate::geometry::{Vec3, angle};
use std::f64::consts::{PI, TAU};

/// A highlight with tails longer than GGX's: "generalised Trowbridge-Reitz" with exponent 1 (Burley
/// 2012, appendix B), masked like GGX of roughness 0.25.
#[derive(Clone, Copy, Debug)]
pub(super) struct ClearCoat {
    alpha: f64,
}

impl ClearCoat {
    /// A clear coat with `gloss` from 0, satin, to 1, polished.
    pub fn new(gloss: f64) -> Self {
        Self { alpha: super::mix(0.1, 0.001, gloss) }
    }

    /// `D(m) = (α² − 1) / (π ln α² (1 + (α² − 1) cos² θ))`, per steradian of facet normals.
    pub fn d(&self, m: Vec3) -> f64 {
        let square = self.alpha * self.alpha;
        // 1 − cos² + α² cos², without cancellation at the peak.
        let root = m.x * m.x + m.y * m.y + square * m.z * m.z;
        (square - 1.0) / (PI * square.ln() * root)
    }

    pub fn g(&self, eye: Vec3, light: Vec3, m: Vec3) -> f64 {
        Microfacets::new(Distribution::Ggx, 0.25, 0.25).g(eye, light, m)
    }

    /// A facet normal with density D(m) cos θ, which integrates to 1.
    pub fn sample(&self, u: [f64; 2]) -> Vec3 {
        let square = self.alpha * self.alpha;
        // 1 − cos² θ, from cos² θ = (1 − α^(2(1−u))) / (1 − α²).
        let sin2 = ((square.powf(1.0 - u[0]) - square) / (1.0 - square)).clamp(0.0, 1.0);
        let (sin, cos) = (sin2.sqrt(), (1.0 - sin2).sqrt());
        let (sin_phi, cos_phi) = angle::sin_cos(TAU * u[1]);
        Vec3::new(sin * cos_phi, sin * sin_phi, cos)
    }
}
