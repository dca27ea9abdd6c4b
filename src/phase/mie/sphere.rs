//! Scattering of a plane wave by one sphere of a homogeneous material (Mie 1908).
//!
//! The series, their recurrences and the signs follow Bohren and Huffman, *Absorption and Scattering of Light
//! by Small Particles*, 1983, chapter 4 and appendix A: the index is n + ik with k ≥ 0 for what absorbs. The
//! number of terms is Wiscombe's ("Improved Mie scattering algorithms", Applied Optics 19(9), 1980). The
//! medium around the sphere absorbs nothing.

use rustfft::num_complex::Complex64;

/// The coefficients aₙ and bₙ of the scattered wave, n = 1, 2, ….
#[derive(Clone, Debug)]
pub struct Sphere {
    /// Circumference over the wavelength in the medium around.
    size: f64,
    /// Coefficients a and b of each order from 1 on.
    pub coefficients: Vec<[Complex64; 2]>,
}

impl Sphere {
    /// `size`: the size parameter 2πr/λ, above 0, with the wavelength in the medium around; `index`: relative
    /// to that of the medium around.
    pub fn new(size: f64, index: Complex64) -> Self {
        let terms = terms(size);
        let inside = logarithmic_derivatives(index * size, terms);
        let [psi, chi] = riccati_bessel(size, terms);
        let coefficient = |n: usize| {
            let order = n as f64 / size;
            let xi = |n: usize| Complex64::new(psi[n], -chi[n]);
            let of = |slope: Complex64| {
                let slope = slope + order;
                (slope * psi[n] - psi[n - 1]) / (slope * xi(n) - xi(n - 1))
            };
            [of(inside[n] / index), of(inside[n] * index)]
        };
        Self { size, coefficients: (1..=terms).map(coefficient).collect() }
    }

    /// A sum over n with 2n + 1.
    fn sum(&self, of: impl Fn(&[Complex64; 2]) -> f64) -> f64 {
        let terms = self.coefficients.iter().enumerate();
        terms.map(|(i, pair)| (2.0 * i as f64 + 3.0) * of(pair)).sum()
    }

    /// What it takes out of the light over what falls on its cross-section.
    pub fn extinction(&self) -> f64 {
        2.0 / (self.size * self.size) * self.sum(|[a, b]| a.re + b.re)
    }

    /// What it scatters over what falls on its cross-section.
    pub fn scattering(&self) -> f64 {
        2.0 / (self.size * self.size) * self.sum(|[a, b]| a.norm_sqr() + b.norm_sqr())
    }

    /// (|S₁|² + |S₂|²) / 2 for unpolarised light: the differential cross-section times k², sr⁻¹.
    pub fn intensity(&self, cos: f64) -> f64 {
        let mut sums = Amplitudes::new(vec![cos]);
        sums.add(self);
        sums.intensities()[0]
    }
}

/// The terms that the series needs.
fn terms(size: f64) -> usize {
    (size + 4.05 * size.cbrt() + 3.0).ceil() as usize
}

/// So many steps beyond |z| a recurrence downward has to begin for its first value not to matter: the error
/// falls the faster the farther n is above |z|, in units of |z|^⅓.
fn beyond(modulus: f64) -> usize {
    16 + (8.0 * modulus.cbrt()) as usize
}

/// Dₙ(z) = ψ′ₙ/ψₙ from n = 0 on, by the recurrence downward, which loses no digits.
fn logarithmic_derivatives(z: Complex64, terms: usize) -> Vec<Complex64> {
    let start = terms.max(z.norm().ceil() as usize) + beyond(z.norm());
    let mut derivatives = vec![Complex64::new(0.0, 0.0); start + 1];
    for n in (1..=start).rev() {
        let order = n as f64 / z;
        derivatives[n - 1] = order - 1.0 / (derivatives[n] + order);
    }
    derivatives.truncate(terms + 1);
    derivatives
}

