//! Records the steps of one path, for `abbe explain`. The steps come from the code that renders, which is
//! compiled a second time with a recorder.

use super::path::Path;
use crate::geometry::{Ray, Vec3};
use crate::light::LightSample;
use crate::sampling::{Density, Stream};
use crate::scene::{Intersection, Scene};
use crate::spectrum::{Sampled, Wavelengths};
use serde::Serialize;
use std::cell::RefCell;
use std::rc::Rc;

/// Observes the steps of a path.
pub(super) trait Observe: Clone {
    fn tell(&self, vertex: u32, step: impl FnOnce() -> Step);
}

/// Observes nothing, at no cost.
#[derive(Clone, Copy)]
pub(super) struct Unseen;

impl Observe for Unseen {
    #[inline(always)]
    fn tell(&self, _: u32, _: impl FnOnce() -> Step) {}
}

/// Records all steps.
#[derive(Clone, Default)]
pub(super) struct Record(Rc<RefCell<Vec<RecordedStep>>>);

impl Record {
    pub fn into_steps(self) -> Vec<RecordedStep> {
        std::mem::take(&mut self.0.borrow_mut())
    }
}

impl Observe for Record {
    fn tell(&self, vertex: u32, step: impl FnOnce() -> Step) {
        self.0.borrow_mut().push(RecordedStep { vertex, step: step() });
    }
}

/// A step of a path, and where in the path it is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RecordedStep {
    /// Surfaces and scattering events that the path had met before.
    pub vertex: u32,
    /// What happened.
    #[serde(flatten)]
    pub step: Step,
}

/// What happens to a path. Places are in the coordinates of the file; what belongs to wavelengths is in the
/// order of the path's, of which the first is the hero.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "step", rename_all = "snake_case")]
pub enum Step {
    /// It meets a surface.
    Surface {
        /// Where it is.
        place: [f64; 3],
        /// Unit geometric normal.
        normal: [f64; 3],
        /// Unit normal that the material is seen with, where that is another: by vertex normals, a normal map
        /// or a bump map. On the same side as the surface's own.
        shading_normal: Option<[f64; 3]>,
        /// From where the ray began.
        distance: f64,
        /// Numbers as in the images of `abbe render --aov`.
        shape: u32,
        /// Number of the triangle, or 0.
        primitive: u32,
        /// Number of the material.
        material: u32,
        /// The medium that it came through, if there is one that does anything, as they are numbered.
        medium: Option<u32>,
        /// What each wavelength carries over the hero's density.
        throughput: Vec<f64>,
        /// The density with which each wavelength would have come this way, over the hero's.
        ratio: Vec<f64>,
    },
    /// A medium scatters it.
    Medium {
        /// Where it is.
        place: [f64; 3],
        /// From where the ray began.
        distance: f64,
        /// Number of the medium.
        medium: Option<u32>,
        /// As for a surface, after the scattering.
        throughput: Vec<f64>,
        /// As for a surface, after the scattering.
        ratio: Vec<f64>,
    },
    /// It leaves the scene.
    Escape {
        /// Unit vector along which it leaves.
        direction: [f64; 3],
        /// Number of the medium that it leaves through.
        medium: Option<u32>,
        /// As for a surface.
        throughput: Vec<f64>,
        /// As for a surface.
        ratio: Vec<f64>,
    },
    /// It has found light, of which this is the part in the sample's radiance, its weights included.
    Found {
        /// Part of the radiance by wavelength, W·m⁻²·sr⁻¹·nm⁻¹.
        contribution: Vec<f64>,
    },
    /// A light was chosen and asked from here.
    LightSample {
        /// Where on the light; only a direction for those that are infinitely far away.
        toward: [f64; 3],
        /// Distance to the light; `None` for those that are infinitely far away.
        distance: Option<f64>,
        /// Per steradian; none for lights without extent.
        density: Option<f64>,
        /// The part in the sample's radiance. Zero where something is in the way.
        contribution: Vec<f64>,
    },
    /// It goes on from the surface or the medium.
    Scatter {
        /// Unit vector along which it goes on.
        direction: [f64; 3],
        /// Whether to the other side of the surface.
        transmitted: bool,
        /// The hero's, per steradian; none for one of finitely many directions.
        density: Option<f64>,
        /// As for a surface, after the scattering.
        throughput: Vec<f64>,
        /// As for a surface, after the scattering.
        ratio: Vec<f64>,
    },
    /// It has survived Russian roulette with this probability.
    Survive {
        /// From above 0 to 1.
        probability: f64,
    },
    /// Here it has split, and what follows, to the next branch of this vertex or to the end, is the branch of
    /// this number, which weighs so much in the sample.
    Branch {
        /// Number of the branch, counted from 0.
        number: u32,
        /// Number of branches.
        of: u32,
        /// Weight in the sample, from 0 to 1.
        weight: f64,
    },
    /// It ends.
    End {
        /// The reason, as a clause.
        why: &'static str,
    },
}

