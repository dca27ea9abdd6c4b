//! Emitters.

mod pictures;
mod placements;
mod sunsky;

use super::spectral::{Emission, OptionalSpectral, required};
use super::view::View;
use super::{Field, Ignored, Parameter, Range, Simple, Takes, boolean, declare, fields, float, ignored};
use crate::scene::description::{Light, LightKind, SpectrumSource};
use crate::scene::read::query::capital;
use crate::scene::read::spectra::Use;
use crate::scene::read::{Class, Entry, ObjectId, Query, Reader, Value};
use crate::scene::source::SceneError;
use crate::scene::write::{Node, Writer};
use pictures::{Picture, looked_up_in_uv, slide_varies};
use placements::{Position, Rigid, Travel, Turned};

/// What an emitter is.
#[expect(clippy::large_enum_variant, reason = "it lives while a light is read or written")]
pub enum Emitter {
    /// What stands by itself.
    Alone(LightKind),
    /// The surface of a shape, with its radiance.
    Surface(SpectrumSource),
    /// A surface that shines along its normals alone.
    Beams(SpectrumSource),
}

/// Emitters that are surfaces of shapes.
const SURFACES: [&str; 2] = ["area", "directionalarea"];

declare! {
    Class::Emitter => Emitter, common common;

    "area", "a shape that shines alike in all directions" => Emitter::Surface(radiance) {
        radiance: RADIANCE,
    };
    "constant", "the same light from everywhere" => Emitter::Alone(LightKind::Constant { radiance }) {
        radiance: Emission { name: "radiance", may_vary: false, doc: "radiance, W·m⁻²·sr⁻¹·nm⁻¹" },
    } ignoring [ignored("to_world", Takes::Transform, "a constant light looks the same from everywhere")];
    "directional", "parallel light from beyond the scene"
        => Emitter::Alone(LightKind::Directional { travels, motion, irradiance }) {
        (travels, motion): Travel,
        irradiance: Emission { name: "irradiance", may_vary: false, doc: "irradiance across it, W·m⁻²·nm⁻¹" },
    };
    "directionalarea", "a shape that shines along its normals alone, which no path from a camera finds"
        => Emitter::Beams(radiance) { radiance: RADIANCE };
    "envmap", "a picture all around, +y at its top"
        => Emitter::Alone(LightKind::EnvironmentMap { to_world, file, image, scale }) {
        to_world: Turned,
        (file, image): Picture,
        scale: SCALE,
    } ignoring [ignored("mis_compensation", Takes::Boolean, "it is a matter of noise")];
    "point", "light from a point" => Emitter::Alone(LightKind::Point { position, motion, intensity }) {
        (position, motion): Position,
        intensity: INTENSITY,
    };
    "projector", "a picture thrown along the local +z"
        => Emitter::Alone(LightKind::Projector { to_world, motion, irradiance, scale, field_of_view }) {
        (to_world, motion): Rigid,
        irradiance: Emission { name: "irradiance", may_vary: true, doc: "the picture, as irradiance at a distance of 1" },
        scale: SCALE,
        field_of_view: View,
    } then looked_up_in_uv;
    "spot", "light from a point along its local +z"
        => Emitter::Alone(LightKind::Spot { to_world, motion, intensity, cutoff_angle, beam_width, texture }) {
        (to_world, motion): Rigid,
        intensity: INTENSITY,
        (cutoff_angle, beam_width): Cone,
        texture: OptionalSpectral(required("texture", Use::Emission, "transmittance of a slide in it")),
    } then slide_varies;
    "sunsky", "clear sky and sun, the zenith at the local +z"
        => Emitter::Alone(LightKind::SunSky {
            to_world, turbidity, albedo, sun_direction, sky_scale, sun_scale, sun_aperture, complex_sun
        }) {
        to_world: Turned,
        turbidity: float("turbidity", 3.0, "haze, from clear air to a heavy haze")
            .within(Range::between(1.0, 10.0)).remedy("1 is clear air, 10 a heavy haze"),
        albedo: super::spectral::spectrum("albedo", Use::Reflectance, 0.3, "reflectance of the ground"),
        sun_direction: sunsky::Sun,
        sky_scale: brightness("sky_scale", "factor on the light of the sky"),
        sun_scale: brightness("sun_scale", "factor on the light of the sun"),
        sun_aperture: float("sun_aperture", 0.5358, "angle across the sun")
            .within(Range { low: 0.001, with_low: true, high: 180.0, with_high: false }).unit("degrees")
            .said("The sun is {} degrees wide", "expected an angle from 0.001 to below 180 degrees"),
        complex_sun: boolean("complex_sun", false, "whether it is darker at its limb, by wavelength"),
    };
}

