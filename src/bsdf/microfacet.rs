//! Statistics of a surface made of many small facets that are themselves smooth.
//!
//! A distribution says how many facets face which way (D), how many of those a direction sees (G1,
//! Smith's masking), and samples the visible ones. Facets are in the local frame, on the side z > 0;
//! directions given to these functions are above the surface too.
//!
//! Assumptions: the facets' heights and slopes are uncorrelated (Smith), and light meets one facet
//! only. What facets would pass on to one another is lost; the loss grows with roughness.
//!
//! References: Walter et al., "Microfacet Models for Refraction through Rough Surfaces", EGSR 2007;
//! Heitz, "Understanding the Masking-Shadowing Function", JCGT 3(2), 2014.

use super::facets::{FacetReflection, FacetTransmission};
use crate::geometry::{Vec3, angle};
use crate::lanes::{Real, Vector};
use statrs::function::erf::{erf_inv, erfc};
use std::f64::consts::{FRAC_1_PI, FRAC_2_SQRT_PI, TAU};

/// 1/√π
const FRAC_1_SQRT_PI: f64 = 0.5 * FRAC_2_SQRT_PI;

/// Distribution of the slopes of microfacets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Distribution {
    /// Gaussian slopes (Beckmann and Spizzichino 1963).
    Beckmann,
    /// Trowbridge and Reitz 1975, called GGX by Walter et al. 2007: long tails.
    Ggx,
}

/// Facets of one distribution, for formulas of one surface or of several.
pub trait Facets<R: Real> {
    /// Width along x and y of the local frame, above 0; see [`Microfacets::new`].
    fn alpha(&self) -> [R; 2];

    /// D(m): area of the facets of normal `m` per area of surface and steradian of normals, so that
    /// `∫ D(m) m.z dm = 1`.
    fn d(&self, m: Vector<R>) -> R;

    /// G1(v, m): which fraction of the facets with normal `m` is seen from `v`, 0–1.
    /// Zero where `v` would see the back of `m`.
    fn g1(&self, v: Vector<R>, m: Vector<R>) -> R;

    /// `∫ D(m) max(0, v·m) dm`: the facets seen from `v`, projected, per area of surface.
    /// This is v.z over Smith's exact G1, but finite at grazing directions.
    fn projected_area(&self, v: Vector<R>) -> R;

    /// The density, per steradian of facet normals, of the facets that `v` sees:
    /// `D(m) max(0, v·m) / ∫ D(m) max(0, v·m) dm` (Heitz 2014). It integrates to 1.
    #[inline(always)]
    fn visible(&self, v: Vector<R>, m: Vector<R>) -> R {
        self.d(m) * v.dot(m).greater(R::of(0.0)) / self.projected_area(v)
    }

    /// sin θ times the roughness in the azimuth of `v`.
    #[inline(always)]
    fn spread(&self, v: Vector<R>) -> R {
        let [along_x, along_y] = self.alpha();
        length(along_x * v.x, along_y * v.y)
    }
}

/// Facets of the distribution [`Distribution::Ggx`] by their two roughnesses.
#[derive(Clone, Copy, Debug)]
pub struct Ggx<R> {
    /// See [`Facets::alpha`].
    pub alpha: [R; 2],
}

impl<R: Real> Facets<R> for Ggx<R> {
    #[inline(always)]
    fn alpha(&self) -> [R; 2] {
        self.alpha
    }

    /// Walter et al. 2007, eq. 33.
    #[inline(always)]
    fn d(&self, m: Vector<R>) -> R {
        let (u, v) = (m.x / self.alpha[0], m.y / self.alpha[1]);
        let root = u * u + v * v + m.z * m.z;
        let density = R::of(1.0) / (root * root);
        let d = R::of(FRAC_1_PI) * density / (self.alpha[0] * self.alpha[1]);
        R::choose(m.z.gt(R::of(0.0)), d, R::of(0.0))
    }

    /// Walter et al. 2007, eq. 34.
    #[inline(always)]
    fn g1(&self, v: Vector<R>, m: Vector<R>) -> R {
        let zero = R::of(0.0);
        let g1 = R::of(2.0) * v.z / (v.z + length(v.z, self.spread(v)));
        R::choose(v.dot(m).gt(zero) & v.z.gt(zero), g1, zero)
    }

