//! Hair: its places in the shared table, Mitsuba's values, and its furnace.

use super::*;
use abbe::bsdf::{Fibre, Hair};

pub fn table<const C: usize>() -> Vec<(String, Bsdf<C>)> {
    let fibres = [
        ("hair", 1.55, [0.3, 0.3], 2.0),
        ("silk", 1.4, [0.1, 0.2], -3.0),
        ("wool", 1.55, [0.9, 0.8], 10.0),
        ("hollow hair", 0.8, [0.5, 0.3], 2.0),
    ];
    let hair = |eta, roughness, tilt: f64| {
        Bsdf::Hair(Hair { absorption: ramp(0.2, 0.15), fibre: Fibre::new(eta, roughness, tilt.to_radians()) })
    };
    fibres.into_iter().map(|(name, eta, roughness, tilt)| (name.into(), hair(eta, roughness, tilt))).collect()
}

/// Parameters up to the ends of their ranges.
pub fn random<const C: usize>(uniform: &mut Uniform, eta: f64, absorption: Sampled<C>) -> Bsdf<C> {
    let roughness = |uniform: &mut Uniform| match uniform.next() {
        u if u < 0.2 => 0.001,
        u if u < 0.3 => 1.0,
        _ => uniform.between(0.001, 1.0),
    };
    let roughness = [roughness(uniform), roughness(uniform)];
    let tilt = uniform.between(-45.0f64, 45.0).to_radians();
    Bsdf::Hair(Hair { absorption, fibre: Fibre::new(eta, roughness, tilt) })
}

/// Values of Mitsuba 3 in single precision (validation/optics/make_hair_reference.py). Its e^−x I₀(x) beyond
/// x = 12 ends after 1 + 1/(16 x), where the series has 1 + 1/(8 x) (Abramowitz and Stegun, 9.7.1): up to
/// 1/(16 · 12) too little, in the narrow lobes of smoother fibres. The furnace below says that ours is right.
#[test]
fn hair_is_mitsubas() {
    let reference = include_str!("../../data/hair_reference.csv");
    let absorption = reference.lines().find_map(|line| line.strip_prefix("# absorption ")).unwrap();
    let absorption: Vec<f64> = absorption.split(' ').map(|number| number.parse().unwrap()).collect();
    let absorption = Sampled(<[f64; 4]>::try_from(absorption).unwrap());
    let mut worst = [0.0f64; 2];
    let mut rows = 0;
    for line in reference.lines().filter(|line| !line.starts_with(['#', 'e'])) {
        let numbers: Vec<f64> = line.split(',').map(|field| field.parse().unwrap()).collect();
        let [eta, along, around, tilt] = numbers[..4] else { panic!("{line}") };
        let fibre = Fibre::new(eta, [along, around], tilt.to_radians());
        let vector = |first: usize| Vec3::from_slice(&numbers[first..first + 3]).normalize();
        let found = Bsdf::Hair(Hair { absorption, fibre }).evaluate(vector(4), vector(7));
        for lane in 0..4 {
            let error = (found.f_cos[lane] / numbers[10 + lane] - 1.0).abs();
            let allowed = if along < 0.8 { 1.0 / (16.0 * 12.0) } else { 1e-4 };
            assert!(error < allowed, "{line}: {found:?}, lane {lane} off by {error:e}");
            worst[usize::from(along < 0.8)] = error.max(worst[usize::from(along < 0.8)]);
        }
        rows += 1;
    }
    println!("off by {worst:?} at most");
    assert_eq!(rows, 168);
}

/// A fibre that absorbs nothing sends on all that it gets: by the midpoint rule over the angles along and
/// around it, which would be exact but for the crease of a lobe on the far side of the fibre.
#[test]
fn a_clear_fibre_is_a_perfect_furnace() {
    const STEPS: u32 = 300;
    let middle = |i: u32, width: f64| width * ((f64::from(i) + 0.5) / f64::from(STEPS) - 0.5);
    for roughness in [[0.15, 0.3], [0.6, 0.2], [1.0, 1.0]] {
        for tilt in [0.0, 2.0, 10.0f64] {
            let fibre = Fibre::new(1.55, roughness, tilt.to_radians());
            let bsdf = Bsdf::Hair(Hair { absorption: Sampled([0.0]), fibre });
            for eye in [at(1.0, 0.0), at(0.4, 0.3), at(0.1, 2.0)] {
                let mut sum = 0.0;
                for i in 0..STEPS {
                    let theta = middle(i, PI);
                    for k in 0..STEPS {
                        let phi = middle(k, TAU);
                        let across = theta.cos();
                        let light = Vec3::new(across * phi.cos(), theta.sin(), across * phi.sin());
                        sum += bsdf.evaluate(eye, light).f_cos.hero() * across;
                    }
                }
                let whole = sum * PI * TAU / f64::from(STEPS * STEPS);
                assert!((whole - 1.0).abs() < 1e-5, "{roughness:?}, {tilt}°, {eye}: {whole}");
            }
        }
    }
}

/// What takes each way through a smooth fibre that is seen head-on, by Fresnel and Beer–Lambert: a way of two
/// radii in.
#[test]
fn absorption_is_that_of_the_way_through() {
    let (eta, sigma) = (1.55, 0.4f64);
    let bsdf = Bsdf::Hair(Hair { absorption: Sampled([sigma]), fibre: Fibre::new(eta, [0.3, 0.3], 0.0) });
    let reflectance = ((eta - 1.0) / (eta + 1.0)).powi(2);
    let once = (-2.0 * sigma).exp();
    let expected = reflectance + (1.0 - reflectance).powi(2) * once / (1.0 - reflectance * once);
    let scatter = bsdf.sample(Vec3::Z, 0.5, [0.3, 0.6]).unwrap();
    assert!(close(scatter.weight.hero(), expected, 1e-14), "{scatter:?}, expected {expected}");
}
