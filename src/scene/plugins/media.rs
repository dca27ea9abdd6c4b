//! Media: what absorbs and scatters in space.

use super::fields::Float;
use super::spectral::Quantity;
use super::textures::volumes;
use super::{Field, Ignored, Parameter, Simple, Takes, declare, float, ignored, phases};
use crate::scene::description::{
    DensitySource, EmissionSource, Medium, MediumContent, Phase, PhaseKind, SpectrumKind, SpectrumSource,
};
use crate::scene::read::spectra::{self, Use};
use crate::scene::read::textures::varies;
use crate::scene::read::{Class, ObjectId, Query, Reader, Value};
use crate::scene::source::SceneError;
use crate::scene::write::{Node, Writer};

/// A medium as it is written: the factor by itself, for multiplied into the values it could round to others.
#[expect(clippy::large_enum_variant, reason = "a scene has few media")]
pub enum Content {
    Homogeneous {
        extinction: SpectrumSource,
        scale: f64,
        albedo: SpectrumSource,
        phase: Phase,
        emission: Option<EmissionSource>,
    },
    Heterogeneous {
        extinction: SpectrumSource,
        scale: f64,
        albedo: SpectrumSource,
        phase: Phase,
        emission: Option<EmissionSource>,
        density: Option<DensitySource>,
    },
    Suspension {
        particles: Vec<Phase>,
        absorption: SpectrumSource,
        metres: f64,
        emission: Option<EmissionSource>,
        density: Option<DensitySource>,
    },
}

