//! The triangles and spheres of a small scene, and from which places segments to another one may meet them.
//! Spheres are tested exactly, for all lanes at once.
//!
//! Triangles that together make up a parallelogram are one facet. A facet has three linear functions of a
//! place x: its height over the plane, and two coordinates v and w in it, each from 0 to 1 in the facet. A
//! segment from o to e meets the plane at the fraction t = h(o) / (h(o) - h(e)) of its way, where
//! v = v(o) + t (v(e) - v(o)).
//!
//! The functions are computed in `f64` and rounded to `f32`, in node space: places and distances are at most
//! 4 there, so a height errs by less than 2⁻²², and v by less than 2⁻²² (1 + g) where its gradient has the
//! length g. So t errs by less than 2⁻²⁰ / |h(o) - h(e)|, and v by less than 2⁻¹⁸ (1 + g) / |h(o) - h(e)|:
//! [`MARGIN`] is four times that. Where the exact test finds a hit, the ray's point at the computed distance
//! is, whatever the angle, no farther from the plane than some hundred roundings of `f64`, as for the offset
//! of rays from meshes, and the line passes the triangle as near: far less than rounding here. Triangles with
//! too small an angle for that are always tested.

use super::Other;
use super::few_rays::{ALONG, RayFacet};
use super::node::NodeSpace;
use super::packet::Packet;
use super::rays::{NO_FACET, Primitive};
use crate::geometry::{SurfacePoint, Vec3};
use crate::lanes::{LANES, Mask, REGISTERS, Real, Register, Vec3Lanes, WIDTH};
use crate::shape::{Shape, Sphere};
use smallvec::{SmallVec, smallvec};
use wide::f32x8;

/// Most triangles of a small scene: with more a tree is faster.
pub(super) const MOST: usize = 64;

/// By how much the tests err toward a hit, where the gradient is small and the heights differ by 1.
const MARGIN: f32 = 1.0 / (1 << 16) as f32;

/// The least sine of an angle, and the least altitude in node space, of a triangle whose plane is known well
/// enough.
const LEAST: (f64, f64) = (1e-4, 1e-7);

/// The greatest distance from the scene's centre, and the greatest offset of a ray's origin, for which the
/// bounds hold.
const GREATEST: (f64, f64) = (1.001, 1e-7);

/// A triangle of a small scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FewTriangle {
    pub vertices: [Vec3; 3],
    pub primitive: Primitive,
}

/// A sphere of a small scene.
#[derive(Clone, Debug)]
pub(super) struct FewSphere {
    /// Its number among the primitives.
    pub number: f64,
    sphere: Sphere,
    centre: Vec3,
    /// With a reserve. Infinite for an ellipsoid.
    radius: f64,
}

/// Triangles that lie in one parallelogram.
#[derive(Clone, Debug)]
struct Facet {
    triangles: SmallVec<[FewTriangle; 2]>,
    /// Height, v and w of a place in node space: gradient and value at its origin. `None` where they are not
    /// known well enough.
    functions: Option<[(Vec3, f64); 3]>,
    /// The fraction of it that no triangle covers.
    waste: f64,
}

/// What is asked of a facet for each query.
#[derive(Clone, Debug)]
pub(super) struct Tested {
    pub triangles: SmallVec<[[Vec3; 3]; 2]>,
    /// Their numbers among all triangles.
    pub numbers: SmallVec<[f64; 2]>,
    /// What rays ask for.
    pub rays: RayFacet,
    /// What v, w and the fraction of a segment's way are uncertain by, times the difference of the heights.
    pub slack: f32,
    /// Whether every segment is tested.
    pub always: bool,
}

#[derive(Clone, Debug)]
pub(super) struct Few {
    pub space: NodeSpace,
    /// In their order, by which hits tell them.
    primitives: Vec<Primitive>,
    pub facets: Vec<Tested>,
    pub spheres: Vec<FewSphere>,
    /// The functions of a register of facets: x, y and z of the gradient, and the value at the origin.
    functions: Vec<[[Register; 4]; 3]>,
}

/// A point in the coordinates of each facet.
pub(super) type PointAtFacets = SmallVec<[[f32; WIDTH * 3]; 8]>;

/// Where the places of all lanes lie for a facet: their heights, v and w.
pub(super) struct Sides([[f32x8; 2]; 3]);

/// Where a place must be so that no segment from some others crosses a facet.
#[derive(Clone, Copy)]
pub(super) struct Clear {
    /// At a height less than this, or
    pub below: f32,
    /// greater than this.
    pub above: f32,
    /// Whether it may also be in the facet, if that is left whole.
    pub within: bool,
}

/// Which segments may cross a facet, and which are sure to.
pub(super) struct Crossing {
    pub near: Mask,
    pub within: Mask,
    /// Those that do not run along it: what lies in it is on one side.
    pub slanted: Mask,
}

