//! Profiles and implicit surfaces: surfaces that are given in coordinates of their own by where lines cross
//! them, flat, swept, turned or implicit.
//!
//! What they have in common is here: their place in the world, the rounding that comes with it, and how they
//! are sampled.

mod blobs;
mod extrusion;
mod facets;
mod outline;
mod polygon;
mod profile;
mod revolution;
mod superquadric;

use super::crossing::Crossings;
use super::placement::Placement;
use super::random_lines::{self, Crossed, OnLine};
use super::{AreaSample, Parametrisation, ShapeError, SurfaceHit};
use crate::geometry::{Bounds, Ray, SurfacePoint, Transform, Vec3};
use blobs::Blobs;
pub use blobs::{Blob, Kernel};
use extrusion::Extrusion;
use facets::Facets;
use glam::DMat4;
pub use outline::FillRule;
use polygon::Polygon;
pub use profile::Interpolation;
use revolution::Revolution;
use smallvec::SmallVec;
use superquadric::Superquadric;

/// Which shape, in its own coordinates.
#[derive(Clone, Debug, PartialEq)]
pub enum ProfileOrImplicitKind {
    /// A polygon in the plane z = 0, bounded by closed contours.
    Polygon {
        /// Closed polygons, each by its corners (x, y).
        contours: Vec<Vec<[f64; 2]>>,
        /// Which points count as inside.
        rule: FillRule,
    },
    /// A polygon swept along z, from one height to another.
    Extrusion {
        /// Closed polygons, each by its corners (x, y).
        contours: Vec<Vec<[f64; 2]>>,
        /// Which points count as inside.
        rule: FillRule,
        /// The lower and the upper height.
        heights: [f64; 2],
        /// Whether it is closed at both ends.
        capped: bool,
    },
    /// A profile of points (r, z) turned around z.
    Revolution {
        /// The points: distance from the axis, at least 0, and height.
        profile: Vec<[f64; 2]>,
        /// How points are joined.
        interpolation: Interpolation,
        /// Whether the profile comes back to where it begins.
        closed: bool,
        /// Whether the ends of one that does not are closed by disks.
        capped: bool,
    },
    /// (|x/a|^(2/e₂) + |y/b|^(2/e₂))^(e₂/e₁) + |z/c|^(2/e₁) = 1 with the semi-axes a, b, c and the exponents
    /// e₁, e₂ from 0.001, almost a box, by 1, an ellipsoid, to 2, an octahedron.
    Superquadric {
        /// e₁, along z, and e₂, across it.
        exponents: [f64; 2],
        /// a, b and c, above 0.
        semi_axes: Vec3,
    },
    /// Where the densities of soft balls add up to a threshold.
    Blobs {
        /// The soft balls.
        blobs: Vec<Blob>,
        /// How the density of a ball falls off.
        kernel: Kernel,
        /// The density on the surface. Above 0.
        threshold: f64,
    },
}

/// A shape in coordinates in which none of a point's exceeds 1.
#[derive(Clone, Debug)]
enum Form {
    Polygon(Polygon),
    Extrusion(Extrusion),
    Revolution(Revolution),
    Superquadric(Superquadric),
    Blobs(Blobs),
}

/// What a shape is to know of itself, in its own coordinates. Its parts are numbered in a way of its own.
trait Local {
    /// Crossings in ascending order of the line through a point, its direction of unit length, where
    /// coordinates of points near the shape are rounded by up to `rounding`.
    fn crossed(&self, origin: Vec3, direction: Vec3, rounding: f64) -> SmallVec<[OnLine; 4]>;
    /// Unit normal, outward from a closed shape.
    fn normal(&self, point: Vec3, part: u32) -> Vec3;
    /// The point of a part near to one that is almost on it.
    fn project(&self, point: Vec3, part: u32) -> Vec3;
    /// uv, ∂p/∂u and ∂p/∂v.
    fn parametrisation(&self, point: Vec3, part: u32) -> ([f64; 2], [Vec3; 2]);
    /// The largest direction · x.
    fn reach(&self, direction: Vec3) -> f64;
    /// Bound on how far from the shape, along the normal, its own arithmetic may place a point.
    fn rounding(&self, point: Vec3) -> f64;
    fn is_closed(&self) -> bool;
}

