//! What share of unpolarised light a smooth interface reflects.
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
    let senkrecht = step / ((c + g) * (c + g));
    let parallel_root = eta2 * c + g;
    let parallel = step * ((eta2 + 1.0) * c * c - 1.0) / (parallel_root * parallel_root);
    let reflectance = 0.5 * (senkrecht * senkrecht + parallel * parallel);
    // Rounding may pass 1 by an ulp at grazing incidence.
    Interface { reflectance: reflectance.min(1.0), cos_refracted: g / eta }
}

/// Fresnel reflectance of an absorbing material of complex index n + ik, 0–1.
///
/// `cos_incident` is in [0, 1]; `n` ≥ 0 and `k` ≥ 0 are relative to the (real) index outside.
/// With k = 0 it equals [`dielectric`]. A purely imaginary index (n = 0) reflects everything.
pub fn conductor(cos_incident: f64, n: f64, k: f64) -> f64 {
    if n == 0.0 {
        return 1.0;
    }
    let c = cos_incident;
    // a + ib = √((n + ik)² − sin² θ)
    let real = squared_g(c, n, k);
    let half_imaginary = n * k;
    let modulus = real.hypot(2.0 * half_imaginary);
    let (a, b) = if real >= 0.0 {
        let a = (0.5 * (modulus + real)).sqrt();
        (a, if a > 0.0 { half_imaginary / a } else { 0.0 })
    } else {
        let b = (0.5 * (modulus - real)).sqrt();
        (half_imaginary / b, b)
    };
    // |m² − 1|² and the squared moduli of the denominators, m = n + ik.
    let k2 = k * k;
    let step = ((n - 1.0) * (n - 1.0) + k2) * ((n + 1.0) * (n + 1.0) + k2);
    if step == 0.0 {
        return 0.0;
    }
    let senkrecht_root = (c + a) * (c + a) + b * b;
    let senkrecht = step / (senkrecht_root * senkrecht_root);
    let real_m2 = (n - k) * (n + k);
    let imaginary_m2 = 2.0 * half_imaginary;
    let (x, y) = (real_m2 * c + a, imaginary_m2 * c + b);
    let parallel_root = x * x + y * y;
    let (x, y) = ((real_m2 + 1.0) * c * c - 1.0, imaginary_m2 * c * c);
    let parallel = step * ((x * x + y * y) / (parallel_root * parallel_root));
    (0.5 * (senkrecht + parallel)).min(1.0)
}

/// `n² − k² − sin² θ`, arranged so that it keeps its digits both near the normal (small n) and
/// near grazing incidence (n near 1).
fn squared_g(c: f64, n: f64, k: f64) -> f64 {
    if c > 0.7 { (n - k) * (n + k) - (1.0 - c) * (1.0 + c) } else { (n - 1.0) * (n + 1.0) - k * k + c * c }
}
