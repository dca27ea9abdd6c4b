//! Media: what absorbs and scatters in space.

use super::fields::Float;
use super::spectral::Quantity;
use super::{Field, Ignored, Parameter, Simple, Takes, declare, float, ignored, phases};
use crate::scene::description::{Medium, Phase, SpectrumKind, SpectrumSource};
use crate::scene::read::spectra::Use;
use crate::scene::read::textures::varies;
use crate::scene::read::{Class, ObjectId, Query, Reader};
use crate::scene::source::SceneError;
use crate::scene::write::{Node, Writer};

/// A medium as it is written: the factor by itself, for multiplied into the values it could round to others.
pub enum Content {
    Homogeneous { extinction: SpectrumSource, scale: f64, albedo: SpectrumSource, phase: Phase },
    Heterogeneous { extinction: SpectrumSource, scale: f64, albedo: SpectrumSource, phase: Phase },
}

declare! {
    Class::Medium => Content;

    "homogeneous", "the same everywhere" => Content::Homogeneous { extinction, scale, albedo, phase } {
        extinction: EXTINCTION,
        scale: SCALE,
        albedo: ALBEDO,
        phase: PhaseFunction,
    } ignoring [weighed("sample_emitters"), weighed("has_spectral_extinction")] then steady;
    "heterogeneous", "may vary from place to place"
        => Content::Heterogeneous { extinction, scale, albedo, phase } {
        extinction: EXTINCTION,
        scale: SCALE,
        albedo: ALBEDO,
        phase: PhaseFunction,
    } ignoring [weighed("sample_emitters"), weighed("has_spectral_extinction")] then steady;
}

const EXTINCTION: Quantity = Quantity {
    name: "sigma_t",
    purpose: Use::Absorption,
    default: Some(1.0),
    doc: "what is absorbed and scattered per unit of length",
};

const SCALE: Simple<Float> = float("scale", 1.0, "factor on `sigma_t`")
    .not_negative()
    .said("The medium is scaled by {}", "expected a factor of at least 0");

/// Mitsuba 3's default.
const ALBEDO: Quantity = Quantity {
    name: "albedo",
    purpose: Use::Albedo,
    default: Some(0.75),
    doc: "fraction of that which is scattered",
};

fn weighed(name: &'static str) -> Ignored {
    ignored(name, Takes::Boolean, "lights are sampled, and all wavelengths are weighed")
}

/// In what directions a medium scatters.
struct PhaseFunction;

impl Field for PhaseFunction {
    type Value = Phase;

    fn parameters(&self) -> Vec<Parameter> {
        let doc = "in what directions it scatters; otherwise `isotropic`";
        vec![Parameter { doc, ..Parameter::new("", Takes::Object("phase")) }]
    }

    fn read(&self, query: &Query<'_>) -> Option<Phase> {
        Some(phases::of_medium(query))
    }

    fn write(&self, node: Node, phase: &Phase, writer: &mut Writer) -> Node {
        node.child(phases::node(phase, writer))
    }
}

/// `None` where the medium is wrong, which is reported.
pub fn of_object(reader: &Reader, id: ObjectId) -> Option<Medium> {
    let query = Query::new(reader, id);
    let object = query.object;
    let content = read(&query)?;
    query.finish();
    let varies = matches!(content, Content::Heterogeneous { .. });
    let (Content::Homogeneous { extinction, scale, albedo, phase }
    | Content::Heterogeneous { extinction, scale, albedo, phase }) = content;
    let extinction = SpectrumSource { scale: extinction.scale * scale, ..extinction };
    let (place, id) = (object.place.clone(), object.id.clone());
    Some(Medium { place, id, varies, extinction, albedo, phase })
}

pub fn node(medium: &Medium, writer: &mut Writer) -> Node {
    let Medium { place, id, varies, extinction, albedo, phase } = medium.clone();
    let scale = extinction.scale;
    let extinction = SpectrumSource { scale: 1.0, ..extinction };
    let content = match varies {
        true => Content::Heterogeneous { extinction, scale, albedo, phase },
        false => Content::Homogeneous { extinction, scale, albedo, phase },
    };
    write(&content, &place, writer).id(&id)
}

/// Refuses what varies where nothing may, and what varies over surfaces alone.
fn steady(query: &Query<'_>, content: Content) -> Option<Content> {
    let heterogeneous = matches!(content, Content::Heterogeneous { .. });
    let (Content::Homogeneous { extinction, albedo, .. } | Content::Heterogeneous { extinction, albedo, .. }) =
        &content;
    refuse_variation(query, "sigma_t", extinction, heterogeneous);
    refuse_variation(query, "albedo", albedo, heterogeneous);
    Some(content)
}

/// Refuses what varies where the medium is the same everywhere, and what varies over surfaces alone.
fn refuse_variation(query: &Query<'_>, name: &'static str, source: &SpectrumSource, heterogeneous: bool) {
    let is_grid = matches!(source.kind, SpectrumKind::Volume(_));
    if !varies(source) || heterogeneous && is_grid {
        return;
    }
    let problem = format!("\"{name}\" of {} varies from place to place", query.title());
    let error = SceneError::at(&query.place(name), problem, "expected a number or a spectrum");
    query.error(match (heterogeneous, is_grid) {
        (false, true) => error.with_remedy("use a `heterogeneous` medium"),
        _ => error.with_remedy("in a `heterogeneous` medium it may be a <volume type=\"gridvolume\">"),
    });
}