impl Form {
    fn local(&self) -> &dyn Local {
        match self {
            Self::Polygon(polygon) => polygon,
            Self::Extrusion(extrusion) => extrusion,
            Self::Revolution(revolution) => revolution,
            Self::Superquadric(superquadric) => superquadric,
            Self::Blobs(blobs) => blobs,
        }
    }
}

/// A shape of a profile or of an implicit function, placed in the scene.
#[derive(Clone, Debug)]
pub struct ProfileOrImplicit {
    form: Form,
    placement: Placement,
    inward: bool,
    /// Box in local coordinates.
    around: Bounds,
    /// The flat pieces of a shape that consists of them.
    facets: Option<Facets>,
}

impl ProfileOrImplicit {
    /// `to_world` applied to a shape. Normals point to +z of a polygon, out of all others, unless
    /// `flip_normals`.
    pub fn new(
        to_world: &Transform,
        kind: &ProfileOrImplicitKind,
        flip_normals: bool,
    ) -> Result<Self, ShapeError> {
        let scaled = |scale: f64| Placement::new(&Transform::scale(scale).then(to_world));
        let (form, placement) = match kind {
            ProfileOrImplicitKind::Polygon { contours, rule } => {
                let (polygon, scale) = Polygon::new(contours, *rule)?;
                (Form::Polygon(polygon), scaled(scale)?)
            }
            ProfileOrImplicitKind::Extrusion { contours, rule, heights, capped } => {
                let (extrusion, scale) = Extrusion::new(contours, *rule, *heights, *capped)?;
                (Form::Extrusion(extrusion), scaled(scale)?)
            }
            ProfileOrImplicitKind::Revolution { profile, interpolation, closed, capped } => {
                let (revolution, scale) = Revolution::new(profile, *interpolation, *closed, *capped)?;
                (Form::Revolution(revolution), scaled(scale)?)
            }
            ProfileOrImplicitKind::Superquadric { exponents, semi_axes } => {
                let size = |axis: usize| match semi_axes[axis] {
                    size if size > 0.0 && size.is_finite() => Ok(size),
                    size => Err(ShapeError::Radius(size)),
                };
                let stretch = Vec3::new(size(0)?, size(1)?, size(2)?);
                let stretched = Transform::new(DMat4::from_scale(stretch)).ok_or(ShapeError::Placement)?;
                let form = Form::Superquadric(Superquadric::new(*exponents)?);
                (form, Placement::new(&stretched.then(to_world))?)
            }
            ProfileOrImplicitKind::Blobs { blobs, kernel, threshold } => {
                let (made, scale, origin) = Blobs::new(blobs, *kernel, *threshold)?;
                let place = Transform::scale(scale).then(&Transform::translation(origin));
                (Form::Blobs(made), Placement::new(&place.then(to_world))?)
            }
        };
        let facets = match &form {
            Form::Polygon(polygon) => Some(Facets::new(&placement, polygon.facets())),
            Form::Extrusion(extrusion) => Some(Facets::new(&placement, extrusion.facets())),
            Form::Revolution(_) | Form::Superquadric(_) | Form::Blobs(_) => None,
        };
        let reach = |sign: f64| Vec3::from(Vec3::AXES.map(|axis| sign * form.local().reach(axis * sign)));
        let around = Bounds { min: reach(-1.0), max: reach(1.0) };
        Ok(Self { form, placement, inward: flip_normals, around, facets })
    }

    /// Whether it encloses a volume.
    pub fn is_closed(&self) -> bool {
        self.form.local().is_closed()
    }

    /// Whether it is a part of a plane.
    pub fn is_flat(&self) -> bool {
        matches!(self.form, Form::Polygon(_))
    }

    /// Whether it is anything but flat pieces.
    #[cfg(test)]
    pub(super) fn is_curved(&self) -> bool {
        self.facets.is_none()
    }

    /// Nearest distance with 0 ≤ t < `ray.t_max`, and the part that is met.
    pub fn intersect(&self, ray: &Ray) -> Option<(f64, u32)> {
        self.placement.nearest(ray, |origin, direction| self.crossed(origin, direction))
    }

