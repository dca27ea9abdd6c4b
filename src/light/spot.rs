//! Spot lights: a point that shines into a cone, as Mitsuba 3's `spot`.

use crate::geometry::{Ray, Transform, Vec3};
use crate::shape::AtRest;
use crate::spectrum::{Sampled, Spectrum};
use crate::texture::{Texture, TexturePoint};
use std::f64::consts::TAU;

/// A point that shines into a cone around its local +z.
#[derive(Clone, Debug)]
pub struct Spot {
    /// Where it stands, in scene units.
    pub position: Vec3,
    /// Radiant intensity along the axis, W·sr⁻¹·nm⁻¹.
    pub intensity: Spectrum,
    from_world: Transform,
    /// Half the angle of the cone beyond which there is no light, radians.
    cutoff: f64,
    /// Half the angle of the cone within which there is no loss, radians.
    beam: f64,
    /// A slide in the beam: a factor on the intensity.
    slide: Option<Texture>,
}

impl Spot {
    /// Angles in radians, between the axis and the edge of the cone.
    pub fn new(to_world: &Transform, intensity: Spectrum, cutoff: f64, beam: f64) -> Self {
        Self {
            position: to_world.point(Vec3::ZERO),
            intensity,
            from_world: to_world.inverse(),
            cutoff,
            beam,
            slide: None,
        }
    }

    /// The spot with a texture in its beam, whose unit square is circumscribed about the cone.
    pub fn with_slide(self, slide: Texture) -> Self {
        Self { slide: Some(slide), ..self }
    }

    /// Radiant intensity in a direction away from the light. From the beam's edge to the cut-off the
    /// intensity falls linearly with the angle.
    pub fn intensity<const C: usize>(&self, direction: Vec3, nm: &[f64; C]) -> Sampled<C> {
        let local = self.from_world.vector(direction).normalize();
        let fraction = self.falloff(local.z);
        if fraction == 0.0 {
            return Sampled::ZERO;
        }
        let intensity = self.intensity.sample(nm) * fraction;
        match &self.slide {
            None => intensity,
            Some(slide) => {
                // Mitsuba 3's mapping, which turns the picture over where the cone is wider than a half
                // space.
                let unit = 0.5 / (local.z * self.cutoff.tan());
                let uv = [0.5 + unit * local.x, 0.5 + unit * local.y];
                let at = TexturePoint { uv, position: self.position, at_rest: AtRest::NONE, mesh: None };
                intensity * slide.sample(&at, nm)
            }
        }
    }

    /// The solid angle that the light fills, about, sr.
    pub fn solid_angle(&self) -> f64 {
        TAU * (1.0 - self.cutoff.cos())
    }

    /// The part of a ray that lies within the cone; all of it where the cone is wider than a half space.
    /// `None` where none does.
    pub fn lit(&self, ray: &Ray) -> Option<[f64; 2]> {
        let cos = self.cutoff.cos();
        if cos <= 0.0 {
            return Some([0.0, ray.t_max]);
        }
        let (origin, direction) = (self.from_world.point(ray.origin), self.from_world.vector(ray.direction));
        // z ≥ 0 and z² ≥ cos² |p|² at p = origin + t · direction.
        let square = cos * cos;
        let quadratic = |p: Vec3, q: Vec3| p.z * q.z - square * p.dot(q);
        let [a, half_b, c] =
            [quadratic(direction, direction), quadratic(origin, direction), quadratic(origin, origin)];
        let within = |t: f64| {
            let p = origin + direction * t;
            p.z >= 0.0 && quadratic(p, p) >= 0.0
        };
        let root = (half_b * half_b - a * c).max(0.0).sqrt();
        let mut ends = [(-half_b - root) / a, (-half_b + root) / a, -c / (2.0 * half_b)];
        if a != 0.0 {
            ends[2] = ends[1];
        }
        ends.sort_by(f64::total_cmp);
        let mut lit: Option<[f64; 2]> = None;
        let mut start = 0.0;
        for end in ends.into_iter().filter(|end| end.is_finite() && *end > 0.0).chain([ray.t_max]) {
            let end = end.min(ray.t_max);
            let middle = if end.is_finite() { 0.5 * (start + end) } else { 2.0 * start + 1.0 };
            // The cone is convex, so the parts within it adjoin.
            if end > start && within(middle) {
                lit = Some([lit.map_or(start, |lit| lit[0]), end]);
            }
            start = end.max(start);
        }
        lit
    }

    fn falloff(&self, cos: f64) -> f64 {
        if cos <= self.cutoff.cos() {
            0.0
        } else if cos >= self.beam.cos() {
            1.0
        } else {
            (self.cutoff - cos.clamp(-1.0, 1.0).acos()) / (self.cutoff - self.beam)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mitsuba 3.9.1, `spot` with cutoff_angle 20 and beam_width 15 (`emitter.sample_direction`), and with a
    /// non-uniform `to_world`.
    #[test]
    fn the_profile_is_mitsubas() {
        let at = |spot: &Spot, degrees: f64| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            spot.intensity(Vec3::new(sin, 0.0, cos), &[550.0]).hero()
        };
        let spot = |cutoff: f64, beam: f64, to_world: &Transform| {
            Spot::new(to_world, Spectrum::ONE, cutoff.to_radians(), beam.to_radians())
        };
        let narrow = spot(20.0, 15.0, &Transform::IDENTITY);
        for (degrees, expected) in [(14.9, 1.0), (15.1, 0.98), (17.0, 0.6), (19.9, 0.02), (20.1, 0.0)] {
            assert!((at(&narrow, degrees) - expected).abs() < 1e-9, "{degrees}: {}", at(&narrow, degrees));
        }
        let wide = spot(170.0, 10.0, &Transform::IDENTITY);
        for (degrees, expected) in [(14.9, 0.96937), (91.0, 0.49375), (120.0, 0.3125), (170.0, 0.0)] {
            assert!((at(&wide, degrees) - expected).abs() < 1e-5, "{degrees}: {}", at(&wide, degrees));
        }
        let tall = Transform::new(glam::DMat4::from_scale(Vec3::new(1.0, 1.0, 3.0))).unwrap();
        assert_eq!([5.0, 10.0].map(|degrees| at(&spot(20.0, 15.0, &tall), degrees)), [1.0, 0.0]);
    }
}
