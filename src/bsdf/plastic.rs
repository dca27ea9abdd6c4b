//! A smooth coat over a diffuse base.

use super::dielectric::interfaces;
use super::{Bsdf, Evaluation, RoughCoat, RoughPlastic, Scatter, flipped, fresnel, share};
use crate::geometry::Vec3;
use crate::sampling::{Density, warp};
use crate::spectrum::{Sampled, Spectrum};
use crate::texture::{Texture, TexturePoint};
use std::f64::consts::FRAC_1_PI;

/// A diffuse base under a smooth dielectric coat. The coat reflects a part of the light. The rest enters, is
/// scattered by the base, and leaves after any number of reflections on the coat's inner side. Black from
/// below. Mitsuba's `plastic`.
#[derive(Clone, Copy, Debug)]
pub struct Plastic<const C: usize> {
    /// Index of the coat over that of what is above.
    pub eta: Sampled<C>,
    /// What lies beneath the coat.
    pub base: DiffuseBase<C>,
    /// Multiplies what the coat reflects outside; 1 in nature.
    pub specular_reflectance: Sampled<C>,
    /// Fraction of the diffuse light from below that the coat reflects; follows from `eta`.
    inner_reflectance: Sampled<C>,
}

/// What lies under a coat.
#[derive(Clone, Copy, Debug)]
pub struct DiffuseBase<const C: usize> {
    /// ρ, 0–1.
    pub reflectance: Sampled<C>,
    /// Whether each reflection on the base multiplies by ρ, which shifts the colour. Otherwise only the first
    /// does, as if the base were white for the others.
    pub nonlinear: bool,
}

impl<const C: usize> DiffuseBase<C> {
    /// `ρ/(1 − ρ R)`, or `ρ/(1 − R)` where not nonlinear: the sum over all orders of reflection between the
    /// base and the coat, whose inner side reflects the fraction R of diffuse light.
    pub(super) fn with_interreflection(&self, lane: usize, inner_reflectance: f64) -> f64 {
        let reflectance = self.reflectance[lane];
        let returned = if self.nonlinear { reflectance * inner_reflectance } else { inner_reflectance };
        reflectance / (1.0 - returned)
    }
}

impl<const C: usize> Plastic<C> {
    /// The parameters are the fields of the same names; `eta` > 0.
    pub fn new(eta: Sampled<C>, base: DiffuseBase<C>, specular_reflectance: Sampled<C>) -> Self {
        // Most indices are the same at all wavelengths.
        let inner = |eta: f64| fresnel::diffuse_reflectance(1.0 / eta);
        let hero = inner(eta.hero());
        let inner_reflectance = eta.map(|lane| if lane == eta.hero() { hero } else { inner(lane) });
        Self { eta, base, specular_reflectance, inner_reflectance }
    }

    pub(super) fn evaluate(&self, toward_eye: Vec3, toward_light: Vec3) -> Evaluation<C> {
        if toward_eye.z <= 0.0 || toward_light.z <= 0.0 {
            return Evaluation::ZERO;
        }
        let reflectance = self.reflectance(toward_eye);
        let diffuse = Sampled::from_fn(|lane| 1.0 - self.mirror_probability(lane, reflectance[lane]));
        self.diffuse(toward_eye, toward_light, diffuse)
    }

    pub(super) fn sample(&self, toward_eye: Vec3, lobe: f64, u: [f64; 2]) -> Option<Scatter<C>> {
        if toward_eye.z <= 0.0 {
            return None;
        }
        let reflectance = self.reflectance(toward_eye);
        let mirror = Sampled::from_fn(|lane| self.mirror_probability(lane, reflectance[lane]));
        if lobe < mirror.hero() {
            return Some(Scatter {
                toward_light: -flipped(toward_eye),
                weight: self.specular_reflectance * reflectance / mirror.hero(),
                density: Density::Discrete,
                ratio: mirror / mirror.hero(),
                transmitted: false,
            });
        }
        let toward_light = Vec3::from(warp::cosine_hemisphere(u));
        let Evaluation { f_cos, density } =
            self.diffuse(toward_eye, toward_light, mirror.map(|mirror| 1.0 - mirror));
        Scatter::with_density(toward_light, f_cos, density, false)
    }