    /// All crossings along the whole line.
    pub fn crossings(&self, ray: &Ray) -> Crossings {
        self.placement.crossings(ray, self.inward, |origin, direction| self.crossed(origin, direction))
    }

    /// The point of a part near to `position`.
    pub fn surface(&self, position: Vec3, part: u32) -> SurfaceHit {
        let local = self.placement.pose.local_point(position);
        self.surface_at(self.form.local().project(local, part), part)
    }

    fn surface_at(&self, local: Vec3, part: u32) -> SurfaceHit {
        let position = self.placement.pose.world_point(local);
        let outward = self.form.local().normal(local, part);
        let image = self.placement.pose.world_normal(outward);
        let stretch = image.length();
        let error =
            self.placement.error(position, outward, stretch) + self.form.local().rounding(local) / stretch;
        let normal = image / if self.inward { -stretch } else { stretch };
        SurfaceHit { point: SurfacePoint { position, normal, error }, shading_normal: normal }
    }

    /// Coordinates and tangents at a point of a part.
    pub fn parametrisation(&self, position: Vec3, part: u32) -> Parametrisation {
        let local = self.placement.pose.local_point(position);
        let (uv, along) = self.form.local().parametrisation(local, part);
        let [tangent, bitangent] = along.map(|vector| self.placement.pose.world_vector(vector));
        Parametrisation { uv, tangent, bitangent }
    }

    /// A box around it.
    pub fn bounds(&self) -> Bounds {
        let linear = self.placement.pose.linear;
        let reach = |sign: f64| {
            Vec3::from([0, 1, 2].map(|axis| sign * self.form.local().reach(linear.row(axis) * sign)))
        };
        Bounds { min: self.placement.pose.origin + reach(-1.0), max: self.placement.pose.origin + reach(1.0) }
    }

    /// Exact for what consists of flat pieces, else to about 10⁻⁴ of itself.
    pub fn area(&self) -> f64 {
        match &self.facets {
            Some(facets) => facets.area(),
            None => random_lines::integral(self, |normal| self.placement.area_stretch(normal)),
        }
    }

    /// Uniform in world area on what consists of flat pieces; else see `random_lines`: for some `u` there is
    /// no point.
    pub fn sample(&self, u: [f64; 2]) -> Option<AreaSample> {
        let (local, part, density) = match &self.facets {
            Some(facets) => {
                let (local, part) = facets.sample(u);
                (local, part, 1.0 / facets.area())
            }
            None => {
                let (local, part) = random_lines::sample(self, u)?;
                let local = self.form.local().project(local, part);
                (local, part, self.local_area_density(local, self.form.local().normal(local, part)))
            }
        };
        Some(AreaSample { triangle: part, ..AreaSample::analytic(self.surface_at(local, part), density) })
    }

    /// Density per area with which a sample is the point.
    pub fn area_density(&self, point: &SurfacePoint) -> f64 {
        if let Some(facets) = &self.facets {
            return 1.0 / facets.area();
        }
        let normal = self.placement.pose.local_normal(point.normal).normalize_or_zero();
        self.local_area_density(self.placement.pose.local_point(point.position), normal)
    }

    fn local_area_density(&self, local: Vec3, normal: Vec3) -> f64 {
        random_lines::density(self, local, normal) / self.placement.area_stretch(normal)
    }
}

impl Crossed for ProfileOrImplicit {
    fn around(&self) -> Bounds {
        self.around
    }

    fn crossed(&self, origin: Vec3, direction: Vec3) -> SmallVec<[OnLine; 4]> {
        let rounding = self.placement.coordinate_error(1.0 + origin.abs().max_element());
        self.form.local().crossed(origin, direction, rounding)
    }

    fn normal(&self, point: Vec3, part: u32) -> Vec3 {
        self.form.local().normal(point, part)
    }
}

/// The least power of two that a number does not exceed: coordinates are divided by it without rounding, so
/// that shapes that share corners still share them. 0 and infinite where the number is.
fn power_above(number: f64) -> f64 {
    number.log2().ceil().exp2()
}
