use super::tree::Bound;
use super::{Guides, LightHit, Receiver, sees_none_of};
use crate::geometry::{Bounds, Placed, Pose, SurfacePoint, Vec3};
use crate::lanes::{Real, Vector};
use crate::shape::solid::Solid;
use crate::shape::{AreaSample, AtRest, Hit, NO_INSTANCE, Shape, ShapeSample, per_steradian};
use crate::texture::{MeshPoint, TexturePoint};
use std::sync::Arc;

/// A surface whose front emits.
#[derive(Clone, Debug)]
pub struct AreaGeometry {
    /// In coordinates of its own where it is placed, else in the world's.
    pub(super) shape: Shape,
    placed: Option<Box<Placed>>,
    /// What it is a part of.
    whole: Option<Whole>,
    /// In the coordinates of the shape.
    pub(super) extent: Extent,
    /// Whether each triangle is a part.
    pub(super) divided: bool,
    /// Where light samples go, if not to all of it alike.
    pub(super) guides: Option<Guides>,
}

/// Where a surface is, and how large.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    pub area: f64,
    /// A sphere around the surface.
    centre: Vec3,
    radius: f64,
    /// The normal of a surface that lies in one plane.
    plane: Option<Vec3>,
}

impl Extent {
    /// About the solid angle that the front subtends, from places anywhere from whose `facing` side alone
    /// light counts. Zero only where it is not seen at all.
    #[inline(always)]
    pub fn estimates<R: Real>(&self, position: Vector<R>, facing: Vector<R>) -> R {
        let hidden = sees_none_of(position, facing, self.centre, self.radius);
        R::choose(hidden, R::of(0.0), self.estimates_all_around(position))
    }

    /// The same where light from anywhere counts.
    #[inline(always)]
    fn estimates_all_around<R: Real>(&self, from: Vector<R>) -> R {
        let away = from - Vector::of(self.centre);
        let squared = away.length_squared() + R::of(self.radius * self.radius);
        let estimate = |cos: R| R::of(self.area) * cos / squared;
        let Some(normal) = self.plane else {
            // The mean over the directions from which a convex body is seen.
            return estimate(R::of(0.25));
        };
        let height = Vector::of(normal).dot(away);
        // A wide light seen at a slant has parts that are seen less so.
        let seen = estimate((height / squared.sqrt()).greater(R::of(0.1)));
        R::choose(height.le(R::of(0.0)), R::of(0.0), seen)
    }
}

/// Flat meshes of at most so many triangles have but one part: there is little to choose.
const FLAT_TRIANGLES: usize = 64;

/// The solid of which a surface is a part: only what is left of the surface emits.
#[derive(Clone, Debug)]
struct Whole {
    solid: Arc<Solid>,
    /// Which of the scene's shapes the surface is.
    shape: u32,
    /// Whether the solid is carried along; otherwise its coordinates are those of the world.
    carried: bool,
}

impl Whole {
    fn shows(&self, sample: &ShapeSample, time: f64) -> bool {
        self.solid.shows(self.shape, &sample.surface.point, time)
    }
}

impl AreaGeometry {
    /// `textured`: whether its radiance differs from place to place.
    pub fn new(shape: Shape, textured: bool) -> Self {
        let bounds = shape.bounds();
        let plane = plane_normal(&shape);
        let divided = match &shape {
            Shape::Mesh(mesh) => {
                !mesh.is_rectangle()
                    && (plane.is_none() || textured || mesh.triangle_count() > FLAT_TRIANGLES)
            }
            _ => false,
        };
        Self {
            extent: Extent {
                area: shape.area(),
                centre: bounds.centre(),
                radius: 0.5 * bounds.diameter(),
                plane,
            },
            divided,
            guides: None,
            shape,
            placed: None,
            whole: None,
        }
    }

    /// A surface in coordinates of its own that is carried along.
    pub fn carried(shape: Shape, textured: bool, placed: Placed) -> Self {
        Self { placed: Some(Box::new(placed)), ..Self::new(shape, textured) }
    }