const RADIANCE: Emission =
    Emission { name: "radiance", may_vary: true, doc: "radiance, W·m⁻²·sr⁻¹·nm⁻¹" };

const INTENSITY: Emission =
    Emission { name: "intensity", may_vary: false, doc: "radiant intensity, W·sr⁻¹·nm⁻¹" };

/// A factor on what is emitted.
const SCALE: Simple<fields::Float> = float("scale", 1.0, "factor on what is emitted")
    .not_negative()
    .said("The light is scaled by {}", "expected a factor of at least 0")
    .remedy("light cannot be taken away");

const fn brightness(name: &'static str, doc: &'static str) -> Simple<fields::Float> {
    float(name, 1.0, doc).not_negative().remedy("light cannot be taken away")
}

/// Checked by [`sampling_weight`].
const WEIGHT: Ignored = ignored("sampling_weight", Takes::Float(Range::NOT_NEGATIVE), "");

fn common() -> Vec<Parameter> {
    vec![WEIGHT.parameter()]
}

/// An emitter that stands by itself. `None` where it is wrong, which is reported.
pub fn of_scene(reader: &Reader, id: ObjectId) -> Option<Light> {
    let query = Query::new(reader, id);
    let object = query.object;
    if SURFACES.contains(&object.plugin.as_str()) {
        let problem = match object.plugin.as_str() {
            "area" => "An area light needs a shape",
            _ => "A directional area light needs a shape",
        };
        query.error(
            SceneError::at(
                &object.place,
                problem,
                "expected inside a <shape>, or an id that a shape refers to",
            )
            .with_remedy("put it into the shape whose surface shines"),
        );
        return None;
    }
    let emitter = read(&query);
    if !NAMES.contains(&object.plugin.as_str()) {
        return None;
    }
    let weight = sampling_weight(&query);
    for (entry, _) in query.objects(Class::Medium) {
        let text = "the medium of a light changes nothing: rays know what they are in".to_owned();
        reader.remark(&entry.place, text);
    }
    let weight_place = query.place("sampling_weight");
    query.finish();
    let Emitter::Alone(kind) = emitter? else { return None };
    if weight == Some(0.0) && !kind.is_environment() {
        reader.remark(
            &weight_place,
            "the light is dark: with a sampling_weight of 0 nothing in Mitsuba 3 finds a light without extent".to_owned(),
        );
        return None;
    }
    Some(Light { place: object.place.clone(), kind })
}

pub fn node(light: &Light, writer: &mut Writer) -> Node {
    write(&Emitter::Alone(light.kind.clone()), &light.place, writer)
}

/// The light of a shape that shines.
pub fn surface_node(radiance: &SpectrumSource, writer: &mut Writer) -> Node {
    write(&Emitter::Surface(radiance.clone()), &radiance.place, writer)
}

/// Whether a light that stands in the scene is the surface of shapes that refer to it: then these read it.
pub fn belongs_to_shapes(reader: &Reader, entry: &Entry, id: ObjectId) -> bool {
    if !SURFACES.contains(&reader.tree.get(id).plugin.as_str()) {
        return false;
    }
    let shapes = reader.tree.objects.iter().filter(|object| object.class == Class::Shape);
    let refers = |entry: &&Entry| matches!(entry.value, Value::Object(target) if target == id);
    let uses = shapes.flat_map(|shape| &shape.entries).filter(refers).count();
    if uses > 1 {
        let text = "an area light of several shapes: each of them shines like this".to_owned();
        reader.extension(&entry.place, text);
    }
    uses > 0
}

