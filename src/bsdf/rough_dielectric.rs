//! A rough interface between two transparent media.

use super::dielectric::{Dielectric, interfaces};
use super::fresnel;
use super::microfacet::Microfacets;
use super::{Evaluation, Scatter, flipped, reflected, refracted};
use crate::geometry::Vec3;
use crate::sampling::Density;
use crate::spectrum::Sampled;

/// Indices closer to 1 than this bend and reflect nothing that can be computed: the facet that would
/// join two directions is lost in rounding. The ray goes straight on, as through a smooth interface.
const MATCHED: f64 = 1e-6;

/// An interface whose surface is made of small smooth interfaces (Walter et al., "Microfacet Models
/// for Refraction through Rough Surfaces", EGSR 2007). Mitsuba's `roughdielectric`, with an index for
/// each wavelength.
///
/// Two directions on opposite sides are joined by a different facet at each index, so that the lanes
/// of a dispersive interface have different densities for the same pair; none of them is zero.
#[derive(Clone, Copy, Debug)]
pub struct RoughDielectric<const C: usize> {
    /// What each facet is made of.
    pub facet: Dielectric<C>,
    /// Distribution of the microfacets' normals.
    pub microfacets: Microfacets,
}

/// `f · |cos θ_light|` and density of one way to scatter, in one lane.
#[derive(Clone, Copy)]
struct Lane {
    f_cos: f64,
    density: f64,
}

impl Lane {
    const ZERO: Self = Self { f_cos: 0.0, density: 0.0 };
}

impl<const C: usize> RoughDielectric<C> {
    pub(super) fn evaluate(&self, toward_eye: Vec3, toward_light: Vec3) -> Evaluation<C> {
        let eta = self.facet.eta_toward(toward_eye.z > 0.0);
        // Seen from the eye's side, which is then above. The distribution is the same for both sides.
        let (eye, light) = if toward_eye.z < 0.0 {
            (flipped(toward_eye), flipped(toward_light))
        } else {
            (toward_eye, toward_light)
        };
        if eye.z == 0.0 || light.z == 0.0 {
            return Evaluation::ZERO;
        }
        if light.z > 0.0 {
            // No facet can be told where both graze the surface from opposite sides.
            (eye + light).try_normalize().map_or(Evaluation::ZERO, |m| self.reflection(eye, light, m, eta))
        } else {
            self.transmission(eye, light, None, eta)
        }
    }

    pub(super) fn sample(&self, toward_eye: Vec3, lobe: f64, u: [f64; 2]) -> Option<Scatter<C>> {
        if toward_eye.z == 0.0 {
            return None;
        }
        let eta = self.facet.eta_toward(toward_eye.z > 0.0);
        if is_matched(eta.hero()) {
            return self.straight(toward_eye, eta);
        }
        let eye = if toward_eye.z < 0.0 { flipped(toward_eye) } else { toward_eye };
        let m = self.microfacets.sample_visible(eye, u);
        let hero = fresnel::dielectric(eye.dot(m).clamp(0.0, 1.0), eta.hero());
        let transmitted = lobe >= self.facet.choice(0, hero.reflectance).reflection;
        let light = if transmitted { refracted(eye, m, eta.hero(), hero) } else { reflected(eye, m) };
        if light.z == 0.0 || (light.z < 0.0) != transmitted {
            return None;
        }
        let Evaluation { f_cos, density } = if transmitted {
            self.transmission(eye, light, Some(m), eta)
        } else {
            self.reflection(eye, light, m, eta)
        };
        let toward_light = if toward_eye.z < 0.0 { flipped(light) } else { light };
        Scatter::with_density(toward_light, f_cos, density, transmitted)
    }

    /// Reflection of `light` to `eye`, both above, by facets `m`, which is the same for all lanes.
    fn reflection(&self, eye: Vec3, light: Vec3, m: Vec3, eta: Sampled<C>) -> Evaluation<C> {
        let facets = self.microfacets.reflection(eye, light, m);
        let interfaces = interfaces(facets.cos, eta);
        lanes(|lane| {
            if is_matched(eta[lane]) {
                return Lane::ZERO;
            }
            let reflectance = interfaces[lane].reflectance;
            Lane {
                f_cos: self.facet.specular_reflectance[lane] * reflectance * facets.value,
                density: self.facet.choice(lane, reflectance).reflection * facets.density,
            }
        })
    }

    /// Transmission from `light`, below, to `eye`, above. `hero_facet` is the hero's facet where it
    /// is known already.
    fn transmission(
        &self,
        eye: Vec3,
        light: Vec3,
        hero_facet: Option<Vec3>,
        eta: Sampled<C>,
    ) -> Evaluation<C> {
        let hero_facet = hero_facet.or_else(|| joining_facet(eye, light, eta.hero()));
        let hero = self.transmission_lane(0, eye, light, hero_facet, eta.hero());
        lanes(|lane| {
            let same_facet = eta[lane] == eta.hero();
            let same_factors = self.facet.specular_transmittance[lane]
                == self.facet.specular_transmittance.hero()
                && self.facet.specular_reflectance[lane] == self.facet.specular_reflectance.hero();
            if same_facet && same_factors {
                return hero;
            }
            let facet = if same_facet { hero_facet } else { joining_facet(eye, light, eta[lane]) };
            self.transmission_lane(lane, eye, light, facet, eta[lane])
        })
    }

    fn transmission_lane(&self, lane: usize, eye: Vec3, light: Vec3, facet: Option<Vec3>, eta: f64) -> Lane {
        let Some(m) = facet else { return Lane::ZERO };
        let Some(facets) = self.microfacets.transmission(eye, light, m, eta) else { return Lane::ZERO };
        let reflectance = fresnel::dielectric(facets.cos, eta).reflectance;
        Lane {
            f_cos: self.facet.specular_transmittance[lane] * (1.0 - reflectance) * facets.value,
            density: self.facet.choice(lane, reflectance).transmission * facets.density,
        }
    }

    /// The way through an interface that the hero doesn't notice.
    fn straight(&self, toward_eye: Vec3, eta: Sampled<C>) -> Option<Scatter<C>> {
        let together = eta.map(|eta| if is_matched(eta) { 1.0 } else { 0.0 });
        Some(Scatter {
            toward_light: -toward_eye,
            weight: together * self.facet.specular_transmittance,
            density: Density::Discrete,
            ratio: together,
            transmitted: true,
        })
    }
}

fn lanes<const C: usize>(lane: impl Fn(usize) -> Lane) -> Evaluation<C> {
    let mut evaluation = Evaluation::ZERO;
    for i in 0..C {
        let Lane { f_cos, density } = lane(i);
        evaluation.f_cos[i] = f_cos;
        evaluation.density[i] = density;
    }
    evaluation
}

/// The facet, facing up, that refracts `light` from below to `eye` above at the relative index `eta`.
fn joining_facet(eye: Vec3, light: Vec3, eta: f64) -> Option<Vec3> {
    if is_matched(eta) {
        return None;
    }
    let half = (eye + light * eta).try_normalize()?;
    Some(if half.z < 0.0 { -half } else { half })
}

fn is_matched(eta: f64) -> bool {
    (eta - 1.0).abs() < MATCHED
}
