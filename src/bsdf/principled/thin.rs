//! A surface without a body.

use super::albedo::{self, Albedo};
use super::{MEAN_SHEEN, PrincipledBase, choose, cosine_density, interface, mix, probabilities};
use crate::bsdf::facets::FacetReflection;
use crate::bsdf::microfacet::Microfacets;
use crate::bsdf::{Evaluation, Scatter, flipped, reflected};
use crate::geometry::Vec3;
use crate::sampling::warp;
use crate::spectrum::Sampled;
use std::f64::consts::FRAC_1_PI;

/// A thin sheet, diffuse or of rough glass, the same from both sides. Its specular transmission is centred on
/// the direction of incidence. Mitsuba's `principledthin`.
#[derive(Clone, Copy, Debug)]
pub struct PrincipledThin<const C: usize> {
    /// What it has in common with [`super::Principled`].
    pub base: PrincipledBase<C>,
    /// Diffuse transmission: at 0 none of the diffuse light leaves on the other side, at 1 half, at 2 all.
    pub diff_trans: f64,
    /// Index of the sheet over that of what surrounds it.
    pub eta: f64,
    /// Bounds the scattered energy; `None` where the sheet is as Burley and Mitsuba have it.
    pub albedo: Option<&'static Albedo>,
}

/// Factor on the roughness for transmission, which two rough faces of the index `eta` make (Burley 2015,
/// section 3.2).
pub(super) fn spread(eta: f64) -> f64 {
    0.65 * eta - 0.35
}

/// Mitsuba ends the transmitted lobe where a facet would send light back above itself.
pub(super) fn is_cut(light: Vec3, m: Vec3) -> bool {
    light.dot(m) >= 0.0
}

const LOBES: usize = 4;
const DIFFUSE_REFLECTION: usize = 0;
const DIFFUSE_TRANSMISSION: usize = 1;
const REFLECTED: usize = 2;
const STRAIGHT: usize = 3;

impl<const C: usize> PrincipledThin<C> {
    pub(in crate::bsdf) fn evaluate(&self, toward_eye: Vec3, toward_light: Vec3) -> Evaluation<C> {
        let (eye, light) = if toward_eye.z < 0.0 {
            (flipped(toward_eye), flipped(toward_light))
        } else {
            (toward_eye, toward_light)
        };
        if eye.z == 0.0 || light.z == 0.0 {
            return Evaluation::ZERO;
        }
        let transmitted = light.z < 0.0;
        // Transmission mirrors the reflection to the other side.
        let mirrored = if transmitted { flipped(light) } else { light };
        let Some(m) = (eye + mirrored).try_normalize() else { return Evaluation::ZERO };
        let FacetReflection { value, density, cos } = self.facets(transmitted).reflection(eye, mirrored, m);
        let interface = interface(cos, self.eta);
        let facets = if transmitted && is_cut(light, m) { 0.0 } else { value };
        let cosine = cosine_density(light.z);
        let lobes = self.lobes(eye.z);
        let (diffuse_lobe, facets_lobe) =
            if transmitted { (DIFFUSE_TRANSMISSION, STRAIGHT) } else { (DIFFUSE_REFLECTION, REFLECTED) };
        let shape = if transmitted { 1.0 } else { self.base.diffuse(eye.z, light.z, cos) };
        let diffuse = self.diffuse_weights()[diffuse_lobe] * FRAC_1_PI * shape;
        let mut evaluation = Evaluation::ZERO;
        for (lane, probability) in lobes.iter().enumerate() {
            let color = self.base.color[lane];
            let (specular, sheen) = if transmitted {
                (color * (1.0 - interface.reflectance), 0.0)
            } else {
                let tinted = if self.base.spec_tint > 0.0 {
                    self.base.tinted(lane, cos, self.eta, interface)
                } else {
                    0.0
                };
                let sheen = self.diffuse_weights()[DIFFUSE_REFLECTION] * self.base.sheen(lane, cos);
                (mix(interface.reflectance, tinted, self.base.spec_tint), sheen)
            };
            evaluation.f_cos[lane] =
                self.base.spec_trans * specular * facets + light.z.abs() * (color * diffuse + sheen);
            evaluation.density[lane] =
                probability[diffuse_lobe] * cosine + probability[facets_lobe] * density;
        }
        if let Some(albedo) = self.albedo {
            let divisor = albedo::divisor(self.returned(albedo, eye), self.returned(albedo, mirrored));
            evaluation.f_cos = evaluation.f_cos / divisor;
        }
        evaluation
    }

