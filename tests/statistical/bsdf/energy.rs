//! Energy is kept or lost as said, and light may run backwards.

use super::*;

/// Helmholtz: f is symmetric; through an interface f/η² is, with η of the side that light comes from.
/// Values here include the compression of radiance, so it is f_cos / |cos θ_light| times η_light².
#[test]
fn reciprocity() {
    for (name, bsdf) in table::<4>() {
        if is_one_way(&bsdf) {
            continue;
        }
        let mut uniform = Uniform::new(2);
        for _ in 0..2000 {
            let (a, b) = (uniform.direction(), uniform.direction());
            let (there, back) = (bsdf.evaluate(a, b), bsdf.evaluate(b, a));
            for lane in 0..4 {
                let eta = match bsdf {
                    Bsdf::RoughDielectric(rough) => rough.facet.eta[lane],
                    Bsdf::Principled(principled) => principled.eta,
                    _ => 1.0,
                };
                let index = |v: Vec3| if v.z > 0.0 { 1.0 } else { eta };
                // f(eye a, light b) · η_b² = f(eye b, light a) · η_a²
                let there = there.f_cos[lane] / b.z.abs() * index(b).powi(2);
                let back = back.f_cos[lane] / a.z.abs() * index(a).powi(2);
                assert!((there - back).abs() <= 1e-7 * there.max(1e-12), "{name}: {a}, {b}: {there} {back}");
            }
        }
    }
}

/// Mitsuba's thin glass cuts its transmitted lobe by a rule that is not the same when light runs backwards.
/// In hair, tilt and index count for the eye's direction alone. Measurements have errors.
fn is_one_way<const C: usize>(bsdf: &Bsdf<C>) -> bool {
    match bsdf {
        Bsdf::PrincipledThin(thin) => thin.base.spec_trans > 0.0,
        Bsdf::Hair(_) | Bsdf::Measured(_) => true,
        _ => false,
    }
}

/// Power that leaves for power that arrives, in a white furnace, estimated from samples. Weights are
/// for radiance: the power through an interface is η² times as much.
fn albedo(bsdf: &Bsdf<1>, eye: Vec3, samples: u32) -> Estimate {
    let mut uniform = Uniform::new(3);
    let moments: Moments = (0..samples)
        .map(|_| {
            let Some(scatter) = bsdf.sample(eye, uniform.next(), uniform.pair()) else { return 0.0 };
            let eta = bsdf.relative_index().unwrap_or(1.0);
            let eta = if eye.z > 0.0 { eta } else { 1.0 / eta };
            scatter.weight.hero() * if scatter.transmitted { eta * eta } else { 1.0 }
        })
        .collect();
    moments.estimate()
}

/// Smooth glass neither loses nor makes energy: reflected and transmitted weights times their
/// probabilities make exactly 1.
#[test]
fn smooth_glass_is_a_perfect_furnace() {
    for eta in [0.2, 0.75, 0.999, 1.0, 1.000277, 1.5, 2.42, 9.0] {
        for z in [1.0, 0.7, 0.3, 0.01, -0.01, -0.3, -0.745, -1.0] {
            let bsdf = Bsdf::Dielectric(glass::<1>(eta, 0.0));
            let relative: f64 = if z > 0.0 { eta } else { 1.0 / eta };
            for lobe in [0.0, 0.02, 0.3, 0.7, 1.0 - f64::EPSILON] {
                let scatter = bsdf.sample(at(z, 0.3), lobe, [0.5, 0.5]).unwrap();
                let power = if scatter.transmitted { relative * relative } else { 1.0 };
                assert!(close(scatter.weight.hero() * power, 1.0, 1e-13), "eta {eta}, z {z}: {scatter:?}");
            }
        }
    }
}

