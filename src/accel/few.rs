//! The triangles of a small scene, and from which places segments to another one may meet them.
//!
//! Triangles that together make up a parallelogram are one facet. A facet has three linear functions of a
//! place x: its height over the plane and two coordinates v and w in it, each from 0 to 1 in the facet. A
//! segment from o to e meets the plane where v = (v(e) h(o) - v(o) h(e)) / (h(o) - h(e)).
//!
//! The functions are computed in `f64` and rounded to `f32`, in node space: places and distances are at most
//! 4 there, and rounding changes a height by less than 2⁻²². What the exact test finds is never left out:
//! - Where it finds a hit, the ray's point at the computed distance is, whatever the angle, no farther from
//!   the plane than some hundred roundings of `f64`, as for the offset of rays from meshes. So not both ends
//!   of the segment are higher than [`MARGIN`] on the same side. Triangles with too small an angle for that
//!   are always tested.
//! - The line then passes the triangle as near. Along a line v changes in proportion to h, so v(e) h(o) -
//!   v(o) h(e) lies between 0 and h(o) - h(e) up to that distance times (|v(o)| + |v(e)| + the gradient of v
//!   times |h(o) - h(e)|). Rounding to `f32` adds less than 2⁻²⁰ (|v(o)| + |v(e)| + 1).

use super::node::NodeSpace;
use super::packet::Packet;
use super::few_rays::RayFacet;
use super::rays::KnownTriangle;
use crate::geometry::{SurfacePoint, Vec3};
use crate::lanes::{LANES, Mask, REGISTERS, Vec3Lanes, WIDTH};
use smallvec::{SmallVec, smallvec};
use wide::{f32x8, f64x4};

/// Most triangles of a small scene: with more a tree is faster.
pub(super) const MOST: usize = 64;

/// By how much the tests err toward a hit, in node space.
pub(super) const MARGIN: f32 = 1.0 / (1 << 18) as f32;

/// The least sine of an angle, and the least altitude in node space, of a triangle whose plane is known well
/// enough.
const LEAST: (f64, f64) = (1e-4, 1e-7);

/// The greatest distance from the scene's centre, and the greatest offset of a ray's origin, for which the
/// bounds hold.
const GREATEST: (f64, f64) = (1.001, 1e-7);

/// Triangles that lie in one parallelogram.
#[derive(Clone, Debug)]
struct Facet {
    triangles: SmallVec<[KnownTriangle; 2]>,
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
    /// What v and w are uncertain by, times the margin.
    pub slack: [f32; 2],
    /// Whether every segment is tested.
    pub always: bool,
}

#[derive(Clone, Debug)]
pub(super) struct Few {
    pub space: NodeSpace,
    /// In the order of their shapes and of their own numbers.
    triangles: Vec<KnownTriangle>,
    pub facets: Vec<Tested>,
    /// The functions of four facets: x, y and z of the gradient, and the value at the origin.
    functions: Vec<[[f64x4; 4]; 3]>,
}

/// A point in the coordinates of each facet.
pub(super) type PointAtFacets = SmallVec<[[f32; WIDTH * 3]; 8]>;

/// Where the places of all lanes lie for a facet.
pub(super) struct Sides {
    /// Surely before the plane, and surely behind it.
    front: Mask,
    back: Mask,
    height: [f32x8; 2],
    across: [[f32x8; 2]; 2],
}

impl Few {
    /// `None` of too many, and of none.
    pub fn new(packets: &[Packet], space: &NodeSpace) -> Option<Self> {
        if packets.len() > MOST {
            return None;
        }
        let area = |[a, b, c]: [Vec3; 3]| (b - a).cross(c - a).length_squared();
        let mut triangles: Vec<KnownTriangle> = packets.iter().flat_map(Packet::triangles).collect();
        triangles.retain(|KnownTriangle { vertices, .. }| vertices[0] != vertices[1] || area(*vertices) > 0.0);
        if triangles.is_empty() || triangles.len() > MOST {
            return None;
        }
        triangles.sort_by_key(|known| (known.shape, known.triangle));
        let mut facets = Vec::new();
        let mut left = triangles.clone();
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
        let functions = facets.chunks(WIDTH).map(|four| {
            std::array::from_fn(|function| {
                let of = |lane: usize| {
                    let functions = four.get(lane).and_then(|facet| facet.functions);
                    functions.map_or((Vec3::ZERO, 0.0), |functions| functions[function])
                };
                let row = |part: fn((Vec3, f64)) -> f64| f64x4::new([0, 1, 2, 3].map(|lane| part(of(lane))));
                [row(|(g, _)| g.x), row(|(g, _)| g.y), row(|(g, _)| g.z), row(|(_, at)| at)]
            })
        });
        let functions = functions.collect();
        let facets = facets.into_iter().map(|facet| facet.tested(&triangles)).collect();
        Some(Self { space: *space, triangles, facets, functions })
    }

