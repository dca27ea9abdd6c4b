//! A rough coat over a diffuse base.

use super::kept::Kept;
use super::microfacet::{Distribution, Microfacets};
use super::plastic::DiffuseBase;
use super::{Evaluation, Scatter, fresnel, reflected, refracted, share};
use crate::geometry::Vec3;
use crate::sampling::quadrature::gauss_legendre;
use crate::sampling::warp;
use crate::spectrum::Sampled;
use rayon::prelude::*;
use std::f64::consts::FRAC_1_PI;

/// A diffuse base under a rough dielectric coat. The coat reflects as a rough surface does. The fractions of
/// the light that it transmits from above and reflects on the inside are averages over its facets
/// ([`RoughCoat`]). Black from below. Mitsuba's `roughplastic`.
#[derive(Clone, Copy, Debug)]
pub struct RoughPlastic<const C: usize> {
    /// Reflectances of the coat, tabulated by angle.
    pub coat: &'static RoughCoat,
    /// What lies beneath the coat.
    pub base: DiffuseBase<C>,
    /// Multiplies what the coat reflects outside; 1 in nature.
    pub specular_reflectance: Sampled<C>,
}

/// A rough dielectric interface and its transmittance, averaged over the facets.
///
/// The tables are Mitsuba 3's: 64 steps of the cosine from 0 to 1, linear between. The inner reflectance is
/// the plain mean over the 64 directions and so 1.5 % below the integral.
#[derive(Clone, Debug)]
pub struct RoughCoat {
    microfacets: Microfacets,
    /// Index below over that above.
    eta: f64,
    /// Transmittance from above, by the cosine of the incident direction.
    transmittance: [f64; STEPS],
    /// Fraction of diffuse light from below that is reflected.
    inner_reflectance: f64,
}

/// Directions in the tables.
const STEPS: usize = 64;

/// Square root of the number of facets in an average. Mitsuba's number, where it leaves an error: 4e-4 with
/// GGX.
const FACETS: usize = 32;

/// The same where some facets reflect totally.
const FACETS_INSIDE: usize = 96;

impl RoughCoat {
    /// The coat of facets of roughness `alpha`; `eta` is the index below over that above, positive and not 1.
    /// Kept for the rest of the program, once for all materials that ask for the same.
    pub fn shared(distribution: Distribution, alpha: f64, eta: f64) -> &'static Self {
        static COATS: Kept<(bool, u64, u64), RoughCoat> = Kept::new();
        let key = (distribution == Distribution::Ggx, alpha.to_bits(), eta.to_bits());
        COATS.get(key, || Self::new(Microfacets::new(distribution, alpha, alpha), eta))
    }

    fn new(microfacets: Microfacets, eta: f64) -> Self {
        // At 0 itself nothing is visible.
        let cosines: [f64; STEPS] = std::array::from_fn(|step| (step as f64 / (STEPS - 1) as f64).max(1e-6));
        let rule = |eta: f64| {
            let nodes = gauss_legendre(if eta > 1.0 { FACETS } else { FACETS_INSIDE });
            nodes.map(|(x, weight)| (0.5 + 0.5 * x, 0.5 * weight)).collect::<Vec<_>>()
        };
        let (outer, inner) = (rule(eta), rule(1.0 / eta));
        let mut tables = [[0.0; 2]; STEPS];
        tables.par_iter_mut().zip(cosines).for_each(|([transmitted, reflected], cosine)| {
            *transmitted = interface_albedo(&microfacets, cosine, eta, &outer).transmitted;
            *reflected = cosine * interface_albedo(&microfacets, cosine, 1.0 / eta, &inner).reflected;
        });
        Self {
            microfacets,
            eta,
            transmittance: tables.map(|[transmitted, _]| transmitted),
            inner_reflectance: 2.0 * tables.iter().map(|[_, reflected]| reflected).sum::<f64>()
                / STEPS as f64,
        }
    }

    fn transmittance(&self, cosine: f64) -> f64 {
        let place = cosine.clamp(0.0, 1.0) * (STEPS - 1) as f64;
        let step = (place as usize).min(STEPS - 2);
        let fraction = place - step as f64;
        self.transmittance[step] * (1.0 - fraction) + self.transmittance[step + 1] * fraction
    }
}

/// Fractions of the light from one direction that a rough interface reflects and transmits.
struct InterfaceAlbedo {
    reflected: f64,
    transmitted: f64,
}

