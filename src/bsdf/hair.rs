//! Hair and fur.
//!
//! A fibre is a cylinder of rough, coloured glass under tilted scales. Light takes one of these ways through
//! it: R is reflected, TT goes straight through, TRT is reflected once inside, and the rest more often. Each
//! way is a lobe, spread along the fibre and around it. Chiang, Bitterli, Tappan and Burley, "A Practical and
//! Controllable Hair and Fur Model for Production Path Tracing", Computer Graphics Forum 35(2), 2016, which
//! builds on Marschner et al. (2003) and d'Eon et al. (2011). Mitsuba's `hair`.
//!
//! The fibre runs along the local y axis. θ is the angle of a direction to the plane across the fibre, φ the
//! angle around the fibre, from x to z. A whole walk inside the fibre begins and ends at one point.

use super::{Bsdf, Evaluation, Scatter, fresnel};
use crate::geometry::Vec3;
use crate::spectrum::Sampled;
use crate::texture::{Texture, TexturePoint};
use std::f64::consts::{FRAC_1_PI, PI, TAU};

/// R, TT, TRT, and all that is reflected inside more often.
const LOBES: usize = 4;
const REST: usize = LOBES - 1;

/// A fibre at one point.
#[derive(Clone, Copy, Debug)]
pub struct Hair<const C: usize> {
    /// What the inside absorbs per radius of the fibre, at least 0.
    pub absorption: Sampled<C>,
    /// What is the same all over and at all wavelengths.
    pub fibre: Fibre,
}

/// The shape of the lobes.
#[derive(Clone, Copy, Debug)]
pub struct Fibre {
    /// Index inside over that outside, not 1.
    eta: f64,
    /// Variance v of R along the fibre. That of TT is a quarter of it, and that of the others four times as
    /// much.
    variance: f64,
    /// Scale s of the logistic distribution around the fibre.
    scale: f64,
    /// Sine and cosine of the angles by which scales turn R, TT and TRT.
    tilts: [[f64; 2]; REST],
}

impl Fibre {
    /// `eta`: index inside over that outside, not 1. The roughnesses along and around the fibre are above 0
    /// and at most 1 (the fits of section 4.1 of the paper). `tilt`: angle of the scales, radians.
    pub fn new(eta: f64, [along, around]: [f64; 2], tilt: f64) -> Self {
        let deviation = 0.726 * along + 0.812 * along.powi(2) + 3.7 * along.powi(20);
        let logistic = 0.265 * around + 1.194 * around.powi(2) + 5.372 * around.powi(22);
        Self {
            eta,
            variance: deviation * deviation,
            scale: (PI / 8.0).sqrt() * logistic,
            tilts: [-2.0, 1.0, 4.0].map(|turns: f64| (turns * tilt).sin_cos().into()),
        }
    }

    fn variance(&self, lobe: usize) -> f64 {
        self.variance * [1.0, 0.25, 4.0, 4.0][lobe]
    }

    /// M: density over sin θ of the angle to which a lobe sends light that comes at the angle of
    /// `from`. Both are the sine and the cosine of θ.
    fn along(&self, lobe: usize, from: [f64; 2], to: [f64; 2]) -> f64 {
        let v = self.variance(lobe);
        let cosines = from[1] * to[1] / v;
        let sines = from[0] * to[0] / v;
        scaled_bessel(cosines) * (cosines - sines - 1.0 / v).exp() / (v * -(-2.0 / v).exp_m1())
    }

    /// N: density of the angle around the fibre, given how far it is from the angle of a smooth fibre.
    fn around(&self, lobe: usize, off: f64) -> f64 {
        if lobe == REST {
            return 0.5 * FRAC_1_PI;
        }
        let s = self.scale;
        let off = (off - TAU * (off / TAU).round()).abs();
        let tail = (-off / s).exp();
        tail / (s * (1.0 + tail).powi(2) * (0.5 * PI / s).tanh())
    }

    /// The angle θ seen by a lobe behind tilted scales, as sine and cosine.
    fn tilted(&self, lobe: usize, [sin, cos]: [f64; 2]) -> [f64; 2] {
        let [sin_tilt, cos_tilt] = if lobe == REST { [0.0, 1.0] } else { self.tilts[lobe] };
        [sin * cos_tilt + cos * sin_tilt, (cos * cos_tilt - sin * sin_tilt).abs()]
    }
}

/// What is known once the direction toward the eye is.
struct Incident<const C: usize> {
    /// Sine and cosine of θ.
    theta: [f64; 2],
    phi: f64,
    /// Where each lobe would leave a smooth fibre, as a difference of φ.
    turns: [f64; LOBES],
    /// The fraction of the light that takes each way.
    attenuation: [Sampled<C>; LOBES],
    /// All of it.
    whole: Sampled<C>,
}