    #[inline(always)]
    fn projected_area(&self, v: Vector<R>) -> R {
        R::of(0.5) * (v.z + length(v.z, self.spread(v)))
    }
}

impl<R: Real> Ggx<R> {
    /// A normal among those that v sees (Heitz 2018). `u` is a point of the unit square.
    #[inline(always)]
    pub fn sample_visible(&self, v: Vector<R>, u: [R; 2]) -> Vector<R> {
        let m = sample_unit_ggx(Vector::new(self.alpha[0] * v.x, self.alpha[1] * v.y, v.z).normalize(), u);
        Vector::new(self.alpha[0] * m.x, self.alpha[1] * m.y, m.z).normalize()
    }
}

/// Facets of the distribution [`Distribution::Beckmann`] by their two roughnesses.
#[derive(Clone, Copy, Debug)]
pub struct Beckmann<R> {
    /// See [`Facets::alpha`].
    pub alpha: [R; 2],
}

impl<R: Real> Facets<R> for Beckmann<R> {
    #[inline(always)]
    fn alpha(&self) -> [R; 2] {
        self.alpha
    }

    /// Walter et al. 2007, eq. 25.
    #[inline(always)]
    fn d(&self, m: Vector<R>) -> R {
        let zero = R::of(0.0);
        let (u, v) = (m.x / self.alpha[0], m.y / self.alpha[1]);
        let (slope2, z2) = (u * u + v * v, m.z * m.z);
        let d = (-slope2 / z2).exp() / (z2 * z2) * R::of(FRAC_1_PI) / (self.alpha[0] * self.alpha[1]);
        // Beyond this slope the exponential vanishes; so does z⁴, at worst.
        R::choose(m.z.gt(zero) & slope2.lt(R::of(700.0) * z2), d, zero)
    }

    /// The rational approximation of Walter et al. 2007 (eq. 27, within 0.4 % of Smith's function), because
    /// that is what the rough surfaces of Mitsuba 3 mean.
    #[inline(always)]
    fn g1(&self, v: Vector<R>, m: Vector<R>) -> R {
        let (zero, one) = (R::of(0.0), R::of(1.0));
        let spread = self.spread(v);
        let a = v.z / spread;
        let part = a * (R::of(3.535) + R::of(2.181) * a) / (one + a * (R::of(2.276) + R::of(2.577) * a));
        let g1 = R::choose(v.z.ge(R::of(1.6) * spread), one, part);
        R::choose(v.dot(m).gt(zero) & v.z.gt(zero), g1, zero)
    }

    /// With a = v.z / spread it is ½ (v.z (1 + erf a) + spread exp(−a²)/√π)
    /// = v.z + ½ spread exp(−a²) (1/√π − a exp(a²) erfc a).
    #[inline(always)]
    fn projected_area(&self, v: Vector<R>) -> R {
        let spread = self.spread(v);
        // Beyond a = 6 no facet is hidden: erfc 6 is below the precision of f64.
        let a = (v.z / spread).lesser(R::of(6.0));
        let x = (a + a - R::of(3.0)) / (a + R::of(3.0));
        let rest = REST.iter().rev().fold(R::of(0.0), |sum, &coefficient| sum * x + R::of(coefficient));
        v.z + R::of(0.5) * spread * ((-a * a).exp() * rest)
    }
}

/// 1/√π − a exp(a²) erfc a for 0 ≤ a ≤ 6, in powers of x = (2a − 3)/(a + 3): Chebyshev's
/// interpolation of degree 18, calculated with 60 digits. The error of the projected area is below
/// 4·10⁻¹⁶ of it.
const REST: [f64; 19] = [
    0.081_811_458_866_280_04,
    -0.171_339_839_674_823_36,
    0.164_399_142_281_142_33,
    -0.097_518_446_387_250_6,
    0.038_718_652_658_436_49,
    -0.009_668_838_064_391_174,
    0.000_994_620_452_439_907,
    0.000_201_375_951_876_591_11,
    -6.732_762_130_879_428e-5,
    -4.134_173_041_137_65e-6,
    3.514_105_548_538_538e-6,
    1.979_519_464_299_191e-7,
    -1.901_077_528_532_725_6e-7,
    -2.103_128_139_201_407_3e-8,
    9.895_876_794_344_067e-9,
    2.170_477_113_417_686_4e-9,
    -3.892_224_398_951_555e-10,
    -1.451_275_653_452_768_5e-10,
    4.701_227_253_342_82e-12,
];

