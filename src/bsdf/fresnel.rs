//! What fraction of unpolarised light a smooth interface reflects.
//!
//! Snell's law and the Fresnel equations for plane waves, exact for every angle. Left out:
//! polarisation (the two components are averaged) and coherence between interfaces.
//!
//! The textbook forms subtract nearly equal numbers where indices match or rays graze. With
//! `g = √(η² − 1 + c²)` and `c = cos θ` the amplitudes
//!
//! `r_s = (c − g)/(c + g)` and `r_p = (η² c − g)/(η² c + g)`
//!
//! become, extended by their own denominators,
//!
//! `r_s = −(η² − 1)/(c + g)²` and `r_p = (η² − 1)((η² + 1) c² − 1)/(η² c + g)²`,
//!
//! in which the only differences left are those that vanish in truth (matched indices, Brewster's
//! angle). The same holds for a complex index, of which only moduli are needed.
//!
//! Reference: Born and Wolf, "Principles of Optics", 7th ed., sections 1.5.2 and 14.2.

use crate::lanes::Real;

/// What a smooth interface between two dielectrics does with a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interface {
    /// Share of the power reflected, 0–1. What is not reflected is transmitted.
    pub reflectance: f64,
    /// Cosine between the refracted ray and the normal on the far side; 0 with total reflection.
    pub cos_refracted: f64,
}

/// Fresnel reflectance and refraction of an interface between two dielectrics.
///
/// `cos_incident` is the cosine between the ray and the normal on the near side, in [0, 1];
/// `eta` > 0 is the index of the far side over that of the near side.
/// Beyond the critical angle the reflectance is 1. Matched indices (`eta` = 1) reflect nothing and
/// bend nothing, even at grazing incidence.
pub fn dielectric(cos_incident: f64, eta: f64) -> Interface {
    if eta == 1.0 {
        return Interface { reflectance: 0.0, cos_refracted: cos_incident };
    }
    let c = cos_incident;
    let g2 = squared_g(c, eta, 0.0);
    if g2 <= 0.0 {
        return Interface { reflectance: 1.0, cos_refracted: 0.0 };
    }
    let g = g2.sqrt();
    let eta2 = eta * eta;
    let step = (eta - 1.0) * (eta + 1.0);
    let r_s = step / ((c + g) * (c + g));
    let p_root = eta2 * c + g;
    let r_p = step * brewster(c, eta2) / (p_root * p_root);
    let reflectance = 0.5 * (r_s * r_s + r_p * r_p);
    // Rounding may pass 1 by an ulp at grazing incidence.
    Interface { reflectance: reflectance.min(1.0), cos_refracted: g / eta }
}

/// Fresnel reflectance of an absorbing material of complex index n + ik, 0–1.
///
/// `cos_incident` is in [0, 1]; `n` ≥ 0 and `k` ≥ 0 are relative to the (real) index outside.
/// With k = 0 it equals [`dielectric`]. A purely imaginary index (n = 0) reflects everything.
#[inline(always)]
pub fn conductor<R: Real>(cos_incident: R, n: R, k: R) -> R {
    let (zero, half, one) = (R::of(0.0), R::of(0.5), R::of(1.0));
    let c = cos_incident;
    // w = a + ib = √(m² − sin² θ), m = n + ik: of it the real part and |w|² do.
    let real = squared_g(c, n, k);
    let half_imaginary = n * k;
    let modulus = (real * real + R::of(4.0) * half_imaginary * half_imaginary).sqrt();
    let large = (half * (modulus + real.abs())).sqrt();
    let small = R::choose(large.gt(zero), half_imaginary / large, zero);
    let a = R::choose(real.ge(zero), large, small);
    // |m² − 1|². The denominators are (c + w)² and (m² c + w)² = (c + w)² (c w + sin² θ)².
    let k2 = k * k;
    let step = ((n - one) * (n - one) + k2) * ((n + one) * (n + one) + k2);
    let sin2 = (one - c) * (one + c);
    let s_root = c * c + R::of(2.0) * c * a + modulus;
    let p_root = sin2 * sin2 + R::of(2.0) * c * sin2 * a + c * c * modulus;
    let (x, y) = (brewster(c, (n - k) * (n + k)), R::of(2.0) * half_imaginary * c * c);
    let both = s_root * p_root;
    let reflectance = (half * step * ((p_root * p_root + x * x + y * y) / (both * both))).lesser(one);
    R::choose(n.eq(zero), one, R::choose(step.eq(zero), zero, reflectance))
}

