//! BSDFs.

mod conductors;
mod hair;
mod measured;
mod nesting;
mod principled;
mod roughness;

use super::fields::Boolean;
use super::indices::{Exterior, Index, Interior};
use super::spectral::{Spectral, required, spectrum};
use super::{Simple, boolean, declare, float};
use crate::scene::description::{Bsdf, BsdfKind, NormalMapShading};
use crate::scene::read::spectra::{self, Use};
use crate::scene::read::{Class, ObjectId, Query, Reader};
use crate::scene::source::{Place, SceneError};
use crate::scene::write::{Node, Writer};
use conductors::Metal;
use measured::Measurement;
use nesting::{Held, Map, Sides};
use principled::{Base, RelativeIndex};
use roughness::{Coat, Rough};
use std::rc::Rc;
use std::sync::Arc;

declare! {
    Class::Bsdf => BsdfKind;

    "diffuse", "sends light back alike in all directions" => BsdfKind::Diffuse { reflectance } {
        reflectance: fraction("reflectance", 0.5, "fraction of the light that is sent back"),
    };
    "conductor", "smooth metal" => BsdfKind::Conductor { index, specular_reflectance, roughness: None } {
        index: Metal,
        specular_reflectance: SPECULAR_REFLECTANCE,
    };
    "roughconductor", "metal with a rough surface"
        => BsdfKind::Conductor { index, specular_reflectance, roughness: Some(roughness) } {
        index: Metal,
        specular_reflectance: SPECULAR_REFLECTANCE,
        roughness: Rough,
    } ignoring [roughness::sample_visible()];
    "dielectric", "the smooth surface of a clear body"
        => BsdfKind::Dielectric {
            interior, exterior, specular_reflectance, specular_transmittance, roughness: None
        } {
        interior: Interior,
        exterior: Exterior::SURROUNDINGS,
        specular_reflectance: SPECULAR_REFLECTANCE,
        specular_transmittance: SPECULAR_TRANSMITTANCE,
    };
    "roughdielectric", "the rough surface of a clear body"
        => BsdfKind::Dielectric {
            interior, exterior, specular_reflectance, specular_transmittance, roughness: Some(roughness)
        } {
        interior: Interior,
        exterior: Exterior::SURROUNDINGS,
        specular_reflectance: SPECULAR_REFLECTANCE,
        specular_transmittance: SPECULAR_TRANSMITTANCE,
        roughness: Rough,
    } ignoring [roughness::sample_visible()];
    "thindielectric", "a sheet of clear glass, both of its faces in one"
        => BsdfKind::ThinDielectric { interior, exterior, specular_reflectance, specular_transmittance } {
        interior: Interior,
        exterior: Exterior::AIR,
        specular_reflectance: SPECULAR_REFLECTANCE,
        specular_transmittance: SPECULAR_TRANSMITTANCE,
    };
    "plastic", "a smooth coat on a diffuse base"
        => BsdfKind::Plastic {
            interior, exterior, diffuse_reflectance, specular_reflectance, nonlinear, coat: None
        } {
        interior: COAT_INDEX,
        exterior: Exterior::AIR,
        diffuse_reflectance: DIFFUSE_REFLECTANCE,
        specular_reflectance: SPECULAR_REFLECTANCE,
        nonlinear: NONLINEAR,
    };
    "roughplastic", "a rough coat on a diffuse base"
        => BsdfKind::Plastic {
            interior, exterior, diffuse_reflectance, specular_reflectance, nonlinear, coat: Some(coat)
        } {
        interior: COAT_INDEX,
        exterior: Exterior::AIR,
        diffuse_reflectance: DIFFUSE_REFLECTANCE,
        specular_reflectance: SPECULAR_REFLECTANCE,
        nonlinear: NONLINEAR,
        coat: Coat,
    } ignoring [roughness::sample_visible()];
    "principled", "a mixture of metal, glass and coated diffuse surfaces by parameters without units"
        => BsdfKind::Principled { base, metallic, clearcoat, clearcoat_gloss, eta, conserve_energy } {
        base: Base,
        metallic: spectrum("metallic", Use::Fraction, 0.0, "fraction that is metal"),
        clearcoat: spectrum("clearcoat", Use::Amount, 0.0, "strength of a coat"),
        clearcoat_gloss: spectrum("clearcoat_gloss", Use::Fraction, 0.0, "how smooth that coat is"),
        eta: RelativeIndex,
        conserve_energy: CONSERVE_ENERGY,
    } ignoring [
        principled::rate("diffuse_reflectance_sampling_rate"),
        principled::rate("main_specular_sampling_rate"),
        principled::rate("clearcoat_sampling_rate"),
    ] then principled::with_refraction;
    "principledthin", "such a surface as a thin sheet"
        => BsdfKind::PrincipledThin { base, diff_trans, eta, conserve_energy } {
        base: Base,
        diff_trans: spectrum("diff_trans", Use::Amount, 0.0, "half the fraction of the diffuse light that gets through"),
        eta: spectrum("eta", Use::Amount, 1.5, "index of the sheet over that of its surroundings"),
        conserve_energy: CONSERVE_ENERGY,
    } ignoring [
        principled::rate("diffuse_reflectance_sampling_rate"),
        principled::rate("diffuse_transmittance_sampling_rate"),
        principled::rate("specular_reflectance_sampling_rate"),
        principled::rate("specular_transmittance_sampling_rate"),
    ] then principled::sound_sheet;
    "twosided", "a BSDF on both sides of a surface, or one on either"
        => BsdfKind::TwoSided { front, back, allow_transmission } {
        allow_transmission: boolean("allow_transmission", false, "whether light may get through"),
        (front, back): Sides,
    } then nesting::opaque;
    "mask", "a surface with holes" => BsdfKind::Mask { opacity, nested } {
        opacity: spectrum("opacity", Use::Weight, 0.5, "fraction that is there"),
        nested: Held("the BSDF of what is there"),
    };
    "blendbsdf", "a mixture of two BSDFs" => BsdfKind::Blend { weight, nested: [first, second] } {
        weight: required("weight", Use::Weight, "fraction of the second"),
        (first, second): nesting::Mixed,
    };
    "bumpmap", "a BSDF that is shaded as if the surface were raised"
        => BsdfKind::BumpMap {
            height, scale, shading: NormalMapShading { flip_invalid_normals, use_shadowing_function }, nested
        } {
        flip_invalid_normals: FLIP_INVALID_NORMALS,
        use_shadowing_function: USE_SHADOWING_FUNCTION,
        height: Map,
        scale: float("scale", 1.0, "factor on the heights"),
        nested: Held("the BSDF of the surface"),
    };
    "normalmap", "a BSDF that is shaded with other normals"
        => BsdfKind::NormalMap {
            normals, shading: NormalMapShading { flip_invalid_normals, use_shadowing_function }, nested
        } {
        flip_invalid_normals: FLIP_INVALID_NORMALS,
        use_shadowing_function: USE_SHADOWING_FUNCTION,
        normals: required("normalmap", Use::Normals, "normals by (n + 1) / 2, in raw values"),
        nested: Held("the BSDF of the surface"),
    };
    "hair", "a fibre of hair or fur, for `bsplinecurve` and `linearcurve`"
        => BsdfKind::Hair { absorption, interior, exterior, roughness: [along, around], scale_tilt } {
        absorption: hair::Absorption,
        interior: hair::INDEX,
        exterior: Exterior::AIR,
        along: hair::roughness("longitudinal_roughness", "roughness along the fibre"),
        around: hair::roughness("azimuthal_roughness", "roughness around the fibre"),
        scale_tilt: hair::SCALE_TILT,
    };
    "measured", "reflects as it was measured, by direction and wavelength; black on its back"
        => BsdfKind::Measured(source) {
        source: Measurement,
    };
    "null", "lets everything pass, as if there were no surface" => BsdfKind::Null {} {};
    "diffusetransmitter" extension "Lambertian reflection and transmission"
        => BsdfKind::DiffuseTransmitter { reflectance, transmittance } {
        reflectance: fraction("reflectance", 0.25, "fraction of the light that is sent back"),
        transmittance: fraction("transmittance", 0.25, "fraction of the light that is sent through"),
    } then loses_light;
}

