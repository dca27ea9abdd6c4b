//! Phase functions: in what directions media scatter.

use super::fields::{Choices, Float, Numbers};
use super::indices::Index;
use super::spectral::{self, Quantity, Spectral};
use super::textures::volumes;
use super::{Field, Parameter, Range, Simple, Takes, choice, declare, float, numbers, optional};
use crate::phase::mie::Sizes;
use crate::phase::{PhaseTable, Sggx};
use crate::scene::description::{FlakeMatrix, MieSource, Phase, PhaseKind, SpectrumKind};
use crate::scene::read::query::capital;
use crate::scene::read::spectra::{self, Use};
use crate::scene::read::textures::varies;
use crate::scene::read::{Class, ObjectId, Query, Reader, Value};
use crate::scene::source::SceneError;
use crate::scene::write::{self, Node, Writer};

declare! {
    Class::Phase => PhaseKind;

    "isotropic", "alike in all directions" => PhaseKind::Isotropic {} {};
    "hg", "the function of Henyey and Greenstein" => PhaseKind::HenyeyGreenstein { g } { g: MEAN_COSINE };
    "rayleigh", "of particles that are much smaller than the wavelength" => PhaseKind::Rayleigh {} {};
    "tabphase", "a table" => PhaseKind::Tabulated { values } { values: VALUES } then possible;
    "blendphase", "a mixture of two" => PhaseKind::Blend { weight, nested } {
        weight: Quantity {
            name: "weight", purpose: Use::Weight, default: None, doc: "fraction of the second; it may be a `<volume>`"
        },
        nested: Two,
    } then over_volumes;
    "sggx", "small flakes that mirror" => PhaseKind::Sggx { matrix } { matrix: Ellipsoid };
    "mie" extension "spheres, computed from their sizes and their index" => PhaseKind::Mie(source) {
        source: Spheres,
    };
    "air" extension "molecules of air, computed" => PhaseKind::Air { amount } {
        amount: float(
            "amount", 1.0, "molecules over those of air at 288.15 K and 1013.25 hPa; only a `suspension` asks for it",
        ).not_negative(),
    };
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

/// The matrix of `sggx`: in a grid, as Mitsuba 3 has it, or as six numbers.
struct Ellipsoid;

impl Field for Ellipsoid {
    type Value = FlakeMatrix;

    fn parameters(&self) -> Vec<Parameter> {
        let doc = "S_xx, S_yy, S_zz, S_xy, S_xz and S_yz of the ellipsoid, as six numbers (an extension) or as a \
                   grid of six channels that is the same everywhere";
        vec![Parameter { doc, is_required: true, ..Parameter::new("S", Takes::Numbers) }]
    }

    fn read(&self, query: &Query<'_>) -> Option<FlakeMatrix> {
        let refuse = |problem: &str, expected: &str| {
            query.error(SceneError::at(&query.place("S"), problem, expected));
            None
        };
        let six = "expected S_xx, S_yy, S_zz, S_xy, S_xz and S_yz";
        let (values, grid) = match query.entry("S").map(|entry| &entry.value) {
            Some(Value::Object(id)) if query.reader.tree.get(*id).class == Class::Volume => {
                let source = volumes::of_object(query.reader, *id)?;
                let SpectrumKind::Volume(volume) = &source.kind else {
                    return refuse("The matrix \"S\" is one number", six);
                };
                if volume.grid.channels != 6 {
                    return refuse("The matrix \"S\" has no six channels", six);
                }
                let mut cells = volume.grid.values.chunks_exact(6);
                let first = cells.next().map(<[f32]>::to_vec).unwrap_or_default();
                if cells.any(|cell| cell != first) {
                    let expected = "expected a grid with the same values everywhere";
                    return refuse("The matrix \"S\" varies from place to place", expected);
                }
                (first.into_iter().map(f64::from).collect(), Some(volume.clone()))
            }
            Some(_) => {
                query.reader.extension(&query.place("S"), "S: six numbers without a grid".to_owned());
                (spectra::numbers(query, "S")?, None)
            }
            None => return query.required("S", None),
        };
        let Ok(elements) = <[f64; 6]>::try_from(values) else {
            return refuse("The matrix \"S\" has no six numbers", six);
        };
        if Sggx::new(elements).is_none() {
            let expected = "expected a positive definite matrix, such as 1, 1, 1, 0, 0, 0";
            return refuse("The matrix \"S\" is no ellipsoid", expected);
        }
        Some(FlakeMatrix { elements, grid, place: query.place("S") })
    }

    fn write(&self, node: Node, matrix: &FlakeMatrix, writer: &mut Writer) -> Node {
        match &matrix.grid {
            Some(grid) => node.named("S", volumes::node(grid, &matrix.place, writer)),
            None => node.with("S", write::Value::Numbers(matrix.elements.to_vec())),
        }
    }
}

/// Spheres: their sizes, what they are of and what they are in.
struct Spheres;

/// How radii are distributed.
#[derive(Clone, Copy, PartialEq)]
enum Distribution {
    One,
    LogNormal,
    Gamma,
}

impl Spheres {
    const DISTRIBUTION: Simple<Choices<Distribution>> = choice(
        "distribution",
        Distribution::One,
        &[("one", Distribution::One), ("lognormal", Distribution::LogNormal), ("gamma", Distribution::Gamma)],
        "all of one radius, a normal distribution of its logarithm, or Hansen's gamma distribution",
    );
    const RADIUS: Simple<Float> =
        float("radius", 1.0, "radius; the median of `lognormal`, the effective radius of `gamma`")
            .unit("µm")
            .positive();
    const SPREAD: Simple<Float> = float("spread", 1.5, "geometric standard deviation of `lognormal`")
        .within(Range { low: 1.0, with_low: false, high: 10.0, with_high: true })
        .quiet();
    const VARIANCE: Simple<Float> = float("variance", 0.1, "effective variance of `gamma`")
        .within(Range { low: 0.0, with_low: false, high: 0.5, with_high: false })
        .quiet();
    const INDEX: Index =
        Index { name: "int_ior", default: 1.333, default_name: "water", doc: "index of the spheres" };
    const HOST: Index =
        Index { name: "ext_ior", default: 1.000_277, default_name: "air", doc: "index of what they are in" };
    const K: Spectral =
        spectral::spectrum("k", Use::ConductorIndex, 0.0, "imaginary part of the spheres' index");
    const FRACTION: Simple<Float> =
        float("fraction", 1e-6, "fraction of space that they fill; only a `suspension` asks for it")
            .within(Range { low: 0.0, with_low: false, high: 1.0, with_high: true });
}

impl Field for Spheres {
    type Value = Box<MieSource>;

    fn parameters(&self) -> Vec<Parameter> {
        [
            Self::DISTRIBUTION.parameters(),
            Self::RADIUS.parameters(),
            Self::SPREAD.parameters(),
            Self::VARIANCE.parameters(),
            Self::INDEX.parameters(),
            Self::K.parameters(),
            Self::HOST.parameters(),
            vec![Parameter { default: String::new(), ..Self::FRACTION.parameters().remove(0) }],
        ]
        .concat()
    }

    fn read(&self, query: &Query<'_>) -> Option<Box<MieSource>> {
        let distribution = Self::DISTRIBUTION.read(query);
        let (radius, spread) = (Self::RADIUS.read(query), Self::SPREAD.read(query));
        let variance = Self::VARIANCE.read(query);
        let (index, host, k) = (Self::INDEX.read(query), Self::HOST.read(query), Self::K.read(query));
        let fraction = optional(Self::FRACTION).read(query);
        let distribution = distribution?;
        for (name, of) in [("spread", Distribution::LogNormal), ("variance", Distribution::Gamma)] {
            if query.has(name) && distribution != of {
                let problem = format!("\"{name}\" says nothing of this distribution");
                let word = if of == Distribution::Gamma { "gamma" } else { "lognormal" };
                let expected = format!("expected it beside the distribution \"{word}\"");
                query.error(SceneError::at(&query.place(name), problem, expected));
                return None;
            }
        }
        let (radius, spread, variance) = (radius?, spread?, variance?);
        let sizes = match distribution {
            Distribution::One => Sizes::One(radius),
            Distribution::LogNormal => Sizes::LogNormal { median: radius, spread },
            Distribution::Gamma => Sizes::Gamma { effective: radius, variance },
        };
        Some(Box::new(MieSource { sizes, index: index?, k: k?, host: host?, fraction: fraction? }))
    }

    fn write(&self, node: Node, source: &Box<MieSource>, writer: &mut Writer) -> Node {
        let MieSource { sizes, index, k, host, fraction } = &**source;
        let (distribution, radius) = match *sizes {
            Sizes::One(radius) => (Distribution::One, radius),
            Sizes::LogNormal { median, .. } => (Distribution::LogNormal, median),
            Sizes::Gamma { effective, .. } => (Distribution::Gamma, effective),
        };
        let node = Self::DISTRIBUTION.write(node, &distribution, writer);
        let node = Self::RADIUS.write(node, &radius, writer);
        let node = match sizes {
            Sizes::One(_) => node,
            Sizes::LogNormal { spread, .. } => Self::SPREAD.write(node, spread, writer),
            Sizes::Gamma { variance, .. } => Self::VARIANCE.write(node, variance, writer),
        };
        let node = Self::INDEX.write(node, index, writer);
        let node = Self::K.write(node, k, writer);
        let node = Self::HOST.write(node, host, writer);
        optional(Self::FRACTION).write(node, fraction, writer)
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
