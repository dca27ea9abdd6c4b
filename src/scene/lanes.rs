//! What the rays of several paths meet, one path for each lane.

use super::counting::RayKind;
use super::intersection::Intersection;
use super::scene::{Scene, Surface};
use crate::accel::{Accel, Hits, NO_FACET, Rays};
use crate::bsdf::{EvenRoughMetal, Specular};
use crate::geometry::{Points, Vec3};
use crate::lanes::{
    Mask, REGISTERS, Real, Register, Row, Vec3Lanes, WIDTH, lanes_of, mask_of, part, registers_of, set,
};
use crate::material::{Even, MaterialId, Materials};
use crate::shape::Shape;
use crate::spectrum::Spectrum;
use std::collections::HashMap;

/// Where the rays of some lanes have met surfaces; see [`Intersection`].
#[derive(Clone, Debug)]
pub struct Intersections {
    /// The lanes that have met a surface.
    pub met: Mask,
    /// Where they have met it.
    pub point: [Points<Register>; REGISTERS],
    /// Shading normals of the front.
    pub shading_normal: [Vec3Lanes; REGISTERS],
    /// The lanes that have met a light.
    pub on_light: Mask,
    hits: Hits,
    time: f64,
    from_front: Mask,
    coincident: Mask,
}

/// A triangle of a scene that consists of few: what a hit of it gives but for the place.
#[derive(Clone, Copy, Debug)]
pub(super) struct KnownSurface {
    origin: Vec3,
    edges: [Vec3; 2],
    normal: Vec3,
    error: f64,
    is_light: bool,
    /// Whether its shading normal is that of the triangle.
    is_flat: bool,
}

/// How surfaces scatter, as far as that is the same all over them.
#[derive(Clone, Debug, Default)]
pub(super) struct EvenSurfaces {
    /// By shape, front and back.
    sides: Vec<[Side; 2]>,
    pub reflectances: Vec<Spectrum>,
    pub metals: Vec<EvenRoughMetal>,
}

/// One side of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Diffuse, with the reflectance of this number; see [`Scene::reflectances`].
    Diffuse(u32),
    /// A rough metal, of this number; see [`Scene::metals`].
    Metal(u32),
    /// It reflects nothing.
    Black,
    /// Anything else: [`Scene::shade`] tells.
    Other,
}

impl Intersections {
    /// No lane has met anything.
    pub const NONE: Self = Self {
        met: 0,
        point: [Points::NONE; REGISTERS],
        shading_normal: [Vec3Lanes::ZERO; REGISTERS],
        on_light: 0,
        hits: Hits::NONE,
        time: 0.0,
        from_front: 0,
        coincident: 0,
    };

    /// Leaves out what was met before, at a time.
    pub fn clear(&mut self, time: f64) {
        (self.met, self.time) = (0, time);
    }

    /// The facets that rays from there leave; see [`Rays::leaves`].
    pub fn facet(&self) -> &Row {
        &self.hits.facet
    }

    /// Puts in what one lane has met.
    pub fn set(&mut self, lane: usize, hit: &Intersection) {
        self.met |= 1 << lane;
        self.hits.set(lane, &hit.hit);
        set(&mut self.hits.t, lane, hit.t);
        set(&mut self.hits.facet, lane, NO_FACET);
        self.set_point(lane, hit);
    }

    fn set_point(&mut self, lane: usize, hit: &Intersection) {
        let (bit, register) = (1 << lane, lane / WIDTH % REGISTERS);
        let put = |mask: &mut Mask, holds: bool| *mask = *mask & !bit | if holds { bit } else { 0 };
        self.point[register].set(lane, &hit.point);
        self.shading_normal[register].set(lane, hit.shading_normal);
        put(&mut self.on_light, hit.light.is_some());
        put(&mut self.from_front, hit.from_front);
        put(&mut self.coincident, hit.coincident);
    }

    /// What one lane has met.
    pub fn get(&self, scene: &Scene, lane: usize) -> Intersection {
        let register = lane / WIDTH % REGISTERS;
        let hit = self.hits.get(lane);
        Intersection {
            t: hit.t,
            point: self.point[register].get(lane),
            shading_normal: self.shading_normal[register].get(lane),
            light: scene.surfaces[hit.shape as usize].light,
            hit,
            time: self.time,
            from_front: self.from_front >> lane & 1 == 1,
            coincident: self.coincident >> lane & 1 == 1,
        }
    }
}

impl KnownSurface {
    /// Stands for what is no triangle.
    const NONE: Self = Self {
        origin: Vec3::ZERO,
        edges: [Vec3::ZERO; 2],
        normal: Vec3::Z,
        error: 0.0,
        is_light: false,
        is_flat: false,
    };

    /// Those of [`Accel::few_primitives`].
    pub fn all(accel: &Accel, shapes: &[Shape], surfaces: &[Surface]) -> Vec<Self> {
        let known = accel.few_primitives().iter().map(|primitive| {
            let Shape::Mesh(mesh) = &shapes[primitive.shape as usize] else { return Self::NONE };
            let [a, b, c] = mesh.triangle(primitive.triangle);
            let found = mesh.surface(primitive.triangle, [0.0; 2]);
            Self {
                origin: a,
                edges: [b - a, c - a],
                normal: found.point.normal,
                error: found.point.error,
                is_light: surfaces[primitive.shape as usize].light.is_some(),
                is_flat: mesh.data().normals.is_none(),
            }
        });
        known.collect()
    }
}

