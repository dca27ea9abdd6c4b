//! Distances along a ray at which lamps are near.
//!
//! A lamp at the distance D from a ray, and nearest to it at t = n, lights a place of the ray by
//! 1 / (D² + (t − n)²). Distances with a density proportional to that are at equal angles as seen from the
//! lamp (Kulla and Fajardo, "Importance Sampling Techniques for Path Tracing in Participating Media",
//! Computer Graphics Forum 31(4), 2012). Of several lamps each has a share of the samples, by what all of the
//! ray gets from it. Only those distances count that the cone of a spot light holds.

use super::{Light, Lights};
use crate::geometry::{Ray, Vec3};
use crate::spectrum::Wavelengths;
use smallvec::SmallVec;

/// A scene with more lamps than this aims at none: the sum over all of them would be in each density.
const MOST: usize = 8;

/// Lamps that light a ray.
#[derive(Clone, Debug)]
pub struct Aim {
    lamps: SmallVec<[Lamp; 2]>,
}

/// A lamp beside a ray.
#[derive(Clone, Copy, Debug)]
struct Lamp {
    /// Intensity, up to a factor common to all; then the share of the samples.
    share: f64,
    /// Where along the ray it is nearest, and how far away it is there.
    nearest: f64,
    distance: f64,
    /// The part of the ray that it lights.
    lit: [f64; 2],
    /// The angles of the ends of that part, as seen from the lamp.
    angles: [f64; 2],
}

/// Where a lamp stands, and the radius of a ball around it.
struct NearLamp {
    centre: Vec3,
    radius: f64,
    intensity: f64,
    lit: [f64; 2],
}

impl Lights {
    /// Whether [`Self::aim`] may find anything.
    pub fn can_aim(&self) -> bool {
        let lamps = self.lights.iter().filter(|light| !matches!(light, Light::Directional { .. }));
        (1..=MOST).contains(&lamps.count())
    }

    /// The lamps that are no farther from a ray than a quarter of `reach`, and near some of it that is no
    /// farther than that from its beginning. `None` where there is no such lamp. All wavelengths of the path
    /// count alike.
    pub fn aim<const C: usize>(
        &self,
        ray: &Ray,
        time: f64,
        wavelengths: &Wavelengths<C>,
        reach: f64,
    ) -> Option<Aim> {
        let mut lamps = SmallVec::new();
        for light in 0..self.lights.len() {
            let Some(NearLamp { centre, radius, intensity, lit }) =
                self.near_lamp(light, ray, time, wavelengths)
            else {
                continue;
            };
            let toward = centre - ray.origin;
            let nearest = toward.dot(ray.direction);
            // A lamp that has a size lights what is within it no brighter than its surface.
            let distance = ((toward - ray.direction * nearest).length_squared() + radius * radius).sqrt();
            let near = 4.0 * distance <= reach && -distance <= nearest && nearest - distance <= reach;
            // On the line of the ray itself no distance is likelier than another by a factor that is known.
            if near && distance > 1e-9 * nearest.abs() && intensity > 0.0 && intensity.is_finite() {
                lamps.push(Lamp { share: intensity, nearest, distance, lit, angles: [0.0; 2] });
            }
        }
        (!lamps.is_empty()).then_some(Aim { lamps })
    }

    /// In the coordinates of the scene, but for the part of the ray, which no coordinates change.
    fn near_lamp<const C: usize>(
        &self,
        light: usize,
        ray: &Ray,
        time: f64,
        wavelengths: &Wavelengths<C>,
    ) -> Option<NearLamp> {
        let whole = [0.0, f64::INFINITY];
        let nm = &wavelengths.nm;
        let (centre, radius, intensity, lit) = match &self.lights[light] {
            Light::Area { geometry, mean, .. } => {
                let (centre, radius) = geometry.ball(time);
                (centre, radius, geometry.world_area(time) * mean.sample(nm).sum(), whole)
            }
            Light::Spot(spot) => {
                let local = match self.placed(light).map(|placed| placed.at(time)) {
                    None => *ray,
                    Some(pose) => Ray {
                        origin: pose.local_point(ray.origin),
                        direction: pose.local_vector(ray.direction),
                        ..*ray
                    },
                };
                (self.place(light, time)?, 0.0, spot.intensity.sample(nm).sum(), spot.lit(&local)?)
            }
            other => (self.place(light, time)?, 0.0, other.spectrum().sample(nm).sum(), whole),
        };
        Some(NearLamp { centre, radius, intensity, lit })
    }
}

