//! A density that falls off exponentially with height: that of an atmosphere of one temperature.
//!
//! Along a ray it has no closed integral where the ground is a sphere. A ray is cut where it crosses shells
//! of a thickness in which the density falls by a factor of e, and where it is lowest. A Gauss-Legendre rule
//! of eight points integrates each piece up to rounding.

use super::FreeFlight;
use super::grid::invert;
use crate::geometry::{Ray, Transform, Vec3};
use crate::sampling::quadrature::gauss_legendre;
use crate::spectrum::Sampled;
use std::ops::ControlFlow;
use std::sync::LazyLock;

/// 1 on the ground and below it, e^(−h/H) at a height h above, nothing beyond the top.
#[derive(Clone, Debug)]
pub struct Exponential {
    /// From the coordinates of the scene to those in which a flat ground is the plane z = 0, and a sphere has
    /// its centre at the origin. It keeps lengths.
    to_local: Transform,
    /// Radius of the ground. `None` where it is flat.
    radius: Option<f64>,
    scale_height: f64,
    top: f64,
}

/// Scale heights above which the density is 0: e^−746 is less than half the least number.
const VANISHES: f64 = 746.0;

static RULE: LazyLock<Vec<(f64, f64)>> =
    LazyLock::new(|| gauss_legendre(8).map(|(x, weight)| (0.5 + 0.5 * x, 0.5 * weight)).collect());

impl Exponential {
    /// All lengths above 0.
    pub fn new(to_local: Transform, radius: Option<f64>, scale_height: f64, top: f64) -> Self {
        Self { to_local, radius, scale_height, top }
    }

    /// Density at a place, over that at height 0.
    pub fn at(&self, position: Vec3) -> f64 {
        self.at_height(self.height(self.to_local.point(position)))
    }

    fn height(&self, local: Vec3) -> f64 {
        match self.radius {
            None => local.z,
            Some(radius) => local.length() - radius,
        }
    }

    fn at_height(&self, height: f64) -> f64 {
        if height > self.top { 0.0 } else { (-height.max(0.0) / self.scale_height).exp() }
    }

    /// The integral of the density along a ray.
    pub fn depth(&self, ray: &Ray) -> f64 {
        let line = Line::new(self, ray);
        let mut sum = 0.0;
        line.pieces(|from, to| {
            sum += line.integral(from, to);
            ControlFlow::Continue(())
        });
        sum
    }

    /// Where the integral along a ray reaches a value.
    pub fn fly(&self, ray: &Ray, target: f64) -> FreeFlight<1> {
        let line = Line::new(self, ray);
        let (mut sum, mut ended) = (0.0, None);
        line.pieces(|from, to| {
            let piece = line.integral(from, to);
            if sum + piece <= target {
                sum += piece;
                return ControlFlow::Continue(());
            }
            let left = target - sum;
            let distance = match to.is_finite() {
                true => invert([from, to], left, |t| line.integral(from, t), |t| line.on(t)),
                false => from + left / line.on(from + 1.0),
            };
            ended = Some((distance, sum + line.integral(from, distance), line.on(distance)));
            ControlFlow::Break(())
        });
        match ended {
            Some((distance, depth, density)) => {
                FreeFlight::Ended { distance, depths: Sampled([depth]), extinction: Sampled([density]) }
            }
            None => FreeFlight::Passed { depths: Sampled([sum]) },
        }
    }
}

/// A ray in the atmosphere's coordinates.
struct Line<'a> {
    of: &'a Exponential,
    origin: Vec3,
    direction: Vec3,
    t_max: f64,
}

impl<'a> Line<'a> {
    fn new(of: &'a Exponential, ray: &Ray) -> Self {
        let (origin, direction) = (of.to_local.point(ray.origin), of.to_local.vector(ray.direction));
        Self { of, origin, direction, t_max: ray.t_max }
    }

    fn on(&self, t: f64) -> f64 {
        self.of.at_height(self.of.height(self.origin + self.direction * t))
    }

    fn integral(&self, from: f64, to: f64) -> f64 {
        // An infinite piece is level, or lies below the ground.
        if self.of.radius.is_none() && (self.direction.z == 0.0 || to.is_infinite()) {
            let density = self.on(from + 1.0);
            return if density > 0.0 { density * (to - from) } else { 0.0 };
        }
        let width = to - from;
        RULE.iter().map(|(place, weight)| weight * self.on(from + width * place)).sum::<f64>() * width
    }

    /// Where the line crosses a height, up to twice.
    fn crossings(&self, height: f64) -> [f64; 2] {
        match self.of.radius {
            None => [(height - self.origin.z) / self.direction.z, f64::NAN],
            Some(radius) => {
                let nearest = -self.origin.dot(self.direction);
                let lowest = (self.origin + self.direction * nearest).length_squared();
                let reach = ((radius + height) * (radius + height) - lowest).sqrt();
                [nearest - reach, nearest + reach]
            }
        }
    }