    /// Makes it the part of a solid that it is in the scene's list of shapes; `carried`: together with the
    /// whole solid.
    pub fn is_part(&mut self, solid: Arc<Solid>, shape: u32, carried: bool) {
        self.whole = Some(Whole { solid, shape, carried });
    }

    fn pose(&self, time: f64) -> Option<Pose> {
        self.placed.as_ref().map(|placed| placed.at(time))
    }

    /// In its own coordinates.
    pub fn area(&self) -> f64 {
        self.extent.area
    }

    /// About its area in the world at a time.
    pub fn world_area(&self, time: f64) -> f64 {
        self.extent.area * self.pose(time).map_or(1.0, |pose| pose.mean_area_ratio())
    }

    /// Whether all of the surface emits.
    pub fn is_whole(&self) -> bool {
        self.whole.is_none()
    }

    /// Whether it is whole, and stays where it is.
    pub fn stands_alone(&self) -> bool {
        self.placed.is_none() && self.is_whole()
    }

    /// A point of it at a time, and its density per unit of area in the world: uniform in its own
    /// coordinates. Only for what is whole.
    pub fn sample(&self, u: [f64; 2], time: f64) -> Option<ShapeSample> {
        let AreaSample { mut surface, triangle, barycentric, mut density } = self.shape.sample(u)?;
        if let Some(placed) = &self.placed {
            let pose = placed.at(time);
            density /= pose.area_ratio(surface.point.normal);
            surface.point = placed.surface_point(&pose, &surface.point, 2.0 * self.extent.radius);
        }
        (self.is_whole() && density > 0.0).then_some(ShapeSample { surface, triangle, barycentric, density })
    }

    /// World over own area around a point with a normal in the world, at a time.
    pub(super) fn area_ratio(&self, normal: Vec3, time: f64) -> f64 {
        let ratio = |pose: Pose| pose.area_ratio(pose.local_normal(normal).normalize_or_zero());
        self.pose(time).map_or(1.0, ratio)
    }

    /// A box around it in the world, from one time to another.
    pub fn bounds(&self, during: [f64; 2]) -> Bounds {
        let own = self.shape.bounds();
        self.placed.as_ref().map_or(own, |placed| placed.bounds(own, during))
    }

    /// A ball around it: its centre and radius.
    pub fn ball(&self, time: f64) -> (Vec3, f64) {
        match &self.placed {
            None => (self.extent.centre, self.extent.radius),
            Some(placed) => {
                let centre = placed.at(time).world_point(self.extent.centre);
                (centre, self.extent.radius * placed.largest_stretch())
            }
        }
    }

    /// How many parts there are that can be chosen apart.
    pub fn parts(&self) -> u32 {
        match &self.shape {
            Shape::Mesh(mesh) if self.divided => mesh.triangle_count() as u32,
            _ => 1,
        }
    }

    /// The part that a triangle belongs to.
    pub fn part_of(&self, triangle: u32) -> u32 {
        if self.divided { triangle } else { 0 }
    }

    /// What is known of a part while the shutter is open. `radiance`: what that of the surface amounts to.
    /// `None` for what has no area.
    pub fn bound(&self, part: u32, radiance: f64, during: [f64; 2]) -> Option<Bound> {
        let (bounds, area, normal) = match &self.shape {
            Shape::Mesh(mesh) if self.divided => {
                let normal = mesh.surface(part, [1.0 / 3.0; 2]).point.normal;
                (Bounds::of(mesh.triangle(part)), mesh.triangle_area(part), Some(normal))
            }
            shape => (shape.bounds(), self.extent.area, self.extent.plane),
        };
        if !(area > 0.0 && area.is_finite()) {
            return None;
        }
        let radiance = radiance * self.guides.as_ref().map_or(1.0, |guides| guides.of(part).brightness);
        let intensity = |area: f64| match normal {
            Some(_) => radiance * area,
            // The mean over the directions from which a convex body is seen.
            None => 0.25 * radiance * area,
        };
        let Some(placed) = &self.placed else {
            return Some(match normal {
                Some(normal) => Bound::flat(bounds, normal, intensity(area)),
                None => Bound::round(bounds, intensity(area)),
            });
        };
        let pose = placed.at(0.5 * (during[0] + during[1]));
        let area = area * pose.mean_area_ratio();
        let bounds = placed.bounds(bounds, during);
        let still = normal.filter(|_| !placed.is_moving());
        Some(match still.and_then(|normal| pose.world_normal(normal).try_normalize()) {
            Some(normal) => Bound::flat(bounds, normal, intensity(area)),
            None => Bound::round(bounds, intensity(area)),
        })
    }