/// A distribution of facet normals with its two roughnesses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Microfacets {
    distribution: Distribution,
    alpha_u: f64,
    alpha_v: f64,
}

impl Microfacets {
    /// Smallest roughness, which also stands for smaller ones; also Mitsuba's.
    pub const MIN_ALPHA: f64 = 1e-4;

    /// Roughness `alpha_u` along the frame's x axis and `alpha_v` along its y axis: √2 times the
    /// standard deviation of the slope for Beckmann, the analogous scale for GGX.
    /// Values below [`Self::MIN_ALPHA`] (and NaN) are raised to it.
    pub fn new(distribution: Distribution, alpha_u: f64, alpha_v: f64) -> Self {
        Self { distribution, alpha_u: alpha_u.max(Self::MIN_ALPHA), alpha_v: alpha_v.max(Self::MIN_ALPHA) }
    }

    /// Beckmann's or GGX's.
    pub fn distribution(&self) -> Distribution {
        self.distribution
    }

    /// The two roughnesses; see [`Facets::alpha`].
    pub fn alpha(&self) -> [f64; 2] {
        [self.alpha_u, self.alpha_v]
    }

    /// Whether the two roughnesses differ.
    pub fn is_anisotropic(&self) -> bool {
        self.alpha_u != self.alpha_v
    }

    /// See [`Facets::g1`].
    pub fn g1(&self, v: Vec3, m: Vec3) -> f64 {
        match self.distribution {
            Distribution::Beckmann => self.beckmann().g1(v.into(), m.into()),
            Distribution::Ggx => self.ggx().g1(v.into(), m.into()),
        }
    }

    /// G(a, b, m) = G1(a, m) G1(b, m): masking and shadowing taken as independent, as Mitsuba does.
    pub fn g(&self, a: Vec3, b: Vec3, m: Vec3) -> f64 {
        self.g1(a, m) * self.g1(b, m)
    }

    /// See [`FacetReflection::about`].
    #[inline]
    pub fn reflection(&self, eye: Vec3, light: Vec3, m: Vec3) -> FacetReflection<f64> {
        let [eye, light, m] = [eye, light, m].map(Vector::of);
        match self.distribution {
            Distribution::Beckmann => FacetReflection::about(&self.beckmann(), eye, light, m),
            Distribution::Ggx => FacetReflection::about(&self.ggx(), eye, light, m),
        }
    }

    /// From `light`, below, to `eye`, above, by way of the facets of normal `m`. `eta` is the index below
    /// over that above. `None` where one of the directions would see the wrong side of the facets.
    #[inline]
    pub fn transmission(&self, eye: Vec3, light: Vec3, m: Vec3, eta: f64) -> Option<FacetTransmission> {
        match self.distribution {
            Distribution::Beckmann => FacetTransmission::about(&self.beckmann(), eye, light, m, eta),
            Distribution::Ggx => FacetTransmission::about(&self.ggx(), eye, light, m, eta),
        }
    }

    /// A facet normal with density [`Facets::visible`] from two uniform numbers in [0, 1).
    /// `v.z` must be positive.
    pub fn sample_visible(&self, v: Vec3, u: [f64; 2]) -> Vec3 {
        match self.distribution {
            Distribution::Beckmann => {
                // Stretching space by the roughness makes the surface isotropic with roughness 1.
                let stretched = Vec3::new(self.alpha_u * v.x, self.alpha_v * v.y, v.z).normalize();
                let m = sample_unit_beckmann(stretched, u);
                Vec3::new(self.alpha_u * m.x, self.alpha_v * m.y, m.z).normalize()
            }
            Distribution::Ggx => self.ggx().sample_visible(v.into(), u).into(),
        }
    }

    fn ggx(&self) -> Ggx<f64> {
        Ggx { alpha: self.alpha() }
    }