/// ψₙ(x) = x jₙ(x) and χₙ(x) = −x yₙ(x) from n = 0 on. Upward the recurrence is stable for χ, and for ψ up to
/// n ≈ x; beyond, ψ follows from the ratios ψₙ₋₁/ψₙ, which are computed downward.
fn riccati_bessel(x: f64, terms: usize) -> [Vec<f64>; 2] {
    let last = terms + beyond(x);
    let next = |n: usize, last: f64, before: f64| (2 * n + 1) as f64 / x * last - before;
    let mut chi = vec![x.cos(), x.cos() / x + x.sin()];
    let mut psi = vec![x.sin()];
    let mut ratios = vec![0.0; last + 1];
    ratios[last] = (2 * last + 1) as f64 / x;
    for n in (1..last).rev() {
        ratios[n] = (2 * n + 1) as f64 / x - 1.0 / ratios[n + 1];
    }
    for n in 1..=terms {
        if n > 1 {
            chi.push(next(n - 1, chi[n - 1], chi[n - 2]));
        }
        psi.push(match n {
            _ if n as f64 > x => psi[n - 1] / ratios[n],
            1 => x.sin() / x - x.cos(),
            _ => next(n - 1, psi[n - 1], psi[n - 2]),
        });
    }
    [psi, chi]
}

/// S₁ ± S₂ of one sphere after another at the same cosines.
pub struct Amplitudes {
    cosines: Vec<f64>,
    /// πₙ₋₁ and πₙ, and real and imaginary part of S₁ + S₂ and of S₁ − S₂: of each cosine in turn.
    columns: [Vec<f64>; 6],
}

impl Amplitudes {
    /// For directions of these cosines of the scattering angle.
    pub fn new(cosines: Vec<f64>) -> Self {
        let columns = std::array::from_fn(|_| vec![0.0; cosines.len()]);
        Self { cosines, columns }
    }

    /// Those of a sphere.
    pub fn add(&mut self, sphere: &Sphere) {
        let [before, last, sum_re, sum_im, difference_re, difference_im] = &mut self.columns;
        before.fill(0.0);
        last.fill(1.0);
        for column in [&mut *sum_re, &mut *sum_im, &mut *difference_re, &mut *difference_im] {
            column.fill(0.0);
        }
        for (i, [a, b]) in sphere.coefficients.iter().enumerate() {
            let n = i as f64 + 1.0;
            let factor = (2.0 * n + 1.0) / (n * (n + 1.0));
            let [plus, minus] = [(a + b) * factor, (a - b) * factor];
            for (k, &cos) in self.cosines.iter().enumerate() {
                // πₙ and τₙ (Bohren and Huffman, eq. 4.47); πₙ₊₁ for the next term.
                let (pi, pi_before) = (last[k], before[k]);
                let tau = n * cos * pi - (n + 1.0) * pi_before;
                let (up, down) = (pi + tau, pi - tau);
                sum_re[k] += plus.re * up;
                sum_im[k] += plus.im * up;
                difference_re[k] += minus.re * down;
                difference_im[k] += minus.im * down;
                before[k] = pi;
                last[k] = ((2.0 * n + 1.0) * cos * pi - (n + 1.0) * pi_before) / n;
            }
        }
    }