impl EvenSurfaces {
    pub fn new(materials: &Materials, surfaces: &[Surface]) -> Self {
        let mut even = Self::default();
        let mut numbers: HashMap<(MaterialId, bool), Side> = HashMap::new();
        for surface in surfaces {
            let sides = [true, false].map(|front| {
                *numbers.entry((surface.material, front)).or_insert_with(|| {
                    match materials.even(surface.material, front) {
                        None => Side::Other,
                        Some(Even::Black) => Side::Black,
                        Some(Even::Diffuse(reflectance)) => {
                            even.reflectances.push(reflectance.clone());
                            Side::Diffuse(even.reflectances.len() as u32 - 1)
                        }
                        Some(Even::Metal(metal)) => {
                            even.metals.push(*metal);
                            Side::Metal(even.metals.len() as u32 - 1)
                        }
                    }
                })
            });
            even.sides.push(sides);
        }
        even
    }
}

impl Scene {
    /// Where the rays of the lanes asked for first meet a surface, if each surface that a ray meets is one:
    /// see [`Self::meets_at_once`]. What was in `found` before is overwritten or left out.
    pub fn intersect_in_lanes(
        &self,
        rays: &Rays,
        time: f64,
        kind: RayKind,
        asked: Mask,
        found: &mut Intersections,
    ) {
        found.time = time;
        self.closest_in_lanes(kind.begins(), rays, time, asked, &mut found.hits);
        found.met = found.hits.met;
        (found.on_light, found.from_front, found.coincident) = (0, 0, 0);
        let mut left = 0;
        for register in registers_of(found.met) {
            let met = part(found.met, register);
            let known = found.hits.known[register];
            let is_known = known.ge(Register::ZERO).mask() & met;
            if is_known == 0 {
                left |= met << (WIDTH * register);
                continue;
            }
            let records = known.to_array().map(|number| &self.known[number.max(0.0) as usize]);
            let row = |of: fn(&KnownSurface) -> f64| Register::new(records.map(of));
            let vector = |of: fn(&KnownSurface) -> Vec3| {
                let vectors = records.map(of);
                let axis = |of: fn(&Vec3) -> f64| Register::new(vectors.each_ref().map(of));
                Vec3Lanes { x: axis(|v| v.x), y: axis(|v| v.y), z: axis(|v| v.z) }
            };
            let [v, w] = [0, 1].map(|weight| found.hits.barycentric[weight][register]);
            let (ab, ac) = (vector(|known| known.edges[0]), vector(|known| known.edges[1]));
            let normal = vector(|known| known.normal);
            found.point[register] = Points {
                position: vector(|known| known.origin) + ab * v + ac * w,
                normal,
                error: row(|known| known.error),
            };
            found.shading_normal[register] = normal;
            let from_front = rays.direction[register].dot(normal).lt(Register::ZERO).mask();
            let mask = |of: fn(&KnownSurface) -> bool| {
                (0..WIDTH).fold(0, |mask, lane| mask | Mask::from(of(records[lane])) << lane) & met
            };
            found.on_light |= mask(|known| known.is_light) << (WIDTH * register);
            found.from_front |= (from_front & met) << (WIDTH * register);
            left |= (met & !(is_known & mask(|known| known.is_flat))) << (WIDTH * register);
        }
        for lane in lanes_of(left) {
            let (hit, ray) = (found.hits.get(lane), rays.get(lane));
            found.set_point(lane, &self.intersection(&hit, &ray, time));
        }
    }

    /// How the side of a surface that a lane has met scatters.
    pub fn side(&self, hits: &Intersections, lane: usize, front: bool) -> Side {
        self.even.sides[hits.hits.get(lane).shape as usize][usize::from(!front)]
    }

    /// Those of even diffuse sides, by their numbers.
    pub fn reflectances(&self) -> &[Spectrum] {
        &self.even.reflectances
    }

    /// Even rough metals, by their numbers.
    pub fn metals(&self) -> &[EvenRoughMetal] {
        &self.even.metals
    }

    /// Whether most rays are answered for all lanes at once: the scene consists of few triangles and spheres,
    /// and nothing absorbs light between them.
    pub fn answers_lanes(&self) -> bool {
        !self.known.is_empty() && !self.features.absorption
    }

    /// Whether a segment leads through nothing, and what it meets is a surface.
    pub fn has_plain_segments(&self) -> bool {
        let features = &self.features;
        !features.medium_stack && !features.absorption && !features.interface_events()
    }

    /// Whether what rays of a kind meet first is a surface unless [`Self::interfaces`] says otherwise. Where
    /// they are in no medium, nothing on the way to it counts.
    pub fn meets_at_once(&self, kind: RayKind) -> bool {
        !(kind == RayKind::Camera && self.limits.hide_emitters)
    }

    /// Whether what a lane has met is the surface of a body.
    pub fn is_of_body(&self, found: &Intersections, lane: usize) -> bool {
        self.body_of(&found.hits.get(lane)).is_some()
    }

    /// [`Self::is_nearly_specular`] of what a lane has met.
    pub fn is_nearly_specular_in_lane(&self, found: &Intersections, lane: usize) -> bool {
        self.surfaces[found.hits.get(lane).shape as usize].specular == Specular::Nearly
    }

    /// The lanes that may have met several surfaces at once, or a boundary of bodies: what becomes of their
    /// rays depends on the media that they are in.
    pub fn interfaces(&self, found: &Intersections) -> Mask {
        if !self.features.interface_events() {
            return 0;
        }
        let is_interface = |&lane: &usize| {
            let hit = found.hits.get(lane);
            self.body_of(&hit).is_some()
                || self.may_touch(hit.shape, &found.point[lane / WIDTH % REGISTERS].get(lane))
        };
        mask_of(lanes_of(found.met).filter(is_interface))
    }
}
