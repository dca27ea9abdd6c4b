//! Numbers stay finite whatever comes in.

use super::*;

/// Random inputs, a quarter of a million, grazing, parallel, extreme or outside reason: every number is
/// finite and not negative.
#[test]
fn nothing_is_nan() {
    fn check<const C: usize>(inputs: u32) {
        let mut uniform = Uniform::new(5);
        for _ in 0..inputs {
            let extreme = |uniform: &mut Uniform, low: f64, high: f64| {
                let u = uniform.next();
                let log = |u: f64| low * (high / low).powf(u);
                if u < 0.1 {
                    low
                } else if u > 0.9 {
                    high
                } else {
                    log(uniform.next())
                }
            };
            let share = |uniform: &mut Uniform| match uniform.next() {
                u if u < 0.1 => 0.0,
                u if u < 0.3 => 1.0,
                _ => uniform.next(),
            };
            let lanes = |uniform: &mut Uniform, f: &dyn Fn(&mut Uniform) -> f64| {
                let same = uniform.next() < 0.3;
                let first = f(uniform);
                Sampled::<C>(std::array::from_fn(|_| if same { first } else { f(uniform) }))
            };
            let index = |uniform: &mut Uniform| match uniform.next() {
                u if u < 0.1 => 1.0,
                u if u < 0.3 => 1.0 + (uniform.next() - 0.5) * extreme(uniform, 1e-16, 1e-3),
                _ => extreme(uniform, 0.05, 20.0),
            };
            let absorption = |uniform: &mut Uniform| match uniform.next() {
                u if u < 0.2 => 0.0,
                _ => extreme(uniform, 1e-12, 100.0),
            };
            let graze = |uniform: &mut Uniform| {
                let z = match uniform.next() {
                    u if u < 0.05 => 0.0,
                    u if u < 0.1 => 1.0,
                    u if u < 0.4 => extreme(uniform, 1e-300, 0.1),
                    _ => uniform.next(),
                };
                at(if uniform.next() < 0.5 { z } else { -z }, uniform.between(0.0, TAU))
            };
            let distribution = if uniform.next() < 0.5 { Distribution::Beckmann } else { Distribution::Ggx };
            let microfacets = Microfacets::new(
                distribution,
                extreme(&mut uniform, 1e-4, 3.0),
                extreme(&mut uniform, 1e-4, 3.0),
            );
            let conductor = Conductor {
                eta: lanes(&mut uniform, &absorption),
                k: lanes(&mut uniform, &absorption),
                specular_reflectance: lanes(&mut uniform, &share),
            };
            let dielectric = Dielectric {
                eta: lanes(&mut uniform, &index),
                specular_reflectance: lanes(&mut uniform, &share),
                specular_transmittance: lanes(&mut uniform, &share),
            };
            let reflectance = lanes(&mut uniform, &share);
            let bsdf = match uniform.between(0.0, 16.0) as u32 {
                0 => Bsdf::Lambert(Lambert { reflectance }),
                1 => Bsdf::DiffuseTransmitter(DiffuseTransmitter {
                    reflectance,
                    transmittance: Sampled::ONE - reflectance,
                }),
                2 => Bsdf::Conductor(conductor),
                3 | 4 => Bsdf::RoughConductor(RoughConductor { facet: conductor, microfacets }),
                5 => Bsdf::Dielectric(dielectric),
                10..=13 => layered::random(&mut uniform, dielectric, reflectance),
                15 => measured::random(&mut uniform),
                14 => {
                    let absorption = lanes(&mut uniform, &absorption);
                    hair::random(&mut uniform, dielectric.eta.hero(), absorption)
                }
                _ => Bsdf::RoughDielectric(RoughDielectric { facet: dielectric, microfacets }),
            };
            let eye = graze(&mut uniform);
            let light = match uniform.next() {
                u if u < 0.1 => eye,
                u if u < 0.2 => -eye,
                u if u < 0.3 => Vec3::new(-eye.x, -eye.y, eye.z),
                _ => graze(&mut uniform),
            };
            let whole = |values: Sampled<C>| values.0.iter().all(|v| v.is_finite() && *v >= 0.0);
            let found = bsdf.evaluate(eye, light);
            assert!(whole(found.f_cos) && whole(found.density), "{bsdf:?} {eye:?} {light:?}: {found:?}");
            let u = |uniform: &mut Uniform| match uniform.next() {
                u if u < 0.05 => 0.0,
                u if u < 0.1 => 1.0 - f64::EPSILON / 2.0,
                _ => uniform.next(),
            };
            let (lobe, pair) = (u(&mut uniform), [u(&mut uniform), u(&mut uniform)]);
            if let Some(scatter) = bsdf.sample(eye, lobe, pair) {
                let what = format!("{bsdf:?} {eye:?}, {lobe}, {pair:?}: {scatter:?}");
                assert!(whole(scatter.weight) && whole(scatter.ratio), "{what}");
                assert!((scatter.toward_light.length() - 1.0).abs() < 1e-9, "{what}");
                if let Density::PerSolidAngle(density) = scatter.density {
                    assert!(density.is_finite() && density > 0.0, "{what}");
                }
            }
        }
    }
    check::<1>(stress::count(75_000, 3_000_000));
    check::<4>(stress::count(125_000, 5_000_000));
    check::<8>(stress::count(50_000, 2_000_000));
}