/// The part of a length by which rays miss a sphere that they are not asked for: far more than rounding.
const RESERVE: f64 = 1e-9;

impl FewSphere {
    fn new(number: f64, sphere: Sphere) -> Self {
        let (centre, radius) = sphere.ball().unwrap_or((Vec3::ZERO, f64::INFINITY));
        Self { number, sphere, centre, radius: radius * (1.0 + RESERVE) }
    }

    /// [`Sphere::distance`] along rays of such lengths, in a register of which some lanes are asked for.
    /// `None` where all of these surely pass it by: their lines are farther from the centre than the radius,
    /// lead away from it, or end before it.
    #[inline(always)]
    pub fn distance(
        &self,
        origin: Vec3Lanes,
        direction: Vec3Lanes,
        length: Register,
        asked: Mask,
    ) -> Option<(Register, <Register as Real>::Truth)> {
        let toward = Vec3Lanes::of(self.centre) - origin;
        let (along, speed) = (toward.dot(direction), direction.length_squared());
        let (radius, kept) = (Register::splat(self.radius), Register::splat(1.0 - RESERVE));
        let (away, within) = (toward.length_squared() * kept, radius * radius);
        let passes = (away * speed - along * along).gt(within * speed);
        let leads_away = away.gt(within) & along.lt(Register::ZERO);
        // The direction's length is at most the greater of 1 and its square.
        let entry = along * kept - radius * speed.greater(Register::ONE);
        let ends_before = entry.gt(length * speed);
        if asked & !(passes | leads_away | ends_before).mask() == 0 {
            return None;
        }
        Some(self.sphere.distance(origin, direction))
    }
}

impl Few {
    /// `None` of too many, of none, and where there is anything but triangles and spheres.
    pub fn new(packets: &[Packet], others: &[(u32, Other)], space: &NodeSpace) -> Option<Self> {
        if packets.len() + others.len() > MOST {
            return None;
        }
        let sphere = |(shape, other): &(u32, Other)| match other {
            Other::Shape(Shape::Sphere(sphere)) => {
                Some((Primitive { shape: *shape, triangle: 0 }, sphere.clone()))
            }
            _ => None,
        };
        let spheres: Vec<(Primitive, Sphere)> = others.iter().map(sphere).collect::<Option<_>>()?;
        let area = |[a, b, c]: [Vec3; 3]| (b - a).cross(c - a).length_squared();
        let mut triangles: Vec<FewTriangle> = packets.iter().flat_map(Packet::triangles).collect();
        triangles.retain(|FewTriangle { vertices, .. }| vertices[0] != vertices[1] || area(*vertices) > 0.0);
        let mut primitives: Vec<Primitive> = triangles.iter().map(|triangle| triangle.primitive).collect();
        primitives.extend(spheres.iter().map(|(primitive, _)| *primitive));
        if primitives.is_empty() || primitives.len() > MOST {
            return None;
        }
        primitives.sort();
        let mut facets = Vec::new();
        let mut left = triangles;
        while let Some(first) = left.pop() {
            let joined = left.iter().enumerate().find_map(|(index, second)| {
                let facet = Facet::new(space, smallvec![first, *second])?;
                (facet.waste < 0.01).then_some((index, facet))
            });
            facets.push(match joined {
                Some((index, facet)) => {
                    left.remove(index);
                    facet
                }
                None => Facet::new(space, smallvec![first]).unwrap_or(Facet {
                    triangles: smallvec![first],
                    functions: None,
                    waste: 1.0,
                }),
            });
        }
        let functions = facets.chunks(WIDTH).map(|facets| {
            std::array::from_fn(|function| {
                let of = |lane: usize| {
                    let functions = facets.get(lane).and_then(|facet| facet.functions);
                    functions.map_or((Vec3::ZERO, 0.0), |functions| functions[function])
                };
                let row =
                    |part: fn((Vec3, f64)) -> f64| Register::new(std::array::from_fn(|lane| part(of(lane))));
                [row(|(g, _)| g.x), row(|(g, _)| g.y), row(|(g, _)| g.z), row(|(_, at)| at)]
            })
        });
        let functions = functions.collect();
        let facets = facets.into_iter().map(|facet| facet.tested(&primitives)).collect();
        let numbered = |(primitive, sphere)| FewSphere::new(number_of(&primitives, &primitive), sphere);
        let spheres = spheres.into_iter().map(numbered).collect();
        Some(Self { space: *space, primitives, facets, spheres, functions })
    }

    pub fn memory(&self) -> usize {
        let functions = size_of_val(&self.facets[..]) + size_of_val(&self.functions[..]);
        functions + size_of_val(&self.primitives[..]) + size_of_val(&self.spheres[..])
    }

