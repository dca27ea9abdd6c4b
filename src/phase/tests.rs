use super::*;
use crate::spectrum::Spectrum;
use std::f64::consts::PI;

fn examples() -> Vec<(&'static str, Phase, f64)> {
    let table = |values: &[f64]| Phase::Table(Box::new(PhaseTable::new(values).unwrap()));
    let blend = Phase::Blend {
        weight: Texture::Uniform(Spectrum::Constant(0.25)),
        nested: Box::new([Phase::Isotropic, Phase::HenyeyGreenstein(0.8)]),
    };
    // Each with its mean cosine.
    vec![
        ("isotropic", Phase::Isotropic, 0.0),
        ("hg 0", Phase::HenyeyGreenstein(0.0), 0.0),
        ("hg 1e-9", Phase::HenyeyGreenstein(1e-9), 1e-9),
        ("hg 0.5", Phase::HenyeyGreenstein(0.5), 0.5),
        ("hg -0.7", Phase::HenyeyGreenstein(-0.7), -0.7),
        ("hg 0.95", Phase::HenyeyGreenstein(0.95), 0.95),
        ("rayleigh", Phase::Rayleigh, 0.0),
        // ∫ μ (1 + μ / 2) / 2 dμ over −1 to 1.
        ("linear table", table(&[0.5, 1.0, 1.5]), 1.0 / 6.0),
        ("table with a gap", table(&[1.0, 0.0, 0.0, 0.0, 1.0]), 0.0),
        ("blend", blend, 0.2),
    ]
}

/// A midpoint sum over the cosine, fine enough for the sharpest of the examples.
fn integral(f: impl Fn(f64) -> f64) -> f64 {
    const CELLS: u32 = 1_000_000;
    let step = 2.0 / f64::from(CELLS);
    (0..CELLS).map(|i| f(-1.0 + (f64::from(i) + 0.5) * step) * step).sum()
}

#[test]
fn each_is_a_density_of_the_mean_cosine_that_it_says() {
    for (name, phase, mean) in examples() {
        let at = |cos: f64| TAU * phase.evaluate(cos, Vec3::ZERO);
        let (whole, first) = (integral(at), integral(|cos| cos * at(cos)));
        assert!((whole - 1.0).abs() < 1e-7, "{name}: {whole}");
        assert!((first - mean).abs() < 1e-7, "{name}: {first}, not {mean}");
    }
}

/// The probability up to each sampled cosine is the number that it was sampled by.
#[test]
fn samples_invert_the_cumulated_density() {
    for (name, phase, _) in examples().into_iter().filter(|(name, ..)| *name != "blend") {
        for u in [1e-6, 0.01, 0.2, 0.499, 0.5, 0.8, 0.999, 1.0 - 1e-6] {
            let sample = phase.sample(Vec3::Z, Vec3::ZERO, [u, 0.3, 0.5]);
            let cos = sample.direction.z;
            let width = (cos + 1.0) / 400_000.0;
            let below: f64 = (0..400_000)
                .map(|i| {
                    let cos = -1.0 + (f64::from(i) + 0.5) * width;
                    TAU * phase.evaluate(cos, Vec3::ZERO) * width
                })
                .sum();
            assert!((below - u).abs() < 1e-6, "{name}: up to {cos} lies {below}, not {u}");
            let direct = phase.evaluate(cos, Vec3::ZERO);
            assert!((sample.value - direct).abs() <= 1e-9 * direct.max(1.0), "{name}");
        }
    }
}

#[test]
fn a_blend_chooses_by_its_weight() {
    let (_, blend, mean) = examples().pop().unwrap();
    let n = 400u32;
    let mut sum = 0.0;
    for i in 0..n {
        for j in 0..n {
            let [u, choice] = [i, j].map(|k| (f64::from(k) + 0.5) / f64::from(n));
            sum += blend.sample(Vec3::Z, Vec3::ZERO, [u, 0.1, choice]).direction.z;
        }
    }
    assert!((sum / f64::from(n * n) - mean).abs() < 1e-4, "{sum}");
}

/// Around any axis alike: the mean direction is the mean cosine along the way that light comes.
#[test]
fn directions_turn_about_the_way_that_light_comes() {
    let comes = Vec3::new(0.36, -0.48, 0.8);
    let n = 256u32;
    let mut mean = Vec3::ZERO;
    for i in 0..n {
        for j in 0..n {
            let [u, v] = [i, j].map(|k| (f64::from(k) + 0.5) / f64::from(n));
            let sample = Phase::HenyeyGreenstein(0.6).sample(comes, Vec3::ZERO, [u, v, 0.5]);
            assert!((sample.direction.length() - 1.0).abs() < 1e-12);
            mean += sample.direction / f64::from(n * n);
        }
    }
    assert!((mean - comes * 0.6).length() < 1e-4, "{mean}");
}

#[test]
fn values_that_are_known() {
    let forward = Phase::HenyeyGreenstein(0.8).evaluate(1.0, Vec3::ZERO);
    assert!((forward - 1.8 / (0.2 * 0.2 * 4.0 * PI)).abs() < 1e-12);
    assert!((Phase::Rayleigh.evaluate(-1.0, Vec3::ZERO) - 3.0 / (8.0 * PI)).abs() < 1e-15);
    for bad in [&[1.0][..], &[0.0, 0.0], &[1.0, -1.0], &[f64::NAN, 1.0]] {
        assert!(PhaseTable::new(bad).is_none(), "{bad:?}");
    }
}