    /// Least and greatest height.
    fn reach(&self) -> [f64; 2] {
        let height = |t: f64| self.of.height(self.origin + self.direction * t);
        let nearest = (-self.origin.dot(self.direction)).max(0.0).min(self.t_max);
        let [low, end] = match self.of.radius {
            // No number for an endless level ray, which the minimum and the maximum pass over.
            None => [height(self.t_max); 2],
            Some(_) if self.t_max.is_infinite() => [height(nearest), f64::INFINITY],
            Some(_) => [nearest, self.t_max].map(height),
        };
        [low.min(height(0.0)), end.max(height(0.0))]
    }

    /// Where pieces begin and end, in order. Shells that the line does not come to have no part in it.
    fn ends(&self) -> Vec<f64> {
        let Exponential { scale_height, top, .. } = *self.of;
        let [low, high] = self.reach().map(|height| (height.min(top) / scale_height).clamp(0.0, VANISHES));
        let shells = low as u32..high.ceil() as u32;
        let heights = shells.map(|shell| f64::from(shell) * scale_height).chain([top]);
        let mut ends: Vec<f64> = heights.flat_map(|height| self.crossings(height)).collect();
        if self.of.radius.is_some() {
            ends.push(-self.origin.dot(self.direction));
        }
        ends.extend([0.0, self.t_max]);
        ends.retain(|t| (0.0..=self.t_max).contains(t));
        ends.sort_by(f64::total_cmp);
        ends
    }

