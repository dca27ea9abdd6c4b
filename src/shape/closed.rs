//! Whether a shape encloses a volume: what is inside of it can then be told from how often a line has crossed
//! it.

use super::{Mesh, Shape};
use crate::geometry::{Ray, Vec3};
use crate::sampling::quadrature::midpoints;

impl Shape {
    /// Whether it is closed and its normals point outward, so that every line enters and leaves it by turns.
    pub fn encloses(&self) -> bool {
        self.is_closed().is_ok() && self.faces_outward()
    }

    /// Whether the normals of a closed shape point outward: whether lines enter it before they leave it.
    pub fn faces_outward(&self) -> bool {
        if let Self::Mesh(mesh) = self {
            return mesh.has_outward_normals();
        }
        let probes = (0..16).filter_map(|i| self.sample([(f64::from(i) + 0.5) / 16.0, 0.3]));
        let first_crossing = |point: Vec3, normal: Vec3| {
            self.crossings(&Ray::new(point, -normal)).first().map(|crossing| crossing.enters)
        };
        let mut found = probes.filter_map(|probe| {
            let point = probe.surface.point;
            first_crossing(point.position, point.normal)
        });
        found.next().unwrap_or(false)
    }

    /// Bound on how far the surface lies from where its file puts it: meshes are rounded to single precision,
    /// everything by the transforms. `shift` is how far it was moved to the scene's own coordinates.
    pub fn placement_error(&self, shift: f64) -> f64 {
        let bounds = self.bounds();
        let reach = if bounds.is_empty() { 0.0 } else { bounds.min.abs().max(bounds.max.abs()).length() };
        // A point goes through few products of matrices and one of a matrix and a vector, of four terms each.
        let by_transforms = 32.0 * f64::EPSILON * (reach + shift);
        match self {
            Self::Mesh(_) => 0.5 * f64::from(f32::EPSILON) * reach + by_transforms,
            _ => by_transforms,
        }
    }

    /// A plane parts two shapes by at least so much, or, below zero, no plane that is tried parts them and
    /// some let them reach into one another by no more than that. Exact for balls. Tried are planes across
    /// the axes and across the line between the middles, and the faces of meshes of few triangles.
    pub fn gap(&self, other: &Self) -> f64 {
        let [own, others] = [self, other].map(Self::bounds);
        let boxes = own.gap(others);
        let direction = match (others.centre() - own.centre()).try_normalize() {
            Some(direction) if boxes.is_finite() => direction,
            _ => return boxes,
        };
        let between = |direction: Vec3| -(self.reach(direction) + other.reach(-direction));
        let gap = boxes.max(between(direction));
        if gap > 0.0 {
            return gap;
        }
        let outward = self.few_faces().map(|[a, b, c]| (b - a).cross(c - a));
        let inward = other.few_faces().map(|[a, b, c]| (c - a).cross(b - a));
        outward.chain(inward).filter_map(Vec3::try_normalize).map(between).fold(gap, f64::max)
    }

    /// The triangles of a mesh, if they are so few that each may be looked at.
    fn few_faces(&self) -> impl Iterator<Item = [Vec3; 3]> + '_ {
        const FEW: u32 = 64;
        let mesh = match self {
            Self::Mesh(mesh) => Some(mesh).filter(|mesh| mesh.triangle_count() <= FEW as usize),
            _ => None,
        };
        mesh.into_iter()
            .flat_map(|mesh| (0..mesh.triangle_count() as u32).map(|triangle| mesh.triangle(triangle)))
    }

    /// How far the surfaces of two shapes at least stay from one another, one of which may lie within the
    /// other. Below zero where that is not seen: it is where one is a ball around the other, or a mesh of few
    /// triangles each of whose planes has the other on one side.
    pub fn clearance(&self, other: &Self) -> f64 {
        if ![self, other].iter().all(|shape| shape.bounds().half_area().is_finite()) {
            return f64::NEG_INFINITY;
        }
        self.clearance_within(other).max(other.clearance_within(self))
    }

    fn clearance_within(&self, around: &Self) -> f64 {
        match around {
            Self::Sphere(sphere) if let Some((centre, radius)) = sphere.ball() => {
                radius - self.farthest_from(centre)
            }
            Self::Mesh(_) => {
                let of_triangle = |[a, b, c]: [Vec3; 3]| {
                    let normal = (b - a).cross(c - a).try_normalize()?;
                    let height = normal.dot(a);
                    let clearance = (height - self.reach(normal)).max(-self.reach(-normal) - height);
                    // The first plane that crosses the other shape says that nothing is known.
                    (clearance > 0.0).then_some(clearance)
                };
                let mut faces = around.few_faces().peekable();
                if faces.peek().is_none() {
                    return f64::NEG_INFINITY;
                }
                faces
                    .try_fold(f64::INFINITY, |least, face| Some(least.min(of_triangle(face)?)))
                    .unwrap_or(f64::NEG_INFINITY)
            }
            _ => f64::NEG_INFINITY,
        }
    }

    /// How deep all of it lies within a ball. Below zero where it does not, or where this is no ball.
    pub fn depth_within_ball(&self, ball: &Self) -> f64 {
        match ball {
            Self::Sphere(_) => self.clearance_within(ball),
            _ => f64::NEG_INFINITY,
        }
    }

    /// A lower bound on the distance of a place from the surface, up to rounding. It says something of balls
    /// and round rings only: their boxes hold much that is far from them.
    pub fn distance_from(&self, place: Vec3) -> f64 {
        match self {
            Self::Sphere(sphere) if let Some((centre, radius)) = sphere.ball() => {
                (place.distance(centre) - radius).abs()
            }
            Self::Torus(torus) => torus.distance_from(place).unwrap_or(0.0),
            _ => 0.0,
        }
    }

    /// An upper bound on the distance of the points of the shape from a place.
    fn farthest_from(&self, place: Vec3) -> f64 {
        match self {
            Self::Sphere(sphere) if let Some((centre, radius)) = sphere.ball() => {
                centre.distance(place) + radius
            }
            _ => self.bounds().corners().map(|corner| corner.distance(place)).fold(0.0, f64::max),
        }
    }

    /// An upper bound on direction · x for the points x of the shape.
    fn reach(&self, direction: Vec3) -> f64 {
        /// Larger meshes are taken for their boxes: they may have many neighbours.
        const FEW: usize = 10_000;
        match self {
            Self::Sphere(sphere) => sphere.reach(direction),
            Self::Mesh(mesh) if mesh.triangle_count() <= FEW => {
                let vertices = (0..mesh.triangle_count() as u32).flat_map(|triangle| mesh.triangle(triangle));
                vertices.map(|vertex| direction.dot(vertex)).fold(f64::NEG_INFINITY, f64::max)
            }
            _ => {
                let bounds = self.bounds();
                direction.dot(bounds.centre()) + direction.abs().dot(0.5 * (bounds.max - bounds.min))
            }
        }
    }

    /// The largest error bound of a point on it, as far as a grid of points tells. Not a bound: it says how
    /// far to look.
    pub fn typical_error(&self) -> f64 {
        let errors = midpoints(8).filter_map(|u| Some(self.sample(u)?.surface.point.error));
        errors.fold(0.0, f64::max)
    }
}

impl Mesh {
    /// Whether a closed mesh encloses a positive volume.
    fn has_outward_normals(&self) -> bool {
        let side = if self.data().flip_normals { -1.0 } else { 1.0 };
        self.data().volume() * side > 0.0
    }
}