    fn beckmann(&self) -> Beckmann<f64> {
        Beckmann { alpha: self.alpha() }
    }
}

/// A visible normal of the GGX distribution with roughness 1: the facets seen are those of a
/// hemisphere, and reflecting `v` about them covers a spherical cap uniformly
/// (Dupuy and Benyoub, "Sampling Visible GGX Normals with Spherical Caps", 2023).
#[inline(always)]
fn sample_unit_ggx<R: Real>(v: Vector<R>, u: [R; 2]) -> Vector<R> {
    let one = R::of(1.0);
    let up = one + v.z;
    // The cap point's z is rest − v.z and sin² θ = (1 − z)(1 + z), both without cancellation.
    let rest = (one - u[1]) * up;
    let sin = (u[1] * up * ((one - v.z).greater(R::of(0.0)) + rest)).sqrt();
    let (sin_phi, cos_phi) = angle::sin_cos(R::of(TAU) * u[0]);
    Vector::new(sin * cos_phi + v.x, sin * sin_phi + v.y, rest)
}

/// A visible normal of the Beckmann distribution with roughness 1, not normalised, z = 1.
///
/// With the azimuth of `v` turned to x, the slopes separate (Heitz and d'Eon, "Importance Sampling
/// Microfacet-Based BSDFs using the Distribution of Visible Normals", EGSR 2014): the one across is
/// Gaussian, the one along has the density below.
fn sample_unit_beckmann(v: Vec3, u: [f64; 2]) -> Vec3 {
    let sin = length(v.x, v.y);
    let (cos_phi, sin_phi) = if sin > 0.0 { (v.x / sin, v.y / sin) } else { (1.0, 0.0) };
    let along = beckmann_visible_slope(v.z, sin, u[0]);
    let across = erf_inv(2.0 * open(u[1]) - 1.0);
    Vec3::new(-(cos_phi * along - sin_phi * across), -(sin_phi * along + cos_phi * across), 1.0)
}

/// √(a² + b²) for numbers whose squares neither overflow nor matter where they underflow.
#[inline(always)]
fn length<R: Real>(a: R, b: R) -> R {
    (a * a + b * b).sqrt()
}

/// Keeps a number of [0, 1) away from 0 and 1, where an unbounded slope would be infinite.
fn open(u: f64) -> f64 {
    u.clamp(f64::EPSILON / 4.0, 1.0 - f64::EPSILON / 2.0)
}

