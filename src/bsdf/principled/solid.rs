//! The surface of a body.

use super::albedo::{self, Albedo};
use super::clear_coat::ClearCoat;
use super::{
    COAT_REFLECTANCE, MEAN_SHEEN, PrincipledBase, choose, cosine_density, interface, mix, probabilities,
    schlick_cosine, schlick_weight,
};
use crate::bsdf::fresnel::Interface;
use crate::bsdf::{Evaluation, Scatter, flipped, reflected, refracted, share};
use crate::geometry::Vec3;
use crate::sampling::warp;
use crate::spectrum::Sampled;
use std::f64::consts::FRAC_1_PI;

/// Metal, diffuse base and glass under sheen and clear coat. Only the glass is seen from below.
/// Mitsuba's `principled`.
#[derive(Clone, Copy, Debug)]
pub struct Principled<const C: usize> {
    /// What it has in common with [`super::PrincipledThin`].
    pub base: PrincipledBase<C>,
    /// Weight of metal.
    pub metallic: f64,
    /// Strength of the clear coat, at least 0.
    pub clearcoat: f64,
    /// Gloss of the clear coat, from 0, satin, to 1, polished.
    pub clearcoat_gloss: f64,
    /// Index below over that above, the same at all wavelengths.
    pub eta: f64,
    /// Bounds the reflected energy; `None` where the surface is as Burley and Mitsuba have it.
    pub albedo: Option<&'static Albedo>,
}

/// Lobes that a direction is sampled from.
const LOBES: usize = 3;
const DIFFUSE: usize = 0;
const COAT: usize = 1;
const FACETS: usize = 2;

/// Fractions of the light that facets reflect and transmit in one lane.
#[derive(Clone, Copy)]
struct FacetAlbedo {
    reflectance: f64,
    transmittance: f64,
}

impl FacetAlbedo {
    fn reflection_probability(self) -> f64 {
        share(self.reflectance, self.transmittance)
    }

    fn transmission_probability(self) -> f64 {
        share(self.transmittance, self.reflectance)
    }
}

impl<const C: usize> Principled<C> {
    /// Whether light gets through.
    pub(in crate::bsdf) fn transmits(&self) -> bool {
        self.glass_weight() > 0.0
    }

    pub(in crate::bsdf) fn evaluate(&self, toward_eye: Vec3, toward_light: Vec3) -> Evaluation<C> {
        let above = toward_eye.z > 0.0;
        // Seen from the eye's side; the facets are the same for both.
        let (eye, light) =
            if above { (toward_eye, toward_light) } else { (flipped(toward_eye), flipped(toward_light)) };
        if eye.z == 0.0 || light.z == 0.0 || !(above || self.transmits()) {
            return Evaluation::ZERO;
        }
        let eta = self.eta_toward(above);
        let lobes = self.lobes(eye.z, above);
        let evaluation = if light.z > 0.0 {
            // No half vector exists where both graze the surface from opposite sides.
            let half = (eye + light).try_normalize();
            half.map_or(Evaluation::ZERO, |m| self.reflection(eye, light, m, eta, above, lobes))
        } else if self.transmits() {
            let half = (eye + light * eta).try_normalize();
            half.map_or(Evaluation::ZERO, |m| {
                self.transmission(eye, light, if m.z < 0.0 { -m } else { m }, eta, above, lobes)
            })
        } else {
            Evaluation::ZERO
        };
        match self.albedo {
            None => evaluation,
            Some(albedo) => {
                let [eye, light] =
                    [toward_eye, toward_light].map(|direction| self.returned(albedo, direction));
                Evaluation { f_cos: evaluation.f_cos / albedo::divisor(eye, light), ..evaluation }
            }
        }
    }