/// The fraction of diffuse light (radiance the same from all directions) that a smooth interface between two
/// dielectrics reflects, 0 to below 1; `eta` > 0 is the index of the far side over that of the near side.
///
/// Exact: the integral `∫ 2 R(c) c dc` of [`dielectric`] over all cosines c. For n = `eta` > 1 it is
///
/// `½ + (n−1)(3n+1)/6(n+1)² + n²(n²−1)²/(n²+1)³ ln((n−1)/(n+1)) − 2n³(n²+2n−1)/(n²+1)(n⁴−1)
/// + 8n⁴(n⁴+1)/(n²+1)(n⁴−1)² ln n`.
///
/// Its last two terms are infinite at n = 1. With `t = (n−1)/(n+1)`, and so ln n = 2 artanh t, what is
/// infinite cancels before anything is computed: all digits are left at every n. The other way, from the
/// denser side, as much light passes as there is room for it: 1 − R(1/n) = (1 − R(n))/n².
///
/// References: Duntley, "The optical properties of diffusing materials", J. Opt. Soc. Am. 32 (1942), after
/// Walsh (1926); the n² law: Born and Wolf, section 4.8.3.
pub fn diffuse_reflectance(eta: f64) -> f64 {
    if eta == 1.0 {
        return 0.0;
    }
    let t = (eta - 1.0).abs() / (eta + 1.0);
    let (t2, sum, difference) = (t * t, 1.0 + t, 1.0 - t);
    // artanh t = t + t³ rest
    let rest = if t < 0.1 {
        (0..7).rev().fold(0.0, |series, k| series * t2 + 1.0 / f64::from(2 * k + 3))
    } else {
        (0.5 * eta.ln().abs() - t) / (t2 * t)
    };
    let (sum2, even) = (sum * sum, 1.0 + t2);
    let polynomial =
        [3.0, 8.0, 16.0, 36.0, 6.0, -24.0, 0.0, 44.0, 7.0].into_iter().fold(0.0, |value, c| value * t + c);
    let of_rest = 3.0 * sum2 * sum2 * difference * difference * (1.0 + t2 * (6.0 + t2)) * rest;
    let from_rarer = t * (polynomial + of_rest + 24.0 * sum2 * t * t.ln()) / (12.0 * even * even * even);
    let reflectance = if eta > 1.0 { from_rarer } else { (1.0 - eta) * (1.0 + eta) + eta * eta * from_rarer };
    // Rounding may reach 1 where nearly nothing passes.
    reflectance.min(1.0 - f64::EPSILON)
}

/// `n² − k² − sin² θ`, arranged so that it keeps its digits both near the normal (small n) and
/// near grazing incidence (n near 1).
#[inline(always)]
fn squared_g<R: Real>(c: R, n: R, k: R) -> R {
    let one = R::of(1.0);
    let steep = (n - k) * (n + k) - (one - c) * (one + c);
    let flat = (n - one) * (n + one) - k * k + c * c;
    R::choose(c.gt(R::of(0.7)), steep, flat)
}

