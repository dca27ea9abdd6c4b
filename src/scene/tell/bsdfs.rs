use super::super::description::{
    Alpha, Bsdf, BsdfKind, CoatRoughness, ConductorIndex, IndexKind, IndexSource, MetalAssumption,
    NormalMapShading, PrincipledBase, Roughness,
};
use super::super::read::Class;
use super::spectra;
use super::{Teller, Told, Value};
use crate::bsdf::microfacet::Distribution;
use std::rc::Rc;
use std::sync::Arc;

pub(super) fn tell(teller: &mut Teller, bsdf: &Arc<Bsdf>) -> Rc<Told> {
    let key = Arc::as_ptr(bsdf);
    if let Some(known) = teller.bsdfs.get(&key) {
        return Rc::clone(known);
    }
    let told = Rc::new(kind(teller, bsdf));
    teller.bsdfs.insert(key, Rc::clone(&told));
    told
}

fn kind(teller: &mut Teller, bsdf: &Bsdf) -> Told {
    let told = |plugin| Told::new(Class::Bsdf, plugin, &bsdf.place).id(&bsdf.id);
    match &bsdf.kind {
        BsdfKind::Diffuse { reflectance } => told("diffuse").spectrum("reflectance", reflectance),
        BsdfKind::DiffuseTransmitter { reflectance, transmittance } => told("diffusetransmitter")
            .spectrum("reflectance", reflectance)
            .spectrum("transmittance", transmittance),
        BsdfKind::Conductor { index, specular_reflectance, roughness } => {
            let plugin = if roughness.is_some() { "roughconductor" } else { "conductor" };
            let told = conductor_index(told(plugin), index);
            rough(told.spectrum("specular_reflectance", specular_reflectance), roughness)
        }
        BsdfKind::Dielectric {
            interior,
            exterior,
            specular_reflectance,
            specular_transmittance,
            roughness,
        } => {
            let plugin = if roughness.is_some() { "roughdielectric" } else { "dielectric" };
            let told = index(told(plugin), "int_ior", interior);
            let told = match exterior {
                Some(exterior) => index(told, "ext_ior", exterior),
                None => told.remark("outside is whatever surrounds it, air outside everything"),
            };
            let told = told
                .spectrum("specular_reflectance", specular_reflectance)
                .spectrum("specular_transmittance", specular_transmittance);
            rough(told, roughness)
        }
        BsdfKind::ThinDielectric { interior, exterior, specular_reflectance, specular_transmittance } => {
            in_air(index(told("thindielectric"), "int_ior", interior), exterior)
                .spectrum("specular_reflectance", specular_reflectance)
                .spectrum("specular_transmittance", specular_transmittance)
        }
        BsdfKind::Plastic {
            interior,
            exterior,
            diffuse_reflectance,
            specular_reflectance,
            nonlinear,
            coat,
        } => {
            let plugin = if coat.is_some() { "roughplastic" } else { "plastic" };
            let told = in_air(index(told(plugin), "int_ior", interior), exterior)
                .spectrum("diffuse_reflectance", diffuse_reflectance)
                .spectrum("specular_reflectance", specular_reflectance)
                .boolean("nonlinear", *nonlinear);
            match coat {
                Some(CoatRoughness { distribution, alpha }) => {
                    told.text("distribution", distribution_name(*distribution)).float("alpha", *alpha)
                }
                None => told,
            }
        }
        BsdfKind::Principled { base, metallic, clearcoat, clearcoat_gloss, eta, conserve_energy } => {
            let told = principled(told("principled"), base)
                .spectrum("metallic", metallic)
                .spectrum("clearcoat", clearcoat)
                .spectrum("clearcoat_gloss", clearcoat_gloss)
                .float("eta", *eta);
            conserving(told, *conserve_energy)
        }
        BsdfKind::PrincipledThin { base, diff_trans, eta, conserve_energy } => {
            let told = principled(told("principledthin"), base)
                .spectrum("diff_trans", diff_trans)
                .spectrum("eta", eta);
            conserving(told, *conserve_energy)
        }
        BsdfKind::Null => told("null"),
        BsdfKind::Mask { opacity, nested } => {
            told("mask").spectrum("opacity", opacity).child(tell(teller, nested))
        }
        BsdfKind::Blend { weight, nested: [first, second] } => told("blendbsdf")
            .spectrum("weight", weight)
            .child(tell(teller, first))
            .child(tell(teller, second))
            .remark("the weight is that of the second"),
        BsdfKind::BumpMap { height, scale, shading, nested } => normal_map_shading(told("bumpmap"), *shading)
            .spectrum("texture", height)
            .float("scale", *scale)
            .child(tell(teller, nested)),
        BsdfKind::NormalMap { normals, shading, nested } => normal_map_shading(told("normalmap"), *shading)
            .spectrum("normalmap", normals)
            .child(tell(teller, nested)),
        BsdfKind::TwoSided { front, back, allow_transmission } => {
            let told = told("twosided")
                .boolean("allow_transmission", *allow_transmission)
                .child(tell(teller, front));
            match back {
                None => told.remark("the same on both sides"),
                Some(back) => {
                    told.child(tell(teller, back)).remark("the first is in front, the second behind")
                }
            }
        }
    }
}