    pub fn primitives(&self) -> &[Primitive] {
        &self.primitives
    }

    /// See [`super::Accel::facet_of`].
    pub fn facet_of(&self, primitive: &Primitive) -> f64 {
        let number = number_of(&self.primitives, primitive);
        let facet = self.facets.iter().position(|facet| facet.numbers.contains(&number));
        facet.map_or(NO_FACET, |facet| facet as f64)
    }

    /// Whether the bounds hold for rays from or to a point.
    pub fn is_sure(&self, point: &SurfacePoint) -> bool {
        let (distance, offset) = GREATEST;
        self.space.place(point.position).abs().max_element() <= distance
            && point.error * self.space.scale() <= offset
    }

    /// The coordinates of a point at each facet: heights, v and w of the facets of a register by turns.
    pub fn seen(&self, place: Vec3) -> PointAtFacets {
        let place = self.space.place(place);
        let [x, y, z] = place.to_array().map(Register::splat);
        let of_register = |functions: &[[Register; 4]; 3]| {
            let mut values = [0.0; WIDTH * 3];
            for (function, [gx, gy, gz, at]) in functions.iter().enumerate() {
                let numbers = (*gx * x + *gy * y + *gz * z + *at).to_array();
                for lane in 0..WIDTH {
                    values[WIDTH * function + lane] = numbers[lane] as f32;
                }
            }
            values
        };
        self.functions.iter().map(of_register).collect()
    }

    /// Where the places of all lanes lie for each facet.
    pub fn sides(&self, places: &[Vec3Lanes; REGISTERS]) -> Vec<Sides> {
        let places = places.map(|place| self.space.place_lanes(place));
        let of_facet = |index: usize| {
            let [height, v, w] = std::array::from_fn(|function| {
                let [gx, gy, gz, at] = self.functions[index / WIDTH][function]
                    .map(|values| Register::splat(values.as_array()[index % WIDTH]));
                let mut values = [0.0f32; LANES];
                for (register, place) in places.iter().enumerate() {
                    let numbers = (gx * place.x + gy * place.y + gz * place.z + at).to_array();
                    for lane in 0..WIDTH {
                        values[WIDTH * register + lane] = numbers[lane] as f32;
                    }
                }
                halves(&values)
            });
            Sides([height, v, w])
        };
        (0..self.facets.len()).map(of_facet).collect()
    }
}

#[inline(always)]
pub(super) fn halves(values: &[f32; LANES]) -> [f32x8; 2] {
    let half = |first: usize| f32x8::new(std::array::from_fn(|lane| values[first + lane]));
    [half(0), half(LANES / 2)]
}

#[inline(always)]
pub(super) fn mask(halves: [f32x8; 2]) -> Mask {
    halves[0].to_bitmask() | halves[1].to_bitmask() << (LANES / 2)
}

impl Sides {
    /// To which places no segment from some lanes crosses the facet. `own`: lanes that lie in it, where it is
    /// left whole.
    pub fn clear(&self, lanes: Mask, own: Mask) -> Clear {
        /// More than heights and the offsets of rays err by.
        const OFF: f32 = 1e-6;
        /// More than what a segment rises that runs along the facet.
        const RISE: f32 = 2.0 / ALONG;
        let height = self.0[0];
        let below = |bound: f32| mask(height.map(|height| height.simd_lt(f32x8::splat(-bound))));
        let above = |bound: f32| mask(height.map(|height| height.simd_gt(f32x8::splat(bound))));
        let others = lanes & !own;
        let least = if lanes & own == 0 { OFF } else { RISE };
        let bound = |side: Mask| if others & !side == 0 { least } else { f32::INFINITY };
        let within = lanes & !(below(RISE) | above(RISE)) == 0;
        Clear { below: -bound(below(OFF)), above: bound(above(OFF)), within }
    }

    /// From which places a segment to one other crosses the facet, by the height, v and w of that; also from
    /// what is no number. `slack`: [`Tested::slack`].
    #[inline(always)]
    pub fn crossing(&self, end: [f32; 3], slack: f32) -> Crossing {
        let end = end.map(f32x8::splat);
        let [mut missed, mut within, mut slanted] = [[f32x8::ZERO; 2]; 3];
        for half in 0..2 {
            let [height, v, w] = self.0.map(|function| function[half]);
            let inverse = f32x8::ONE / (height - end[0]);
            // The fraction of the way at which it meets the plane.
            let t = height * inverse;
            let slack = inverse.abs() * f32x8::splat(slack);
            let inside = [(v, end[1]), (w, end[2])].map(|(start, end)| {
                let place = (end - start).mul_add(t, start);
                place.fast_min(f32x8::ONE - place)
            });
            let inside = inside[0].fast_min(inside[1]).fast_min(t).fast_min(f32x8::ONE - t);
            missed[half] = inside.simd_lt(-slack);
            within[half] = inside.simd_gt(slack);
            slanted[half] = inverse.abs().simd_lt(f32x8::splat(ALONG));
        }
        Crossing { near: !mask(missed), within: mask(within), slanted: mask(slanted) }
    }
}

