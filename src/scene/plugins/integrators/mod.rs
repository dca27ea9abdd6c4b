//! Integrators.

mod nested;

use super::fields::{Boolean, Fixed, Integer};
use super::{Field, Ignored, Parameter, Range, Simple, Takes, boolean, declare, ignored, integer};
use crate::scene::Techniques;
use crate::scene::description::{Aov, Integrator, IntegratorKind, Moments};
use crate::scene::read::{Class, Query, aovs};
use crate::scene::source::{Place, SceneError};
use crate::scene::write::{Node, Writer};
use nested::{Images, Named, Within, beside, of_a_picture};

/// An integrator as its plugin has it.
pub enum Method {
    Path { max_depth: Option<u32>, rr_depth: u32, hide_emitters: bool },
    VolPath { max_depth: Option<u32>, rr_depth: u32, hide_emitters: bool },
    Walk { max_depth: Option<u32>, rr_depth: u32, hide_emitters: bool },
    Direct { techniques: Techniques, hide_emitters: bool },
    Depth,
    Aov { aovs: Vec<Aov>, inner: Option<Named> },
    Moment { inner: Option<Named> },
}

declare! {
    Class::Integrator => Method, common common;

    "path", "path tracing; to pass a `null` or `mask` surface is a segment of its own"
        => Method::Path { max_depth, rr_depth, hide_emitters } {
        max_depth: MaxDepth(None),
        rr_depth: RR_DEPTH,
        hide_emitters: HIDE_EMITTERS,
    };
    "direct", "paths of at most two segments" => Method::Direct { techniques, hide_emitters } {
        techniques: Samples,
        hide_emitters: HIDE_EMITTERS,
    };
    "volpath", "path tracing; paths and light samples pass `null` and `mask` surfaces as if there were none"
        => Method::VolPath { max_depth, rr_depth, hide_emitters } {
        max_depth: MaxDepth(None),
        rr_depth: RR_DEPTH,
        hide_emitters: HIDE_EMITTERS,
    };
    "volpathmis", "the same" => Method::VolPath { max_depth, rr_depth, hide_emitters } {
        max_depth: MaxDepth(None),
        rr_depth: RR_DEPTH,
        hide_emitters: HIDE_EMITTERS,
    } ignoring [ignored("use_spectral_mis", Takes::Boolean, "")];
    "ptracer", "stands for `path`" => Method::Path { max_depth, rr_depth, hide_emitters } {
        max_depth: MaxDepth(None),
        rr_depth: RR_DEPTH,
        hide_emitters: HIDE_EMITTERS,
    } then traces_from_cameras;
    "depth", "the distance of what is seen first" => Method::Depth {} {} ignoring [HIDDEN];
    "aov", "the picture of the integrator in it, and images of what the camera sees first"
        => Method::Aov { aovs, inner } {
        aovs: Images,
        inner: Within { is_required: false },
    } ignoring [HIDDEN];
    "moment", "the picture of the integrator in it, and the second moments of its samples"
        => Method::Moment { inner } {
        inner: Within { is_required: true },
    } ignoring [HIDDEN] then of_a_picture;
    "prb", "stands for `path`, as do all that differentiate" => Method::Path { max_depth, rr_depth, hide_emitters } {
        max_depth: MaxDepth(DIFFERENTIATED_DEPTH),
        rr_depth: RR_DEPTH,
        hide_emitters: HIDE_EMITTERS,
    } ignoring [GUIDING, GUIDING_PROJ, SEED, SPPC, SPPP, SPPI, ROUNDS] then differentiates_nothing;
    "prb_basic", "the same" => Method::Path { max_depth, rr_depth, hide_emitters } {
        max_depth: MaxDepth(DIFFERENTIATED_DEPTH),
        rr_depth: RR_DEPTH,
        hide_emitters: HIDE_EMITTERS,
    } ignoring [GUIDING, GUIDING_PROJ, SEED, SPPC, SPPP, SPPI, ROUNDS] then differentiates_nothing;
    "prb_projective", "the same" => Method::Path { max_depth, rr_depth, hide_emitters } {
        max_depth: MaxDepth(DIFFERENTIATED_DEPTH),
        rr_depth: RR_DEPTH,
        hide_emitters: HIDE_EMITTERS,
    } ignoring [GUIDING, GUIDING_PROJ, SEED, SPPC, SPPP, SPPI, ROUNDS] then differentiates_nothing;
    "prbvolpath", "stands for `volpath`" => Method::VolPath { max_depth, rr_depth, hide_emitters } {
        max_depth: MaxDepth(DIFFERENTIATED_DEPTH),
        rr_depth: RR_DEPTH,
        hide_emitters: HIDE_EMITTERS,
    } ignoring [GUIDING, GUIDING_PROJ, SEED, SPPC, SPPP, SPPI, ROUNDS] then differentiates_nothing;
    "direct_projective", "stands for `direct`" => Method::Direct { techniques, hide_emitters } {
        techniques: Fixed(Techniques::Both),
        hide_emitters: HIDE_EMITTERS,
    } ignoring [
        ignored("max_depth", Takes::Integer(-1, MOST), "").silent(),
        ignored("rr_depth", Takes::Integer(1, MOST), "").silent(),
        GUIDING, GUIDING_PROJ, SEED, SPPC, SPPP, SPPI, ROUNDS,
    ] then differentiates_nothing;
    "walk" extension "a random walk that does not sample lights",
        "a random walk that finds lights by chance, an oracle for tests"
        => Method::Walk { max_depth, rr_depth, hide_emitters } {
        max_depth: MaxDepth(None),
        rr_depth: RR_DEPTH,
        hide_emitters: HIDE_EMITTERS,
    };
}

