//! A hero and its companions share one direction.

use super::*;

/// The estimator that a path makes of one scattering event: the hero decides, all lanes are weighed by
/// the balance heuristic over which lane could have been the hero. For every lane its mean over heroes
/// is that lane's own expectation of an arbitrary incident light.
fn spectral_estimator_is_unbiased<const C: usize>(bsdf: &Bsdf<C>, eye: Vec3, name: &str, level: f64) {
    let light = |v: Vec3| 1.0 + 0.5 * v.x + v.y * v.y * v.z + if v.z < 0.3 { 1.0 } else { 0.0 };
    let mut together = vec![Moments::default(); C];
    let mut own = vec![Moments::default(); C];
    let mut uniform = Uniform::new(4);
    for _ in 0..stress::count(10_000, 200_000) {
        for (hero, own) in own.iter_mut().enumerate() {
            // Lanes rotated so that `hero` comes first.
            let order: [usize; C] = std::array::from_fn(|i| (hero + i) % C);
            let rotated = with_lanes(bsdf, |values| Sampled(order.map(|lane| values[lane])));
            let mut contributions = [0.0; C];
            if let Some(scatter) = rotated.sample(eye, uniform.next(), uniform.pair()) {
                let densities = scatter.ratio.sum();
                for (i, lane) in order.into_iter().enumerate() {
                    contributions[lane] =
                        C as f64 * scatter.weight[i] / densities * light(scatter.toward_light);
                }
            }
            for (moments, contribution) in together.iter_mut().zip(contributions) {
                moments.push(contribution);
            }
            let single = alone(bsdf, hero).sample(eye, uniform.next(), uniform.pair());
            own.push(single.map_or(0.0, |s| s.weight.hero() * light(s.toward_light)));
        }
    }
    for lane in 0..C {
        let test = welch(&together[lane].estimate(), &own[lane].estimate());
        assert!(test.p_value > level, "{name}, lane {lane}: {:?} {:?} {test}", together[lane], own[lane]);
    }
}

/// Whether lanes have densities of their own.
fn parted(bsdf: &Bsdf<4>) -> bool {
    !matches!(
        bsdf,
        Bsdf::Black | Bsdf::Null | Bsdf::Lambert(_) | Bsdf::Conductor(_) | Bsdf::RoughConductor(_)
    )
}

#[test]
fn hero_and_companions_are_unbiased_together() {
    let strong = RoughDielectric {
        facet: glass::<4>(1.4, 0.1),
        microfacets: Microfacets::new(Distribution::Ggx, 0.2, 0.3),
    };
    let mut cases: Vec<(String, Bsdf<4>)> = vec![
        ("strongly dispersive rough glass".into(), Bsdf::RoughDielectric(strong)),
        ("strongly dispersive smooth glass".into(), Bsdf::Dielectric(glass(1.4, 0.1))),
    ];
    // Which distribution the facets have makes no difference to how lanes share a direction.
    let told = |name: &str| !name.contains("Beckmann") && !name.contains("0.05");
    cases.extend(table::<4>().into_iter().filter(|(name, bsdf)| parted(bsdf) && told(name)));
    // From below, past the critical angle of some lanes but not of others.
    let eyes = [at(0.7, 0.5), at(-0.69, 1.0), at(-0.2, 2.0)];
    let level = sidak(1e-3, cases.len() * eyes.len() * 4);
    for (name, bsdf) in &cases {
        for eye in eyes {
            spectral_estimator_is_unbiased(bsdf, eye, &format!("{name} from {eye}"), level);
        }
    }
}

/// Where companions part: only at the refraction of a lane whose index differs, each lane with its own
/// Fresnel reflectance, total or not.
#[test]
fn companions_part_only_where_they_must() {
    let flint = glass::<4>(1.6, 0.02);
    let eye = at(0.8, 0.0);
    let reflectance = |lane: usize| abbe::bsdf::fresnel::dielectric(0.8, flint.eta[lane]).reflectance;
    let reflected = Bsdf::Dielectric(flint).sample(eye, 0.0, [0.0; 2]).unwrap();
    let refracted = Bsdf::Dielectric(flint).sample(eye, 0.5, [0.0; 2]).unwrap();
    assert!(!reflected.transmitted && refracted.transmitted);
    for lane in 0..4 {
        let expected = reflectance(lane) / reflectance(0);
        assert!(
            close(reflected.weight[lane], expected, 1e-14) && close(reflected.ratio[lane], expected, 1e-14)
        );
        let stays = if lane == 0 { 1.0 } else { 0.0 };
        assert_eq!(refracted.ratio[lane], stays);
        assert_eq!(refracted.weight[lane] > 0.0, lane == 0);
    }
    let plain = Bsdf::Dielectric(glass::<4>(1.5, 0.0)).sample(eye, 0.5, [0.0; 2]).unwrap();
    assert_eq!(plain.ratio, Sampled::ONE);
    assert_eq!(plain.weight, Sampled::splat(plain.weight.hero()));
    // From inside at 39.5°: beyond the critical angle of 1.6 (38.7°) but not of 1.55 (40.2°).
    let inside = at(-39.5f64.to_radians().cos(), 0.0);
    let hero_total = Bsdf::Dielectric(glass::<2>(1.6, -0.05)).sample(inside, 0.99, [0.0; 2]).unwrap();
    assert!(!hero_total.transmitted && hero_total.ratio[1] < 1.0 && hero_total.ratio[1] > 0.1);
    let companion_total = Bsdf::Dielectric(glass::<2>(1.55, 0.05)).sample(inside, 0.0, [0.0; 2]).unwrap();
    assert!(!companion_total.transmitted);
    assert!(close(companion_total.weight[1] / companion_total.weight[0], companion_total.ratio[1], 1e-14));
    assert!(companion_total.ratio[1] > 1.0);
}