    /// The directional albedo: the power that leaves the sheet on both sides.
    fn returned(&self, albedo: &Albedo, direction: Vec3) -> Sampled<C> {
        let facets = albedo.facets(&self.base, direction);
        let [back, through] = self.diffuse_weights();
        let diffuse = back * albedo::diffuse(&self.base, direction) + through;
        let sheen = back * albedo::sheen(direction);
        let normal = ((self.eta - 1.0) / (self.eta + 1.0)).powi(2);
        Sampled::from_fn(|lane| {
            let color = self.base.color[lane];
            let tinted = self.base.tint[lane] * normal * (facets.mirror - facets.schlick) + facets.schlick;
            let reflected = mix(facets.interface, tinted, self.base.spec_tint);
            self.base.spec_trans * (reflected + color * facets.transmitted)
                + diffuse * color
                + sheen * self.base.sheen_scale(lane)
        })
    }

    pub(in crate::bsdf) fn sample(&self, toward_eye: Vec3, lobe: f64, u: [f64; 2]) -> Option<Scatter<C>> {
        if toward_eye.z == 0.0 {
            return None;
        }
        let eye = if toward_eye.z < 0.0 { flipped(toward_eye) } else { toward_eye };
        let (lobe, _) = choose(self.lobes(eye.z)[0], lobe)?;
        let transmitted = lobe == DIFFUSE_TRANSMISSION || lobe == STRAIGHT;
        let up = match lobe {
            DIFFUSE_REFLECTION | DIFFUSE_TRANSMISSION => Vec3::from(warp::cosine_hemisphere(u)),
            _ => reflected(eye, self.facets(transmitted).sample_visible(eye, u)),
        };
        // A direction below the surface would meet another facet, and is lost.
        if up.z <= 0.0 {
            return None;
        }
        let above = (toward_eye.z > 0.0) != transmitted;
        let toward_light = if above { up } else { flipped(up) };
        let Evaluation { f_cos, density } = self.evaluate(toward_eye, toward_light);
        Scatter::with_density(toward_light, f_cos, density, transmitted)
    }

    /// The facets for reflection, or the smoother (or rougher) ones for transmission.
    fn facets(&self, transmitted: bool) -> Microfacets {
        self.base.microfacets(if transmitted { spread(self.eta) } else { 1.0 })
    }

    /// Weights of diffuse reflection and diffuse transmission.
    fn diffuse_weights(&self) -> [f64; 2] {
        let (all, through) = (1.0 - self.base.spec_trans, 0.5 * self.diff_trans);
        [all * (1.0 - through), all * through]
    }

    /// Each lane's probabilities of choosing the lobes, about in proportion to what they carry.
    fn lobes(&self, cos_eye: f64) -> [[f64; LOBES]; C] {
        let interface = interface(cos_eye, self.eta);
        let [back, through] = self.diffuse_weights();
        let mut lobes = [[0.0; LOBES]; C];
        for (lane, lobes) in lobes.iter_mut().enumerate() {
            let color = self.base.color[lane];
            let tinted = mix(
                interface.reflectance,
                self.base.tinted(lane, cos_eye, self.eta, interface),
                self.base.spec_tint,
            );
            *lobes = probabilities([
                back * (color + MEAN_SHEEN * self.base.sheen),
                through * color,
                self.base.spec_trans * tinted,
                self.base.spec_trans * color * (1.0 - interface.reflectance),
            ]);
        }
        lobes
    }
}
