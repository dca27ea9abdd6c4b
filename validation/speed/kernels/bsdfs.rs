//! Each BSDF: sampling and evaluating, at four wavelengths.

use super::{BATCH, Kernel};
use abbe::bsdf::microfacet::Distribution;
use abbe::bsdf::{
    Bsdf, Conductor, Dielectric, DiffuseBase, DiffuseTransmitter, Lambert, Microfacets, Plastic, Principled,
    PrincipledBase, PrincipledThin, RoughCoat, RoughConductor, RoughDielectric, RoughPlastic, ThinDielectric,
};
use abbe::geometry::Vec3;
use abbe::sampling::warp;
use abbe::spectrum::Sampled;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// A function of the lane: `first` at the hero, changing by `step` from lane to lane.
fn ramp(first: f64, step: f64) -> Sampled<4> {
    Sampled(std::array::from_fn(|lane| first + step * lane as f64))
}

fn table() -> Vec<(&'static str, Bsdf<4>)> {
    let one = Sampled::ONE;
    let metal = Conductor { eta: ramp(0.2, 0.3), k: ramp(3.0, -0.2), specular_reflectance: one };
    let glass = Dielectric { eta: ramp(1.5, 0.0), specular_reflectance: one, specular_transmittance: one };
    let flint = Dielectric { eta: ramp(1.6, 0.02), ..glass };
    let diffuse = DiffuseBase { reflectance: ramp(0.7, -0.1), nonlinear: true };
    let ggx = Microfacets::new(Distribution::Ggx, 0.3, 0.3);
    let beckmann = Microfacets::new(Distribution::Beckmann, 0.3, 0.3);
    let base = PrincipledBase {
        color: ramp(0.7, -0.1),
        tint: ramp(1.0, -0.1),
        roughness: 0.5,
        anisotropic: 0.6,
        spec_trans: 0.5,
        spec_tint: 0.5,
        sheen: 0.4,
        sheen_tint: 0.5,
        flatness: 0.3,
    };
    let coated =
        Principled { base, metallic: 0.3, clearcoat: 0.8, clearcoat_gloss: 0.3, eta: 1.5, albedo: None };
    let pane = ThinDielectric { eta: glass.eta, specular_reflectance: one, specular_transmittance: one };
    let coat = RoughCoat::shared(Distribution::Ggx, 0.3, 1.5);
    let leaf = DiffuseTransmitter { reflectance: ramp(0.5, -0.1), transmittance: ramp(0.1, 0.05) };
    vec![
        ("lambert", Bsdf::Lambert(Lambert { reflectance: ramp(0.8, -0.1) })),
        ("diffuse transmitter", Bsdf::DiffuseTransmitter(leaf)),
        ("conductor", Bsdf::Conductor(metal)),
        ("rough conductor, GGX", Bsdf::RoughConductor(RoughConductor { facet: metal, microfacets: ggx })),
        (
            "rough conductor, Beckmann",
            Bsdf::RoughConductor(RoughConductor { facet: metal, microfacets: beckmann }),
        ),
        ("glass", Bsdf::Dielectric(glass)),
        ("flint", Bsdf::Dielectric(flint)),
        ("rough glass, GGX", Bsdf::RoughDielectric(RoughDielectric { facet: glass, microfacets: ggx })),
        ("rough flint, GGX", Bsdf::RoughDielectric(RoughDielectric { facet: flint, microfacets: ggx })),
        ("pane", Bsdf::ThinDielectric(pane)),
        ("plastic", Bsdf::Plastic(Plastic::new(glass.eta, diffuse, one))),
        (
            "rough plastic, GGX",
            Bsdf::RoughPlastic(RoughPlastic { coat, base: diffuse, specular_reflectance: one }),
        ),
        ("principled", Bsdf::Principled(coated)),
        (
            "principled thin",
            Bsdf::PrincipledThin(PrincipledThin { base, diff_trans: 0.7, eta: 1.5, albedo: None }),
        ),
    ]
}

/// Directions from above and two sample values with each, and one for the lobe.
fn inputs() -> Vec<(Vec3, Vec3, f64, [f64; 2])> {
    let mut random = Pcg64::seed_from_u64(1);
    let mut pair = move || [random.random(), random.random()];
    (0..BATCH)
        .map(|_| {
            let mut direction = || Vec3::from(warp::cosine_hemisphere(pair()));
            let (eye, light) = (direction(), direction());
            (eye, light, pair()[0], pair())
        })
        .collect()
}

pub fn sampling() -> Vec<Kernel> {
    let kernel = |(name, bsdf): (&str, Bsdf<4>)| {
        let of = inputs();
        Kernel::batch(name, move |i| bsdf.sample(of[i].0, of[i].2, of[i].3))
    };
    table().into_iter().map(kernel).collect()
}

pub fn evaluation() -> Vec<Kernel> {
    let kernel = |(name, bsdf): (&str, Bsdf<4>)| {
        let of = inputs();
        Kernel::batch(name, move |i| bsdf.evaluate(of[i].0, of[i].1))
    };
    table().into_iter().filter(|(_, bsdf)| !bsdf.is_discrete()).map(kernel).collect()
}
