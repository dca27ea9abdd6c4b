//! Blobs.

use super::{blobs, double, new_shape};
use crate::geometry::{Transform, Vec3};
use crate::shape::tests::doubled::{Doubled, Polynomial};
use crate::shape::tests::oracle::{Line, any_ray, near};
use crate::shape::tests::placement;
use crate::shape::{Kernel, ProfileOrImplicitKind};
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg as Random;

/// The density less the threshold of all blobs in 32 digits, without the exponential's.
fn density(line: &Line, kind: &ProfileOrImplicitKind, t: Doubled) -> Doubled {
    let ProfileOrImplicitKind::Blobs { blobs, kernel, threshold } = kind else { unreachable!() };
    let mut sum = -double(*threshold);
    for blob in blobs {
        let away = [0, 1, 2].map(|k| line.0[k].at(t) - blob.centre[k].into());
        let squared = (away[0] * away[0] + away[1] * away[1] + away[2] * away[2])
            / (double(blob.radius) * blob.radius.into());
        let one = double(1.0);
        let value = match kernel {
            Kernel::Gaussian => {
                // exp x = exp(x / 1024)^1024
                let x = squared * double(-4.0 / 1024.0);
                let mut series = one;
                for k in (1..16).rev() {
                    series = one + series * x / double(f64::from(k));
                }
                (0..10).fold(series, |power, _| power * power)
            }
            _ if squared.high >= 1.0 => double(0.0),
            Kernel::Metaball if (squared * 9.0.into() - one).high <= 0.0 => one - squared * 3.0.into(),
            Kernel::Metaball => {
                let rest = one - squared.sqrt();
                double(1.5) * rest * rest
            }
            Kernel::Soft => {
                let nine = double(9.0);
                one - squared * (double(22.0) - squared * (double(17.0) - squared * 4.0.into())) / nine
            }
        };
        sum = sum + value * blob.strength.into();
    }
    sum
}

/// The same in `f64`, which away from zero tells the sign as well: of each blob the squared distance from it
/// along a line, in terms of its radius, as a quadratic of the line's parameter.
struct InDouble {
    quadratics: Vec<([f64; 3], f64)>,
    kernel: Kernel,
    threshold: f64,
}

impl InDouble {
    fn new(line: &Line, kind: &ProfileOrImplicitKind) -> Self {
        let ProfileOrImplicitKind::Blobs { blobs, kernel, threshold } = kind else { unreachable!() };
        let quadratics = blobs.iter().map(|blob| {
            let squares = [0, 1, 2].map(|k| {
                let away = &line.0[k] - &Polynomial::constant(blob.centre[k]);
                &away * &away
            });
            let sum = &(&squares[0] + &squares[1]) + &squares[2];
            let square = double(blob.radius) * blob.radius.into();
            ([0, 1, 2].map(|power| (sum.0[power] / square).high), blob.strength)
        });
        Self { quadratics: quadratics.collect(), kernel: *kernel, threshold: *threshold }
    }

    fn density(&self, t: f64) -> f64 {
        let of_blob = |&([c, b, a], strength): &([f64; 3], f64)| {
            let squared = (a * t + b) * t + c;
            let value = match self.kernel {
                Kernel::Gaussian => (-4.0 * squared).exp(),
                _ if squared >= 1.0 => 0.0,
                Kernel::Metaball if 9.0 * squared <= 1.0 => 1.0 - 3.0 * squared,
                Kernel::Metaball => 1.5 * (1.0 - squared.max(0.0).sqrt()).powi(2),
                Kernel::Soft => 1.0 - squared * (22.0 - squared * (17.0 - 4.0 * squared)) / 9.0,
            };
            strength * value
        };
        self.quadratics.iter().map(of_blob).sum::<f64>() - self.threshold
    }
}

/// By brute force: signs in many places along the line, and halving between them.
fn check_blobs(rays: u32) {
    const STEPS: u32 = 2_000;
    let (mut touching, mut hits) = (0, 0);
    for (i, kernel) in [Kernel::Soft, Kernel::Metaball, Kernel::Gaussian].into_iter().enumerate() {
        for (j, to_world) in
            [Transform::IDENTITY, placement(Vec3::new(0.9, 0.5, 0.3))].into_iter().enumerate()
        {
            let kind = blobs(kernel);
            let shape = new_shape(&to_world, &kind);
            let bounds = shape.bounds();
            let mut random = Random::seed_from_u64((10 * i + j) as u64);
            for _ in 0..rays {
                let ray = any_ray(&shape, bounds, &mut random);
                let line = Line::new(&ray, &to_world);
                let found = shape.crossings(&ray);
                hits += found.len();
                // Each crossing is where the sign changes, to within its bound.
                for (k, crossing) in found.iter().enumerate() {
                    let t = double(crossing.hit.t) - near(&ray).into();
                    let [before, after] =
                        [-crossing.error, crossing.error].map(|by| density(&line, &kind, t + by.into()).high);
                    assert!(crossing.enters == (k % 2 == 0));
                    let gap = |other: Option<&crate::shape::Crossing>| {
                        other.is_none_or(|other| {
                            (other.hit.t - crossing.hit.t).abs() > other.error + crossing.error
                        })
                    };
                    if gap(found.get(k + 1)) && (k == 0 || gap(found.get(k - 1))) {
                        assert!(
                            (after > 0.0) == crossing.enters && (before < 0.0) == crossing.enters,
                            "{kernel:?}: {ray:?} {crossing:?} {before:e} {after:e}"
                        );
                        assert!(
                            crossing.error < 1e-6 * (1.0 + crossing.hit.t.abs()),
                            "{kernel:?}: {crossing:?}"
                        );
                    } else {
                        touching += 1;
                    }
                }
                // No other change of sign.
                let along = InDouble::new(&line, &kind);
                let reach = bounds.diameter();
                let middle = -(ray.origin - bounds.centre()).dot(ray.direction);
                let mut inside = 0;
                for step in 0..=STEPS {
                    let t = middle + reach * (2.0 * f64::from(step) / f64::from(STEPS) - 1.0);
                    let passed = found.iter().filter(|crossing| crossing.hit.t < t).count();
                    let value = along.density(t - near(&ray));
                    let expected = passed % 2 == 1;
                    inside += u32::from(expected);
                    assert!(
                        (value > 0.0) == expected || value.abs() < 1e-9,
                        "{kernel:?}: {ray:?} {t} {value:?} {found:?}"
                    );
                }
                assert!(inside < STEPS);
            }
        }
    }
    println!("{touching} crossings of {hits} touch within rounding");
    assert!(hits as u32 > 2 * rays);
}

#[test]
fn blobs_are_crossed_where_their_density_passes_the_threshold() {
    check_blobs(crate::stress::count(60, 170_000));
}