impl<const C: usize> Hair<C> {
    fn incident(&self, toward_eye: Vec3) -> Incident<C> {
        let eta = self.fibre.eta;
        let sin = toward_eye.y;
        let cos = toward_eye.x.hypot(toward_eye.z);
        // γ: angle around the fibre between the normal and the direction, outside and inside.
        let gamma = (-toward_eye.x).atan2(toward_eye.z);
        let index = (eta * eta - sin * sin).max(0.0).sqrt();
        let sin_gamma_inside = if index > 0.0 { (-toward_eye.x / index).clamp(-1.0, 1.0) } else { 0.0 };
        let gamma_inside = sin_gamma_inside.asin();
        // Length of the way through the fibre, in radii.
        let cos_inside = (1.0 - (sin / eta).powi(2)).max(0.0).sqrt();
        let length = 2.0 * (1.0 - sin_gamma_inside.powi(2)).sqrt() / cos_inside;
        let reflectance = fresnel::dielectric(toward_eye.z.abs(), eta).reflectance;
        let mut attenuation = [Sampled::ZERO; LOBES];
        attenuation[0] = Sampled::splat(reflectance);
        if reflectance < 1.0 {
            let transmittance = self.absorption.map(|sigma| (-sigma * length).exp());
            let once = transmittance * reflectance;
            attenuation[1] = transmittance * (1.0 - reflectance).powi(2);
            attenuation[2] = attenuation[1] * once;
            attenuation[REST] = attenuation[2] * once / once.map(|once| 1.0 - once);
        }
        Incident {
            theta: [sin, cos],
            phi: toward_eye.z.atan2(toward_eye.x),
            turns: std::array::from_fn(|lobe| lobe as f64 * (2.0 * gamma_inside + PI) - 2.0 * gamma),
            attenuation,
            whole: attenuation.into_iter().fold(Sampled::ZERO, |sum, part| sum + part),
        }
    }

    pub(super) fn evaluate(&self, toward_eye: Vec3, toward_light: Vec3) -> Evaluation<C> {
        self.scattered(&self.incident(toward_eye), toward_light)
    }

    fn scattered(&self, incident: &Incident<C>, toward_light: Vec3) -> Evaluation<C> {
        let theta = [toward_light.y, toward_light.x.hypot(toward_light.z)];
        let turn = toward_light.z.atan2(toward_light.x) - incident.phi;
        let mut f_cos = Sampled::ZERO;
        for (lobe, attenuation) in incident.attenuation.iter().enumerate() {
            let along = self.fibre.along(lobe, self.fibre.tilted(lobe, incident.theta), theta);
            f_cos += *attenuation * (along * self.fibre.around(lobe, turn - incident.turns[lobe]));
        }
        // A lobe is chosen in proportion to its light, so the weight is the same in all directions.
        let density = f_cos.zip(incident.whole, |f_cos, whole| if whole > 0.0 { f_cos / whole } else { 0.0 });
        Evaluation { f_cos, density }
    }

    pub(super) fn sample(&self, toward_eye: Vec3, lobe: f64, u: [f64; 2]) -> Option<Scatter<C>> {
        let incident = self.incident(toward_eye);
        let (lobe, around) = incident.choose(lobe);
        let v = self.fibre.variance(lobe);
        let cos = (1.0 + v * (u[0] + (1.0 - u[0]) * (-2.0 / v).exp()).ln()).max(-1.0);
        let sin = (1.0 - cos * cos).sqrt();
        let [sin_eye, cos_eye] = self.fibre.tilted(lobe, incident.theta);
        let y = (sin * (TAU * u[1]).cos() * cos_eye - cos * sin_eye).clamp(-1.0, 1.0);
        let turn = if lobe == REST {
            TAU * around
        } else {
            let s = self.fibre.scale;
            let from = 1.0 / (1.0 + (PI / s).exp());
            let below = around * (0.5 * PI / s).tanh() + from;
            incident.turns[lobe] + (-s * (1.0 / below - 1.0).ln()).clamp(-PI, PI)
        };
        let (z, x) = (incident.phi + turn).sin_cos();
        let across = (1.0 - y * y).sqrt();
        let toward_light = Vec3::new(across * x, y, across * z);
        let Evaluation { f_cos, density } = self.scattered(&incident, toward_light);
        let transmitted = toward_eye.z * toward_light.z < 0.0;
        Scatter::with_density(toward_light, f_cos, density, transmitted)
    }
}

impl<const C: usize> Incident<C> {
    /// A lobe by the hero's light, and what is left of the uniform number.
    fn choose(&self, u: f64) -> (usize, f64) {
        let mut left = u * self.whole.hero();
        for (lobe, attenuation) in self.attenuation.iter().enumerate() {
            let part = attenuation.hero();
            if left < part {
                return (lobe, left / part);
            }
            left -= part;
        }
        (0, u)
    }
}

/// e^−x I₀(x) for x ≥ 0, within 2·10⁻⁷ of itself. Source: Abramowitz and Stegun, 9.8.1 and 9.8.2.
fn scaled_bessel(x: f64) -> f64 {
    const SMALL: [f64; 7] =
        [1.0, 3.515_622_9, 3.089_942_4, 1.206_749_2, 0.265_973_2, 0.036_076_8, 0.004_581_3];
    const LARGE: [f64; 9] = [
        0.398_942_28,
        0.013_285_92,
        0.002_253_19,
        -0.001_575_65,
        0.009_162_81,
        -0.020_577_06,
        0.026_355_37,
        -0.016_476_33,
        0.003_923_77,
    ];
    let polynomial = |coefficients: &[f64], t: f64| coefficients.iter().rev().fold(0.0, |sum, c| sum * t + c);
    if x < 3.75 {
        polynomial(&SMALL, (x / 3.75).powi(2)) * (-x).exp()
    } else {
        polynomial(&LARGE, 3.75 / x) / x.sqrt()
    }
}

/// Hair or fur.
#[derive(Clone, Debug)]
pub struct HairTextures {
    /// What the inside absorbs per radius of the fibre, at least 0.
    pub absorption: Texture,
    /// The shape of the lobes.
    pub fibre: Fibre,
}

impl HairTextures {
    pub(super) fn bsdf<const C: usize>(&self, at: &TexturePoint, nm: &[f64; C]) -> Bsdf<C> {
        Bsdf::Hair(Hair { absorption: self.absorption.sample(at, nm), fibre: self.fibre })
    }
}