declare! {
    Class::Medium => Content;

    "homogeneous", "one extinction everywhere; `albedo`, `emission` and `temperature` may be a `<volume>`"
        => Content::Homogeneous { extinction, scale, albedo, phase, emission } {
        extinction: EXTINCTION,
        scale: SCALE,
        albedo: ALBEDO,
        phase: PhaseFunction,
        emission: Emission,
    } ignoring [weighed("sample_emitters"), weighed("has_spectral_extinction")] then steady;
    "heterogeneous",
    "varies from place to place: `sigma_t`, `albedo`, `emission` and `temperature` may be a `<volume>`"
        => Content::Heterogeneous { extinction, scale, albedo, phase, emission, density } {
        extinction: EXTINCTION,
        scale: SCALE,
        albedo: ALBEDO,
        phase: PhaseFunction,
        emission: Emission,
        density: Density,
    } ignoring [weighed("sample_emitters"), weighed("has_spectral_extinction")] then steady;
    "suspension" extension "particles whose extinction, albedo and phase function are computed"
        => Content::Suspension { particles, absorption, metres, emission, density } {
        absorption: Quantity {
            name: "absorption",
            purpose: Use::Absorption,
            default: Some(0.0),
            doc: "what the particles are in absorbs per unit of length",
        },
        metres: float("metres", 1.0, "length of the scene's unit").unit("m").positive(),
        particles: Particles,
        emission: Emission,
        density: Density,
    } then steady;
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

/// The particles of a suspension: at least one kind, each with how much there is of it.
struct Particles;

impl Field for Particles {
    type Value = Vec<Phase>;

    fn parameters(&self) -> Vec<Parameter> {
        let doc = "particles, `mie` with its `fraction` or `air`; several may stand beside one another";
        vec![Parameter { doc, is_required: true, ..Parameter::new("", Takes::Object("phase")) }]
    }

    fn read(&self, query: &Query<'_>) -> Option<Vec<Phase>> {
        let nested = query.objects(Class::Phase);
        if nested.is_empty() {
            if !query.has_broken() {
                let problem = "This suspension holds no particles";
                let expected = "expected a <phase type=\"mie\"> or <phase type=\"air\">";
                query.error(SceneError::at(&query.object.place, problem, expected));
            }
            return None;
        }
        let of = |id: ObjectId| {
            let phase = phases::of_object(query.reader, id)?;
            let (problem, expected) = match &phase.kind {
                PhaseKind::Mie(source) if source.fraction.is_some() => return Some(phase),
                PhaseKind::Air { .. } => return Some(phase),
                PhaseKind::Mie(_) => (
                    "It is not said how many spheres there are",
                    "expected the `fraction` of space that they fill",
                ),
                _ => (
                    "This phase function does not say how much its particles scatter",
                    "expected `mie` or `air`; the others belong into a `homogeneous` medium",
                ),
            };
            query.error(SceneError::at(&phase.place, problem, expected));
            None
        };
        // All of them, so that each that is wrong is reported.
        let found: Vec<Option<Phase>> = nested.into_iter().map(|(_, id)| of(id)).collect();
        found.into_iter().collect()
    }

    fn write(&self, node: Node, particles: &Vec<Phase>, writer: &mut Writer) -> Node {
        particles.iter().fold(node, |node, phase| node.child(phases::node(phase, writer)))
    }
}

/// Light that a medium sends out, by one of two parameters.
struct Emission;

impl Field for Emission {
    type Value = Option<EmissionSource>;

    fn parameters(&self) -> Vec<Parameter> {
        let parameter = |name, purpose, unit, doc| Parameter {
            unit,
            doc,
            is_extension: true,
            ..Parameter::new(name, Takes::Spectrum(purpose))
        };
        vec![
            parameter(
                "emission",
                Use::Emission,
                "",
                "radiance that it sends out per unit of length; a number is that many times D65",
            ),
            parameter(
                "temperature",
                Use::Amount,
                "K",
                "instead of `emission`: it sends out what a black body does, as far as it absorbs",
            ),
        ]
    }

    fn read(&self, query: &Query<'_>) -> Option<Option<EmissionSource>> {
        for name in ["emission", "temperature"].into_iter().filter(|name| query.has(name)) {
            query
                .reader
                .extension(&query.place(name), format!("{name}: media of Mitsuba 3 send out no light"));
        }
        if query.has("emission") && query.has("temperature") {
            let problem = "The medium has an emission and a temperature";
            query.error(SceneError::at(&query.place("temperature"), problem, "expected one of them"));
            return None;
        }
        let found = |name, purpose| spectra::read(query, name, purpose);
        let source = match query.has("temperature") {
            false => found("emission", Use::Emission).map(EmissionSource::Radiance),
            true => found("temperature", Use::Amount).map(EmissionSource::Temperature),
        };
        Some(source)
    }

    fn write(&self, node: Node, emission: &Option<EmissionSource>, writer: &mut Writer) -> Node {
        match emission {
            None => node,
            Some(EmissionSource::Radiance(source)) => quantity(node, "emission", source, writer),
            Some(EmissionSource::Temperature(source)) => quantity(node, "temperature", source, writer),
        }
    }
}

/// A grid is written by itself: the texture `volume` around it is for surfaces.
fn quantity(node: Node, name: &'static str, source: &SpectrumSource, writer: &mut Writer) -> Node {
    match &source.kind {
        SpectrumKind::Volume(volume) => node.named(name, volumes::node(volume, &source.place, writer)),
        _ => node.spectrum(name, source),
    }
}

/// How much there is of a medium from place to place.
struct Density;

impl Field for Density {
    type Value = Option<DensitySource>;

    fn parameters(&self) -> Vec<Parameter> {
        let doc = "factor on its extinction that varies from place to place";
        vec![Parameter { doc, is_extension: true, ..Parameter::new("density", Takes::Object("volume")) }]
    }

    fn read(&self, query: &Query<'_>) -> Option<Option<DensitySource>> {
        let Some(entry) = query.entry("density") else { return Some(None) };
        query
            .reader
            .extension(&query.place("density"), "density: a factor on all of the extinction".to_owned());
        if let Value::Object(id) = &entry.value
            && let Some(found) = volumes::density(query.reader, *id)
        {
            return Some(Some(found?));
        }
        let source = spectra::read(query, "density", Use::Absorption)?;
        let is_number = matches!(&source.kind, SpectrumKind::Volume(volume) if volume.grid.channels == 1);
        if !is_number {
            let problem = "The density is no grid of numbers";
            let expected = "expected a `gridvolume` of one channel, an `exponential` or a `texturevolume`";
            query
                .error(SceneError::at(&query.place("density"), problem, expected).with_remedy(
                    "what is the same everywhere belongs into `sigma_t`, `scale` or `fraction`",
                ));
            return None;
        }
        Some(Some(DensitySource::Grid(source)))
    }

    fn write(&self, node: Node, density: &Option<DensitySource>, writer: &mut Writer) -> Node {
        match density {
            None => node,
            Some(DensitySource::Grid(source)) => quantity(node, "density", source, writer),
            Some(DensitySource::Exponential(source)) => {
                let place = &node.place.clone();
                node.named("density", volumes::exponential_node(source, place, writer))
            }
            Some(DensitySource::Sampled(source)) => {
                let place = &node.place.clone();
                node.named("density", volumes::sampled_node(source, place, writer))
            }
        }
    }
}

/// `None` where the medium is wrong, which is reported.
pub fn of_object(reader: &Reader, id: ObjectId) -> Option<Medium> {
    let query = Query::new(reader, id);
    let object = query.object;
    let content = read(&query)?;
    query.finish();
    let plain = |varies, extinction: SpectrumSource, scale: f64, albedo, phase| {
        let extinction = SpectrumSource { scale: extinction.scale * scale, ..extinction };
        MediumContent::Plain { varies, extinction, albedo, phase }
    };
    let (content, emission, density) = match content {
        Content::Homogeneous { extinction, scale, albedo, phase, emission } => {
            (plain(false, extinction, scale, albedo, phase), emission, None)
        }
        Content::Heterogeneous { extinction, scale, albedo, phase, emission, density } => {
            (plain(true, extinction, scale, albedo, phase), emission, density)
        }
        Content::Suspension { particles, absorption, metres, emission, density } => {
            (MediumContent::Suspension { particles, absorption, metres }, emission, density)
        }
    };
    let (place, id) = (object.place.clone(), object.id.clone());
    Some(Medium { place, id, content, emission, density })
}

pub fn node(medium: &Medium, writer: &mut Writer) -> Node {
    let Medium { place, id, content, emission, density } = medium.clone();
    let content = match content {
        MediumContent::Suspension { particles, absorption, metres } => {
            Content::Suspension { particles, absorption, metres, emission, density }
        }
        MediumContent::Plain { varies, extinction, albedo, phase } => {
            let scale = extinction.scale;
            let extinction = SpectrumSource { scale: 1.0, ..extinction };
            match varies {
                true => Content::Heterogeneous { extinction, scale, albedo, phase, emission, density },
                false => Content::Homogeneous { extinction, scale, albedo, phase, emission },
            }
        }
    };
    write(&content, &place, writer).id(&id)
}

/// Refuses what varies where it may not, and what varies over surfaces alone.
fn steady(query: &Query<'_>, content: Content) -> Option<Content> {
    let (extinction, varying, albedo, emission) = match &content {
        Content::Homogeneous { extinction, albedo, emission, .. } => {
            (("sigma_t", extinction), Varying::Nothing, Some(albedo), emission)
        }
        Content::Heterogeneous { extinction, albedo, emission, density, .. } => {
            let varying = if density.is_some() { Varying::ByDensity } else { Varying::ByGrid };
            (("sigma_t", extinction), varying, Some(albedo), emission)
        }
        Content::Suspension { absorption, emission, .. } => {
            (("absorption", absorption), Varying::ByDensity, None, emission)
        }
    };
    refuse_variation(query, extinction.0, extinction.1, varying);
    if let Some(albedo) = albedo {
        refuse_variation(query, "albedo", albedo, Varying::ByGrid);
    }
    match emission {
        Some(EmissionSource::Radiance(source)) => {
            refuse_variation(query, "emission", source, Varying::ByGrid);
        }
        Some(EmissionSource::Temperature(source)) => {
            refuse_variation(query, "temperature", source, Varying::ByGrid);
        }
        None => {}
    }
    Some(content)
}

/// How a property of a medium may vary.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Varying {
    /// Not at all.
    Nothing,
    /// Not by itself, for the density varies.
    ByDensity,
    ByGrid,
}

fn refuse_variation(query: &Query<'_>, name: &'static str, source: &SpectrumSource, varying: Varying) {
    let is_grid = matches!(source.kind, SpectrumKind::Volume(_));
    if !varies(source) || varying == Varying::ByGrid && is_grid {
        return;
    }
    let problem = format!("\"{name}\" of {} varies from place to place", query.title());
    let error = SceneError::at(&query.place(name), problem, "expected a number or a spectrum");
    query.error(match (varying, is_grid) {
        (Varying::Nothing, true) => error.with_remedy("use a `heterogeneous` medium"),
        (Varying::ByDensity, true) => error.with_remedy("the `density` varies already"),
        (Varying::ByGrid, _) => error.with_remedy("it may be a <volume type=\"gridvolume\">"),
        _ => error.with_remedy("in a `heterogeneous` medium it may be a <volume type=\"gridvolume\">"),
    });
}