    /// The directional albedo. Below the surface it is at most 1, since there is only the glass: 0 will do.
    fn returned(&self, albedo: &Albedo, direction: Vec3) -> Sampled<C> {
        if direction.z <= 0.0 {
            return Sampled::ZERO;
        }
        let facets = albedo.facets(&self.base, direction);
        let diffuse = self.diffuse_weight() * albedo::diffuse(&self.base, direction);
        let sheen = (1.0 - self.metallic) * albedo::sheen(direction);
        let coat = self.clearcoat * albedo.coat(self.clearcoat_gloss, direction);
        let normal = ((self.eta - 1.0) / (self.eta + 1.0)).powi(2);
        // Schlick's reflectance from that at normal incidence.
        let schlick = |normal: f64| normal * (facets.mirror - facets.schlick) + facets.schlick;
        let rest = 1.0 - self.metallic;
        Sampled::from_fn(|lane| {
            let color = self.base.color[lane];
            let clear = mix(facets.interface, schlick(self.base.tint[lane] * normal), self.base.spec_tint);
            let reflected = self.metallic * schlick(color) + rest * clear;
            let transmitted = self.glass_weight() * color.sqrt() * facets.transmitted;
            reflected + transmitted + diffuse * color + sheen * self.base.sheen_scale(lane) + coat
        })
    }

    pub(in crate::bsdf) fn sample(&self, toward_eye: Vec3, lobe: f64, u: [f64; 2]) -> Option<Scatter<C>> {
        let above = toward_eye.z > 0.0;
        if toward_eye.z == 0.0 || !(above || self.transmits()) {
            return None;
        }
        let eye = if above { toward_eye } else { flipped(toward_eye) };
        let (lobe, rest) = choose(self.lobes(eye.z, above)[0], lobe)?;
        let (light, transmitted) = match lobe {
            DIFFUSE => (Vec3::from(warp::cosine_hemisphere(u)), false),
            COAT => (reflected(eye, ClearCoat::new(self.clearcoat_gloss).sample(u)), false),
            _ => {
                let m = self.base.microfacets(1.0).sample_visible(eye, u);
                let cos = eye.dot(m).clamp(0.0, 1.0);
                let eta = self.eta_toward(above);
                let interface = interface(cos, eta);
                if rest < self.facets(0, cos, eta, interface, above).reflection_probability() {
                    (reflected(eye, m), false)
                } else {
                    (refracted(eye, m, eta, interface), true)
                }
            }
        };
        // A direction on the wrong side would meet another facet, and is lost.
        if light.z == 0.0 || (light.z < 0.0) != transmitted {
            return None;
        }
        let toward_light = if above { light } else { flipped(light) };
        let Evaluation { f_cos, density } = self.evaluate(toward_eye, toward_light);
        Scatter::with_density(toward_light, f_cos, density, transmitted)
    }

    /// `light` to `eye`, both above, with the half vector m.
    fn reflection(
        &self,
        eye: Vec3,
        light: Vec3,
        m: Vec3,
        eta: f64,
        above: bool,
        lobes: [[f64; LOBES]; C],
    ) -> Evaluation<C> {
        let facets = self.base.microfacets(1.0).reflection(eye, light, m);
        let cos = facets.cos;
        let interface = interface(cos, eta);
        let (mut coat, mut coat_density) = (0.0, 0.0);
        if above && self.clearcoat > 0.0 {
            let lacquer = ClearCoat::new(self.clearcoat_gloss);
            let d = lacquer.d(m);
            let fresnel = mix(COAT_REFLECTANCE, 1.0, schlick_weight(schlick_cosine(cos, eta, interface)));
            coat = 0.25 * self.clearcoat * fresnel * d * lacquer.g(eye, light, m) * light.z;
            // Jacobian of the reflection about m: dω′ = 4 (v·m) dm.
            coat_density = if cos > 0.0 { d * m.z / (4.0 * cos) } else { 0.0 };
        }
        let diffuse = if above {
            self.diffuse_weight() * FRAC_1_PI * self.base.diffuse(eye.z, light.z, cos)
        } else {
            0.0
        };
        let cosine = cosine_density(light.z);
        let mut evaluation = Evaluation::ZERO;
        for (lane, probability) in lobes.iter().enumerate() {
            let facet = self.facets(lane, cos, eta, interface, above);
            let sheen = if above { (1.0 - self.metallic) * self.base.sheen(lane, cos) } else { 0.0 };
            evaluation.f_cos[lane] =
                facet.reflectance * facets.value + coat + light.z * (self.base.color[lane] * diffuse + sheen);
            evaluation.density[lane] = probability[DIFFUSE] * cosine
                + probability[COAT] * coat_density
                + probability[FACETS] * facet.reflection_probability() * facets.density;
        }
        evaluation
    }

