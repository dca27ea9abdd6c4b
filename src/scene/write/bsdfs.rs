use super::super::description::{
    Alpha, Bsdf, BsdfKind, CoatRoughness, ConductorIndex, IndexKind, IndexSource, MetalAssumption,
    NormalMapShading, PrincipledBase, Roughness,
};
use super::super::read::Class;
use super::spectra;
use super::{Node, Value, Writer};
use crate::bsdf::microfacet::Distribution;
use std::rc::Rc;
use std::sync::Arc;

pub(super) fn write(writer: &mut Writer, bsdf: &Arc<Bsdf>) -> Rc<Node> {
    let key = Arc::as_ptr(bsdf);
    if let Some(known) = writer.bsdfs.get(&key) {
        return Rc::clone(known);
    }
    let node = Rc::new(kind(writer, bsdf));
    writer.bsdfs.insert(key, Rc::clone(&node));
    node
}

fn kind(writer: &mut Writer, bsdf: &Bsdf) -> Node {
    let node = |plugin| Node::new(Class::Bsdf, plugin, &bsdf.place).id(&bsdf.id);
    match &bsdf.kind {
        BsdfKind::Diffuse { reflectance } => node("diffuse").spectrum("reflectance", reflectance),
        BsdfKind::DiffuseTransmitter { reflectance, transmittance } => node("diffusetransmitter")
            .spectrum("reflectance", reflectance)
            .spectrum("transmittance", transmittance),
        BsdfKind::Conductor { index, specular_reflectance, roughness } => {
            let plugin = if roughness.is_some() { "roughconductor" } else { "conductor" };
            let node = conductor_index(node(plugin), index);
            rough(node.spectrum("specular_reflectance", specular_reflectance), roughness)
        }
        BsdfKind::Dielectric {
            interior,
            exterior,
            specular_reflectance,
            specular_transmittance,
            roughness,
        } => {
            let plugin = if roughness.is_some() { "roughdielectric" } else { "dielectric" };
            let node = index(node(plugin), "int_ior", interior);
            let node = match exterior {
                Some(exterior) => index(node, "ext_ior", exterior),
                None => node.remark("outside is whatever surrounds it, air outside everything"),
            };
            let node = node
                .spectrum("specular_reflectance", specular_reflectance)
                .spectrum("specular_transmittance", specular_transmittance);
            rough(node, roughness)
        }
        BsdfKind::ThinDielectric { interior, exterior, specular_reflectance, specular_transmittance } => {
            in_air(index(node("thindielectric"), "int_ior", interior), exterior)
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
            let node = in_air(index(node(plugin), "int_ior", interior), exterior)
                .spectrum("diffuse_reflectance", diffuse_reflectance)
                .spectrum("specular_reflectance", specular_reflectance)
                .boolean("nonlinear", *nonlinear);
            match coat {
                Some(CoatRoughness { distribution, alpha }) => {
                    node.text("distribution", distribution_name(*distribution)).float("alpha", *alpha)
                }
                None => node,
            }
        }
        BsdfKind::Principled { base, metallic, clearcoat, clearcoat_gloss, eta, conserve_energy } => {
            let node = principled(node("principled"), base)
                .spectrum("metallic", metallic)
                .spectrum("clearcoat", clearcoat)
                .spectrum("clearcoat_gloss", clearcoat_gloss)
                .float("eta", *eta);
            conserving(node, *conserve_energy)
        }
        BsdfKind::PrincipledThin { base, diff_trans, eta, conserve_energy } => {
            let node = principled(node("principledthin"), base)
                .spectrum("diff_trans", diff_trans)
                .spectrum("eta", eta);
            conserving(node, *conserve_energy)
        }
        BsdfKind::Null => node("null"),
        BsdfKind::Mask { opacity, nested } => {
            node("mask").spectrum("opacity", opacity).child(write(writer, nested))
        }
        BsdfKind::Blend { weight, nested: [first, second] } => node("blendbsdf")
            .spectrum("weight", weight)
            .child(write(writer, first))
            .child(write(writer, second))
            .remark("the weight is that of the second"),
        BsdfKind::BumpMap { height, scale, shading, nested } => normal_map_shading(node("bumpmap"), *shading)
            .spectrum("texture", height)
            .float("scale", *scale)
            .child(write(writer, nested)),
        BsdfKind::NormalMap { normals, shading, nested } => normal_map_shading(node("normalmap"), *shading)
            .spectrum("normalmap", normals)
            .child(write(writer, nested)),
        BsdfKind::TwoSided { front, back, allow_transmission } => {
            let node = node("twosided")
                .boolean("allow_transmission", *allow_transmission)
                .child(write(writer, front));
            match back {
                None => node.remark("the same on both sides"),
                Some(back) => {
                    node.child(write(writer, back)).remark("the first is in front, the second behind")
                }
            }
        }
    }
}