/// Averages over the facets that are visible at a cosine, over the two numbers that choose a facet.
fn interface_albedo(
    microfacets: &Microfacets,
    cosine: f64,
    eta: f64,
    rule: &[(f64, f64)],
) -> InterfaceAlbedo {
    let from = Vec3::new(((1.0 - cosine) * (1.0 + cosine)).sqrt(), 0.0, cosine);
    let mut albedo = InterfaceAlbedo { reflected: 0.0, transmitted: 0.0 };
    for &(first, first_weight) in rule {
        for &(second, second_weight) in rule {
            let weight = first_weight * second_weight;
            let m = microfacets.sample_visible(from, [first, second]);
            let interface = fresnel::dielectric(from.dot(m).clamp(0.0, 1.0), eta);
            let mirrored = reflected(from, m);
            if mirrored.z > 0.0 {
                albedo.reflected += weight * interface.reflectance * microfacets.g1(mirrored, m);
            }
            let refracted = refracted(from, m, eta, interface);
            if refracted.z < 0.0 && interface.reflectance < 1.0 {
                // The facets hide a direction below just as they hide its opposite above.
                albedo.transmitted += weight * (1.0 - interface.reflectance) * microfacets.g1(-refracted, m);
            }
        }
    }
    albedo
}

impl<const C: usize> RoughPlastic<C> {
    pub(super) fn evaluate(&self, toward_eye: Vec3, toward_light: Vec3) -> Evaluation<C> {
        if toward_eye.z <= 0.0 || toward_light.z <= 0.0 {
            return Evaluation::ZERO;
        }
        let Some(m) = (toward_eye + toward_light).try_normalize() else { return Evaluation::ZERO };
        let RoughCoat { microfacets, eta, inner_reflectance, .. } = self.coat;
        let facets = microfacets.reflection(toward_eye, toward_light, m);
        let coat = fresnel::dielectric(facets.cos, *eta).reflectance * facets.value;
        let cosine = toward_light.z * FRAC_1_PI;
        let through = self.coat.transmittance(toward_eye.z) * self.coat.transmittance(toward_light.z);
        let base = cosine * through / (eta * eta);
        let reflected = self.coat_probability(toward_eye);
        Evaluation {
            f_cos: Sampled::from_fn(|lane| {
                self.specular_reflectance[lane] * coat
                    + self.base.with_interreflection(lane, *inner_reflectance) * base
            }),
            density: reflected.map(|reflected| reflected * facets.density + (1.0 - reflected) * cosine),
        }
    }

    pub(super) fn sample(&self, toward_eye: Vec3, lobe: f64, u: [f64; 2]) -> Option<Scatter<C>> {
        if toward_eye.z <= 0.0 {
            return None;
        }
        let toward_light = if lobe < self.coat_probability(toward_eye).hero() {
            reflected(toward_eye, self.coat.microfacets.sample_visible(toward_eye, u))
        } else {
            Vec3::from(warp::cosine_hemisphere(u))
        };
        let Evaluation { f_cos, density } = self.evaluate(toward_eye, toward_light);
        Scatter::with_density(toward_light, f_cos, density, false)
    }

    /// Each lane's probability of choosing the coat, about in proportion to what coat and base carry.
    fn coat_probability(&self, toward_eye: Vec3) -> Sampled<C> {
        let entering = self.coat.transmittance(toward_eye.z);
        Sampled::from_fn(|lane| {
            let reflected = self.specular_reflectance[lane] * (1.0 - entering);
            let scattered = self.base.reflectance[lane] * entering;
            share(reflected, scattered)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As it is taken out of values of Mitsuba 3.9.1, linear and nonlinear (`bsdf.eval`, index 1.5): R of the
    /// inner side, and the transmittance at normal incidence.
    #[test]
    fn tables_are_mitsubas() {
        let seen = [
            (Distribution::Beckmann, 0.1, 0.58096, 0.95998),
            (Distribution::Beckmann, 0.7, 0.34742, 0.95561),
            (Distribution::Ggx, 0.1, 0.55189, 0.95956),
            (Distribution::Ggx, 0.7, 0.20024, 0.92085),
        ];
        for (distribution, alpha, inner, through) in seen {
            let coat = RoughCoat::shared(distribution, alpha, 1.5);
            let found = (coat.inner_reflectance, coat.transmittance(1.0));
            assert!((found.0 - inner).abs() < 2e-4, "{distribution:?} {alpha}: {found:?}");
            assert!((found.1 - through).abs() < 4e-4, "{distribution:?} {alpha}: {found:?}");
        }
    }
}
