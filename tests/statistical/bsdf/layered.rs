//! Plastic, principled and thin surfaces: their places in the shared table, and Mitsuba's values.

use super::*;
use abbe::bsdf::{RoughCoat, fresnel};
use std::collections::BTreeMap;

fn base<const C: usize>() -> PrincipledBase<C> {
    PrincipledBase {
        color: ramp(0.8, -0.08),
        tint: ramp(1.2, -0.1),
        roughness: 0.5,
        anisotropic: 0.0,
        spec_trans: 0.0,
        spec_tint: 0.0,
        sheen: 0.0,
        sheen_tint: 0.0,
        flatness: 0.0,
    }
}

fn solid<const C: usize>(base: PrincipledBase<C>, eta: f64) -> Principled<C> {
    Principled { base, metallic: 0.0, clearcoat: 0.0, clearcoat_gloss: 0.0, eta, albedo: None }
}

fn coat(distribution: Distribution, alpha: f64, eta: f64) -> &'static RoughCoat {
    RoughCoat::shared(distribution, alpha, eta)
}

pub fn table<const C: usize>() -> Vec<(String, Bsdf<C>)> {
    let diffuse = DiffuseBase { reflectance: ramp(0.7, -0.08), nonlinear: false };
    let specular_reflectance = ramp(1.0, -0.1);
    let pane = ThinDielectric {
        eta: ramp(1.5, 0.02),
        specular_reflectance,
        specular_transmittance: ramp(0.9, -0.1),
    };
    let plastic = Plastic::new(ramp(1.5, 0.02), diffuse, specular_reflectance);
    let nonlinear = DiffuseBase { nonlinear: true, ..diffuse };
    let rough = |distribution, alpha| {
        Bsdf::RoughPlastic(RoughPlastic {
            coat: coat(distribution, alpha, 1.5),
            base: nonlinear,
            specular_reflectance,
        })
    };
    let all = PrincipledBase {
        anisotropic: 0.6,
        spec_trans: 0.5,
        spec_tint: 0.5,
        sheen: 0.4,
        sheen_tint: 0.5,
        flatness: 0.3,
        ..base()
    };
    let coated = Principled {
        metallic: 0.3,
        clearcoat: 0.8,
        clearcoat_gloss: 0.3,
        ..solid(PrincipledBase { spec_trans: 0.0, ..all }, 1.5)
    };
    let glass = PrincipledBase { spec_trans: 1.0, roughness: 0.6, ..base() };
    let thin =
        |base, diff_trans, eta| Bsdf::PrincipledThin(PrincipledThin { base, diff_trans, eta, albedo: None });
    let bright = PrincipledBase { sheen: 2.0, ..all };
    let entries = [
        ("pane", Bsdf::ThinDielectric(pane)),
        ("plastic", Bsdf::Plastic(plastic)),
        ("nonlinear plastic", Bsdf::Plastic(Plastic::new(plastic.eta, nonlinear, specular_reflectance))),
        ("rough plastic, GGX 0.3", rough(Distribution::Ggx, 0.3)),
        ("rough plastic, Beckmann 0.1", rough(Distribution::Beckmann, 0.1)),
        ("principled", Bsdf::Principled(solid(base(), 1.5))),
        ("principled, coated", Bsdf::Principled(coated)),
        ("principled, everything", Bsdf::Principled(Principled { base: all, ..coated })),
        ("principled glass", Bsdf::Principled(solid(glass, 1.5))),
        ("principled bubble", Bsdf::Principled(solid(glass, 0.75))),
        ("thin diffuse", thin(PrincipledBase { sheen: 0.4, ..base() }, 0.7, 1.5)),
        ("thin, everything", thin(all, 1.2, 1.4)),
        ("thin bubble", thin(glass, 0.0, 0.8)),
        (
            "principled, conserving",
            conserving(Bsdf::Principled(Principled { base: bright, clearcoat: 1.5, ..coated }), false),
        ),
        ("thin, conserving", conserving(thin(PrincipledBase { spec_trans: 0.0, ..bright }, 1.2, 1.4), true)),
    ];
    entries.map(|(name, bsdf)| (name.to_owned(), bsdf)).into()
}

