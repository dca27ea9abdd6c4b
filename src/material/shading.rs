//! How a surface scatters at one point, in world space.

use super::normal_map::ShadowTerminator;
use super::{Material, MaterialId, Materials};
use crate::bsdf::{Bsdf, BsdfTextures, Evaluation, Exterior, RoughConductor, Scatter};
use crate::geometry::{Frame, Vec3};
use crate::sampling::decide;
use crate::spectrum::Sampled;
use crate::texture::TexturePoint;
use smallvec::SmallVec;

/// A point of a surface, as far as materials ask.
#[derive(Clone, Copy, Debug)]
pub struct ShadingPoint<'a> {
    /// Around the shading normal of the surface's front.
    pub frame: Frame,
    /// Unit normal of the surface itself, toward its front.
    pub geometric_normal: Vec3,
    /// ∂p/∂u and ∂p/∂v.
    pub tangents: [Vec3; 2],
    /// Where textures are looked up.
    pub texture: TexturePoint<'a>,
}

/// How a surface scatters at one point seen from one direction, at the wavelengths of one path. Directions
/// are in world space, point away from the surface and have unit length.
#[derive(Clone, Debug)]
pub struct Shading<const C: usize> {
    /// How the surface scatters, in the frame of the shading normal.
    pub bsdf: Bsdf<C>,
    /// The frame that the BSDF is in. Left-handed on the back of a two-sided surface, whose z axis alone is
    /// turned.
    pub frame: Frame,
    /// In that frame.
    toward_eye: Vec3,
    terminators: SmallVec<[ShadowTerminator; 1]>,
}

/// A rough metal at one point, as lanes take it.
#[derive(Clone, Copy, Debug)]
pub struct RoughMetal<const C: usize> {
    /// Its facets and what they are made of.
    pub bsdf: RoughConductor<C>,
    /// The frame of the shading normal, with the tangents of the roughness.
    pub frame: Frame,
    /// In the frame.
    pub toward_eye: Vec3,
}

impl Materials {
    /// Goes through what nests to the BSDF at a point. `choice` in [0, 1) chooses between alternatives;
    /// `exterior` is the index of what surrounds the surface.
    pub fn shade<const C: usize>(
        &self,
        mut id: MaterialId,
        at: &ShadingPoint,
        toward_eye: Vec3,
        nm: &[f64; C],
        exterior: Exterior<'_>,
        mut choice: f64,
    ) -> Shading<C> {
        let mut frame = at.frame;
        let mut terminators = SmallVec::new();
        let bsdf = loop {
            match self.get(id) {
                Material::TwoSided { front, back } => {
                    id = if frame.z.dot(toward_eye) < 0.0 {
                        frame.z = -frame.z;
                        *back
                    } else {
                        *front
                    };
                }
                Material::Mask { opacity, nested } => {
                    if !decide(&mut choice, opacity.value(&at.texture)) {
                        break &BsdfTextures::Null;
                    }
                    id = *nested;
                }
                Material::Blend { weight, nested } => {
                    id = nested[usize::from(decide(&mut choice, weight.value(&at.texture)))];
                }
                Material::NormalMapping { mapping, nested } => {
                    let (turned, terminator) = mapping.turn(&frame, at, toward_eye);
                    frame = turned;
                    terminators.push(terminator);
                    id = *nested;
                }
                Material::Bsdf(bsdf) => break bsdf,
            }
        };
        Shading {
            bsdf: bsdf.sample(&at.texture, nm, exterior),
            frame,
            toward_eye: frame.to_local(toward_eye),
            terminators,
        }
    }

    /// Null transmittance: the fraction of light that goes straight on as if there were no surface.
    pub fn null_transmittance<const C: usize>(
        &self,
        id: MaterialId,
        at: &ShadingPoint,
        toward_eye: Vec3,
        nm: &[f64; C],
        exterior: Exterior<'_>,
    ) -> Sampled<C> {
        let of = |id: MaterialId| self.null_transmittance(id, at, toward_eye, nm, exterior);
        let turned = |frame: Frame, id: MaterialId| {
            let at = ShadingPoint { frame, ..*at };
            self.null_transmittance(id, &at, toward_eye, nm, exterior)
        };
        match self.get(id) {
            Material::TwoSided { back, .. } if at.frame.z.dot(toward_eye) < 0.0 => {
                turned(Frame { z: -at.frame.z, ..at.frame }, *back)
            }
            Material::TwoSided { front, .. } => of(*front),
            Material::Mask { opacity, nested } => {
                let opacity = opacity.value(&at.texture).clamp(0.0, 1.0);
                of(*nested) * opacity + Sampled::splat(1.0 - opacity)
            }
            Material::Blend { nested: [first, second], .. } if first == second => of(*first),
            Material::Blend { weight, nested: [first, second] } => {
                let weight = weight.value(&at.texture).clamp(0.0, 1.0);
                of(*first) * (1.0 - weight) + of(*second) * weight
            }
            Material::NormalMapping { mapping, nested } => {
                let (frame, _) = mapping.turn(&at.frame, at, toward_eye);
                turned(frame, *nested)
            }
            Material::Bsdf(bsdf) => {
                bsdf.sample(&at.texture, nm, exterior).null_transmittance(at.frame.to_local(toward_eye))
            }
        }
    }
}