const fn fraction(name: &'static str, default: f64, doc: &'static str) -> Spectral {
    spectrum(name, Use::Reflectance, default, doc)
}

const SPECULAR_REFLECTANCE: Spectral = fraction("specular_reflectance", 1.0, "factor on what is mirrored");

const SPECULAR_TRANSMITTANCE: Spectral =
    fraction("specular_transmittance", 1.0, "factor on what is transmitted");

const DIFFUSE_REFLECTANCE: Spectral = fraction("diffuse_reflectance", 0.5, "reflectance of the base");

/// Mitsuba 3's default for the `int_ior` of plastic.
const COAT_INDEX: Index =
    Index { name: "int_ior", default: 1.49, default_name: "polypropylene", doc: "index of the coat" };

const NONLINEAR: Simple<Boolean> =
    boolean("nonlinear", false, "whether light that is reflected inside is coloured each time");

// The default is not written: Mitsuba 3 would refuse the word.
const CONSERVE_ENERGY: Simple<Boolean> =
    boolean("conserve_energy", false, "whether the surface is kept from returning more than it gets")
        .extension("whether values are divided by what the surface would return beyond what it gets")
        .quiet();

const FLIP_INVALID_NORMALS: Simple<Boolean> =
    boolean("flip_invalid_normals", true, "whether a normal that is seen from behind is flipped");