fn normal_map_shading(told: Told, shading: NormalMapShading) -> Told {
    told.boolean("flip_invalid_normals", shading.flip_invalid_normals)
        .boolean("use_shadowing_function", shading.use_shadowing_function)
}

fn conductor_index(told: Told, index: &ConductorIndex) -> Told {
    match index {
        ConductorIndex::Mirror => told.text("material", "none").remark("a perfect mirror"),
        ConductorIndex::Complex { n, k } => told.spectrum("eta", n).spectrum("k", k),
        ConductorIndex::Named { name, .. } => told.text("material", name),
        ConductorIndex::NormalReflectance { reflectance, assumption } => {
            let told = told.spectrum("normal_reflectance", reflectance);
            match assumption {
                MetalAssumption::NoAbsorption => told.text("assume", "k=0"),
                MetalAssumption::UnitIndex => told.text("assume", "n=1"),
                MetalAssumption::KnownIndex(n) => told.spectrum("eta", n),
            }
        }
    }
}

fn index(told: Told, name: &'static str, index: &IndexSource) -> Told {
    let value = match &index.kind {
        IndexKind::Constant(value) => Value::Float(*value),
        IndexKind::Named(material) => spectra::measured(&index.place, material, 1.0),
        IndexKind::Formula(formula) => spectra::formula(&index.place, formula),
        IndexKind::Tabulated(table) => spectra::tell(table),
        IndexKind::NormalReflectance { reflectance, slab } => {
            let told = told.spectrum("normal_reflectance", reflectance);
            return if *slab { told.text("specimen", "slab") } else { told };
        }
    };
    told.property(Some(name.into()), value, Some(index.place.clone()))
}

fn rough(told: Told, roughness: &Option<Roughness>) -> Told {
    let Some(Roughness { distribution, alpha }) = roughness else { return told };
    let told = told.text("distribution", distribution_name(*distribution));
    match alpha {
        Alpha::Isotropic(alpha) => told.spectrum("alpha", alpha),
        Alpha::Anisotropic([u, v]) => told.spectrum("alpha_u", u).spectrum("alpha_v", v),
    }
}

fn distribution_name(distribution: Distribution) -> &'static str {
    match distribution {
        Distribution::Beckmann => "beckmann",
        Distribution::Ggx => "ggx",
    }
}

fn in_air(told: Told, exterior: &Option<IndexSource>) -> Told {
    match exterior {
        Some(exterior) => index(told, "ext_ior", exterior),
        None => told.remark("outside is air"),
    }
}

/// The default is not told: Mitsuba 3 would refuse the word.
fn conserving(told: Told, conserve_energy: bool) -> Told {
    if conserve_energy { told.boolean("conserve_energy", true) } else { told }
}

fn principled(told: Told, base: &PrincipledBase) -> Told {
    told.spectrum("base_color", &base.base_color)
        .spectrum("roughness", &base.roughness)
        .spectrum("anisotropic", &base.anisotropic)
        .spectrum("spec_trans", &base.spec_trans)
        .spectrum("spec_tint", &base.spec_tint)
        .spectrum("sheen", &base.sheen)
        .spectrum("sheen_tint", &base.sheen_tint)
        .spectrum("flatness", &base.flatness)
}
