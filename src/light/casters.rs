//! Bodies that cast caustics, and the rays of a light that lead to them.

use crate::geometry::{Bounds, Frame, Ray, SurfacePoint, Vec3, angle};
use crate::sampling::warp;
use crate::shape::Shape;
use smallvec::SmallVec;
use std::f64::consts::{FRAC_1_PI, PI, TAU};

/// Bodies that cast caustics, by what they send on.
#[derive(Clone, Debug, Default)]
pub struct CastersByKind {
    /// All that meets them, in single directions: smooth metal and glass.
    pub bodies: Vec<Caster>,
    /// The mirror reflection of a smooth coat.
    pub coats: Vec<Caster>,
    /// All that meets them, in narrow lobes: polished metal.
    pub polished: Vec<Caster>,
}

/// Spheres that hold the bodies, by their kinds.
#[derive(Clone, Debug)]
pub struct Casters(Kinds<Spheres>);

/// What there is of each kind, with the probability of aiming at it.
type Kinds<T> = SmallVec<[(f64, T); 3]>;

/// The spheres of bodies of one kind, at least one.
#[derive(Clone, Debug)]
struct Spheres(Vec<Caster>);

/// A sphere around a body, or around some that are near one another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Caster {
    centre: Vec3,
    radius: f64,
}

impl Caster {
    /// Whatever rounding does, all within the box is within the sphere.
    const RESERVE: f64 = 1.0 + 1e-9;

    /// The sphere around a box.
    pub fn around(bounds: Bounds) -> Self {
        Self { centre: bounds.centre(), radius: 0.5 * bounds.diameter() * Self::RESERVE }
    }

    /// The smallest sphere known to hold what is left of a shape within a box.
    pub fn of(shape: &Shape, left: Bounds) -> Self {
        let around = Self::around(left);
        if !left.contains(shape.bounds()) {
            return around;
        }
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

    /// The sphere's.
    pub fn centre(&self) -> Vec3 {
        self.centre
    }

    /// As seen from afar.
    fn cross_section(&self) -> f64 {
        PI * self.radius * self.radius
    }

    fn bounds(&self) -> Bounds {
        let reach = Vec3::splat(self.radius);
        Bounds { min: self.centre - reach, max: self.centre + reach }
    }
}

/// Up to how many spheres of each kind are looked at from each point of a light.
const MOST: usize = 8;

/// How many light subpaths aim at smooth bodies, at coats and at polished metals, as one to another. Coats
/// reflect some 4 %, and are often large, as that of a floor is. What polished metals cast is less bright.
const TOWARD: [f64; 3] = [3.0, 1.0, 1.0];

impl Casters {
    /// Neighbours among many of a kind share a sphere.
    pub fn new(CastersByKind { bodies, coats, polished }: CastersByKind) -> Self {
        let gathered = |mut bodies: Vec<Caster>| {
            let mut spheres = Vec::new();
            gather(&mut bodies, MOST, &mut spheres);
            (!spheres.is_empty()).then_some(Spheres(spheres))
        };
        let all = TOWARD.into_iter().zip([bodies, coats, polished]);
        Self(kinds(all.filter_map(|(weight, bodies)| Some((weight, gathered(bodies)?)))))
    }

    /// Whether there is nothing to aim at.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The directions from a point of a light's front that may lead to one of them. `None` where none does.
    pub fn seen_from(&self, point: &SurfacePoint) -> Option<TowardCasters> {
        let seen = self.0.iter().filter_map(|(probability, of)| Some((*probability, of.seen_from(point)?)));
        let seen = kinds(seen);
        (!seen.is_empty()).then_some(TowardCasters(seen))
    }

    /// The area of all spheres as they are seen from afar, in squared scene units, counted twice where they
    /// overlap: the mean over the kinds.
    pub fn cross_section(&self) -> f64 {
        self.0.iter().map(|(probability, of)| probability * of.cross_section()).sum()
    }

    /// The solid angle that the spheres fill for a point, but at most a hemisphere's cosine-weighed one: the
    /// mean over the kinds.
    pub fn solid_angle_from(&self, point: Vec3) -> f64 {
        self.0.iter().map(|(probability, of)| probability * of.solid_angle_from(point)).sum()
    }

