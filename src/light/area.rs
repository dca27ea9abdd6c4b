use crate::geometry::{SurfacePoint, Vec3};
use crate::shape::{Hit, NO_INSTANCE, Shape, ShapeSample};
use crate::texture::{MeshPoint, TexturePoint};

/// A surface whose front emits.
#[derive(Clone, Debug)]
pub struct AreaGeometry {
    shape: Shape,
    area: f64,
    /// A sphere around the surface.
    centre: Vec3,
    radius: f64,
    /// The normal of a surface that lies in one plane.
    plane: Option<Vec3>,
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
        }
    }

    pub fn area(&self) -> f64 {
        self.area
    }

    /// A point on the front, as seen from a place. `None` where the surface shows its back, or nothing.
    pub fn sample_toward(&self, from: &SurfacePoint, u: [f64; 2]) -> Option<ShapeSample> {
        let sample = self.shape.sample_toward(from.position, u)?;
        let point = sample.surface.point;
        let front = point.normal.dot(from.position - point.position) > 0.0;
        (front && sample.density > 0.0).then_some(sample)
    }

    /// Where a texture is asked for at a sampled point.
    pub fn texture_point(&self, sample: &ShapeSample) -> TexturePoint<'_> {
        let position = sample.surface.point.position;
        let ShapeSample { triangle, barycentric, .. } = *sample;
        let hit = Hit { t: 0.0, shape: 0, triangle, instance: NO_INSTANCE, barycentric };
        let mesh = match &self.shape {
            Shape::Mesh(mesh) => Some(MeshPoint { mesh, triangle, barycentric }),
            _ => None,
        };
        TexturePoint { uv: self.shape.parametrisation(&hit, position).uv, position, mesh }
    }

    /// The density of [`Self::sample_toward`] at a point of the surface.
    pub fn density_toward(&self, from: &SurfacePoint, point: &SurfacePoint) -> f64 {
        self.shape.density_toward(from.position, point)
    }

    /// About the solid angle that the front subtends, from a place anywhere. Zero only where it is not seen at all.
    pub fn estimate(&self, from: Vec3) -> f64 {
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
        Shape::Sphere(_) | Shape::Cylinder(_) => None,
        Shape::Disk(_) => shape.sample([0.5; 2]).map(|sample| sample.surface.point.normal),
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