const USE_SHADOWING_FUNCTION: Simple<Boolean> =
    boolean("use_shadowing_function", true, "whether the edge of the shadow is softened");

/// What a shape without `bsdf` has: half of the light back, or none where it emits.
pub fn default(place: &Place, emits: bool) -> Arc<Bsdf> {
    let reflectance = spectra::constant(place, if emits { 0.0 } else { 0.5 });
    Arc::new(Bsdf { place: place.clone(), id: None, kind: BsdfKind::Diffuse { reflectance } })
}

/// Reads a BSDF once, however often it is referred to. One that is wrong is reported and becomes the default.
pub fn read_once(reader: &Reader, id: ObjectId) -> Arc<Bsdf> {
    if let Some(known) = reader.bsdfs.borrow().get(&id) {
        return Arc::clone(known);
    }
    let query = Query::new(reader, id);
    let object = query.object;
    let bsdf = match read(&query) {
        Some(kind) => {
            query.finish();
            Arc::new(Bsdf { place: object.place.clone(), id: object.id.clone(), kind })
        }
        None => default(&object.place, false),
    };
    reader.bsdfs.borrow_mut().insert(id, Arc::clone(&bsdf));
    bsdf
}

/// Writes a BSDF once, however many surfaces share it.
pub fn node(bsdf: &Arc<Bsdf>, writer: &mut Writer) -> Rc<Node> {
    let key = Arc::as_ptr(bsdf);
    if let Some(known) = writer.bsdfs.get(&key) {
        return Rc::clone(known);
    }
    let node = Rc::new(write(&bsdf.kind, &bsdf.place, writer).id(&bsdf.id));
    writer.bsdfs.insert(key, Rc::clone(&node));
    node
}

/// Refuses a surface that sends on more than it gets.
fn loses_light(query: &Query<'_>, kind: BsdfKind) -> Option<BsdfKind> {
    let BsdfKind::DiffuseTransmitter { reflectance, transmittance } = &kind else { return Some(kind) };
    // Room for the rounding of values such as 0.7 + 0.3.
    if let Some((nm, sum)) =
        spectra::greatest_sum(reflectance, transmittance).filter(|(_, sum)| *sum > 1.0 + 1e-9)
    {
        let name = if query.has("transmittance") { "transmittance" } else { "reflectance" };
        query.error(
            SceneError::at(
                &query.place(name),
                format!("Reflectance and transmittance sum up to {sum:.6} at {nm} nm"),
                "expected a sum of at most 1 at every wavelength",
            )
            .with_remedy("each is 0.25 where it is not given"),
        );
    }
    Some(kind)
}