const MOST: i64 = u32::MAX as i64;

/// The default of the integrators of Mitsuba 3 that differentiate.
const DIFFERENTIATED_DEPTH: Option<u32> = Some(6);

const RR_DEPTH: Simple<Integer<u32>> = integer(
    "rr_depth",
    5,
    [1, MOST],
    "number of segments from which Russian roulette may end a path; the mirror image in a smooth coat may end sooner",
);

const HIDE_EMITTERS: Simple<Boolean> =
    boolean("hide_emitters", false, "whether the camera does not see lights themselves");

const GUIDING: Ignored = ignored("guiding", Takes::Text, "");
const GUIDING_PROJ: Ignored = ignored("guiding_proj", Takes::Boolean, "");
const SEED: Ignored = ignored("project_seed", Takes::Text, "");
const SPPC: Ignored = count("sppc");
const SPPP: Ignored = count("sppp");
const SPPI: Ignored = count("sppi");
const ROUNDS: Ignored = count("guiding_rounds");

const fn count(name: &'static str) -> Ignored {
    ignored(name, Takes::Integer(0, MOST), "")
}

const HIDDEN: Ignored = ignored("hide_emitters", Takes::Boolean, "");

/// What all integrators take, which changes nothing.
fn ignored_by_all() -> [Ignored; 3] {
    let timeout = ignored("timeout", Takes::Float(Range::ALL), "all samples are taken").listed();
    [count("samples_per_pass"), count("block_size"), timeout]
}

fn common() -> Vec<Parameter> {
    ignored_by_all().iter().map(Ignored::parameter).collect()
}

/// What a scene without integrator has: Mitsuba 3's `path`.
fn default(place: &Place) -> Integrator {
    Integrator {
        place: place.clone(),
        kind: IntegratorKind::Path,
        max_depth: None,
        rr_depth: RR_DEPTH.default(),
        hide_emitters: false,
        techniques: Techniques::Both,
        aovs: Vec::new(),
        moments: None,
    }
}

