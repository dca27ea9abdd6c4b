use super::*;
use crate::sampling::quadrature::midpoints;
use crate::spectrum::Spectrum;
use crate::stats::{SphereCells, sidak, sphere_chi_square};
use crate::units::WavelengthRange;
use std::f64::consts::PI;

const NM: [f64; 3] = [460.0, 530.0, 660.0];

/// The value for light that comes along z and goes on by a cosine, at the first wavelength.
fn at(phase: &Phase, cos: f64) -> f64 {
    let sin = ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt();
    phase.evaluate(Vec3::Z, Vec3::new(sin, 0.0, cos), Vec3::ZERO, &NM).hero()
}

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
        let at = |cos: f64| TAU * at(&phase, cos);
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
            let sample = phase.sample(Vec3::Z, Vec3::ZERO, &NM, [u, 0.3, 0.5]);
            let cos = sample.direction.z;
            let width = (cos + 1.0) / 400_000.0;
            let below: f64 = (0..400_000)
                .map(|i| {
                    let cos = -1.0 + (f64::from(i) + 0.5) * width;
                    TAU * at(&phase, cos) * width
                })
                .sum();
            assert!((below - u).abs() < 1e-6, "{name}: up to {cos} lies {below}, not {u}");
            let direct = at(&phase, cos);
            assert!((sample.value.hero() - direct).abs() <= 1e-9 * direct.max(1.0), "{name}");
        }
    }
}

#[test]
fn a_blend_chooses_by_its_weight() {
    let (_, blend, mean) = examples().pop().unwrap();
    let cosine = |[u, choice]: [f64; 2]| blend.sample(Vec3::Z, Vec3::ZERO, &NM, [u, 0.1, choice]).direction.z;
    let found = midpoints(400).map(cosine).sum::<f64>() / f64::from(400 * 400);
    assert!((found - mean).abs() < 1e-4, "{found}");
}

/// Around any axis alike: the mean direction is the mean cosine along the way that light comes.
#[test]
fn directions_turn_about_the_way_that_light_comes() {
    let comes = Vec3::new(0.36, -0.48, 0.8);
    let mut mean = Vec3::ZERO;
    for [u, v] in midpoints(256) {
        let sample = Phase::HenyeyGreenstein(0.6).sample(comes, Vec3::ZERO, &NM, [u, v, 0.5]);
        assert!((sample.direction.length() - 1.0).abs() < 1e-12);
        mean += sample.direction / f64::from(256 * 256);
    }
    assert!((mean - comes * 0.6).length() < 1e-4, "{mean}");
}

#[test]
fn values_that_are_known() {
    let forward = at(&Phase::HenyeyGreenstein(0.8), 1.0);
    assert!((forward - 1.8 / (0.2 * 0.2 * 4.0 * PI)).abs() < 1e-12);
    assert!((at(&Phase::Rayleigh, -1.0) - 3.0 / (8.0 * PI)).abs() < 1e-15);
    for bad in [&[1.0][..], &[0.0, 0.0], &[1.0, -1.0], &[f64::NAN, 1.0]] {
        assert!(PhaseTable::new(bad).is_none(), "{bad:?}");
    }
}

/// Phase functions that differ by wavelength or by direction.
fn uneven() -> Vec<(&'static str, Phase)> {
    let range = WavelengthRange { min: 400.0, max: 700.0 };
    let cosines = [-1.0, -0.5, 0.3, 0.9, 1.0];
    let rows =
        vec![vec![1.0, 0.5, 0.5, 2.0, 10.0], vec![3.0, 0.5, 0.1, 0.0, 1.0], vec![0.0, 0.0, 1.0, 1.0, 1.0]];
    let table = Phase::Spectral(Box::new(SpectralTable::new(range, &cosines, rows).unwrap()));
    let rising = Spectrum::regular(400.0, 700.0, &[0.0, 3.0], crate::spectrum::Extrapolation::Hold).unwrap();
    let parts = vec![
        (Spectrum::Constant(1.0), Phase::Rayleigh),
        (rising, Phase::HenyeyGreenstein(0.7)),
        (Spectrum::Constant(0.5), table.clone()),
    ];
    let flakes = |values| Phase::Sggx(Box::new(Sggx::new(values).unwrap()));
    vec![
        ("table", table),
        ("mixture", Phase::Mixture(Mixture(parts))),
        ("ball of flakes", flakes([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])),
        ("needle of flakes", flakes([0.15, 1.0, 0.8, 0.0, 0.0, 0.0])),
        ("skewed flakes", flakes([1.0, 0.35, 0.32, 0.52, 0.44, 0.2])),
    ]
}