    /// (|S₁|² + |S₂|²) / 2 at each cosine.
    pub fn intensities(&self) -> Vec<f64> {
        let [_, _, a, b, c, d] = &self.columns;
        let squares = a.iter().zip(b).zip(c.iter().zip(d));
        squares.map(|((a, b), (c, d))| 0.25 * (a * a + b * b + c * c + d * d)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    impl Sphere {
        /// The mean cosine of the angle by which light is scattered.
        pub(in crate::phase::mie) fn mean_cosine(&self) -> f64 {
            let pairs = self.coefficients.iter().enumerate();
            let own = pairs.map(|(i, [a, b])| {
                let n = i as f64 + 1.0;
                (2.0 * n + 1.0) / (n * (n + 1.0)) * (a * b.conj()).re
            });
            let neighbours = self.coefficients.windows(2).enumerate().map(|(i, pair)| {
                let n = i as f64 + 1.0;
                let ([a, b], [c, d]) = (pair[0], pair[1]);
                n * (n + 2.0) / (n + 1.0) * (a * c.conj() + b * d.conj()).re
            });
            let sum = own.sum::<f64>() + neighbours.sum::<f64>();
            4.0 / (self.size * self.size * self.scattering()) * sum
        }
    }

    /// x, n, k, the efficiencies and the mean cosine, and intensities at six angles.
    const REFERENCE: &str = include_str!("../../../tests/data/mie_reference.csv");

    fn close(name: &str, found: f64, expected: f64, tolerance: f64) {
        assert!((found - expected).abs() <= tolerance * expected.abs(), "{name}: {found}, not {expected}");
    }

    #[test]
    fn spheres_are_those_of_another_program() {
        let mut count = 0;
        for line in REFERENCE.lines().filter(|line| !line.starts_with('#')) {
            let numbers: Vec<f64> = line.split(',').map(|number| number.parse().unwrap()).collect();
            let [size, n, k, extinction, scattering, back, mean_cosine] = numbers[..7] else {
                panic!("{line}")
            };
            let sphere = Sphere::new(size, Complex64::new(n, k));
            // That program takes the first terms of a series for spheres smaller than this. With 40 digits
            // the extinction at x = 0.101 and m = 0.75 is 8.0335381485571e-6, and the program's is 6e-9 more.
            let tolerance = if n * size < 0.1 { 2e-6 } else { 1e-9 };
            let name = |of: &str| format!("{of} at x = {size}, m = {n} + {k}i");
            close(&name("extinction"), sphere.extinction(), extinction, tolerance);
            close(&name("scattering"), sphere.scattering(), scattering, tolerance);
            close(&name("mean cosine"), sphere.mean_cosine(), mean_cosine, tolerance.max(1e-8));
            let backward = 4.0 * sphere.intensity(-1.0) / (size * size);
            close(&name("backscattering"), backward, back, tolerance.max(1e-7));
            for (degrees, expected) in [0.0f64, 10.0, 60.0, 90.0, 137.0, 180.0].iter().zip(&numbers[7..]) {
                let found = sphere.intensity(degrees.to_radians().cos());
                close(&name(&format!("{degrees} degrees")), found, *expected, tolerance.max(1e-7));
            }
            count += 1;
        }
        assert_eq!(count, 19);
    }

    /// Bohren and Huffman, appendix A: the sphere that their program prints.
    #[test]
    fn the_sphere_of_the_book() {
        let sphere = Sphere::new(2.0 * PI * 0.525 / 0.6328, Complex64::new(1.55, 0.0));
        assert!((sphere.extinction() - 3.10543).abs() < 5e-6, "{}", sphere.extinction());
        assert!((sphere.scattering() - 3.10543).abs() < 5e-6, "{}", sphere.scattering());
        let size = 2.0 * PI * 0.525 / 0.6328;
        let back = 4.0 * sphere.intensity(-1.0) / (size * size);
        assert!((back - 2.92534).abs() < 5e-6, "{back}");
    }

    /// The first term of the series in x (Bohren and Huffman, eqs. 5.8 and 5.9, and 5.11 for what absorbs).
    #[test]
    fn small_spheres_scatter_as_rayleigh_says() {
        let (size, index) = (1e-3, Complex64::new(1.5, 0.01));
        let sphere = Sphere::new(size, index);
        let polarisability = (index * index - 1.0) / (index * index + 2.0);
        let scattering = 8.0 / 3.0 * size.powi(4) * polarisability.norm_sqr();
        close("scattering", sphere.scattering(), scattering, 1e-5);
        close("extinction", sphere.extinction(), 4.0 * size * polarisability.im, 1e-4);
        for cos in [-1.0, -0.3, 0.0, 0.7, 1.0] {
            let expected = 0.5 * size.powi(6) * polarisability.norm_sqr() * (1.0 + cos * cos);
            close("intensity", sphere.intensity(cos), expected, 1e-5);
        }
    }

    /// The integral of the intensity over all directions is the cross-section.
    #[test]
    fn what_goes_into_all_directions_is_what_is_scattered() {
        for (size, n, k) in [(0.3, 1.33, 0.0), (7.0, 1.6, 0.02), (40.0, 1.33, 1e-4)] {
            let sphere = Sphere::new(size, Complex64::new(n, k));
            let rule = crate::sampling::quadrature::gauss_legendre(160);
            let sum: f64 = rule.map(|(cos, weight)| weight * sphere.intensity(cos)).sum();
            close("all directions", 2.0 * sum / (size * size), sphere.scattering(), 1e-10);
        }
    }
}
