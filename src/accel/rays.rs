//! Rays of several paths, one for each lane, and what they meet.

use super::Accel;
use super::few::Few;
use crate::geometry::Ray;
use crate::lanes::{LANES, Mask, REGISTERS, Register, Row, Vec3Lanes, WIDTH, ZERO, get, lanes_of, set};
use crate::shape::{Hit, NO_INSTANCE};

/// A ray for each lane. Directions have unit length.
#[derive(Clone, Debug)]
pub struct Rays {
    /// Where each ray begins.
    pub origin: [Vec3Lanes; REGISTERS],
    /// Direction of each ray.
    pub direction: [Vec3Lanes; REGISTERS],
    /// Distance at which each ray ends.
    pub t_max: Row,
    /// The facet of a small scene that each ray leaves, as [`Hits::facet`] says it: its own plane is not
    /// asked again. [`NO_FACET`] where it leaves none.
    pub leaves: Row,
    /// The facet that each ray ends before: likewise.
    pub arrives: Row,
}

/// See [`Rays::leaves`].
pub const NO_FACET: f64 = -1.0;

/// What the rays of some lanes have met first.
#[derive(Clone, Debug)]
pub struct Hits {
    /// The lanes that have met anything.
    pub met: Mask,
    /// Distance to what each ray has met.
    pub t: Row,
    /// Weights of the triangle's second and third vertex; see [`Hit::barycentric`].
    pub barycentric: [Row; 2],
    /// What a small scene has been met at, by its number in [`Accel::few_primitives`], and the facet that it
    /// belongs to. [`NO_FACET`] where it is none.
    pub known: Row,
    /// The facet of each of these, or [`NO_FACET`].
    pub facet: Row,
    shape: [u32; LANES],
    triangle: [u32; LANES],
    instance: [u32; LANES],
}

/// A triangle, or a sphere, of a small scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Primitive {
    /// As in [`Hit`].
    pub shape: u32,
    /// Number of the triangle within the shape; 0 for a sphere.
    pub triangle: u32,
}

impl Rays {
    /// Rays without end that leave no facet.
    pub const NONE: Self = Self {
        origin: [Vec3Lanes::ZERO; REGISTERS],
        direction: [Vec3Lanes::ZERO; REGISTERS],
        t_max: [Register::new([f64::INFINITY; WIDTH]); REGISTERS],
        leaves: [Register::new([NO_FACET; WIDTH]); REGISTERS],
        arrives: [Register::new([NO_FACET; WIDTH]); REGISTERS],
    };

    /// The ray of one lane.
    pub fn get(&self, lane: usize) -> Ray {
        let register = lane / WIDTH % REGISTERS;
        Ray {
            origin: self.origin[register].get(lane),
            direction: self.direction[register].get(lane),
            t_max: get(&self.t_max, lane),
        }
    }

    /// Puts a ray into one lane.
    pub fn set(&mut self, lane: usize, ray: &Ray) {
        let register = lane / WIDTH % REGISTERS;
        self.origin[register].set(lane, ray.origin);
        self.direction[register].set(lane, ray.direction);
        set(&mut self.t_max, lane, ray.t_max);
    }
}

impl Hits {
    /// No lane has met anything.
    pub const NONE: Self = Self {
        met: 0,
        t: ZERO,
        barycentric: [ZERO; 2],
        known: [Register::new([NO_FACET; WIDTH]); REGISTERS],
        facet: [Register::new([NO_FACET; WIDTH]); REGISTERS],
        shape: [0; LANES],
        triangle: [0; LANES],
        instance: [NO_INSTANCE; LANES],
    };

    /// What one lane has met. Means nothing where [`Self::met`] lacks the lane.
    pub fn get(&self, lane: usize) -> Hit {
        Hit {
            t: get(&self.t, lane),
            shape: self.shape[lane % LANES],
            triangle: self.triangle[lane % LANES],
            instance: self.instance[lane % LANES],
            barycentric: self.barycentric.each_ref().map(|row| get(row, lane)),
        }
    }

    /// Notes what one lane has met.
    pub fn set(&mut self, lane: usize, hit: &Hit) {
        self.met |= 1 << lane;
        set(&mut self.t, lane, hit.t);
        for (row, weight) in self.barycentric.iter_mut().zip(hit.barycentric) {
            set(row, lane, weight);
        }
        self.identify(lane, hit.shape, hit.triangle, hit.instance);
    }

    fn identify(&mut self, lane: usize, shape: u32, triangle: u32, instance: u32) {
        self.shape[lane % LANES] = shape;
        self.triangle[lane % LANES] = triangle;
        self.instance[lane % LANES] = instance;
    }
}

impl Accel {
    /// The triangles and spheres of a scene that consists of few, in their order. Empty for other scenes.
    pub fn few_primitives(&self) -> &[Primitive] {
        self.few.as_ref().map_or(&[], Few::primitives)
    }

    /// The facet that a triangle of a small scene belongs to. [`NO_FACET`] where it is none.
    pub fn facet_of(&self, shape: u32, triangle: u32) -> f64 {
        let primitive = Primitive { shape, triangle };
        self.few.as_ref().map_or(NO_FACET, |few| few.facet_of(&primitive))
    }

    /// [`Accel::closest`] of the lanes asked for. What was in `hits` before is overwritten or left out.
    pub fn closest_of(&self, rays: &Rays, time: f64, asked: Mask, hits: &mut Hits) {
        hits.met = 0;
        let Some(few) = &self.few else {
            hits.known = Hits::NONE.known;
            hits.facet = Hits::NONE.facet;
            for lane in lanes_of(asked) {
                if let Some(hit) = self.closest(&rays.get(lane), time) {
                    hits.set(lane, &hit);
                }
            }
            return;
        };
        few.closest(rays, asked, hits);
        for lane in lanes_of(hits.met) {
            let Primitive { shape, triangle } = few.primitives()[get(&hits.known, lane) as usize];
            hits.identify(lane, shape, triangle, NO_INSTANCE);
        }
    }

    /// The lanes asked for whose ray is [`Accel::occluded`].
    pub fn occluded_of(&self, rays: &Rays, time: f64, asked: Mask) -> Mask {
        match &self.few {
            Some(few) => few.occluded(rays, asked),
            None => self.occluded_together(&std::array::from_fn(|lane| rays.get(lane)), time, asked),
        }
    }
}