    /// A point on the front of a part, as seen from a place. `None` where the surface shows its back, or
    /// nothing, and where it is cut away.
    pub fn sample_toward(
        &self,
        part: u32,
        from: &SurfacePoint,
        time: f64,
        u: [f64; 2],
    ) -> Option<ShapeSample> {
        let (local, world) = match &self.whole {
            Some(whole) if whole.carried || self.placed.is_none() => (Some(whole), None),
            whole => (None, whole.as_ref()),
        };
        let left = |whole: Option<&Whole>, sample: &ShapeSample| whole.is_none_or(|w| w.shows(sample, time));
        let Some(placed) = &self.placed else {
            return self.sample_local(part, from.position, u).filter(|sample| left(local, sample));
        };
        let pose = placed.at(time);
        let mut sample = self
            .sample_local(part, pose.local_point(from.position), u)
            .filter(|sample| left(local, sample))?;
        let point = placed.surface_point(&pose, &sample.surface.point, 2.0 * self.extent.radius);
        let direction = (point.position - from.position).try_normalize()?;
        sample.surface.point = point;
        sample.density *= pose.solid_angle_ratio(direction);
        left(world, &sample).then_some(sample)
    }

    fn sample_local(&self, part: u32, from: Vec3, u: [f64; 2]) -> Option<ShapeSample> {
        let sample = match (&self.guides, &self.shape) {
            (Some(guides), shape) => guides.of(part).sample(shape, part, u)?.seen_from(from)?,
            (None, Shape::Mesh(mesh)) if self.divided => mesh.sample_triangle(part, u)?.seen_from(from)?,
            (None, shape) => shape.sample_toward(from, u)?,
        };
        let point = sample.surface.point;
        let front = point.normal.dot(from - point.position) > 0.0;
        (front && sample.density > 0.0).then_some(sample)
    }

