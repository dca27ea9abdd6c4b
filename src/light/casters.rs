//! Bodies that cast caustics, and the directions from a light that lead to them.

use crate::geometry::{Bounds, Frame, SurfacePoint, Vec3, angle};
use crate::sampling::warp;
use crate::shape::Shape;
use smallvec::SmallVec;
use std::f64::consts::{FRAC_1_PI, TAU};

/// Spheres that hold the bodies.
#[derive(Clone, Debug, Default)]
pub struct Casters(Vec<Caster>);

/// A sphere around a body, or around some that are near one another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Caster {
    centre: Vec3,
    radius: f64,
}

impl Caster {
    /// Whatever rounding does, all within the box is within the sphere.
    const RESERVE: f64 = 1.0 + 1e-9;

    pub fn around(bounds: Bounds) -> Self {
        Self { centre: bounds.centre(), radius: 0.5 * bounds.diameter() * Self::RESERVE }
    }

    pub fn of(shape: &Shape) -> Self {
        let around = Self::around(shape.bounds());
        let radius = match shape {
            Shape::Sphere(sphere) => sphere.radius(),
            Shape::Mesh(mesh) => {
                let vertices = (0..mesh.triangle_count() as u32).flat_map(|triangle| mesh.triangle(triangle));
                let squared = vertices.map(|vertex| vertex.distance_squared(around.centre));
                Some(squared.fold(0.0, f64::max).sqrt())
            }
            _ => None,
        };
        Self { radius: radius.map_or(around.radius, |radius| radius * Self::RESERVE), ..around }
    }

    fn bounds(&self) -> Bounds {
        let reach = Vec3::splat(self.radius);
        Bounds { min: self.centre - reach, max: self.centre + reach }
    }
}

/// Up to how many spheres each is looked at from each point of a light.
const MOST: usize = 8;

impl Casters {
    /// Of many bodies those that are near one another share a sphere.
    pub fn new(mut bodies: Vec<Caster>) -> Self {
        let mut spheres = Vec::new();
        gather(&mut bodies, MOST, &mut spheres);
        Self(spheres)
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The directions from a point of a light's front that may lead to one of them. `None` where none does.
    pub fn seen_from(&self, point: &SurfacePoint) -> Option<Aim> {
        let mut cones = SmallVec::new();
        let mut solid_angle = 0.0;
        for &Caster { centre, radius } in &self.0 {
            let away = centre - point.position;
            // Wholly behind the light.
            if away.dot(point.normal) <= -radius {
                continue;
            }
            let squared = away.length_squared();
            let sin2 = radius * radius / squared;
            // Around the light, or so near that it is seen almost everywhere.
            if sin2.is_nan() || sin2 > WIDE {
                return Some(Aim::Everywhere { normal: point.normal });
            }
            // 1 − cos without cancellation.
            let height = sin2 / (1.0 + (1.0 - sin2).sqrt());
            solid_angle += TAU * height;
            cones.push(Cone { axis: away / squared.sqrt(), height });
        }
        (!cones.is_empty()).then_some(Aim::Cones { cones, solid_angle })
    }
}

/// sin² of the angle that a sphere fills to each side, from which on light is sent out everywhere.
const WIDE: f64 = 0.9;

/// Divides bodies among at most so many spheres, halving them across where they are spread most.
fn gather(bodies: &mut [Caster], most: usize, spheres: &mut Vec<Caster>) {
    match bodies {
        [] => {}
        [body] => spheres.push(*body),
        _ if most <= 1 => spheres.push(Caster::around(Bounds::of_all(bodies.iter().map(Caster::bounds)))),
        _ => {
            let extent = Bounds::of(bodies.iter().map(|body| body.centre));
            let size = (extent.max - extent.min).to_array();
            let axis = (0..3).max_by(|&a, &b| size[a].total_cmp(&size[b])).unwrap_or(0);
            bodies.sort_by(|a, b| a.centre[axis].total_cmp(&b.centre[axis]));
            let (low, high) = bodies.split_at_mut(bodies.len() / 2);
            gather(low, most / 2, spheres);
            gather(high, most - most / 2, spheres);
        }
    }
}

/// Directions from a point of a light.
#[derive(Clone, Debug)]
pub enum Aim {
    /// Within the cones in which the bodies are seen; of so many steradians together, counted twice where they overlap.
    Cones { cones: SmallVec<[Cone; 2]>, solid_angle: f64 },
    /// To the side that the normal points to, by the cosine.
    Everywhere { normal: Vec3 },
}

#[derive(Clone, Copy, Debug)]
pub struct Cone {
    axis: Vec3,
    /// 1 − cos of the angle between the axis and the rim.
    height: f64,
}

impl Cone {
    fn holds(&self, direction: Vec3) -> bool {
        // Half the square of the difference is 1 − cos, and keeps its digits.
        0.5 * (self.axis - direction).length_squared() <= self.height
    }

    /// Evenly in solid angle.
    fn sample(&self, u: [f64; 2]) -> Vec3 {
        let below = u[0] * self.height;
        let sin = (below * (2.0 - below)).sqrt();
        let (sin_turn, cos_turn) = angle::sin_cos(TAU * u[1]);
        Frame::around(self.axis).to_world(Vec3::new(sin * cos_turn, sin * sin_turn, 1.0 - below))
    }
}

impl Aim {
    /// A direction and its density per steradian; `choice` in [0, 1) chooses among the cones. `None` where there is no density.
    pub fn sample(&self, choice: f64, u: [f64; 2]) -> Option<(Vec3, f64)> {
        match self {
            Self::Everywhere { normal } => {
                let local = warp::cosine_hemisphere(u);
                let direction = Frame::around(*normal).to_world(local).try_normalize()?;
                (local.z > 0.0).then_some((direction, local.z * FRAC_1_PI))
            }
            Self::Cones { cones, solid_angle } => {
                let mut rest = choice * solid_angle;
                let last = cones.last()?;
                let chosen = cones.iter().find(|cone| {
                    rest -= TAU * cone.height;
                    rest < 0.0
                });
                let direction = chosen.unwrap_or(last).sample(u).try_normalize()?;
                let holding = cones.iter().filter(|cone| cone.holds(direction)).count();
                (holding > 0).then(|| (direction, holding as f64 / solid_angle))
            }
        }
    }
}
