//! Numbers that count what is done with them, and the counts that the texts state.

use super::{assert_near_vector, scattered};
use abbe::geometry::{Frame, Ray, Transform, Vec3};
use abbe::shape::{Disk, Sphere};
use std::cell::RefCell;
use std::f64::consts::PI;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Additions and subtractions, multiplications, divisions, square roots and comparisons.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Counts {
    add: u32,
    mul: u32,
    div: u32,
    sqrt: u32,
    cmp: u32,
}

thread_local! {
    static COUNTS: RefCell<Counts> = RefCell::default();
}

/// A number that counts what is done with it.
#[derive(Clone, Copy, Debug)]
struct Counted(f64);

fn count(which: impl FnOnce(&mut Counts) -> &mut u32) {
    COUNTS.with_borrow_mut(|counts| *which(counts) += 1);
}

impl Add for Counted {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        count(|counts| &mut counts.add);
        Self(self.0 + other.0)
    }
}

impl Sub for Counted {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        count(|counts| &mut counts.add);
        Self(self.0 - other.0)
    }
}

impl Mul for Counted {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        count(|counts| &mut counts.mul);
        Self(self.0 * other.0)
    }
}

impl Div for Counted {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        count(|counts| &mut counts.div);
        Self(self.0 / other.0)
    }
}

impl Neg for Counted {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl Counted {
    fn sqrt(self) -> Self {
        count(|counts| &mut counts.sqrt);
        Self(self.0.sqrt())
    }