/// A density where there is one.
pub(super) fn known(density: Density) -> Option<f64> {
    match density {
        Density::PerSolidAngle(density) => Some(density),
        Density::Discrete => None,
    }
}

pub(super) fn list<const C: usize>(values: Sampled<C>) -> Vec<f64> {
    values.0.to_vec()
}

/// Unit normals that are closer than this are told as one: rounding sets them apart.
const SAME_NORMAL: f64 = 1e-6;

pub(super) fn axes(v: Vec3) -> [f64; 3] {
    v.to_array()
}

impl<const C: usize, O: Observe> Path<C, O> {
    /// Tells of a light sample and what it brings.
    pub(super) fn tell_of_light(&self, scene: &Scene, sample: &LightSample<C>, light: Sampled<C>) {
        self.seen.tell(self.vertex, || {
            let Ray { origin, direction, t_max } = sample.shadow_ray;
            let end = t_max.is_finite().then(|| scene.in_file(origin + direction * t_max));
            Step::LightSample {
                toward: axes(end.unwrap_or(direction)),
                distance: end.map(|_| t_max),
                density: known(sample.density),
                contribution: list(light * self.branch_weight),
            }
        });
    }

    pub(super) fn tell_of_surface(
        &self,
        scene: &Scene,
        ray: &Ray,
        hit: &Intersection,
        wavelengths: &Wavelengths<C>,
        stream: &Stream,
    ) {
        let shading_normal = || {
            let normal = self.shading(scene, ray, hit, wavelengths, stream).normal();
            ((normal - hit.point.normal).length() > SAME_NORMAL).then(|| axes(normal))
        };
        self.seen.tell(self.vertex, || Step::Surface {
            place: axes(scene.in_file(hit.point.position)),
            normal: axes(hit.point.normal),
            shading_normal: shading_normal(),
            distance: (hit.point.position - ray.origin).length(),
            shape: scene.shape_number(hit),
            primitive: scene.primitive_number(hit),
            material: scene.material_number(hit),
            medium: scene.medium_number(&self.media.here),
            throughput: list(self.throughput),
            ratio: list(self.ratio),
        });
    }

    pub(super) fn tell_of_escape(&self, scene: &Scene, ray: &Ray) {
        self.seen.tell(self.vertex, || Step::Escape {
            direction: axes(ray.direction),
            medium: scene.medium_number(&self.media.here),
            throughput: list(self.throughput),
            ratio: list(self.ratio),
        });
    }

    /// Tells of the direction in which the path has just left a vertex.
    pub(super) fn tell_of_scatter(&self, direction: Vec3, transmitted: bool, density: Density) {
        self.seen.tell(self.vertex - 1, || Step::Scatter {
            direction: axes(direction),
            transmitted,
            density: known(density),
            throughput: list(self.throughput),
            ratio: list(self.ratio),
        });
    }

    pub(super) fn tell_of_survival(&self, kept: f64) {
        if kept < 1.0 {
            self.seen.tell(self.vertex - 1, || Step::Survive { probability: kept });
        }
    }
}