impl<const C: usize> Shading<C> {
    /// The unit normal that the material is seen with, on the side of the surface's own, also behind what has
    /// two sides.
    pub fn normal(&self) -> Vec3 {
        let Frame { x, y, z } = self.frame;
        z * x.cross(y).dot(z).signum()
    }

    /// The value for light from a direction, and the density of sampling it.
    pub fn evaluate(&self, toward_light: Vec3) -> Evaluation<C> {
        let factor = self.factor(toward_light);
        if factor == 0.0 {
            return Evaluation::ZERO;
        }
        let evaluation = self.bsdf.evaluate(self.toward_eye, self.frame.to_local(toward_light));
        Evaluation { f_cos: evaluation.f_cos * factor, ..evaluation }
    }

    /// A direction toward the light, in world space; see [`Bsdf::sample`].
    pub fn sample(&self, lobe: f64, u: [f64; 2]) -> Option<Scatter<C>> {
        self.in_world(self.bsdf.sample(self.toward_eye, lobe, u)?)
    }

    /// Takes out the mirror reflection of a smooth coat; see [`Bsdf::mirror_apart`].
    pub fn take_mirror(&mut self) -> Option<Scatter<C>> {
        let (mirror, rest) = self.bsdf.mirror_apart(self.toward_eye)?;
        self.bsdf = rest;
        self.in_world(mirror)
    }

    /// Whether a sample goes on as if there were no surface.
    pub fn passes(&self, scatter: &Scatter<C>) -> bool {
        scatter.transmitted && self.bsdf.has_null_transmission()
    }

    /// A sample of the BSDF in world space. `None` where the normal's factor is zero there. Where there is no
    /// surface its normal counts for nothing.
    fn in_world(&self, scatter: Scatter<C>) -> Option<Scatter<C>> {
        let toward_light = self.frame.to_world(scatter.toward_light).normalize();
        let factor = if self.passes(&scatter) { 1.0 } else { self.factor(toward_light) };
        (factor > 0.0).then(|| Scatter { toward_light, weight: scatter.weight * factor, ..scatter })
    }

    /// The side from which light is scattered to the eye, as a direction of unit length; zero where it is
    /// from both.
    pub fn receiving_side(&self) -> Vec3 {
        if self.bsdf.transmits() {
            Vec3::ZERO
        } else if self.toward_eye.z < 0.0 {
            -self.frame.z
        } else {
            self.frame.z
        }
    }

    /// See [`Bsdf::reflection_probability`].
    pub fn reflection_probability(&self) -> Option<f64> {
        self.bsdf.reflection_probability(self.toward_eye)
    }

    /// For light that goes to the other side, the hero's index there over that on the viewer's side.
    pub fn index_beyond(&self) -> Option<f64> {
        let eta = self.bsdf.relative_index()?;
        Some(if self.toward_eye.z > 0.0 { eta } else { 1.0 / eta })
    }

    /// Whether its frame depends on where it is seen from.
    pub fn turns_with_eye(&self) -> bool {
        !self.terminators.is_empty()
    }

    /// [`Self::evaluate`] where it is seen from another place on the same side; only for one that does not
    /// turn with that.
    pub fn evaluate_from(&self, toward_eye: Vec3, toward_light: Vec3) -> Evaluation<C> {
        debug_assert!(!self.turns_with_eye());
        self.bsdf.evaluate(self.frame.to_local(toward_eye), self.frame.to_local(toward_light))
    }

    /// Whether it looks the same from wherever it is seen on the same side.
    pub fn is_diffuse(&self) -> bool {
        !self.turns_with_eye() && matches!(self.bsdf, Bsdf::Lambert(_))
    }

    /// Normal and reflectance of a diffuse surface that is seen from the side on which it scatters.
    pub fn diffuse(&self) -> Option<(Vec3, Sampled<C>)> {
        match &self.bsdf {
            Bsdf::Lambert(bsdf) if !self.turns_with_eye() && self.toward_eye.z > 0.0 => {
                Some((self.frame.z, bsdf.reflectance))
            }
            _ => None,
        }
    }

    /// What lanes take of a rough metal that is seen from above. `None` for all else.
    pub fn rough_metal(&self) -> Option<RoughMetal<C>> {
        match self.bsdf {
            Bsdf::RoughConductor(bsdf) if !self.turns_with_eye() && self.toward_eye.z > 0.0 => {
                Some(RoughMetal { bsdf, frame: self.frame, toward_eye: self.toward_eye })
            }
            _ => None,
        }
    }

    fn factor(&self, toward_light: Vec3) -> f64 {
        self.terminators.iter().map(|terminator| terminator.factor(toward_light)).product()
    }
}