impl Aim {
    /// The same for a ray that ends at a distance. `None` where no lamp lights what is before it.
    pub fn within(mut self, end: f64) -> Option<Self> {
        let mut sum = 0.0;
        self.lamps.retain(|lamp| {
            lamp.lit[1] = lamp.lit[1].min(end);
            lamp.angles = lamp.lit.map(|t| ((t - lamp.nearest) / lamp.distance).atan());
            let lit = lamp.lit[0] < lamp.lit[1] && lamp.angles[0] < lamp.angles[1];
            lamp.share *= (lamp.angles[1] - lamp.angles[0]) / lamp.distance;
            sum += if lit { lamp.share } else { 0.0 };
            lit
        });
        self.lamps.iter_mut().for_each(|lamp| lamp.share /= sum);
        (sum > 0.0 && sum.is_finite()).then_some(self)
    }

    /// A distance by a sample value. Only after [`Self::within`].
    pub fn sample(&self, mut u: f64) -> f64 {
        let mut chosen = self.lamps[0];
        for lamp in &self.lamps {
            chosen = *lamp;
            if u < lamp.share {
                break;
            }
            u -= lamp.share;
        }
        let [low, high] = chosen.angles;
        let angle = low + (high - low) * (u / chosen.share).clamp(0.0, 1.0);
        (chosen.nearest + chosen.distance * angle.tan()).clamp(chosen.lit[0], chosen.lit[1])
    }

