use crate::geometry::{Bounds, Placed, Pose, SurfacePoint, Vec3};
use crate::shape::solid::Solid;
use crate::shape::{AreaSample, AtRest, Hit, NO_INSTANCE, Shape, ShapeSample};
use crate::texture::{MeshPoint, TexturePoint};
use std::sync::Arc;

/// A surface whose front emits.
#[derive(Clone, Debug)]
pub struct AreaGeometry {
    /// In coordinates of its own where it is placed, else in the world's.
    shape: Shape,
    placed: Option<Box<Placed>>,
    /// What it is a part of.
    whole: Option<Whole>,
    area: f64,
    /// A sphere around the surface.
    centre: Vec3,
    radius: f64,
    /// The normal of a surface that lies in one plane. This, centre and radius are in the coordinates of the shape.
    plane: Option<Vec3>,
}

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
    pub fn new(shape: Shape) -> Self {
        let bounds = shape.bounds();
        Self {
            area: shape.area(),
            centre: bounds.centre(),
            radius: 0.5 * bounds.diameter(),
            plane: plane_normal(&shape),
            shape,
            placed: None,
            whole: None,
        }
    }

    /// A surface in coordinates of its own that is carried along.
    pub fn carried(shape: Shape, placed: Placed) -> Self {
        Self { placed: Some(Box::new(placed)), ..Self::new(shape) }
    }

    /// Makes it the part of a solid that it is in the scene's list of shapes; `carried`: together with the whole solid.
    pub fn is_part(&mut self, solid: Arc<Solid>, shape: u32, carried: bool) {
        self.whole = Some(Whole { solid, shape, carried });
    }

    fn pose(&self, time: f64) -> Option<Pose> {
        self.placed.as_ref().map(|placed| placed.at(time))
    }

    /// In its own coordinates.
    pub fn area(&self) -> f64 {
        self.area
    }

    /// Whether all of the surface emits, and stays where it is.
    pub fn stands_alone(&self) -> bool {
        self.placed.is_none() && self.whole.is_none()
    }

    /// A point of it, uniform in area, which its density is per unit of. Only for what stands alone.
    pub fn sample(&self, u: [f64; 2]) -> Option<ShapeSample> {
        let AreaSample { surface, triangle, barycentric, density } = self.shape.sample(u)?;
        (self.stands_alone() && density > 0.0).then_some(ShapeSample {
            surface,
            triangle,
            barycentric,
            density,
        })
    }

    /// In its own coordinates.
    pub fn bounds(&self) -> Bounds {
        self.shape.bounds()
    }

    /// A point on the front, as seen from a place. `None` where the surface shows its back, or nothing, and where it is cut away.
    pub fn sample_toward(&self, from: &SurfacePoint, time: f64, u: [f64; 2]) -> Option<ShapeSample> {
        let (local, world) = match &self.whole {
            Some(whole) if whole.carried || self.placed.is_none() => (Some(whole), None),
            whole => (None, whole.as_ref()),
        };
        let left = |whole: Option<&Whole>, sample: &ShapeSample| whole.is_none_or(|w| w.shows(sample, time));
        let Some(placed) = &self.placed else {
            return self.sample_local(from.position, u).filter(|sample| left(local, sample));
        };
        let pose = placed.at(time);
        let mut sample =
            self.sample_local(pose.local_point(from.position), u).filter(|sample| left(local, sample))?;
        let point = placed.surface_point(&pose, &sample.surface.point, 2.0 * self.radius);
        let direction = (point.position - from.position).try_normalize()?;
        sample.surface.point = point;
        sample.density *= pose.solid_angle_ratio(direction);
        left(world, &sample).then_some(sample)
    }

    fn sample_local(&self, from: Vec3, u: [f64; 2]) -> Option<ShapeSample> {
        let sample = self.shape.sample_toward(from, u)?;
        let point = sample.surface.point;
        let front = point.normal.dot(from - point.position) > 0.0;
        (front && sample.density > 0.0).then_some(sample)
    }

    /// Where a texture is asked for at a sampled point.
    pub fn texture_point(&self, sample: &ShapeSample, time: f64) -> TexturePoint<'_> {
        let position = sample.surface.point.position;
        let local = self.pose(time).map_or(position, |pose| pose.local_point(position));
        let ShapeSample { triangle, barycentric, .. } = *sample;
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

    /// The density of [`Self::sample_toward`] at a point of the surface.
    pub fn density_toward(&self, from: &SurfacePoint, point: &SurfacePoint, time: f64) -> f64 {
        let Some(pose) = self.pose(time) else { return self.shape.density_toward(from.position, point) };
        let direction = (point.position - from.position).normalize_or_zero();
        let local = SurfacePoint {
            position: pose.local_point(point.position),
            normal: pose.local_normal(point.normal).normalize_or_zero(),
            error: 0.0,
        };
        let density = self.shape.density_toward(pose.local_point(from.position), &local);
        if density > 0.0 { density * pose.solid_angle_ratio(direction) } else { 0.0 }
    }

    /// About the solid angle that the front subtends, from a place anywhere. Zero only where it is not seen at all.
    pub fn estimate(&self, from: Vec3, time: f64) -> f64 {
        let Some(pose) = self.pose(time) else { return self.estimate_local(from) };
        let estimate = self.estimate_local(pose.local_point(from));
        match (pose.world_point(self.centre) - from).try_normalize() {
            // The shape's solid angle in its own coordinates, made one of the world's.
            Some(direction) if estimate > 0.0 => estimate / pose.solid_angle_ratio(direction),
            _ => estimate,
        }
    }

    fn estimate_local(&self, from: Vec3) -> f64 {
        let squared = from.distance_squared(self.centre) + self.radius * self.radius;
        let cos = match self.plane {
            Some(normal) => {
                let height = normal.dot(from - self.centre);
                if height <= 0.0 {
                    return 0.0;
                }
                // A wide light seen at a slant has parts that are seen less so.
                (height / squared.sqrt()).max(0.1)
            }
            // The mean over the directions from which a convex body is seen.
            None => 0.25,
        };
        self.area * cos / squared
    }
}

/// The normal of a surface all of which lies in one plane and faces one way.
fn plane_normal(shape: &Shape) -> Option<Vec3> {
    match shape {
        Shape::Sphere(_)
        | Shape::Cylinder(_)
        | Shape::Quadric(_)
        | Shape::Torus(_)
        | Shape::Sampled(_)
        | Shape::Curves(_)
        | Shape::Patches(_)
        | Shape::SweptSphere(_) => None,
        Shape::Figure(figure) if !figure.is_flat() => None,
        Shape::Disk(_) | Shape::Figure(_) => shape.sample([0.5; 2]).map(|sample| sample.surface.point.normal),
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