    /// The mirror reflection of the coat by itself, and the rest; `None` where the coat mirrors nothing.
    pub(super) fn mirror_apart(&self, toward_eye: Vec3) -> Option<(Scatter<C>, Self)> {
        if toward_eye.z <= 0.0 || self.specular_reflectance.is_zero() {
            return None;
        }
        let mirror = Scatter {
            toward_light: -flipped(toward_eye),
            weight: self.specular_reflectance * self.reflectance(toward_eye),
            density: Density::Discrete,
            ratio: Sampled::ONE,
            transmitted: false,
        };
        Some((mirror, Self { specular_reflectance: Sampled::ZERO, ..*self }))
    }

    /// Value and density of the diffuse lobe, which each lane chooses with the given probability.
    fn diffuse(&self, toward_eye: Vec3, toward_light: Vec3, probability: Sampled<C>) -> Evaluation<C> {
        let cosine = toward_light.z.max(0.0) * FRAC_1_PI;
        let (leaving, entering) = (self.reflectance(toward_eye), self.reflectance(toward_light));
        let value = |lane: usize| {
            let eta = self.eta[lane];
            let through = (1.0 - leaving[lane]) * (1.0 - entering[lane]);
            let scattered = self.base.with_interreflection(lane, self.inner_reflectance[lane]);
            cosine * scattered * through / (eta * eta)
        };
        Evaluation { f_cos: Sampled::from_fn(value), density: probability * cosine }
    }

    /// Probability of the specular lobe, in proportion to what the two lobes carry.
    fn mirror_probability(&self, lane: usize, reflectance: f64) -> f64 {
        let mirrored = self.specular_reflectance[lane] * reflectance;
        let scattered = self.base.reflectance[lane] * (1.0 - reflectance);
        share(mirrored, scattered)
    }

    fn reflectance(&self, direction: Vec3) -> Sampled<C> {
        let cos = direction.z.clamp(0.0, 1.0);
        Sampled(interfaces(cos, self.eta).map(|interface| interface.reflectance))
    }
}

/// A diffuse base under a coat.
#[derive(Clone, Debug)]
pub struct PlasticTextures {
    /// Refractive index of the coat.
    pub interior: Spectrum,
    /// Refractive index around it.
    pub exterior: Spectrum,
    /// Reflectance of the diffuse base, from 0 to 1.
    pub diffuse_reflectance: Texture,
    /// Factor on the coat's reflectance, from 0 to 1; 1 is physical.
    pub specular_reflectance: Texture,
    /// Whether light that is reflected inside is coloured each time.
    pub nonlinear: bool,
    /// A rough coat; its indices are those above.
    pub coat: Option<&'static RoughCoat>,
}