/// The same surface, kept from making energy by tables for it alone or, if it `varies`, for all of its index.
pub fn conserving<const C: usize>(bsdf: Bsdf<C>, varies: bool) -> Bsdf<C> {
    let of = |share: f64| (!varies).then_some(share);
    let extent = |base: PrincipledBase<C>, thin, eta, gloss| Extent {
        thin,
        eta,
        roughness: of(base.roughness),
        anisotropic: of(base.anisotropic),
        gloss,
    };
    match bsdf {
        Bsdf::Principled(solid) => {
            let extent = extent(solid.base, false, solid.eta, of(solid.clearcoat_gloss));
            Bsdf::Principled(Principled { albedo: Some(Albedo::shared(extent)), ..solid })
        }
        Bsdf::PrincipledThin(sheet) => {
            let extent = extent(sheet.base, true, sheet.eta, Some(0.0));
            Bsdf::PrincipledThin(PrincipledThin { albedo: Some(Albedo::shared(extent)), ..sheet })
        }
        other => other,
    }
}

/// Parameters up to and beyond the ends of their ranges.
pub fn random<const C: usize>(
    uniform: &mut Uniform,
    dielectric: Dielectric<C>,
    reflectance: Sampled<C>,
) -> Bsdf<C> {
    let share = |uniform: &mut Uniform| match uniform.next() {
        u if u < 0.2 => 0.0,
        u if u < 0.3 => 1.0,
        _ => uniform.next(),
    };
    let diffuse = DiffuseBase { reflectance, nonlinear: uniform.next() < 0.5 };
    let specular_reflectance = dielectric.specular_reflectance;
    let base = PrincipledBase {
        color: reflectance,
        tint: dielectric.specular_reflectance * 3.0,
        roughness: share(uniform),
        anisotropic: share(uniform),
        spec_trans: share(uniform),
        spec_tint: share(uniform),
        sheen: 2.0 * share(uniform),
        sheen_tint: share(uniform),
        flatness: share(uniform),
    };
    // Without a jump of the index there is no facet to refract; the reader sees to it.
    let eta = dielectric.eta.hero();
    let eta = if (eta - 1.0).abs() < 1e-4 { 1.001 } else { eta };
    match uniform.between(0.0, 6.0) as u32 {
        0 => Bsdf::ThinDielectric(ThinDielectric {
            eta: dielectric.eta,
            specular_reflectance,
            specular_transmittance: dielectric.specular_transmittance,
        }),
        1 => Bsdf::Plastic(Plastic::new(dielectric.eta, diffuse, specular_reflectance)),
        2 => {
            let alpha = [1e-4, 0.1, 1.0][uniform.between(0.0, 3.0) as usize];
            let coat = coat(Distribution::Ggx, alpha, [0.7, 1.5][uniform.between(0.0, 2.0) as usize]);
            Bsdf::RoughPlastic(RoughPlastic { coat, base: diffuse, specular_reflectance })
        }
        3 | 4 => Bsdf::Principled(Principled {
            base,
            metallic: share(uniform),
            clearcoat: 2.0 * share(uniform),
            clearcoat_gloss: share(uniform),
            eta,
            albedo: None,
        }),
        _ => {
            Bsdf::PrincipledThin(PrincipledThin { base, diff_trans: 2.0 * share(uniform), eta, albedo: None })
        }
    }
}

/// Values of Mitsuba 3 in single precision (validation/optics/make_layered_reference.py). Those of rough
/// plastic rest on tables that Mitsuba integrates with too few facets for more than 0.1 %, those of smooth
/// plastic on a fit, whose error is taken out.
#[test]
fn layered_values_are_mitsubas() {
    let reference = include_str!("../../data/layered_reference.csv");
    let numbers = |line: &str, word: &str| -> Option<Sampled<4>> {
        let values: Vec<f64> =
            line.strip_prefix(word)?.split(' ').map(|number| number.parse().unwrap()).collect();
        Some(Sampled(values.try_into().unwrap()))
    };
    let named = |word: &str| reference.lines().find_map(|line| numbers(line, word)).unwrap();
    let (color, tint) = (named("# colour "), named("# tint "));
    let mut worst = BTreeMap::new();
    for line in reference.lines().filter(|line| !line.starts_with('#')).skip(1) {
        let fields: Vec<&str> = line.split(',').collect();
        let parameters: BTreeMap<&str, &str> =
            fields[1].split(' ').filter_map(|word| word.split_once('=')).collect();
        let bsdf = read(fields[0], &parameters, color, tint);
        let numbers: Vec<f64> = fields[2..].iter().map(|field| field.parse().unwrap()).collect();
        let vector = |first: usize| Vec3::from_slice(&numbers[first..first + 3]).normalize();
        let found = bsdf.evaluate(vector(0), vector(3));
        let allowed = match fields[0] {
            // A coat that is thinner than what surrounds it lets nearly nothing through beyond the critical
            // angle.
            "roughplastic" if fields[1].contains("int_ior=0.8") => 3e-3,
            "roughplastic" => 1e-3,
            _ => 1e-4,
        };
        for lane in 0..4 {
            let fitted = match &bsdf {
                Bsdf::Plastic(plastic) => interreflection_by_fit(plastic, lane),
                _ => 1.0,
            };
            let error = (found.f_cos[lane] * fitted / numbers[6 + lane] - 1.0).abs();
            assert!(error < allowed, "{line}: {found:?}, lane {lane} off by {error:e}");
            let worst = worst.entry(fields[0]).or_insert(0.0);
            *worst = error.max(*worst);
        }
    }
    println!("{worst:?}");
    assert_eq!(worst.len(), 4);
}