    /// Calls with the ends of each piece that lies below the top, in order.
    fn pieces(&self, mut visit: impl FnMut(f64, f64) -> ControlFlow<()>) {
        for pair in self.ends().windows(2) {
            let (from, to) = (pair[0], pair[1]);
            let middle = if to.is_finite() { 0.5 * (from + to) } else { from + 1.0 };
            // What is above the top is no piece.
            if to > from && self.on(middle) > 0.0 && visit(from, to).is_break() {
                return;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::medium::{Density, Diluted};
    use std::f64::consts::PI;

    const EARTH: f64 = 6.371e6;

    fn air(radius: Option<f64>) -> Exponential {
        Exponential::new(Transform::IDENTITY, radius, 8000.0, 96_000.0)
    }

    fn up(ray: &Ray, radius: Option<f64>) -> f64 {
        air(radius).depth(ray)
    }

    #[test]
    fn columns_above_a_flat_ground() {
        let whole = 8000.0 * (1.0 - (-12.0f64).exp());
        for cos in [1.0f64, 0.3, 0.01] {
            let direction = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
            let depth = up(&Ray::new(Vec3::ZERO, direction), None);
            assert!((depth * cos / whole - 1.0).abs() < 1e-12, "{cos}: {depth}");
        }
        let level = Ray { t_max: 5e3, ..Ray::new(Vec3::new(0.0, 0.0, 8000.0), Vec3::X) };
        assert!((up(&level, None) - 5e3 * (-1.0f64).exp()).abs() < 1e-9);
        // Down from above, through to below, where it is as on the ground.
        let down = Ray { t_max: 2e5 + 100.0, ..Ray::new(Vec3::new(0.0, 0.0, 2e5), -Vec3::Z) };
        assert!((up(&down, None) - whole - 100.0).abs() < 1e-6, "{}", up(&down, None));
        assert_eq!(up(&Ray::new(Vec3::new(0.0, 0.0, 1e5), Vec3::Z), None), 0.0);
    }

    /// Below a flat ground, and level above it, there is no end to the air.
    #[test]
    fn endless_rays_in_the_air_end() {
        let air = air(None);
        for (height, direction, depth, distance) in [
            (0.0, -Vec3::Z, 300.0, 300.0),
            (-50.0, Vec3::new(0.6, 0.0, -0.8), 300.0, 300.0),
            (8000.0, Vec3::X, 300.0, 300.0 * 1.0f64.exp()),
            (96_000.0, -Vec3::Z, 9000.0, 96_000.0 + 1000.0 + 8000.0 * (-12.0f64).exp()),
        ] {
            let ray = Ray::new(Vec3::new(0.0, 0.0, height), direction);
            assert_eq!(air.depth(&ray), f64::INFINITY, "{height}");
            let FreeFlight::Ended { distance: found, depths, .. } = air.fly(&ray, depth) else {
                panic!("passed from {height}");
            };
            assert!((found / distance - 1.0).abs() < 1e-9, "{height}: {found}, not {distance}");
            assert!((depths.0[0] / depth - 1.0).abs() < 1e-9, "{height}: {}", depths.0[0]);
        }
    }

    /// A top of ten million scale heights costs no more than air that ends where the density is 0 in doubles.
    /// What is high up counts where a ray has nothing lower.
    #[test]
    fn thin_air_below_a_high_top_takes_few_pieces() {
        let height = 1e-6;
        for radius in [None, Some(1.0)] {
            let ground = radius.unwrap_or(0.0);
            let air = Exponential::new(Transform::IDENTITY, radius, height, 10.0);
            for (low, high, most) in [(0.0, 1e9, 750), (0.0, 2.5, 6), (100.0, 103.0, 8), (800.0, 1e6, 4)] {
                let place = |heights: f64| Vec3::new(0.0, 0.0, ground + heights * height);
                let up = Ray { t_max: (high - low) * height, ..Ray::new(place(low), Vec3::Z) };
                let down = Ray { t_max: up.t_max, ..Ray::new(place(high), -Vec3::Z) };
                for ray in [up, down] {
                    let pieces = Line::new(&air, &ray).ends().len();
                    assert!(pieces <= most, "{radius:?}, {low} to {high}: {pieces}");
                    let expected = height * ((-low).exp() - (-high).exp());
                    let depth = air.depth(&ray);
                    // Heights are differences of places: near 1 these are rounded to 1e-10 of a scale height,
                    // near 1000 to 1e-7.
                    let rounding = if high > 1e6 { 1e-6 } else { 1e-9 };
                    assert!((depth - expected).abs() <= rounding * expected, "{radius:?}, {low}: {depth}");
                }
            }
        }
        // Endless ones, and those that graze a sphere.
        let ends = |radius, ray: Ray| {
            Line::new(&Exponential::new(Transform::IDENTITY, radius, height, 10.0), &ray).ends().len()
        };
        assert!(ends(None, Ray::new(Vec3::ZERO, -Vec3::Z)) <= 5);
        assert!(ends(None, Ray::new(Vec3::new(0.0, 0.0, 5.0), Vec3::Z)) <= 5);
        assert!(ends(Some(1.0), Ray::new(Vec3::new(-2.0, 0.0, 1.0 + 743.5 * height), Vec3::X)) <= 11);
    }

    /// Toward the horizon of a sphere the column is √(πRH/2) but for terms of H/R (Chapman, "The absorption
    /// and dissociative or ionizing effect of monochromatic radiation in an atmosphere on a rotating earth",
    /// Proceedings of the Physical Society 43, 1931).
    #[test]
    fn the_column_toward_the_horizon_is_chapmans() {
        let depth = up(&Ray::new(Vec3::new(0.0, 0.0, EARTH), Vec3::X), Some(EARTH));
        let (height, ratio) = (8000.0, EARTH / 8000.0);
        let expected = height * (0.5 * PI * ratio).sqrt() * (1.0 + 3.0 / (8.0 * ratio));
        assert!((depth / expected - 1.0).abs() < 2e-5, "{depth}, not {expected}");
    }

    #[test]
    fn pieces_sum_to_a_fine_sum_and_flights_end_where_they_should() {
        let air = air(Some(EARTH));
        for (height, direction) in [
            (10.0, Vec3::new(1.0, 0.0, 0.3)),
            (2e4, Vec3::new(1.0, 0.0, -0.06)),
            (2e5, Vec3::new(1.0, 0.2, -0.22)),
        ] {
            let origin = Vec3::new(0.0, 0.0, EARTH + height);
            let ray = Ray { t_max: 1.5e6, ..Ray::new(origin, direction.normalize()) };
            let depth = air.depth(&ray);
            let cells = 1_000_000;
            let step = ray.t_max / f64::from(cells);
            let sum: f64 = (0..cells).map(|i| air.at(ray.at((f64::from(i) + 0.5) * step)) * step).sum();
            assert!((depth / sum - 1.0).abs() < 1e-6, "{height}: {depth}, summed up {sum}");
            for fraction in [1e-6, 0.2, 0.9] {
                let FreeFlight::Ended { distance, depths, extinction } = air.fly(&ray, fraction * depth)
                else {
                    panic!("{height}: passed at {fraction}")
                };
                let up_to = air.depth(&Ray { t_max: distance, ..ray });
                let near = |found: f64| (found - fraction * depth).abs() < 1e-11 * depth;
                assert!(near(up_to) && near(depths.hero()), "{height}, {fraction}: {up_to}, {depths:?}");
                assert!((extinction.hero() - air.at(ray.at(distance))).abs() < 1e-9);
            }
            assert!(matches!(air.fly(&ray, 1.001 * depth), FreeFlight::Passed { .. }));
        }
    }

    /// Straight up from the ground at 1013.25 hPa, of air of 288.15 K. That of the true atmosphere is 0.0972
    /// (Bucholtz 1995): its column holds a little more, for gravity falls with height.
    #[test]
    fn the_optical_depth_of_air_at_550_nm() {
        use crate::phase::air;
        use crate::units::WavelengthRange;
        let (spectrum, _) = air::optics(WavelengthRange::VISIBLE).unwrap();
        let density =
            Density::Exponential(Exponential::new(Transform::IDENTITY, Some(EARTH), 8434.5, 101_214.0));
        let air = Diluted { density, spectrum };
        let nm = [550.0, 440.0, 680.0];
        let depths = air.optical_depths(&Ray::new(Vec3::new(0.0, 0.0, EARTH), Vec3::Z), &nm);
        assert!((depths[0] - 0.0972).abs() < 5e-4, "{depths:?}");
        let slope = |a: usize, b: usize| (depths[b] / depths[a]).ln() / (nm[b] / nm[a]).ln();
        assert!((slope(0, 1) + 4.105).abs() < 0.01 && (slope(0, 2) + 4.066).abs() < 0.01, "{depths:?}");
    }
}