    pub fn memory(&self) -> usize {
        size_of_val(&self.facets[..]) + size_of_val(&self.functions[..]) + size_of_val(&self.triangles[..])
    }

    pub fn triangles(&self) -> &[KnownTriangle] {
        &self.triangles
    }

    /// Whether the bounds hold for rays from or to a point.
    pub fn is_sure(&self, point: &SurfacePoint) -> bool {
        let (distance, offset) = GREATEST;
        self.space.place(point.position).abs().max_element() <= distance
            && point.error * self.space.scale() <= offset
    }

    /// The coordinates of a point at each facet: four heights, four v and four w by turns.
    pub fn seen(&self, place: Vec3) -> PointAtFacets {
        let place = self.space.place(place);
        let [x, y, z] = place.to_array().map(f64x4::splat);
        let of_four = |functions: &[[f64x4; 4]; 3]| {
            let mut values = [0.0; WIDTH * 3];
            for (function, [gx, gy, gz, at]) in functions.iter().enumerate() {
                let four = (*gx * x + *gy * y + *gz * z + *at).to_array();
                for lane in 0..WIDTH {
                    values[WIDTH * function + lane] = four[lane] as f32;
                }
            }
            values
        };
        self.functions.iter().map(of_four).collect()
    }

    /// Where the places of all lanes lie for each facet.
    pub fn sides(&self, places: &[Vec3Lanes; REGISTERS]) -> Vec<Sides> {
        let places = places.map(|place| self.space.place_lanes(place));
        let of_facet = |index: usize| {
            let [height, v, w] = std::array::from_fn(|function| {
                let [gx, gy, gz, at] = self.functions[index / WIDTH][function]
                    .map(|four| f64x4::splat(four.as_array()[index % WIDTH]));
                let mut values = [0.0f32; LANES];
                for (register, place) in places.iter().enumerate() {
                    let four = (gx * place.x + gy * place.y + gz * place.z + at).to_array();
                    for lane in 0..WIDTH {
                        values[WIDTH * register + lane] = four[lane] as f32;
                    }
                }
                halves(&values)
            });
            let margin = f32x8::splat(MARGIN);
            Sides {
                front: mask([height[0].simd_gt(margin), height[1].simd_gt(margin)]),
                back: mask([height[0].simd_lt(-margin), height[1].simd_lt(-margin)]),
                height,
                across: [v, w],
            }
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
    /// From which places a segment to one of this height may meet the plane.
    #[inline(always)]
    pub fn apart(&self, height: f32) -> Mask {
        let same = if height > MARGIN {
            self.front
        } else if height < -MARGIN {
            self.back
        } else {
            0
        };
        !same
    }

    /// From which places the line may meet the facet: also from what is no number.
    #[inline(always)]
    pub fn crossing(&self, height: f32, across: [f32; 2], slack: [f32; 2]) -> Mask {
        let end = f32x8::splat(height);
        !mask([0, 1].map(|half| {
            let start = self.height[half];
            let rise = start - end;
            let (least, most) = (rise.fast_min(f32x8::ZERO), rise.fast_max(f32x8::ZERO));
            let beyond = |axis: usize| {
                let from = self.across[axis][half];
                let place = f32x8::splat(across[axis]).mul_sub(start, from * end);
                let uncertain =
                    (from.abs() + f32x8::splat(across[axis].abs() + slack[axis])) * f32x8::splat(MARGIN);
                place.simd_lt(least - uncertain) | place.simd_gt(most + uncertain)
            };
            beyond(0) | beyond(1)
        }))
    }
}

impl Facet {
    /// `None` where the triangles do not lie in one plane, or it is not known well enough.
    fn new(space: &NodeSpace, triangles: SmallVec<[KnownTriangle; 2]>) -> Option<Self> {
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

    fn tested(self, all: &[KnownTriangle]) -> Tested {
        // The distance of a place from where the ray is, in units of the margin, and the heights that it is
        // multiplied by.
        let slack = |gradient: Vec3| (2.0 + gradient.length()) as f32;
        let number = |known: &KnownTriangle| all.iter().position(|other| other == known).unwrap_or(0) as f64;
        let shape = self.triangles[0].shape;
        let rays = RayFacet::new(
            self.functions.as_ref(),
            self.triangles.iter().all(|known| known.shape == shape),
            self.is_covered(),
        );
        Tested {
            slack: self.functions.map_or([0.0; 2], |[_, (v, _), (w, _)]| [slack(v), slack(w)]),
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