/// By what factor Mitsuba's fit of the inner reflectance changes the interreflection of plastic. The fit is
/// that of Egan and Hilgeman, "Spectral reflectance of particulate materials", Applied Optics 12 (1973), and
/// where the coat is the thinner medium that of d'Eon and Irving, "A Quantized-Diffusion Model for Rendering
/// Translucent Materials", SIGGRAPH 2011.
fn interreflection_by_fit(plastic: &Plastic<4>, lane: usize) -> f64 {
    let eta = plastic.eta[lane].recip();
    let fit = if eta < 1.0 {
        (-1.4399 * eta + 0.7099) * eta + 0.6681 + 0.0636 / eta
    } else {
        let coefficients = [-1.36881, 4.98554, -7.80989, 6.75335, -3.4793, 0.919_317];
        coefficients.into_iter().fold(0.0, |sum, coefficient| sum / eta + coefficient)
    };
    let coloured = if plastic.base.nonlinear { plastic.base.reflectance[lane] } else { 1.0 };
    (1.0 - coloured * fresnel::diffuse_reflectance(eta)) / (1.0 - coloured * fit)
}

fn read(plugin: &str, given: &BTreeMap<&str, &str>, color: Sampled<4>, tint: Sampled<4>) -> Bsdf<4> {
    let number = |name: &str| given.get(name).map_or(0.0, |value| value.parse::<f64>().unwrap());
    let diffuse = DiffuseBase { reflectance: color, nonlinear: number("nonlinear") == 1.0 };
    let base = PrincipledBase {
        color,
        tint,
        roughness: if given.contains_key("roughness") { number("roughness") } else { 0.5 },
        anisotropic: number("anisotropic"),
        spec_trans: number("spec_trans"),
        spec_tint: number("spec_tint"),
        sheen: number("sheen"),
        sheen_tint: number("sheen_tint"),
        flatness: number("flatness"),
    };
    let (eta, int_ior) = (number("eta"), number("int_ior"));
    let specular_reflectance = Sampled::ONE;
    match plugin {
        "plastic" => Bsdf::Plastic(Plastic::new(Sampled::splat(int_ior), diffuse, specular_reflectance)),
        "roughplastic" => {
            let distribution =
                if given["distribution"] == "ggx" { Distribution::Ggx } else { Distribution::Beckmann };
            let coat = coat(distribution, number("alpha"), int_ior);
            Bsdf::RoughPlastic(RoughPlastic { coat, base: diffuse, specular_reflectance })
        }
        "principled" => Bsdf::Principled(Principled {
            base,
            metallic: number("metallic"),
            clearcoat: number("clearcoat"),
            clearcoat_gloss: number("clearcoat_gloss"),
            eta,
            albedo: None,
        }),
        _ => {
            let diff_trans = number("diff_trans");
            Bsdf::PrincipledThin(PrincipledThin { base, diff_trans, eta, albedo: None })
        }
    }
}

/// A pane passes and mirrors all that arrives: `R' + T' = 1` with `R' = 2R/(1 + R)`, 1/13 for glass of 1.5 at
/// normal incidence (the slab of the Fresnel tests).
#[test]
fn pane_closed_form() {
    let pane = ThinDielectric {
        eta: Sampled([1.5]),
        specular_reflectance: Sampled::ONE,
        specular_transmittance: Sampled::ONE,
    };
    let bsdf = Bsdf::ThinDielectric(pane);
    for z in [1.0, 0.4, 0.01, -0.4] {
        let eye = at(z, 0.3);
        let passed = bsdf.null_transmittance(eye).hero();
        if z == 1.0 {
            assert!(close(passed, 12.0 / 13.0, 1e-14));
        }
        let (mirror, window) =
            (bsdf.sample(eye, 0.0, [0.5; 2]).unwrap(), bsdf.sample(eye, 1.0 - 1e-9, [0.5; 2]).unwrap());
        assert!(window.transmitted && window.toward_light == -eye && bsdf.has_null_transmission());
        assert!(!mirror.transmitted && mirror.toward_light.z == eye.z);
        assert!(close(mirror.weight.hero(), 1.0, 1e-14) && close(window.weight.hero(), 1.0, 1e-14));
    }
}