/// Directions follow the value of the hero, whatever the companions.
#[test]
fn directions_follow_the_density() {
    let all = uneven();
    let ways = [Vec3::Z, Vec3::new(0.36, -0.48, 0.8), -Vec3::X];
    let level = sidak(0.01, all.len() * ways.len());
    for (name, phase) in &all {
        for comes in ways {
            let test = sphere_chi_square(
                SphereCells::default(),
                100_000,
                |u| Some(phase.sample(comes, Vec3::ZERO, &NM, u).direction),
                |goes| phase.evaluate(comes, goes, Vec3::ZERO, &NM).hero(),
            );
            assert!(test.p_value > level, "{name} from {comes}: {test:?}");
        }
    }
}

/// What a sample says of each wavelength is what the phase function says.
#[test]
fn samples_know_the_value_for_each_wavelength() {
    for (name, phase) in uneven() {
        let comes = Vec3::new(0.6, 0.0, 0.8);
        for u in [[0.1, 0.2, 0.3], [0.9, 0.5, 0.7], [0.5, 0.99, 0.01]] {
            let sample = phase.sample(comes, Vec3::ZERO, &NM, u);
            let direct = phase.evaluate(comes, sample.direction, Vec3::ZERO, &NM);
            for lane in 0..NM.len() {
                let alone = phase.evaluate(comes, sample.direction, Vec3::ZERO, &[NM[lane]]).hero();
                let difference = (sample.value[lane] - direct[lane]).abs().max((alone - direct[lane]).abs());
                assert!(difference <= 1e-9 * alone.max(1.0), "{name}: {sample:?}, {direct:?}, {alone}");
            }
        }
    }
}

/// Mitsuba 3.9.1 (`scalar_spectral`): value and projected area, for directions away from the place.
#[test]
fn flakes_are_those_of_mitsuba() {
    let flakes = Sggx::new([1.0, 0.35, 0.32, 0.52, 0.44, 0.2]).unwrap();
    let cases = [
        ([0.0, 0.0, 1.0], [0.6, 0.0, 0.8], 0.052_312_683, 0.565_685_391),
        ([0.48, 0.6, 0.64], [0.0, -1.0, 0.0], 0.014_049_188, 1.100_421_667),
        ([1.0, 0.0, 0.0], [-0.8, 0.36, 0.48], 0.015_884_435, 1.0),
    ];
    for (eye, goes, value, area) in cases {
        let (eye, goes) = (Vec3::from_array(eye), Vec3::from_array(goes));
        let found = flakes.evaluate(-eye, goes);
        assert!((found / value - 1.0).abs() < 1e-4, "{eye}: {found}, not {value}");
        assert!((flakes.projected_area(eye) / area - 1.0).abs() < 1e-5, "{eye}");
        assert!(flakes.projected_area(eye) <= flakes.max_projected_area());
    }
    // A ball of flakes looks the same from all sides and scatters alike into all directions.
    let ball = Sggx::new([1.0, 1.0, 1.0, 0.0, 0.0, 0.0]).unwrap();
    assert!((ball.evaluate(Vec3::X, Vec3::Y) - 0.25 * FRAC_1_PI).abs() < 1e-15);
    for bad in
        [[1.0, 1.0, 0.0, 0.0, 0.0, 0.0], [1.0, 1.0, 1.0, 2.0, 0.0, 0.0], [-1.0, 1.0, 1.0, 0.0, 0.0, 0.0]]
    {
        assert!(Sggx::new(bad).is_none(), "{bad:?}");
    }
}