/// Whether rounding moves the exact test's hit by less than the offset with which rays leave: that grows with
/// the inverse of the least sine of an angle.
fn is_well_shaped(triangle: &FewTriangle) -> bool {
    const LEAST_SINE: f64 = 0.05;
    (0..3).all(|corner| {
        let [a, b, c] = [0, 1, 2].map(|turn| triangle.vertices[(corner + turn) % 3]);
        let (e, f) = (b - a, c - a);
        e.cross(f).length() >= LEAST_SINE * e.length() * f.length()
    })
}

/// The place of a primitive among all; [`NO_FACET`] where it is none of them.
fn number_of(all: &[Primitive], primitive: &Primitive) -> f64 {
    all.iter().position(|other| other == primitive).map_or(NO_FACET, |number| number as f64)
}

impl Facet {
    /// `None` where the triangles do not lie in one plane, or it is not known well enough.
    fn new(space: &NodeSpace, triangles: SmallVec<[FewTriangle; 2]>) -> Option<Self> {
        let placed: SmallVec<[[Vec3; 3]; 2]> =
            triangles.iter().map(|known| known.vertices.map(|vertex| space.place(vertex))).collect();
        let of_corner = |corner: usize| {
            let [a, b, c] = [0, 1, 2].map(|turn| placed[0][(corner + turn) % 3]);
            Self::functions(&placed, [a, b - a, c - a])
        };
        let waste = |[_, (v, _), (w, _)]: &[(Vec3, f64); 3]| {
            let doubled = |[a, b, c]: &[Vec3; 3]| (*b - *a).cross(*c - *a).length();
            1.0 - 0.5 * placed.iter().map(doubled).sum::<f64>() * v.cross(*w).length()
        };
        let functions = (0..3).filter_map(of_corner).min_by(|a, b| waste(a).total_cmp(&waste(b)))?;
        Some(Self { triangles, waste: waste(&functions), functions: Some(functions) })
    }

    /// With v and w along two edges.
    fn functions(placed: &[[Vec3; 3]], [corner, e, f]: [Vec3; 3]) -> Option<[(Vec3, f64); 3]> {
        let cross = e.cross(f);
        let (sine, altitude) = LEAST;
        let sharp = cross.length() < sine * e.length() * f.length();
        let longest = e.length().max(f.length()).max((f - e).length());
        if sharp || cross.length() < altitude * longest || longest == 0.0 {
            return None;
        }
        let normal = cross.normalize();
        let vertices = || placed.iter().flatten().map(|vertex| *vertex - corner);
        // Far less than the margin.
        if vertices().any(|vertex| vertex.dot(normal).abs() > 1e-9) {
            return None;
        }
        let along = |edge: Vec3, other: Vec3| {
            let across = other.cross(normal);
            let gradient = across / across.dot(edge);
            let ends = vertices().map(|vertex| vertex.dot(gradient));
            let (low, high) = ends.fold((0.0f64, 0.0f64), |(low, high), v| (low.min(v), high.max(v)));
            let gradient = gradient / (high - low);
            (gradient, -corner.dot(gradient) - low / (high - low))
        };
        Some([(normal, -corner.dot(normal)), along(e, f), along(f, e)])
    }

    fn tested(self, all: &[Primitive]) -> Tested {
        let steepest = self.functions.map_or(0.0, |[_, (v, _), (w, _)]| v.length().max(w.length()));
        let number = |known: &FewTriangle| number_of(all, &known.primitive);
        let shape = self.triangles[0].primitive.shape;
        let rays = RayFacet::new(
            self.functions.as_ref(),
            self.triangles.iter().all(|known| known.primitive.shape == shape && is_well_shaped(known)),
            self.is_covered(),
        );
        Tested {
            slack: MARGIN * (1.0 + steepest as f32),
            always: self.functions.is_none(),
            rays,
            numbers: self.triangles.iter().map(number).collect(),
            triangles: self.triangles.iter().map(|known| known.vertices).collect(),
        }
    }

    /// Whether every line that passes well within the parallelogram meets one of its triangles: two that
    /// share their diagonal and leave nothing over.
    fn is_covered(&self) -> bool {
        let [first, second] = self.triangles.as_slice() else { return false };
        let shared = first.vertices.iter().filter(|vertex| second.vertices.contains(vertex)).count();
        shared == 2 && self.waste < 1e-6
    }
}