/// Rough white surfaces lose what facets would have passed on to one another, and never gain.
/// Conductors against the albedo that quadrature of `f_cos` gives, whose error is taken from halving its
/// step. Of the albedos of Cook and Torrance's model (Glassner 1989, ch. 4) only 1.000 ± 0.002 at m = 0.2 and
/// normal incidence is comparable: elsewhere their masking differs from Smith's.
#[test]
fn rough_furnaces_lose_energy() {
    let mirror = Conductor { eta: Sampled([0.0]), k: Sampled([0.0]), specular_reflectance: Sampled::ONE };
    for distribution in [Distribution::Beckmann, Distribution::Ggx] {
        for alpha in [0.01, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0] {
            let microfacets = Microfacets::new(distribution, alpha, alpha);
            for theta in [0.0, 0.7, 1.2, 1.5f64] {
                let eye = at(theta.cos(), 0.3);
                let bsdf = Bsdf::RoughConductor(RoughConductor { facet: mirror, microfacets });
                let metal = albedo(&bsdf, eye, 30_000);
                // The rational G1 of Beckmann may exceed Smith's by 0.4 %, squared.
                assert!(
                    metal.mean <= 1.008 + 4.0 * metal.error(),
                    "{distribution:?} {alpha} {theta}: {metal:?}"
                );
                if alpha > 0.1 {
                    let (coarse, fine) = (quadrature(&bsdf, eye, 150), quadrature(&bsdf, eye, 300));
                    let variance = (fine - coarse).powi(2);
                    let by_quadrature = Estimate { mean: fine, variance, degrees: f64::INFINITY };
                    let test = welch(&metal, &by_quadrature);
                    assert!(
                        test.p_value > 1e-5,
                        "{distribution:?} {alpha} {theta}: {metal:?}, {by_quadrature:?}, {test}"
                    );
                }
                let mut line =
                    format!("{distribution:?} alpha {alpha} theta {theta}: metal {:.4}", metal.mean);
                for (eye, side) in [(eye, "above"), (-eye, "below")] {
                    let rough = RoughDielectric { facet: glass(1.5, 0.0), microfacets };
                    let glass = albedo(&Bsdf::RoughDielectric(rough), eye, 30_000);
                    assert!(
                        glass.mean <= 1.008 + 4.0 * glass.error(),
                        "{distribution:?} {alpha} {theta}: {glass:?}"
                    );
                    line += &format!(", glass from {side} {:.4}", glass.mean);
                }
                println!("{line}");
                if distribution == Distribution::Beckmann && alpha <= 0.2 && theta == 0.0 {
                    assert!((metal.mean - 1.0).abs() < 0.002, "{line}");
                }
            }
        }
    }
}

/// A principled surface with parameters over all of their ranges, and of few indices, which the tables are
/// made for.
fn any_principled(uniform: &mut Uniform) -> Bsdf<1> {
    let share = |uniform: &mut Uniform| match uniform.next() {
        u if u < 0.25 => 0.0,
        u if u < 0.5 => 1.0,
        _ => uniform.next(),
    };
    let base = PrincipledBase {
        color: Sampled([share(uniform).max(0.5)]),
        // That of grey is around 3.
        tint: Sampled([3.0 * uniform.next()]),
        roughness: share(uniform),
        anisotropic: share(uniform),
        spec_trans: share(uniform),
        spec_tint: share(uniform),
        sheen: 3.0 * share(uniform),
        sheen_tint: share(uniform),
        flatness: share(uniform),
    };
    let eta = if uniform.next() < 0.5 { 1.5 } else { 0.7 };
    if uniform.next() < 0.4 {
        return Bsdf::PrincipledThin(PrincipledThin {
            base,
            diff_trans: 2.0 * share(uniform),
            eta,
            albedo: None,
        });
    }
    Bsdf::Principled(Principled {
        base,
        metallic: share(uniform),
        clearcoat: 2.0 * share(uniform),
        clearcoat_gloss: share(uniform),
        eta,
        albedo: None,
    })
}

