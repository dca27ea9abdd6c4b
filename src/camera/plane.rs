//! A film that stands in the scene by itself: what images on it is the scene's own glass.

use crate::geometry::{Bounds, Placed, Ray, Vec3};
use crate::sampling::warp;
use std::f64::consts::PI;

/// Measures, point by point, the irradiance on a plane by light that comes through a round stop before it,
/// W·m⁻²·nm⁻¹:
///
/// E = ∫ L cos θ dω over the stop = ∫ L cos² θ / d² dA, with the distance d = z / cos θ to its points (Born
/// and Wolf, *Principles of Optics*, sec. 4.8).
///
/// The film lies in the local plane z = 0 and faces +z; as for any camera, its pictures' left is local +x and
/// their top +y. A lens before it turns the image by half a turn, as in any real camera.
#[derive(Clone, Debug)]
pub struct SensorPlane {
    placed: Placed,
    /// Width and height of the whole film in pixels.
    film: [f64; 2],
    /// Size of a pixel in scene units.
    pixel: f64,
    stop: Stop,
}

/// A round opening across the sensor's axis. Scene units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// Radius, in scene units. Above 0.
    pub radius: f64,
    /// Distance from the film.
    pub distance: f64,
}

impl SensorPlane {
    /// `placed` by a rigid map or a mirror image of one; `width` is that of the whole film.
    pub fn new(placed: Placed, film: [f64; 2], width: f64, stop: Stop) -> Self {
        Self { placed, film, pixel: width / film[0], stop }
    }

    /// Whether the film moves while the shutter is open.
    pub fn is_moving(&self) -> bool {
        self.placed.is_moving()
    }

    /// A box around where its rays begin, from one time to another, also of those a film's width beyond its
    /// border.
    pub fn origins(&self, during: [f64; 2]) -> Bounds {
        let [x, y] = self.film.map(|pixels| 1.5 * pixels * self.pixel);
        let corner = Vec3::new(x, y, 0.0);
        self.placed.bounds(Bounds { min: -corner, max: corner }, during)
    }

    /// The ray from a film position (pixels from the top left corner) toward the point of the stop that
    /// `stop_u` chooses, evenly over its area, and its weight: what a radiance of 1 along it adds to the
    /// irradiance.
    pub fn ray(&self, film: [f64; 2], stop_u: [f64; 2], time: f64) -> (Ray, f64) {
        let at = |i: usize| (0.5 * self.film[i] - film[i]) * self.pixel;
        let from = Vec3::new(at(0), at(1), 0.0);
        let [x, y] = warp::disk(stop_u).map(|c| c * self.stop.radius);
        let toward = Vec3::new(x, y, self.stop.distance) - from;
        let squared = toward.length_squared();
        let cos_squared = self.stop.distance * self.stop.distance / squared;
        let area = PI * self.stop.radius * self.stop.radius;
        let pose = self.placed.at(time);
        let direction = pose.world_vector(toward).normalize();
        (Ray::new(pose.world_point(from), direction), area * cos_squared / squared)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Transform;
    use crate::sampling::quadrature::midpoints;

    /// A sky of radiance 1 over the disk: E = π/2 (1 − (z² + ρ² − r²) / √((z² + ρ² + r²)² − 4 ρ² r²)) at the
    /// distance ρ from the axis (Howell, *A Catalog of Radiation Heat Transfer Configuration Factors*, B-13).
    #[test]
    fn weights_add_up_to_the_view_of_the_stop() {
        let placed = Placed::still(&Transform::translation(Vec3::new(7.0, -2.0, 1e3))).unwrap();
        for (radius, distance) in [(0.5, 2.0), (3.0, 1.0), (0.01, 0.3)] {
            let plane = SensorPlane::new(placed.clone(), [40.0, 20.0], 4.0, Stop { radius, distance });
            for film in [[20.0, 10.0], [0.0, 0.0], [31.0, 13.0]] {
                const N: usize = 400;
                let mean = midpoints(N).map(|u| plane.ray(film, u, 0.0).1).sum::<f64>() / (N * N) as f64;
                let off_axis = (0.1 * (film[0] - 20.0_f64)).hypot(0.1 * (film[1] - 10.0));
                let (z, rho, r) = (distance * distance, off_axis * off_axis, radius * radius);
                let expected =
                    0.5 * PI * (1.0 - (z + rho - r) / ((z + rho + r).powi(2) - 4.0 * rho * r).sqrt());
                assert!(
                    (mean / expected - 1.0).abs() < 1e-4,
                    "{radius} {distance} {film:?}: {mean} {expected}"
                );
            }
        }
    }

    #[test]
    fn rays_lead_from_the_film_through_the_stop() {
        let placed = Placed::still(&Transform::IDENTITY).unwrap();
        let stop = Stop { radius: 0.2, distance: 3.0 };
        let plane = SensorPlane::new(placed, [40.0, 20.0], 4.0, stop);
        let (ray, _) = plane.ray([10.0, 5.0], [0.5, 0.5], 0.0);
        assert!((ray.origin - Vec3::new(1.0, 0.5, 0.0)).length() < 1e-12, "{}", ray.origin);
        assert!((ray.at(3.0 / ray.direction.z) - Vec3::Z * 3.0).length() < 1e-12);
    }
}