    /// Density of a distance, per unit of length. Only after [`Self::within`].
    pub fn density(&self, t: f64) -> f64 {
        let of = |lamp: &Lamp| {
            let [start, end] = lamp.lit;
            if t < start || t > end {
                return 0.0;
            }
            let [low, high] = lamp.angles;
            let along = (t - lamp.nearest) / lamp.distance;
            lamp.share / ((high - low) * lamp.distance * (1.0 + along * along))
        };
        self.lamps.iter().map(of).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Transform;
    use crate::light::{Setting, Spot};
    use crate::spectrum::{Spectrum, WavelengthDensity};
    use crate::units::WavelengthRange;
    use glam::DMat4;

    fn lights(lights: Vec<Light>) -> (Lights, Wavelengths<1>) {
        let density = WavelengthDensity::new(WavelengthRange::VISIBLE, &[], &[]);
        let setting = Setting { during: [0.0, 1.0], density: &density };
        (Lights::new(lights, None, Vec::new(), &setting), density.sample(0.5))
    }

    fn point(x: f64, y: f64, z: f64, intensity: f64) -> Light {
        Light::Point { position: Vec3::new(x, y, z), intensity: Spectrum::Constant(intensity) }
    }

    fn spot(origin: Vec3, target: Vec3, cutoff: f64) -> Spot {
        let z = (target - origin).normalize();
        let x = z.any_orthonormal_vector();
        let axes = [x, z.cross(x), z].map(|axis| axis.extend(0.0));
        let to_world =
            Transform::new(DMat4::from_cols(axes[0], axes[1], axes[2], origin.extend(1.0))).unwrap();
        Spot::new(&to_world, Spectrum::ONE, cutoff.to_radians(), 0.5 * cutoff.to_radians())
    }

    fn aim(of: Vec<Light>, end: f64) -> Option<Aim> {
        let (lights, wavelengths) = lights(of);
        lights.aim(&Ray::new(Vec3::ZERO, Vec3::Z), 0.0, &wavelengths, f64::INFINITY)?.within(end)
    }

    /// The share of the samples before a distance is the integral of the density up to there.
    #[test]
    fn distances_follow_their_density() {
        let spot = Light::Spot(Box::new(spot(Vec3::new(2.0, 0.0, 1.0), Vec3::new(0.0, 0.0, 2.0), 20.0)));
        for lamps in [
            vec![point(0.1, 0.2, 2.0, 1.0)],
            vec![point(0.5, 0.0, 1.0, 2.0), point(0.0, 1.0, -0.5, 1.0), spot],
        ] {
            for end in [0.7, 4.0] {
                const SAMPLES: usize = 20_000;
                let aim = aim(lamps.clone(), end).unwrap();
                let drawn: Vec<f64> =
                    (0..SAMPLES).map(|i| aim.sample((i as f64 + 0.5) / SAMPLES as f64)).collect();
                assert!(drawn.iter().all(|t| (0.0..=end).contains(t) && aim.density(*t) > 0.0));
                let step = end / 1e5;
                let mut integral = 0.0;
                for i in 0..100_000 {
                    integral += step * aim.density((f64::from(i) + 0.5) * step);
                    if i % 9999 == 0 {
                        let before = drawn.iter().filter(|&&t| t < (f64::from(i) + 1.0) * step).count();
                        let share = before as f64 / SAMPLES as f64;
                        assert!((share - integral).abs() < 1e-3, "{share} before, by the density {integral}");
                    }
                }
                assert!((integral - 1.0).abs() < 1e-3, "{integral}");
            }
        }
    }

    #[test]
    fn lamps_far_from_a_ray_are_left_out() {
        let (lights, wavelengths) = lights(vec![point(0.0, 3.0, 2.0, 1.0)]);
        let ray = Ray::new(Vec3::ZERO, Vec3::Z);
        let found = |ray: &Ray, reach: f64| lights.aim(ray, 0.0, &wavelengths, reach).is_some();
        assert!(found(&ray, 12.1) && !found(&ray, 11.9));
        // Behind its beginning, and beyond what is reached.
        let from = |z: f64| Ray::new(Vec3::Z * z, Vec3::Z);
        assert!(!found(&from(6.0), 40.0) && !found(&from(-19.0), 12.1) && found(&from(-9.0), 12.1));
    }

    /// Outside of it the intensity is 0, just inside it is not.
    #[test]
    fn the_lit_part_is_that_within_the_cone() {
        let mut found = 0;
        for (i, cutoff) in (0..300).zip([15.0, 60.0, 90.0, 120.0].into_iter().cycle()) {
            let number = |k: i32| (f64::from(i * 7 + k) * 0.618_034).fract() * 4.0 - 2.0;
            let spot = spot(
                Vec3::new(number(1), number(2), number(3)),
                Vec3::new(number(4), number(5), 0.3),
                cutoff,
            );
            let direction = Vec3::new(number(6), number(7), 1.1).normalize();
            let ray = Ray::new(Vec3::new(number(8), number(9), number(10)), direction);
            let lit = spot.lit(&ray);
            found += usize::from(lit.is_some());
            for step in 0..400 {
                let t = f64::from(step) * 0.025;
                let within = lit.is_some_and(|[start, end]| (start..=end).contains(&t));
                let shines = !spot.intensity((ray.at(t) - spot.position).normalize(), &[550.0]).is_zero();
                assert!(within || !shines, "{cutoff}: {t} is lit, not in {lit:?}");
                // A wide cone may leave out the middle of a ray.
                let at_end = lit.is_some_and(|lit| lit.iter().any(|end| (end - t).abs() < 1e-6));
                assert!(!within || shines || at_end || cutoff > 90.0, "{cutoff}: {t} is dark, in {lit:?}");
            }
        }
        assert!(found > 100, "{found}");
    }
}