/// The slope x < cot θ with density proportional to `(cos θ − x sin θ) exp(−x²)`, by inverting
///
/// `C(x) = cos θ (1 + erf x) + sin θ exp(−x²)/√π`
///
/// with Halley's method inside a bracket.
fn beckmann_visible_slope(cos: f64, sin: f64, u: f64) -> f64 {
    let u = open(u);
    let gaussian = |u: f64| erf_inv(2.0 * u - 1.0);
    if sin < 1e-9 {
        return gaussian(u);
    }
    // Facets steeper than this have less than 1e-17 of the weight.
    let (mut low, mut high) = (-6.3, (cos / sin).min(6.3));
    let cumulative = |x: f64, bell: f64| cos * erfc(-x) + sin * FRAC_1_SQRT_PI * bell;
    let target = u * cumulative(high, (-high * high).exp());
    // Exact at normal incidence (the Gaussian) and at grazing incidence (exp(−x²) on x < 0).
    // Short of the upper end, where the density vanishes and a step would have no length.
    let mut x = (cos * gaussian(u) - (1.0 - cos) * (-u.ln()).sqrt()).clamp(low, high - 0.1);
    for _ in 0..40 {
        let bell = (-x * x).exp();
        let excess = cumulative(x, bell) - target;
        if excess.abs() <= 1e-14 * target {
            break;
        }
        if excess > 0.0 {
            high = x;
        } else {
            low = x;
        }
        let linear = cos - x * sin;
        let slope = FRAC_2_SQRT_PI * bell * linear;
        let newton = excess / slope;
        let step = newton / (1.0 + newton * (x + 0.5 * sin / linear));
        let next = x - step;
        // Written so that a NaN bisects.
        let next = if next > low && next < high { next } else { 0.5 * (low + high) };
        // Convergence is cubic: the error left is far below this step's.
        if (next - x).abs() <= 1e-6 {
            return next;
        }
        x = next;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stats::{SphereCells, sidak, sphere_chi_square};
    use std::f64::consts::FRAC_PI_2;

    impl Microfacets {
        /// See [`Facets::d`].
        fn d(&self, m: Vec3) -> f64 {
            match self.distribution {
                Distribution::Beckmann => self.beckmann().d(m.into()),
                Distribution::Ggx => self.ggx().d(m.into()),
            }
        }

        /// See [`Facets::visible`].
        fn visible(&self, v: Vec3, m: Vec3) -> f64 {
            match self.distribution {
                Distribution::Beckmann => self.beckmann().visible(v.into(), m.into()),
                Distribution::Ggx => self.ggx().visible(v.into(), m.into()),
            }
        }
    }

    const DISTRIBUTIONS: [Distribution; 2] = [Distribution::Beckmann, Distribution::Ggx];

    fn direction(theta: f64, phi: f64) -> Vec3 {
        Vec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
    }

    /// The integral of `f` over the hemisphere of facet normals, by the midpoint rule in the slope's
    /// azimuth and in t = tan θ/(α + tan θ), which spreads lobes of any width.
    fn over_normals(scale: f64, f: impl Fn(Vec3) -> f64) -> f64 {
        let (rings, sectors) = (1500, 360);
        let mut sum = 0.0;
        for ring in 0..rings {
            let t = (f64::from(ring) + 0.5) / f64::from(rings);
            let tan = scale * t / (1.0 - t);
            let (cos, dtan) = (1.0 / (1.0 + tan * tan).sqrt(), scale / ((1.0 - t) * (1.0 - t)));
            for sector in 0..sectors {
                let phi = TAU * (f64::from(sector) + 0.5) / f64::from(sectors);
                let m = Vec3::new(tan * cos * phi.cos(), tan * cos * phi.sin(), cos);
                // sin θ dθ = sin θ cos² θ d(tan θ)
                sum += f(m) * tan * cos * cos * cos * dtan;
            }
        }
        sum * TAU / f64::from(rings) / f64::from(sectors)
    }

    /// `∫ D(m) m.z dm = 1`, `∫ visible(v, m) dm = 1`: D has the normalisation that it claims, and Smith's
    /// masking, in its closed form, is the one that belongs to D.
    #[test]
    fn integrals_are_one() {
        for distribution in DISTRIBUTIONS {
            for (alpha_u, alpha_v) in [(1e-4, 1e-4), (0.1, 0.1), (0.5, 0.2), (1.0, 1.0), (0.3, 1.5)] {
                let microfacets = Microfacets::new(distribution, alpha_u, alpha_v);
                let scale = f64::sqrt(alpha_u * alpha_v);
                let area = over_normals(scale, |m| microfacets.d(m) * m.z);
                assert!((area - 1.0).abs() < 1e-5, "{microfacets:?}: area {area}");
                for theta in [0.0, 0.4, 1.2, 1.5] {
                    let v = direction(theta, 0.7);
                    let visible = over_normals(scale, |m| microfacets.visible(v, m));
                    assert!((visible - 1.0).abs() < 2e-4, "{microfacets:?}, {theta}: visible {visible}");
                }
            }
        }
    }

    /// The rational G1 of Beckmann stays within 0.4 % of Smith's function, GGX's is exact.
    #[test]
    fn masking_belongs_to_the_projected_area() {
        let mut worst = 0.0f64;
        for distribution in DISTRIBUTIONS {
            let microfacets = Microfacets::new(distribution, 0.5, 0.5);
            for step in 1..1570 {
                let v = direction(f64::from(step) * 1e-3, 0.3);
                let projected = match distribution {
                    Distribution::Beckmann => microfacets.beckmann().projected_area(v.into()),
                    Distribution::Ggx => microfacets.ggx().projected_area(v.into()),
                };
                let smith = v.z / projected;
                let error = (microfacets.g1(v, Vec3::Z) / smith - 1.0).abs();
                worst = worst.max(error);
                let allowed = if distribution == Distribution::Ggx { 1e-14 } else { 0.004 };
                assert!(error <= allowed, "{distribution:?}, {step} mrad: {error}");
            }
        }
        assert!(worst > 0.001, "Beckmann's is an approximation");
    }

    #[test]
    fn visible_normals_follow_their_density() {
        let roughness = [(0.1, 0.1), (0.3, 0.3), (0.6, 0.15), (1.0, 1.0), (1.5, 0.5)];
        let angles = [0.0, 0.5, 1.1, 1.45, 1.57];
        let level = sidak(0.01, 2 * roughness.len() * angles.len());
        for distribution in DISTRIBUTIONS {
            for (alpha_u, alpha_v) in roughness {
                let microfacets = Microfacets::new(distribution, alpha_u, alpha_v);
                for theta in angles {
                    let v = direction(theta, 0.9);
                    let fit = sphere_chi_square(
                        SphereCells { rows: 20, columns: 20 },
                        50_000,
                        |u| Some(microfacets.sample_visible(v, [u[0], u[1]])),
                        |m| microfacets.visible(v, m),
                    );
                    assert!(fit.p_value > level, "{microfacets:?}, {theta}: {fit}");
                }
            }
        }
    }

    /// Glassner (1989), ch. 4, eq. 14 over π: Beckmann's D at m = 0.2 and 0.7 is
    /// `exp(−tan² α/m²)/(π m² cos⁴ α)`.
    #[test]
    fn beckmann_closed_form() {
        for m in [0.2, 0.7] {
            let microfacets = Microfacets::new(Distribution::Beckmann, m, m);
            for angle in [0.0, 0.1, 0.5, 1.0f64] {
                let expected = (-(angle.tan() / m).powi(2)).exp() / (m * m * angle.cos().powi(4)) * FRAC_1_PI;
                let d = microfacets.d(direction(angle, 2.0));
                assert!((d - expected).abs() <= 1e-13 * expected, "{m}, {angle}: {d}, not {expected}");
            }
        }
    }

    /// The inverted slope distribution gives back its argument, into the tails.
    #[test]
    fn beckmann_slopes_invert() {
        for theta in [1e-8, 1e-3, 0.3, 0.8, 1.2, 1.5, 1.57, FRAC_PI_2 - 1e-7, FRAC_PI_2] {
            let (sin, cos) = f64::sin_cos(theta);
            let cumulative = |x: f64| cos * erfc(-x) + sin * FRAC_1_SQRT_PI * (-x * x).exp();
            let all = cumulative((cos / sin).min(6.3));
            let tails = [1e-15, 1e-9, 1e-6, 1.0 - 1e-6, 1.0 - 1e-9, 1.0 - 1e-15];
            for u in tails.into_iter().chain((1..1000).map(|step| f64::from(step) * 1e-3)) {
                let x = beckmann_visible_slope(cos, sin, u);
                assert!(x * sin <= cos + 1e-12, "{theta}, {u}: slope {x} is not visible");
                let error = (cumulative(x) / all - u).abs();
                // The last part allows for the slope's own rounding and the cut tails.
                assert!(error <= 1e-11 * u + 3e-15, "{theta}, {u}: off by {error:e}");
            }
        }
    }

    #[test]
    fn extremes_stay_finite() {
        for distribution in DISTRIBUTIONS {
            for alpha in [0.0, f64::NAN, 1e-4, 1e-3, 1.0, 5.0] {
                let microfacets = Microfacets::new(distribution, alpha, 0.1);
                for theta in [0.0, 1e-9, 0.7, FRAC_PI_2 - 1e-4, FRAC_PI_2 - 1e-9] {
                    for u in [0.0, 1e-300, 0.25, 0.5, 1.0 - f64::EPSILON / 2.0] {
                        for w in [0.0, 0.5, 1.0 - f64::EPSILON / 2.0] {
                            let v = direction(theta, 0.2);
                            let m = microfacets.sample_visible(v, [u, w]);
                            let density = microfacets.visible(v, m);
                            assert!(
                                m.is_normalized() && m.z >= 0.0 && density >= 0.0 && density.is_finite(),
                                "{microfacets:?}, {theta}, {u}, {w}: {m}, {density}"
                            );
                        }
                    }
                }
            }
        }
    }
}