    /// Where a texture is asked for at a sampled point.
    pub fn texture_point(&self, sample: &ShapeSample, time: f64) -> TexturePoint<'_> {
        let position = sample.surface.point.position;
        let local = self.pose(time).map_or(position, |pose| pose.local_point(position));
        self.texture_place(position, local, sample.triangle, sample.barycentric)
    }

    /// The same at a point in the surface's own coordinates.
    pub(super) fn texture_point_at(&self, sample: &AreaSample, time: f64) -> TexturePoint<'_> {
        let local = sample.surface.point.position;
        let position = self.pose(time).map_or(local, |pose| pose.world_point(local));
        self.texture_place(position, local, sample.triangle, sample.barycentric)
    }

    fn texture_place(
        &self,
        position: Vec3,
        local: Vec3,
        triangle: u32,
        barycentric: [f64; 2],
    ) -> TexturePoint<'_> {
        let hit = Hit { t: 0.0, shape: 0, triangle, instance: NO_INSTANCE, barycentric };
        let mesh = match &self.shape {
            Shape::Mesh(mesh) => Some(MeshPoint { mesh, triangle, barycentric }),
            _ => None,
        };
        let here = self.shape.parametrisation(&hit, local);
        let tangents = [here.tangent, here.bitangent];
        let at_rest = match self.pose(f64::NEG_INFINITY) {
            None => AtRest { position, tangents },
            // As instances have it.
            Some(rest) => AtRest {
                position: rest.world_point(local),
                tangents: tangents.map(|tangent| rest.world_vector(tangent)),
            },
        };
        TexturePoint { uv: here.uv, position, at_rest, mesh }
    }

    /// The density of [`Self::sample_toward`] at a point of the surface, for the part that it belongs to.
    pub fn density_toward(&self, from: &SurfacePoint, light_hit: &LightHit, time: f64) -> f64 {
        let point = &light_hit.point;
        let Some(pose) = self.pose(time) else { return self.density_local(from.position, point, light_hit) };
        let direction = (point.position - from.position).normalize_or_zero();
        let local = SurfacePoint {
            position: pose.local_point(point.position),
            normal: pose.local_normal(point.normal).normalize_or_zero(),
            error: 0.0,
        };
        let density = self.density_local(pose.local_point(from.position), &local, light_hit);
        if density > 0.0 { density * pose.solid_angle_ratio(direction) } else { 0.0 }
    }

    fn density_local(&self, from: Vec3, point: &SurfacePoint, light_hit: &LightHit) -> f64 {
        match (&self.guides, &self.shape) {
            (Some(guides), shape) => {
                let place = shape.chart_place(light_hit.triangle, light_hit.barycentric, point.position);
                let guided = guides.of(self.part_of(light_hit.triangle)).density(place);
                per_steradian(from, point, guided * shape.chart_density(light_hit.triangle, point))
            }
            (None, Shape::Mesh(mesh)) if self.divided => {
                per_steradian(from, point, 1.0 / mesh.triangle_area(light_hit.triangle))
            }
            (None, shape) => shape.density_toward(from, point),
        }
    }

    /// About the solid angle that the front subtends, from a place anywhere. Zero only where it is not seen
    /// at all.
    pub fn estimate(&self, from: &Receiver, time: f64) -> f64 {
        let position = from.point.position;
        let Some(pose) = self.pose(time) else {
            return self.extent.estimates::<f64>(Vector::of(position), Vector::of(from.facing));
        };
        let local = pose.local_point(position);
        let estimate = self.extent.estimates_all_around::<f64>(Vector::of(local));
        match (pose.world_point(self.extent.centre) - position).try_normalize() {
            // The shape's solid angle in its own coordinates, made one of the world's.
            Some(direction) if estimate > 0.0 => estimate / pose.solid_angle_ratio(direction),
            _ => estimate,
        }
    }
}

/// The normal of a surface all of which lies in one plane and faces one way.
fn plane_normal(shape: &Shape) -> Option<Vec3> {
    match shape {
        Shape::Sphere(_)
        | Shape::Cylinder(_)
        | Shape::Quadric(_)
        | Shape::Torus(_)
        | Shape::Grid(_)
        | Shape::Curves(_)
        | Shape::Patches(_)
        | Shape::SweptSphere(_) => None,
        Shape::ProfileOrImplicit(figure) if !figure.is_flat() => None,
        Shape::Disk(_) | Shape::ProfileOrImplicit(_) => {
            shape.sample([0.5; 2]).map(|sample| sample.surface.point.normal)
        }
        Shape::Mesh(mesh) => {
            let normal = shape.sample([0.5; 2])?.surface.point.normal;
            let [origin, ..] = mesh.triangle(0);
            let reach = 1e-6 * shape.bounds().diameter();
            let flat =
                (0..mesh.triangle_count() as u32).filter(|&t| !mesh.is_degenerate(t)).all(|triangle| {
                    let [a, b, c] = mesh.triangle(triangle);
                    let off_plane = [a, b, c].iter().any(|&p| normal.dot(p - origin).abs() > reach);
                    let facing = mesh.surface(triangle, [1.0 / 3.0; 2]).point.normal;
                    !off_plane && facing.dot(normal) > 0.0
                });
            flat.then_some(normal)
        }
    }
}