impl PlasticTextures {
    pub(super) fn bsdf<const C: usize>(&self, at: &TexturePoint, nm: &[f64; C]) -> Bsdf<C> {
        let base =
            DiffuseBase { reflectance: self.diffuse_reflectance.sample(at, nm), nonlinear: self.nonlinear };
        let specular_reflectance = self.specular_reflectance.sample(at, nm);
        match self.coat {
            Some(coat) => Bsdf::RoughPlastic(RoughPlastic { coat, base, specular_reflectance }),
            None => {
                let eta = self.interior.sample(nm) / self.exterior.sample(nm);
                Bsdf::Plastic(Plastic::new(eta, base, specular_reflectance))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::quadrature::gauss_legendre;
    use std::f64::consts::TAU;

    /// White plastic returns what it receives, in whatever direction. A fit of the inner reflectance, which
    /// Mitsuba takes, returns 1.0011 of it with an index of 1.49.
    #[test]
    fn white_plastic_returns_all_light() {
        for eta in [0.4, 0.8, 1.0 - 1e-6, 1.0, 1.0 + 1e-6, 1.01, 1.3, 1.49, 1.9, 2.4, 3.5] {
            // Cosines inside and outside the denser of the two by Snell's law, without a singularity in u.
            let scale = (eta - 1.0f64).abs().max(1e-300).sqrt() * (eta + 1.0).sqrt() / eta.min(1.0);
            let end = scale.recip().asinh();
            let directions: Vec<(Vec3, f64)> = gauss_legendre(100)
                .map(|(x, weight)| {
                    let u = 0.5 * end * (1.0 + x);
                    let cos = (scale * u.sinh()).min(1.0);
                    let weight = 0.5 * weight * end * scale * u.cosh();
                    if eta >= 1.0 {
                        return (cos, weight);
                    }
                    let above = ((1.0 - eta) * (1.0 + eta) + eta * eta * cos * cos).sqrt().min(1.0);
                    (above, weight * eta * eta * cos / above)
                })
                .map(|(cos, weight)| {
                    (Vec3::new(((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt(), 0.0, cos), TAU * weight)
                })
                .collect();
            for nonlinear in [false, true] {
                let base = DiffuseBase { reflectance: Sampled([1.0]), nonlinear };
                let plastic = Plastic::new(Sampled([eta]), base, Sampled::ONE);
                for cos in [1.0, 0.9, 0.5, 0.1] {
                    let toward_eye = Vec3::new(f64::sqrt(1.0 - cos * cos), 0.0, cos);
                    let mirrored = plastic.reflectance(toward_eye)[0];
                    let scattered: f64 = directions
                        .iter()
                        .map(|&(light, weight)| weight * plastic.evaluate(toward_eye, light).f_cos[0])
                        .sum();
                    let albedo = mirrored + scattered;
                    assert!((albedo - 1.0).abs() < 1e-12, "{eta}, {nonlinear}, {cos}: {albedo}");
                }
            }
        }
    }

    /// The two parts of a coated surface are the whole: what chance finds of the mirror reflection, and the
    /// value of the base. Without the mirror reflection all samples are the base's.
    #[test]
    fn the_mirror_reflection_is_taken_apart() {
        let base = DiffuseBase { reflectance: Sampled([0.6, 0.2]), nonlinear: true };
        let whole = Plastic::new(Sampled([1.5, 1.6]), base, Sampled([0.5, 1.0]));
        for [cos, u, v] in [[0.9, 0.3, 0.7], [0.4, 0.8, 0.1], [0.01, 0.5, 0.5]] {
            let toward_eye = Vec3::new(f64::sqrt(1.0 - cos * cos), 0.0, cos);
            let (mirror, rest) = whole.mirror_apart(toward_eye).unwrap();
            let chosen = whole.sample(toward_eye, 0.0, [u, v]).unwrap();
            let base = whole.sample(toward_eye, 1.0 - 1e-9, [u, v]).unwrap();
            let alone = rest.sample(toward_eye, 0.0, [u, v]).unwrap();
            assert_eq!((mirror.toward_light, mirror.density), (chosen.toward_light, chosen.density));
            assert_eq!(alone.toward_light, base.toward_light);
            let [of_whole, of_rest] =
                [&whole, &rest].map(|plastic| plastic.evaluate(toward_eye, base.toward_light));
            assert_eq!(of_rest.f_cos, of_whole.f_cos);
            let reflectance = whole.reflectance(toward_eye);
            let probability = [0, 1].map(|lane| whole.mirror_probability(lane, reflectance[lane]));
            for lane in 0..2 {
                // The hero chooses.
                assert!((mirror.weight[lane] - chosen.weight[lane] * probability[0]).abs() <= 1e-15);
                let kept = of_whole.density[lane] / of_rest.density[lane];
                assert!((kept - (1.0 - probability[lane])).abs() <= 1e-12, "{kept} {probability:?}");
            }
            assert!(rest.mirror_apart(toward_eye).is_none());
            assert!(whole.mirror_apart(-toward_eye).is_none());
        }
    }
}