/// At every angle and with any parameters; and where nothing is made, nothing is taken away. Sees about 5 %
/// too much.
#[test]
fn principled_surfaces_that_conserve_energy_make_none() {
    const SETS: usize = 48;
    let samples = stress::count(2000, 40_000);
    let mut uniform = Uniform::new(11);
    let (mut made, mut kept, mut greatest) = (0, 0, (f64::NEG_INFINITY, String::new()));
    for set in 0..SETS {
        let plain = any_principled(&mut uniform);
        let bsdf = layered::conserving(plain, set % 4 != 0);
        for z in [1.0, 0.9, 0.72, 0.7, uniform.next(), 0.3, 0.1, 0.03, -0.5] {
            let eye = at(z, uniform.between(0.0, TAU));
            let (before, after) = (albedo(&plain, eye, samples), albedo(&bsdf, eye, samples));
            made += usize::from(before.mean > 1.02 + 4.0 * before.error());
            kept += usize::from(before.mean == after.mean && before.mean > 0.0);
            // One of 9 · 48 estimates lies 4.4 standard errors beyond in four hundred such runs.
            let excess = (after.mean - 1.0) / after.error().max(1e-9);
            if excess > greatest.0 {
                greatest = (excess, format!("z {z}: {after:?}, {before:?}, {plain:?}"));
            }
            assert!(after.mean <= before.mean + 1e-12, "z {z}: {after:?}, {before:?}, {plain:?}");
        }
    }
    println!("{made} made energy, {kept} are as they were; {greatest:?}");
    assert!(greatest.0 < 4.4, "{greatest:?}");
    assert!(made > 50 && kept > 50, "{made} made energy, {kept} are as they were");
}

/// Without chance, where light is spread so widely that a sum over directions is exact: not above 1, and not
/// far below where energy was made.
#[test]
fn principled_surfaces_that_conserve_energy_lose_little() {
    for roughness in [0.5, 0.75, 1.0] {
        for (sheen, clearcoat) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)] {
            let base = PrincipledBase {
                color: Sampled::ONE,
                tint: Sampled::ONE,
                roughness,
                anisotropic: 0.0,
                spec_trans: 0.0,
                spec_tint: 0.0,
                sheen,
                sheen_tint: 0.0,
                flatness: 0.0,
            };
            let coated =
                Principled { base, metallic: 0.0, clearcoat, clearcoat_gloss: 0.0, eta: 1.5, albedo: None };
            let plain = Bsdf::Principled(coated);
            let bsdf = layered::conserving(plain, false);
            let mut line = format!("roughness {roughness}, sheen {sheen}, coat {clearcoat}:");
            for z in [1.0, 0.7, 0.4, 0.2, 0.1, 0.05] {
                let [before, after] = [plain, bsdf].map(|bsdf| quadrature(&bsdf, at(z, 0.3), 200));
                line += &format!(" {before:.4}→{after:.4}");
                assert!(before > 1.01, "{line}");
                assert!(after < 1.0 + 1e-4 && after > 0.8, "{line}");
            }
            println!("{line}");
        }
    }
}

/// `∫ f_cos` over the upper hemisphere by the midpoint rule.
fn quadrature(bsdf: &Bsdf<1>, eye: Vec3, rows: u32) -> f64 {
    let columns = rows;
    let mut sum = 0.0;
    for row in 0..rows {
        // z = 1 − t² crowds rows towards the normal, z = t² towards the horizon; a smoothstep does both.
        let t = (f64::from(row) + 0.5) / f64::from(rows);
        let (z, dz) = (t * t * (3.0 - 2.0 * t), 6.0 * t * (1.0 - t));
        for column in 0..columns {
            let light = at(z, TAU * (f64::from(column) + 0.5) / f64::from(columns));
            sum += bsdf.evaluate(eye, light).f_cos.hero() * dz;
        }
    }
    sum * TAU / f64::from(rows) / f64::from(columns)
}

/// Lambert reflects ρ of what arrives: irradiance π gives radiance ρ.
#[test]
fn lambert_closed_form() {
    let bsdf = Bsdf::Lambert(Lambert { reflectance: Sampled([0.6]) });
    let found = bsdf.evaluate(at(0.3, 0.0), at(0.5, 1.0));
    assert!(close(found.f_cos.hero(), 0.6 * 0.5 / PI, 1e-15));
    assert!(bsdf.evaluate(at(-0.3, 0.0), at(-0.5, 1.0)).f_cos.is_zero());
    assert!(bsdf.sample(at(-0.3, 0.0), 0.5, [0.5; 2]).is_none());
}
