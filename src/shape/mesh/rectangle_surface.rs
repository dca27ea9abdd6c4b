use super::Mesh;
use super::sampling::CORNERS;
use crate::geometry::{Points, Vec3};
use crate::lanes::{Real, Vector};
use crate::shape::Rectangle;

/// The two triangles of a rectangle, for points of several paths at once.
#[derive(Clone, Debug)]
pub struct RectangleSurface {
    rectangle: Rectangle,
    /// That of the corner (1, 0), and that of the corner (0, 1).
    halves: [Half; 2],
    error: f64,
}

/// A triangle of it.
#[derive(Clone, Copy, Debug)]
struct Half {
    /// Where its vertices lie on the unit square.
    corners: [[f64; 2]; 3],
    origin: Vec3,
    edges: [Vec3; 2],
    normal: Vec3,
}

impl Mesh {
    /// The rectangle that the mesh is, if it is one.
    pub fn rectangle_surface(&self) -> Option<RectangleSurface> {
        let half = |triangle: u32| {
            let [a, b, c] = self.triangle(triangle);
            Half {
                corners: self.data.indices[triangle as usize].map(|index| CORNERS[index as usize]),
                origin: a,
                edges: [b - a, c - a],
                normal: self.surface(triangle, [0.0; 2]).point.normal,
            }
        };
        Some(RectangleSurface { rectangle: self.rectangle?, halves: [half(0), half(1)], error: self.error })
    }
}

impl RectangleSurface {
    /// The rectangle.
    pub fn rectangle(&self) -> &Rectangle {
        &self.rectangle
    }

    /// The points at fractions of the first rectangle's edges, those that [`Mesh::sample_rectangle`] takes.
    #[inline(always)]
    pub fn points<R: Real>(&self, [x, y]: [R; 2]) -> Points<R> {
        let of_half = |half: &Half| {
            let [a, b, c] = half.corners;
            let (ab, ac) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
            let determinant = R::of(ab[0] * ac[1] - ab[1] * ac[0]);
            let (px, py) = (x - R::of(a[0]), y - R::of(a[1]));
            let v = (px * R::of(ac[1]) - py * R::of(ac[0])) / determinant;
            let w = (R::of(ab[0]) * py - R::of(ab[1]) * px) / determinant;
            let [along, across] = half.edges.map(Vector::of);
            (Vector::of(half.origin) + along * v + across * w, Vector::of(half.normal))
        };
        let is_second = y.gt(x);
        let [(position, normal), (of_second, other)] = self.halves.each_ref().map(of_half);
        Points {
            position: Vector::choose(is_second, of_second, position),
            normal: Vector::choose(is_second, other, normal),
            error: R::of(self.error),
        }
    }
}