fn normal_map_shading(node: Node, shading: NormalMapShading) -> Node {
    node.boolean("flip_invalid_normals", shading.flip_invalid_normals)
        .boolean("use_shadowing_function", shading.use_shadowing_function)
}

fn conductor_index(node: Node, index: &ConductorIndex) -> Node {
    match index {
        ConductorIndex::Mirror => node.text("material", "none").remark("a perfect mirror"),
        ConductorIndex::Complex { n, k } => node.spectrum("eta", n).spectrum("k", k),
        ConductorIndex::Named { name, .. } => node.text("material", name),
        ConductorIndex::NormalReflectance { reflectance, assumption } => {
            let node = node.spectrum("normal_reflectance", reflectance);
            match assumption {
                MetalAssumption::NoAbsorption => node.text("assume", "k=0"),
                MetalAssumption::UnitIndex => node.text("assume", "n=1"),
                MetalAssumption::KnownIndex(n) => node.spectrum("eta", n),
            }
        }
    }
}

fn index(node: Node, name: &'static str, index: &IndexSource) -> Node {
    let value = match &index.kind {
        IndexKind::Constant(value) => Value::Float(*value),
        IndexKind::Named(material) => spectra::measured(&index.place, material, 1.0),
        IndexKind::Formula(formula) => spectra::formula(&index.place, formula),
        IndexKind::Tabulated(table) => spectra::write(table),
        IndexKind::NormalReflectance { reflectance, slab } => {
            let node = node.spectrum("normal_reflectance", reflectance);
            return if *slab { node.text("specimen", "slab") } else { node };
        }
    };
    node.property(Some(name.into()), value, Some(index.place.clone()))
}

fn rough(node: Node, roughness: &Option<Roughness>) -> Node {
    let Some(Roughness { distribution, alpha }) = roughness else { return node };
    let node = node.text("distribution", distribution_name(*distribution));
    match alpha {
        Alpha::Isotropic(alpha) => node.spectrum("alpha", alpha),
        Alpha::Anisotropic([u, v]) => node.spectrum("alpha_u", u).spectrum("alpha_v", v),
    }
}

fn distribution_name(distribution: Distribution) -> &'static str {
    match distribution {
        Distribution::Beckmann => "beckmann",
        Distribution::Ggx => "ggx",
    }
}

fn in_air(node: Node, exterior: &Option<IndexSource>) -> Node {
    match exterior {
        Some(exterior) => index(node, "ext_ior", exterior),
        None => node.remark("outside is air"),
    }
}

/// The default is not written: Mitsuba 3 would refuse the word.
fn conserving(node: Node, conserve_energy: bool) -> Node {
    if conserve_energy { node.boolean("conserve_energy", true) } else { node }
}

fn principled(node: Node, base: &PrincipledBase) -> Node {
    node.spectrum("base_color", &base.base_color)
        .spectrum("roughness", &base.roughness)
        .spectrum("anisotropic", &base.anisotropic)
        .spectrum("spec_trans", &base.spec_trans)
        .spectrum("spec_tint", &base.spec_tint)
        .spectrum("sheen", &base.sheen)
        .spectrum("sheen_tint", &base.sheen_tint)
        .spectrum("flatness", &base.flatness)
}