/// The radiance of an emitter that stands in a shape.
pub fn of_shape(reader: &Reader, id: ObjectId) -> Option<SpectrumSource> {
    let query = Query::new(reader, id);
    let object = query.object;
    let plugin = object.plugin.as_str();
    if NAMES.contains(&plugin) && !SURFACES.contains(&plugin) {
        let problem = format!("emitter \"{plugin}\" cannot stand in a shape");
        reader.error(
            SceneError::at(&object.place, capital(&problem), "expected emitter \"area\"")
                .with_remedy("move it out of the shape, directly into the <scene>"),
        );
        return None;
    }
    let emitter = read(&query)?;
    sampling_weight(&query);
    if query.has("to_world") {
        query.entry("to_world");
        query.error(
            SceneError::at(
                &query.place("to_world"),
                "An area light has no place of its own",
                "expected no to_world here",
            )
            .with_remedy("the shape's to_world moves the light as well"),
        );
    }
    query.finish();
    if let Emitter::Surface(radiance) = emitter {
        return Some(radiance);
    }
    reader.remark(
        &object.place,
        "the surface stays dark: as in Mitsuba 3, no path from the camera finds light that leaves along the normal alone"
            .to_owned(),
    );
    None
}

/// Mitsuba 3 chooses lights in proportion to it. The picture does not depend on it; only at 0 a light that
/// nothing but light samples finds is not found.
fn sampling_weight(query: &Query<'_>) -> Option<f64> {
    let weight = query.float("sampling_weight")?;
    if weight < 0.0 {
        let problem = format!("\"sampling_weight\" of {} is {weight}", query.title());
        let place = query.place("sampling_weight");
        query.error(SceneError::at(&place, problem, "expected a number of at least 0"));
        return None;
    }
    if weight > 0.0 {
        query.reader.remark(
            &query.place("sampling_weight"),
            "sampling_weight changes nothing: lights are chosen by what they can contribute".to_owned(),
        );
    }
    Some(weight)
}

/// Where a spot ends, and where it begins to fall off.
struct Cone;

const CUTOFF: Simple<fields::Float> = float("cutoff_angle", 20.0, "from the axis to where it ends")
    .within(Range { low: 0.0, with_low: false, high: 180.0, with_high: true })
    .unit("degrees")
    .said("The spot ends at {} degrees from its axis", "expected an angle above 0 and up to 180 degrees")
    .remedy("the angle is that between the axis and the edge of the cone");

impl Field for Cone {
    type Value = (f64, f64);

    fn parameters(&self) -> Vec<Parameter> {
        let beam = Parameter::new("beam_width", Takes::Float(Range::between(0.0, 180.0)));
        let doc = "from the axis to where it begins to fall off";
        let beam = Parameter { default: "3/4 of it".to_owned(), unit: "degrees", doc, ..beam };
        [CUTOFF.parameters(), vec![beam]].concat()
    }

    fn read(&self, query: &Query<'_>) -> Option<(f64, f64)> {
        let cutoff_angle = CUTOFF.read(query)?;
        let beam_width = query.float("beam_width").unwrap_or(0.75 * cutoff_angle);
        if !(0.0..=180.0).contains(&beam_width) {
            query.error(SceneError::at(
                &query.place("beam_width"),
                format!("The spot begins to fall off at {beam_width} degrees from its axis"),
                "expected an angle from 0 to 180 degrees",
            ));
        }
        Some((cutoff_angle, beam_width))
    }

    fn write(&self, node: Node, (cutoff, beam): &(f64, f64), _: &mut Writer) -> Node {
        node.float("cutoff_angle", *cutoff).float("beam_width", *beam)
    }
}