/// `(m² + 1) cos² θ − 1`, arranged in the same way: it vanishes at Brewster's angle.
#[inline(always)]
fn brewster<R: Real>(c: R, m2: R) -> R {
    let one = R::of(1.0);
    R::choose(c.gt(R::of(0.7)), m2 * c * c - (one - c) * (one + c), (m2 + one) * c * c - one)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::quadrature::gauss_legendre;

    fn close(value: f64, expected: f64, tolerance: f64, what: &str) {
        assert!(
            (value - expected).abs() <= tolerance * expected.abs(),
            "{what}: {value:e}, not {expected:e}"
        );
    }

    /// Against the textbook forms evaluated to 60 digits (validation/optics/make_fresnel_reference.py):
    /// angles 0–90°, n 0.05–10, k 0–10. Near a critical angle the reflectance is ill-conditioned in
    /// its arguments, as 1/g, and so is allowed more there (a row sits within 1e-16 of one).
    #[test]
    fn agrees_with_sixty_digits() {
        let table = include_str!("../../tests/data/fresnel_reference.csv");
        let (mut rows, mut worst) = (0, 0.0f64);
        for line in table.lines().filter(|line| !line.starts_with(['#', 'c'])) {
            let numbers: Vec<f64> = line.split(',').map(|number| number.parse().unwrap()).collect();
            let [c, n, k, expected] = numbers[..] else { panic!("{line}") };
            let error = |value: f64| if expected == 0.0 { value } else { (value / expected - 1.0).abs() };
            let g = squared_g(c, n, k).hypot(2.0 * n * k).sqrt();
            let allowed = 2e-14 + 1e-15 / g;
            let mut judge = |value: f64| {
                worst = worst.max(error(value));
                assert!(
                    error(value) <= allowed.min(1e-7),
                    "{line}: {value:e}, relative error {:e}",
                    error(value)
                );
            };
            judge(conductor(c, n, k));
            if k == 0.0 {
                judge(dielectric(c, n).reflectance);
            }
            rows += 1;
        }
        assert!(rows > 1500);
        eprintln!("{rows} rows, worst relative error {worst:e}");
    }

    /// Glassner, "An Introduction to Ray Tracing" (1989), ch. 4, eq. 16 with its sign corrected:
    /// `F = ½ (g−c)²/(g+c)² {1 + [c(g+c)−1]²/[c(g−c)+1]²}` for glass and n = 2.
    #[test]
    fn textbook_table() {
        let table = [
            (1.5, [0.04, 0.0415226260, 0.0502399110, 0.0891867128, 0.2530605630, 0.6127996453]),
            (2.0, [0.1111111111, 0.1129538084, 0.1226507601, 0.1613765956, 0.3086509920, 0.6301540130]),
        ];
        for (eta, reflectances) in table {
            for (degrees, expected) in [0.0, 30.0, 45.0, 60.0, 75.0, 85.0].into_iter().zip(reflectances) {
                let cos = f64::to_radians(degrees).cos();
                let value = dielectric(cos, eta).reflectance;
                assert!((value - expected).abs() < 1e-10, "n = {eta}, {degrees} degrees: {value}");
                let g = (eta * eta + cos * cos - 1.0).sqrt();
                let parts = ((g - cos) / (g + cos), (cos * (g + cos) - 1.0) / (cos * (g - cos) + 1.0));
                close(value, 0.5 * parts.0 * parts.0 * (1.0 + parts.1 * parts.1), 1e-13, "closed form");
            }
        }
        close(dielectric(1.0, 1.5).reflectance, 0.04, 1e-15, "normal incidence");
    }

    /// At Brewster's angle, atan n, only the component across the plane of incidence is reflected.
    #[test]
    fn brewster() {
        let cos = 1.5f64.atan().cos();
        // tan θ = n makes r_s = (1 − n²)/(1 + n²).
        let r_s: f64 = (1.0 - 2.25) / (1.0 + 2.25);
        close(dielectric(cos, 1.5).reflectance, 0.5 * r_s * r_s, 1e-14, "r_s alone");
    }

    /// sin θc = 1/n. Reflectance is 1 from there on, and below 1 just inside.
    #[test]
    fn critical_angle() {
        let eta: f64 = 1.0 / 1.5;
        let critical = eta.asin();
        assert!((critical.to_degrees() - 41.8103149).abs() < 1e-7);
        for beyond in [1e-12, 1e-6, 0.1, 0.5] {
            let total = dielectric((critical + beyond).cos(), eta);
            assert_eq!((total.reflectance, total.cos_refracted), (1.0, 0.0));
        }
        let inside = dielectric((critical - 1e-6).cos(), eta);
        assert!(inside.reflectance < 1.0 && inside.cos_refracted > 0.0);
        // 30° from air into glass leaves at 19.47° (Snell).
        let refracted = dielectric(30f64.to_radians().cos(), 1.5).cos_refracted;
        close(refracted, (0.5f64 / 1.5).asin().cos(), 1e-15, "Snell");
    }

    /// F(θ_i, η) = F(θ_t, 1/η), and the refracted ray refracts back.
    #[test]
    fn reversible() {
        for step in 1..1000 {
            let cos = f64::from(step) / 1000.0;
            for eta in [0.7, 0.999, 1.000277, 1.33, 1.5, 2.42, 7.0] {
                let there = dielectric(cos, eta);
                if there.reflectance < 1.0 {
                    let back = dielectric(there.cos_refracted, 1.0 / eta);
                    // The rounding of the cosine between is an error in its square, which matters
                    // near the critical angle.
                    let rounding = 4.0 * f64::EPSILON * (1.0 + eta * eta) / cos;
                    let inverting = 4.0 * f64::EPSILON / (eta - 1.0f64).abs();
                    close(back.reflectance, there.reflectance, 4.0 * rounding + inverting, "reflectance");
                    close(back.cos_refracted, cos, rounding / cos, "cosine");
                }
            }
        }
    }

    /// Against quadrature of the Fresnel equations. With `c = √(n² − 1) sinh u` nothing in them is singular.
    #[test]
    fn diffuse_light() {
        let mut indices: Vec<f64> = (-13..=-1).map(|power| 1.0 + 10f64.powi(power)).collect();
        indices.extend((1..=400).map(|step| 1.0 + 0.00625 * f64::from(step)));
        // On both sides of where the series ends, at t = 0.1.
        indices.extend([11.0 / 9.0 - 1e-15, 11.0 / 9.0 + 1e-15, 5.0, 10.0, 100.0]);
        let rule: Vec<(f64, f64)> = gauss_legendre(200).collect();
        for n in indices {
            let scale = ((n - 1.0) * (n + 1.0)).sqrt();
            let end = scale.recip().asinh();
            let (mut outer, mut inner) = (0.0, 0.0);
            for (x, weight) in &rule {
                let u = 0.5 * end * (1.0 + x);
                let cos = (scale * u.sinh()).min(1.0);
                let weight = weight * end * cos * scale * u.cosh();
                outer += weight * dielectric(cos, n).reflectance;
                // The refracted ray, beyond which reflection is total.
                let cos_inside = (scale * scale + cos * cos).sqrt() / n;
                inner += weight * dielectric(cos_inside.min(1.0), 1.0 / n).reflectance / (n * n);
            }
            inner += (n - 1.0) * (n + 1.0) / (n * n);
            // What the index 1/n loses by rounding is as much of n - 1.
            let rounded = 1e-13 + 2e-16 / (n - 1.0).max(1e-16);
            close(diffuse_reflectance(n), outer, 1e-13, &format!("from above, n = {n}"));
            close(diffuse_reflectance(1.0 / n), inner, rounded, &format!("from below, n = {n}"));
        }
        assert_eq!(diffuse_reflectance(1.0), 0.0);
        for eta in [1e-300, 1e-20, 1e-8, 1e8, 1e20, 1e300] {
            assert!((0.9999..1.0).contains(&diffuse_reflectance(eta)), "{eta}");
        }
    }

    /// Edges: grazing, matched, no reflection to divide by, vanishing and huge indices.
    #[test]
    fn finite_at_the_edges() {
        for cos in [0.0, f64::MIN_POSITIVE, 1e-300, 1e-160, 1e-16, 0.5, 1.0 - 1e-16, 1.0] {
            for n in
                [0.0, f64::MIN_POSITIVE, 1e-200, 1e-9, 0.05, 1.0 - 1e-16, 1.0, 1.0 + 2e-16, 1.5, 10.0, 1e6]
            {
                for k in [0.0, f64::MIN_POSITIVE, 1e-200, 1e-12, 1.0, 10.0, 1e6] {
                    let value = conductor(cos, n, k);
                    assert!((0.0..=1.0).contains(&value), "conductor({cos:e}, {n:e}, {k:e}) = {value}");
                }
                if n > 0.0 {
                    let Interface { reflectance, cos_refracted } = dielectric(cos, n);
                    assert!((0.0..=1.0).contains(&reflectance), "dielectric({cos:e}, {n:e}) = {reflectance}");
                    assert!(
                        (0.0..=1.0).contains(&cos_refracted),
                        "dielectric({cos:e}, {n:e}): {cos_refracted}"
                    );
                }
            }
        }
        assert!(dielectric(0.0, 1.5).reflectance > 1.0 - 1e-15);
        assert!(conductor(0.0, 0.2, 3.0) > 1.0 - 1e-15);
        assert_eq!(dielectric(0.3, 1.0), Interface { reflectance: 0.0, cos_refracted: 0.3 });
        // Nothing absorbed, nothing let in.
        assert_eq!(conductor(0.3, 0.0, 0.0), 1.0);
        assert_eq!(conductor(0.3, 0.0, 2.0), 1.0);
    }

    /// R(0) = ((n−1)² + k²)/((n+1)² + k²).
    #[test]
    fn metals_at_normal_incidence() {
        for (n, k) in [(0.2, 3.0), (1.0, 1e-9), (0.05, 9.0), (2.5, 0.0), (10.0, 10.0)] {
            let expected = ((n - 1.0) * (n - 1.0) + k * k) / ((n + 1.0) * (n + 1.0) + k * k);
            close(conductor(1.0, n, k), expected, 1e-14, "normal incidence");
        }
    }

    /// A slab between two faces, all orders of internal reflection summed, by the
    /// reflectances of both faces and the transmittance τ inside: `T = (1−R)² τ/(1 − R² τ²)`.
    #[test]
    fn slab() {
        let (into, out) = (dielectric(1.0, 1.5), dielectric(1.0, 1.0 / 1.5));
        let slab = |tau: f64| {
            let (mut transmitted, mut inside) = (0.0, 1.0 - into.reflectance);
            for _ in 0..40 {
                transmitted += inside * tau * (1.0 - out.reflectance);
                inside *= (tau * out.reflectance).powi(2);
            }
            transmitted
        };
        close(slab(0.512), 0.4720571952, 1e-9, "absorbing");
        close(slab(1.0), 12.0 / 13.0, 1e-12, "clear");
    }
}