    /// A ray from beyond a sphere that holds the scene, along a direction (unit length), that may lead to one
    /// of the bodies, with its density per area across the ray. `choice` in [0, 1) chooses among the bodies.
    /// `None` where there is no density.
    pub fn ray_along(
        &self,
        direction: Vec3,
        scene: &Caster,
        mut choice: f64,
        u: [f64; 2],
    ) -> Option<(Ray, f64)> {
        let (_, Spheres(spheres)) = chosen(&self.0, |(probability, _)| *probability, &mut choice)?;
        let &Caster { centre, radius } = chosen(spheres, Caster::cross_section, &mut choice)?;
        let [x, y] = warp::disk(u);
        let place = centre + Frame::around(direction).to_world(Vec3::new(x, y, 0.0) * radius);
        let back = (place - scene.centre).dot(direction) + scene.radius;
        let density = self.density_along(direction, place);
        (density > 0.0).then(|| (Ray::new(place - direction * back, direction), density))
    }

    /// The density of [`Self::ray_along`] for a ray through a place.
    pub fn density_along(&self, direction: Vec3, place: Vec3) -> f64 {
        self.0.iter().map(|(probability, of)| probability * of.density_along(direction, place)).sum()
    }
}

/// Those that there are, with weights that become probabilities.
fn kinds<T>(of: impl Iterator<Item = (f64, T)>) -> Kinds<T> {
    let mut kinds: Kinds<T> = of.collect();
    let all: f64 = kinds.iter().map(|(weight, _)| weight).sum();
    for (weight, _) in &mut kinds {
        *weight /= all;
    }
    kinds
}

/// One of some, by their weights; what is left of the choice is as good as new.
fn chosen<'a, T>(of: &'a [T], weight: impl Fn(&T) -> f64, choice: &mut f64) -> Option<&'a T> {
    let mut rest = *choice * of.iter().map(&weight).sum::<f64>();
    let reached = |one: &&T| {
        let is_reached = rest < weight(one);
        if !is_reached {
            rest -= weight(one);
        }
        is_reached
    };
    let chosen = of.iter().find(reached).or(of.last())?;
    *choice = rest / weight(chosen);
    Some(chosen)
}