    /// `light` from below to `eye` above, by facets m.
    fn transmission(
        &self,
        eye: Vec3,
        light: Vec3,
        m: Vec3,
        eta: f64,
        above: bool,
        lobes: [[f64; LOBES]; C],
    ) -> Evaluation<C> {
        let Some(facets) = self.base.microfacets(1.0).transmission(eye, light, m, eta) else {
            return Evaluation::ZERO;
        };
        let interface = interface(facets.cos, eta);
        let mut evaluation = Evaluation::ZERO;
        for (lane, probability) in lobes.iter().enumerate() {
            let facet = self.facets(lane, facets.cos, eta, interface, above);
            evaluation.f_cos[lane] = facet.transmittance * facets.value;
            evaluation.density[lane] =
                probability[FACETS] * facet.transmission_probability() * facets.density;
        }
        evaluation
    }

    /// Albedo of facets at a cosine of incidence.
    fn facets(&self, lane: usize, cos: f64, eta: f64, interface: Interface, above: bool) -> FacetAlbedo {
        let reflectance = interface.reflectance;
        let transmittance = self.glass_weight() * self.base.color[lane].sqrt() * (1.0 - reflectance);
        // Mitsuba's metal, too, reflects nothing where the indices match.
        if reflectance == 0.0 {
            return FacetAlbedo { reflectance, transmittance };
        }
        if !above {
            return FacetAlbedo { reflectance: self.glass_weight() * reflectance, transmittance };
        }
        let rest = 1.0 - self.metallic;
        let mut all = rest * (1.0 - self.base.spec_tint) * reflectance;
        if self.metallic > 0.0 {
            let weight = schlick_weight(schlick_cosine(cos, eta, interface));
            all += self.metallic * mix(self.base.color[lane], 1.0, weight);
        }
        if self.base.spec_tint > 0.0 {
            all += rest * self.base.spec_tint * self.base.tinted(lane, cos, eta, interface);
        }
        FacetAlbedo { reflectance: all, transmittance }
    }

    /// Each lane's probabilities of choosing the lobes, about in proportion to what they carry.
    fn lobes(&self, cos_eye: f64, above: bool) -> [[f64; LOBES]; C] {
        let eta = self.eta_toward(above);
        let interface = interface(cos_eye, eta);
        let coat = mix(COAT_REFLECTANCE, 1.0, schlick_weight(cos_eye));
        let mut lobes = [[0.0; LOBES]; C];
        for (lane, lobes) in lobes.iter_mut().enumerate() {
            let facets = self.facets(lane, cos_eye, eta, interface, above);
            let mut weights = [0.0; LOBES];
            weights[FACETS] = facets.reflectance + facets.transmittance;
            if above {
                let sheen = MEAN_SHEEN * self.base.sheen * (1.0 - self.metallic);
                weights[DIFFUSE] = self.diffuse_weight() * self.base.color[lane] + sheen;
                weights[COAT] = 0.25 * self.clearcoat * coat;
            }
            *lobes = probabilities(weights);
        }
        lobes
    }

    /// Weight of the diffuse lobe.
    fn diffuse_weight(&self) -> f64 {
        (1.0 - self.metallic) * (1.0 - self.base.spec_trans)
    }

    /// Weight of glass.
    fn glass_weight(&self) -> f64 {
        (1.0 - self.metallic) * self.base.spec_trans
    }

    /// Index of the far side over that of the near side.
    fn eta_toward(&self, above: bool) -> f64 {
        if above { self.eta } else { 1.0 / self.eta }
    }
}