/// The integrator of the scene that is asked.
pub fn of_scene(scene: &Query<'_>) -> Integrator {
    match scene.object(Class::Integrator) {
        Some((_, id)) => integrator(Query::new(scene.reader, id)),
        None => default(&scene.object.place),
    }
}

fn integrator(query: Query<'_>) -> Integrator {
    let method = read(&query);
    let plugin = query.object.plugin.as_str();
    if !NAMES.contains(&plugin) {
        return default(&query.object.place);
    }
    for parameter in ignored_by_all() {
        parameter.read(&query);
    }
    let place = &query.object.place;
    let integrator = method.map_or_else(|| default(place), |method| method.integrator(place));
    if plugin == "aov" {
        aovs::check(&query, &integrator.aovs);
    }
    query.finish();
    integrator
}

pub fn node(integrator: &Integrator, writer: &mut Writer) -> Node {
    write(&Method::of(integrator), &integrator.place, writer)
}

impl Method {
    /// What is meant by it where it stands at `place`.
    fn integrator(self, place: &Place) -> Integrator {
        let default = default(place);
        match self {
            Self::Path { max_depth, rr_depth, hide_emitters } => {
                Integrator { max_depth, rr_depth, hide_emitters, ..default }
            }
            Self::VolPath { max_depth, rr_depth, hide_emitters } => {
                Integrator { kind: IntegratorKind::VolPath, max_depth, rr_depth, hide_emitters, ..default }
            }
            Self::Walk { max_depth, rr_depth, hide_emitters } => {
                Integrator { kind: IntegratorKind::Walk, max_depth, rr_depth, hide_emitters, ..default }
            }
            Self::Direct { techniques, hide_emitters } => Integrator {
                kind: IntegratorKind::Direct,
                max_depth: Some(2),
                techniques,
                hide_emitters,
                ..default
            },
            Self::Depth => Integrator { kind: IntegratorKind::Depth, ..default },
            Self::Aov { aovs, inner: None } => Integrator { max_depth: Some(0), aovs, ..default },
            Self::Aov { aovs, inner: Some((name, inner)) } => beside(aovs, &name, *inner),
            Self::Moment { inner: None } => default,
            Self::Moment { inner: Some((of, inner)) } => {
                Integrator { moments: Some(Moments { within: None, of }), ..*inner }
            }
        }
    }

    /// The outermost plugin: a `moment` may stand within an `aov`.
    fn of(integrator: &Integrator) -> Self {
        let Integrator { kind, max_depth, rr_depth, hide_emitters, techniques, aovs, moments, .. } =
            integrator.clone();
        let within = moments.as_ref().and_then(|moments| moments.within.clone());
        if !aovs.is_empty() || within.is_some() {
            let moments = moments.map(|moments| Moments { within: None, ..moments });
            let inner = Integrator { aovs: Vec::new(), moments, ..integrator.clone() };
            let name = within.unwrap_or_else(|| "image".to_owned());
            return Self::Aov { aovs, inner: Some((name, Box::new(inner))) };
        }
        if let Some(Moments { of, .. }) = moments {
            let inner = Integrator { moments: None, ..integrator.clone() };
            return Self::Moment { inner: Some((of, Box::new(inner))) };
        }
        match kind {
            IntegratorKind::Path => Self::Path { max_depth, rr_depth, hide_emitters },
            IntegratorKind::VolPath => Self::VolPath { max_depth, rr_depth, hide_emitters },
            IntegratorKind::Walk => Self::Walk { max_depth, rr_depth, hide_emitters },
            IntegratorKind::Direct => Self::Direct { techniques, hide_emitters },
            IntegratorKind::Depth => Self::Depth,
        }
    }
}

/// Says that no light is traced from the lamps alone.
fn traces_from_cameras(query: &Query<'_>, method: Method) -> Option<Method> {
    let text = "integrator \"ptracer\" stands for \"path\", whose picture is the same in expectation but for \
                surfaces with shading normals: light is traced from the lamps where that finds caustics";
    query.reader.remark(&query.object.plugin_place, text.to_owned());
    Some(method)
}