impl Spheres {
    /// The directions from a point of a light's front that may lead to one of them. `None` where none does.
    fn seen_from(&self, point: &SurfacePoint) -> Option<Toward> {
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
                return Some(Toward::Everywhere { normal: point.normal });
            }
            // 1 − cos without cancellation.
            let height = sin2 / (1.0 + (1.0 - sin2).sqrt());
            solid_angle += TAU * height;
            cones.push(Cone { axis: away / squared.sqrt(), height });
        }
        (!cones.is_empty()).then_some(Toward::Cones { cones, solid_angle })
    }

    fn cross_section(&self) -> f64 {
        self.0.iter().map(Caster::cross_section).sum()
    }

    fn solid_angle_from(&self, point: Vec3) -> f64 {
        let of = |caster: &Caster| caster.cross_section() / caster.centre.distance_squared(point);
        self.0.iter().map(of).sum::<f64>().min(PI)
    }

    fn density_along(&self, direction: Vec3, place: Vec3) -> f64 {
        let meets = |caster: &&Caster| {
            let toward = place - caster.centre;
            let across = toward - direction * toward.dot(direction);
            across.length_squared() <= caster.radius * caster.radius
        };
        self.0.iter().filter(meets).count() as f64 / self.cross_section()
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

/// Directions from a point of a light: toward bodies of each kind, with the probability of that.
#[derive(Clone, Debug)]
pub struct TowardCasters(Kinds<Toward>);

/// Directions from a point of a light toward bodies of one kind.
#[derive(Clone, Debug)]
enum Toward {
    /// Within the cones in which the bodies are seen; of so many steradians together, counted twice where
    /// they overlap.
    Cones { cones: SmallVec<[Cone; 2]>, solid_angle: f64 },
    /// Cosine-weighed directions to the side of the normal.
    Everywhere { normal: Vec3 },
}

#[derive(Clone, Copy, Debug)]
struct Cone {
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

impl TowardCasters {
    /// A direction and its density per steradian; `choice` in [0, 1) chooses among the bodies. `None` where
    /// there is no density.
    pub fn sample(&self, mut choice: f64, u: [f64; 2]) -> Option<(Vec3, f64)> {
        let (_, toward) = chosen(&self.0, |(probability, _)| *probability, &mut choice)?;
        let direction = toward.sample(&mut choice, u)?.try_normalize()?;
        let density = self.density(direction);
        (density > 0.0).then_some((direction, density))
    }

    /// The density of [`Self::sample`] in a direction, per steradian.
    pub fn density(&self, direction: Vec3) -> f64 {
        self.0.iter().map(|(probability, toward)| probability * toward.density(direction)).sum()
    }
}

impl Toward {
    fn sample(&self, choice: &mut f64, u: [f64; 2]) -> Option<Vec3> {
        match self {
            Self::Everywhere { normal } => {
                Some(Frame::around(*normal).to_world(Vec3::from(warp::cosine_hemisphere(u))))
            }
            Self::Cones { cones, .. } => Some(chosen(cones, |cone| TAU * cone.height, choice)?.sample(u)),
        }
    }

    fn density(&self, direction: Vec3) -> f64 {
        match self {
            Self::Everywhere { normal } => direction.dot(*normal).max(0.0) * FRAC_1_PI,
            Self::Cones { cones, solid_angle } => {
                cones.iter().filter(|cone| cone.holds(direction)).count() as f64 / solid_angle
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::quadrature::midpoints;
    use crate::stats::chi_square;
    use rand::Rng;
    use rand_pcg::Pcg64Mcg;

    const NONE: CastersByKind = CastersByKind { bodies: Vec::new(), coats: Vec::new(), polished: Vec::new() };

    fn at(x: f64, y: f64, z: f64, radius: f64) -> Caster {
        Caster { centre: Vec3::new(x, y, z), radius }
    }

    fn point(normal: Vec3) -> SurfacePoint {
        SurfacePoint { position: Vec3::ZERO, normal, error: 0.0 }
    }

    /// The mean of one over the density is the solid angle that is covered, and a cone is filled evenly from
    /// its axis to its rim.
    #[test]
    fn directions_follow_their_density() {
        const DIRECTIONS: usize = 200_000;
        const RINGS: usize = 16;
        let one = vec![at(1.0, 0.5, 2.0, 0.8)];
        let overlapping = vec![at(1.0, 0.5, 2.0, 0.8), at(0.5, 0.5, 2.0, 0.9), at(0.0, -3.0, 1.0, 0.3)];
        let coats = vec![at(0.5, 0.0, 2.0, 1.2), at(-1.0, -3.0, 1.0, 0.3)];
        for (bodies, coats) in [(one, vec![]), (overlapping.clone(), vec![]), (overlapping, coats)] {
            let aim =
                Casters::new(CastersByKind { bodies, coats, ..NONE }).seen_from(&point(Vec3::Z)).unwrap();
            let of_kind = |(_, toward): &(f64, Toward)| match toward {
                Toward::Cones { cones, .. } => cones.clone(),
                Toward::Everywhere { .. } => panic!("{aim:?}"),
            };
            let cones: Vec<Cone> = aim.0.iter().flat_map(of_kind).collect();
            let mut generator = Pcg64Mcg::new(cones.len() as u128);
            let mut next = || (generator.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
            let (mut sum, mut squares) = (0.0, 0.0);
            let mut rings = vec![0.0; RINGS];
            for _ in 0..DIRECTIONS {
                let (direction, density) = aim.sample(next(), [next(), next()]).unwrap();
                sum += 1.0 / density;
                squares += 1.0 / (density * density);
                let fraction = 0.5 * (direction - cones[0].axis).length_squared() / cones[0].height;
                if let Some(count) = rings.get_mut((fraction * RINGS as f64) as usize) {
                    *count += 1.0;
                }
            }
            // By a grid of equal solid angles.
            const FINE: usize = 2000;
            let covered = midpoints(FINE).filter(|[u, v]| {
                let z = v * 2.0 - 1.0;
                let (sin, cos) = angle::sin_cos(TAU * u);
                let across = (1.0 - z * z).sqrt();
                cones.iter().any(|cone| cone.holds(Vec3::new(across * cos, across * sin, z)))
            });
            let expected = 2.0 * TAU * covered.count() as f64 / (FINE * FINE) as f64;
            let n = DIRECTIONS as f64;
            let (mean, error) = (sum / n, ((squares / n - (sum / n).powi(2)).max(0.0) / n).sqrt());
            // The grid's own error is that of its cells along the rims.
            assert!((mean - expected).abs() < 4.0 * error + 2e-3 * expected, "{mean} ± {error}, {expected}");
            if cones.len() == 1 {
                assert!(chi_square(&rings, &[n / RINGS as f64; RINGS]).p_value > 0.01, "{rings:?}");
            }
        }
    }

    /// Rays from everywhere beyond the scene: the mean of one over the density is the area that the spheres
    /// cover together, as a grid finds it.
    #[test]
    fn rays_follow_their_density() {
        const RAYS: usize = 200_000;
        const FINE: usize = 1000;
        let bodies = vec![at(1.0, 0.5, 2.0, 0.8), at(0.5, 0.5, 2.0, 0.9), at(0.0, -3.0, 1.0, 0.3)];
        let casters = Casters::new(CastersByKind { bodies, coats: vec![at(0.0, 0.0, 2.0, 1.5)], ..NONE });
        let scene = at(0.0, 0.0, 1.0, 6.0);
        let mut generator = Pcg64Mcg::new(3);
        let mut next = || (generator.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
        for direction in [Vec3::Z, Vec3::new(0.6, -0.8, 0.0), Vec3::new(-0.36, 0.48, -0.8)] {
            let (mut sum, mut squares) = (0.0, 0.0);
            for _ in 0..RAYS {
                let (ray, density) = casters.ray_along(direction, &scene, next(), [next(), next()]).unwrap();
                assert!((ray.origin - scene.centre).dot(direction) <= -scene.radius + 1e-9);
                assert_eq!(ray.direction, direction);
                // The same wherever on the ray it is asked for.
                assert_eq!(casters.density_along(direction, ray.at(3.7)), density);
                sum += 1.0 / density;
                squares += 1.0 / (density * density);
            }
            let frame = Frame::around(direction);
            let covered = midpoints(FINE).filter(|u| {
                let [x, y] = u.map(|u| 10.0 * (u - 0.5));
                casters.density_along(direction, frame.to_world(Vec3::new(x, y, 0.0))) > 0.0
            });
            let expected = 100.0 * covered.count() as f64 / (FINE * FINE) as f64;
            let n = RAYS as f64;
            let (mean, error) = (sum / n, ((squares / n - (sum / n).powi(2)).max(0.0) / n).sqrt());
            assert!((mean - expected).abs() < 4.0 * error + 2e-3 * expected, "{mean} ± {error}, {expected}");
        }
    }

    #[test]
    fn a_light_within_a_body_shines_everywhere() {
        let aim = Casters::new(CastersByKind { bodies: vec![at(0.0, 0.1, 0.3, 1.0)], ..NONE })
            .seen_from(&point(Vec3::Z))
            .unwrap();
        let (direction, density) = aim.sample(0.3, [0.2, 0.9]).unwrap();
        assert!(direction.z > 0.0 && (density - direction.z * FRAC_1_PI).abs() < 1e-15);
    }

    #[test]
    fn what_is_behind_a_light_is_not_aimed_at() {
        let behind = Casters::new(CastersByKind { bodies: vec![at(0.0, 0.0, -2.0, 0.5)], ..NONE });
        assert!(behind.seen_from(&point(Vec3::Z)).is_none());
        assert!(behind.seen_from(&point(-Vec3::Z)).is_some());
    }

    #[test]
    fn spheres_of_many_bodies_hold_them_all() {
        let bodies: Vec<Caster> = (0..100)
            .map(|i| {
                let turn = f64::from(i) * 0.7;
                at(
                    10.0 * turn.cos(),
                    f64::from(i % 7),
                    5.0 * (1.3 * turn).sin(),
                    0.1 + 0.01 * f64::from(i % 5),
                )
            })
            .collect();
        let Casters(kinds) = Casters::new(CastersByKind { bodies: bodies.clone(), ..NONE });
        let [(1.0, Spheres(spheres))] = &kinds[..] else { panic!("{kinds:?}") };
        assert_eq!(spheres.len(), MOST);
        for body in bodies {
            let held = |sphere: &Caster| sphere.centre.distance(body.centre) + body.radius <= sphere.radius;
            assert!(spheres.iter().any(held), "{body:?}");
        }
        assert!(Casters::new(NONE).is_empty());
    }
}
