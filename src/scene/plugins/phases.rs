//! Phase functions: in what directions media scatter.

use super::fields::{Float, Numbers};
use super::spectral::Quantity;
use super::{Field, Parameter, Range, Simple, Takes, declare, float, numbers};
use crate::phase::PhaseTable;
use crate::scene::description::{Phase, PhaseKind, SpectrumKind};
use crate::scene::read::query::capital;
use crate::scene::read::spectra::Use;
use crate::scene::read::textures::varies;
use crate::scene::read::{Class, ObjectId, Query, Reader};
use crate::scene::source::SceneError;
use crate::scene::write::{Node, Writer};

declare! {
    Class::Phase => PhaseKind;

    "isotropic", "alike in all directions" => PhaseKind::Isotropic {} {};
    "hg", "the function of Henyey and Greenstein" => PhaseKind::HenyeyGreenstein { g } { g: MEAN_COSINE };
    "rayleigh", "of particles that are much smaller than the wavelength" => PhaseKind::Rayleigh {} {};
    "tabphase", "a table" => PhaseKind::Tabulated { values } { values: VALUES } then possible;
    "blendphase", "a mixture of two" => PhaseKind::Blend { weight, nested } {
        weight: Quantity {
            name: "weight", purpose: Use::Weight, default: None, doc: "fraction of the second"
        },
        nested: Two,
    } then over_volumes;
}

const MEAN_COSINE: Simple<Float> =
    float("g", 0.8, "mean cosine of the angle, from straight back to straight ahead")
        .within(Range { low: -1.0, with_low: false, high: 1.0, with_high: false })
        .said(
            "The mean cosine \"g\" is {}",
            "expected a number between -1 (straight back) and 1 (straight ahead)",
        );

const VALUES: Simple<Numbers> =
    numbers("values", "values at equal steps of the cosine from -1, straight back, to 1, up to a factor");

/// The two phase functions of a mixture.
struct Two;

impl Field for Two {
    type Value = Box<[Phase; 2]>;

    fn parameters(&self) -> Vec<Parameter> {
        let held = |doc| Parameter { doc, is_required: true, ..Parameter::new("", Takes::Object("phase")) };
        vec![held("the first"), held("the second")]
    }

    fn read(&self, query: &Query<'_>) -> Option<Box<[Phase; 2]>> {
        let nested = query.objects(Class::Phase);
        let found = nested.len();
        let phases: Vec<Phase> =
            nested.into_iter().filter_map(|(_, id)| of_object(query.reader, id)).collect();
        if found != 2 && !query.has_broken() {
            let plural = if found == 1 { "" } else { "s" };
            let problem = format!("{} holds {found} phase function{plural}", capital(&query.title()));
            query.error(SceneError::at(&query.object.place, problem, "expected two"));
        }
        <[Phase; 2]>::try_from(phases).ok().map(Box::new)
    }

    fn write(&self, node: Node, nested: &Box<[Phase; 2]>, writer: &mut Writer) -> Node {
        nested.iter().fold(node, |node, phase| node.child(self::node(phase, writer)))
    }
}

/// The phase function of a medium: isotropic where the file names none, or a wrong one, which is reported.
pub fn of_medium(query: &Query<'_>) -> Phase {
    let named = query.object(Class::Phase).and_then(|(_, id)| of_object(query.reader, id));
    named.unwrap_or_else(|| Phase { place: query.object.place.clone(), kind: PhaseKind::Isotropic })
}

/// `None` where it is wrong, which is reported.
pub fn of_object(reader: &Reader, id: ObjectId) -> Option<Phase> {
    let query = Query::new(reader, id);
    let kind = read(&query);
    if !NAMES.contains(&query.object.plugin.as_str()) {
        return None;
    }
    let place = query.object.place.clone();
    query.finish();
    Some(Phase { place, kind: kind? })
}

pub fn node(phase: &Phase, writer: &mut Writer) -> Node {
    write(&phase.kind, &phase.place, writer)
}

/// Refuses a table that is no phase function.
fn possible(query: &Query<'_>, kind: PhaseKind) -> Option<PhaseKind> {
    if let PhaseKind::Tabulated { values } = &kind
        && PhaseTable::new(values).is_none()
    {
        let problem = "The table is no phase function";
        let expected = "expected two values or more, of at least 0 and not all 0";
        let error = SceneError::at(&query.place("values"), problem, expected);
        query.error(error.with_remedy(
            "they stand at equal steps of the cosine of the angle, from -1 (straight back) to 1 (straight ahead)",
        ));
        return None;
    }
    Some(kind)
}

/// Refuses a weight that varies over surfaces.
fn over_volumes(query: &Query<'_>, kind: PhaseKind) -> Option<PhaseKind> {
    if let PhaseKind::Blend { weight, .. } = &kind
        && varies(weight)
        && !matches!(weight.kind, SpectrumKind::Volume(_))
    {
        let problem = "The weight of a blend of phase functions varies over a surface";
        let expected = "expected a number or a <volume>";
        query.error(SceneError::at(&query.place("weight"), problem, expected));
        return None;
    }
    Some(kind)
}