/// Says what an integrator stands for that also finds derivatives.
fn differentiates_nothing(query: &Query<'_>, method: Method) -> Option<Method> {
    let plugin = &query.object.plugin;
    let stands_for = match method {
        Method::VolPath { .. } => "volpath",
        Method::Direct { .. } => "direct",
        _ => "path",
    };
    let text = format!("integrator \"{plugin}\" stands for \"{stands_for}\": nothing is differentiated here");
    query.reader.remark(&query.object.plugin_place, text);
    Some(method)
}

/// Most segments of a path; `None` is any number. It holds the default.
struct MaxDepth(Option<u32>);

impl Field for MaxDepth {
    type Value = Option<u32>;

    fn parameters(&self) -> Vec<Parameter> {
        let default = self.0.map_or("-1".to_owned(), |depth| depth.to_string());
        let doc = "most segments of a path, the one from the camera included; -1 is any number";
        vec![Parameter { default, doc, ..Parameter::new("max_depth", Takes::Integer(-1, MOST)) }]
    }

    fn read(&self, query: &Query<'_>) -> Option<Option<u32>> {
        Some(match query.integer("max_depth", -1, MOST) {
            Some(depth) => u32::try_from(depth).ok(),
            None => self.0,
        })
    }

    fn write(&self, node: Node, depth: &Option<u32>, _: &mut Writer) -> Node {
        match depth {
            Some(depth) => node.integer("max_depth", *depth),
            None => node.integer("max_depth", -1).remark("paths are of any length"),
        }
    }
}

/// How many samples of which kind Mitsuba 3's `direct` takes at a hit: the picture is the same for any
/// number, as long as no kind is left out.
struct Samples;

impl Field for Samples {
    type Value = Techniques;

    fn parameters(&self) -> Vec<Parameter> {
        let count = |name, least, doc| Parameter {
            default: "1".to_owned(),
            doc,
            ..Parameter::new(name, Takes::Integer(least, MOST))
        };
        vec![
            count("shading_samples", 1, "changes nothing"),
            count("emitter_samples", 0, "0 leaves out samples of lights"),
            count("bsdf_samples", 0, "0 leaves out samples of BSDFs"),
        ]
    }

    fn read(&self, query: &Query<'_>) -> Option<Techniques> {
        let both = query.integer("shading_samples", 1, MOST);
        let [of_lights, of_bsdfs] = ["emitter_samples", "bsdf_samples"].map(|name| {
            let count = query.integer(name, 0, MOST);
            if count.is_some() && both.is_some() {
                query.error(SceneError::at(
                    &query.place(name),
                    "The samples are given twice",
                    format!("expected either shading_samples or {name}"),
                ));
            }
            count != Some(0)
        });
        for name in ["shading_samples", "emitter_samples", "bsdf_samples"] {
            if query.has(name) && of_lights && of_bsdfs {
                query.reader.remark(
                    &query.place(name),
                    format!("{name} changes nothing: one of each kind is taken per path"),
                );
            }
        }
        Some(match (of_lights, of_bsdfs) {
            (true, true) => Techniques::Both,
            (false, true) => Techniques::Scattering,
            (true, false) => Techniques::LightSamples,
            (false, false) => {
                query.error(SceneError::at(
                    &query.place("bsdf_samples"),
                    "Without samples of lights and of BSDFs no light is found",
                    "expected emitter_samples or bsdf_samples of at least 1",
                ));
                Techniques::Both
            }
        })
    }

    fn write(&self, node: Node, techniques: &Techniques, _: &mut Writer) -> Node {
        let samples = |left_out| i64::from(*techniques != left_out);
        node.integer("emitter_samples", samples(Techniques::Scattering))
            .integer("bsdf_samples", samples(Techniques::LightSamples))
    }
}