    fn is_below(self, other: f64) -> bool {
        count(|counts| &mut counts.cmp);
        self.0 < other
    }
}

type Three = [Counted; 3];

fn three(vector: Vec3) -> Three {
    vector.to_array().map(Counted)
}

fn dot(a: Three, b: Three) -> Counted {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn plus(a: Three, b: Three) -> Three {
    [0, 1, 2].map(|i| a[i] + b[i])
}

fn minus(a: Three, b: Three) -> Three {
    [0, 1, 2].map(|i| a[i] - b[i])
}

fn times(a: Three, factor: Counted) -> Three {
    a.map(|c| c * factor)
}

fn over(a: Three, divisor: Counted) -> Three {
    a.map(|c| c / divisor)
}

fn counted<T>(compute: impl FnOnce() -> T) -> (T, Counts) {
    COUNTS.set(Counts::default());
    let value = compute();
    (value, COUNTS.take())
}

fn vector(value: Three) -> Vec3 {
    Vec3::from_array(value.map(|c| c.0))
}

/// The counts that chapters 2, 5 and 7 state, of formulas whose results are those of this program. (That of the quadric, 44
/// additions and 53 multiplications, is of a formula with a misprint, and not repeated here.)
#[test]
fn n26_counts_of_operations() {
    let (origin, direction) = (Vec3::new(1.0, -2.0, -1.0), Vec3::new(1.0, 2.0, 4.0) / 21f64.sqrt());
    let (centre, radius) = (Vec3::new(3.0, 0.0, 5.0), 3.0);
    let ray = Ray::new(origin, direction);
    let sphere = Sphere::new(&Transform::IDENTITY, centre, radius, false).unwrap();
    let t = sphere.intersect(&ray).unwrap();
    let exact = sphere.surface(ray.at(t)).point;
    let [o, d, c] = [origin, direction, centre].map(three);
    let (radius_squared, over_radius) = (Counted(radius * radius), Counted(1.0 / radius));

    let (found, counts) = counted(|| {
        let away = minus(o, c);
        let b = Counted(2.0) * dot(d, away);
        let c_ = dot(away, away) - radius_squared;
        let discriminant = b * b - Counted(4.0) * c_;
        assert!(!discriminant.is_below(0.0));
        let root = discriminant.sqrt();
        let (first, second) = ((-b - root) * Counted(0.5), (-b + root) * Counted(0.5));
        assert!(!first.is_below(0.0) && !second.is_below(0.0));
        let point = plus(o, times(d, first));
        (point, times(minus(point, c), over_radius))
    });
    assert_eq!(counts, Counts { add: 17, mul: 17, sqrt: 1, cmp: 3, div: 0 }, "sphere by algebra");
    assert_near_vector(vector(found.0), exact.position.to_array(), 1e-14);
    assert_near_vector(vector(found.1), exact.normal.to_array(), 1e-14);

    let (found, counts) = counted(|| {
        let toward = minus(c, o);
        let squared = dot(toward, toward);
        assert!(!squared.is_below(radius * radius));
        let closest = dot(toward, d);
        assert!(!closest.is_below(0.0));
        let half_squared = radius_squared - squared + closest * closest;
        assert!(!half_squared.is_below(0.0));
        let point = plus(o, times(d, closest - half_squared.sqrt()));
        (point, times(minus(point, c), over_radius))
    });
    assert_eq!(counts, Counts { add: 16, mul: 13, sqrt: 1, cmp: 3, div: 0 }, "sphere by geometry");
    assert_near_vector(vector(found.0), exact.position.to_array(), 1e-14);

    // The plane x = 7; its division is not among what is stated.
    let (normal, distance) = (Vec3::X, -7.0);
    let toward_plane = Ray::new(Vec3::new(2.0, 3.0, 4.0), Vec3::ONE.normalize());
    let [o, d, n] = [toward_plane.origin, toward_plane.direction, normal].map(three);
    let (found, counts) = counted(|| {
        let rate = dot(n, d);
        assert!(rate.0 != 0.0 && !rate.is_below(0.0));
        let height = -(dot(n, o) + Counted(distance));
        let t = height / rate;
        assert!(!t.is_below(0.0));
        plus(o, times(d, t))
    });
    assert_eq!(
        counts,
        Counts { add: 8, mul: 9, div: 1, cmp: 2, sqrt: 0 },
        "plane, its rate compared once more"
    );
    let turned =
        glam::DMat4::from_translation(Vec3::new(7.0, 8.0, 9.0)) * glam::DMat4::from_rotation_y(PI / 2.0);
    let disk = Disk::new(&Transform::new(turned).unwrap(), false).unwrap();
    assert_near_vector(
        vector(found),
        toward_plane.at(disk.intersect(&toward_plane).unwrap()).to_array(),
        1e-14,
    );

    // Refraction from index 1 into 1.5 and back, in the forms of Whitted, of Heckbert, and a third.
    for (from, to) in [(1.0, 1.5), (1.5, 1.0)] {
        for degrees in [0.0, 10.0, 25.0, 40.0] {
            let (sin, cos) = f64::to_radians(degrees).sin_cos();
            let frame = Frame::around(Vec3::new(2.0, 3.0, 6.0) / 7.0);
            let incident = frame.to_world(Vec3::new(sin, 0.0, -cos));
            let expected = scattered(incident, frame.z, to / from, true).unwrap().to_array();
            let (i, n) = (three(incident), three(frame.z));
            let (n1, n2) = (Counted(from), Counted(to));

            let (whitted, counts) = counted(|| {
                let scaled = over(i, -dot(i, n));
                let sum = plus(scaled, n);
                let index = n2 / n1;
                let factor = Counted(1.0) / (index * index * dot(scaled, scaled) - dot(sum, sum)).sqrt();
                let refracted = minus(times(sum, factor), n);
                over(refracted, dot(refracted, refracted).sqrt())
            });
            assert_eq!(counts, Counts { sqrt: 2, div: 8, mul: 17, add: 15, cmp: 0 }, "Whitted");
            assert_near_vector(vector(whitted), expected, 1e-14);

            let (heckbert, counts) = counted(|| {
                let index = n1 / n2;
                let c1 = -dot(i, n);
                let c2 = (Counted(1.0) - index * index * (Counted(1.0) - c1 * c1)).sqrt();
                plus(times(i, index), times(n, index * c1 - c2))
            });
            assert_eq!(counts, Counts { sqrt: 1, div: 1, mul: 13, add: 8, cmp: 0 }, "Heckbert");
            assert_near_vector(vector(heckbert), expected, 1e-14);

            let (other, counts) = counted(|| {
                let index = n2 / n1;
                let c1 = -dot(i, n);
                let factor = c1 - (index * index - Counted(1.0) + c1 * c1).sqrt();
                over(plus(i, times(n, factor)), index)
            });
            assert_eq!(counts, Counts { sqrt: 1, div: 4, mul: 8, add: 8, cmp: 0 }, "the third");
            assert_near_vector(vector(other), expected, 1e-14);
        }
    }
}
