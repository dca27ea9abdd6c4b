//! The roughness of surfaces made of small facets.

use crate::bsdf::microfacet::Distribution;
use crate::scene::description::{Alpha, CoatRoughness, Roughness};
use crate::scene::plugins::fields::Choices;
use crate::scene::plugins::{Field, Ignored, Parameter, Range, Simple, Takes, choice, ignored};
use crate::scene::read::Query;
use crate::scene::read::spectra::{self, Use};
use crate::scene::source::SceneError;
use crate::scene::write::{Node, Writer};

/// Mitsuba 3's default for `alpha`.
const DEFAULT_ALPHA: f64 = 0.1;

fn distribution() -> Simple<Choices<Distribution>> {
    const WORDS: [(&str, Distribution); 2] =
        [("beckmann", Distribution::Beckmann), ("ggx", Distribution::Ggx)];
    choice("distribution", Distribution::Beckmann, &WORDS, "how the slopes of the facets are distributed")
        .in_any_case()
}

pub fn sample_visible() -> Ignored {
    ignored("sample_visible", Takes::Boolean, "visible normals are always sampled")
}

/// `distribution`, and the roughness in one direction or in two.
fn parameters(takes: &Takes) -> Vec<Parameter> {
    let alpha = |name, default: &str, doc| {
        vec![Parameter { default: default.to_owned(), doc, ..Parameter::new(name, takes.clone()) }]
    };
    let default = DEFAULT_ALPHA.to_string();
    [
        distribution().parameters(),
        alpha("alpha", &default, "root mean square slope of the facets"),
        alpha("alpha_u", "", "the same along u alone, beside `alpha_v`"),
        alpha("alpha_v", "", "the same along v alone"),
    ]
    .concat()
}

/// A roughness that may vary over the surface.
pub struct Rough;

impl Field for Rough {
    type Value = Roughness;

    fn parameters(&self) -> Vec<Parameter> {
        parameters(&Takes::Spectrum(Use::Amount))
    }

    fn read(&self, query: &Query<'_>) -> Option<Roughness> {
        Some(read(query))
    }

    fn write(&self, node: Node, value: &Roughness, writer: &mut Writer) -> Node {
        let node = distribution().write(node, &value.distribution, writer);
        match &value.alpha {
            Alpha::Isotropic(alpha) => node.spectrum("alpha", alpha),
            Alpha::Anisotropic([u, v]) => node.spectrum("alpha_u", u).spectrum("alpha_v", v),
        }
    }
}

/// A roughness that is one number.
pub struct Coat;

impl Field for Coat {
    type Value = CoatRoughness;

    fn parameters(&self) -> Vec<Parameter> {
        parameters(&Takes::Float(Range::NOT_NEGATIVE))
    }

    fn read(&self, query: &Query<'_>) -> Option<CoatRoughness> {
        Some(read_coat(query))
    }

    fn write(&self, node: Node, value: &CoatRoughness, writer: &mut Writer) -> Node {
        distribution().write(node, &value.distribution, writer).float("alpha", value.alpha)
    }
}

/// `distribution`, and `alpha` or `alpha_u` and `alpha_v`, which may vary over the surface.
fn read(query: &Query<'_>) -> Roughness {
    let distribution = distribution().read(query).unwrap_or(Distribution::Beckmann);
    let of = |name| {
        let alpha = spectra::read(query, name, Use::Amount);
        // One that was refused counts as given.
        alpha.or_else(|| query.has(name).then(|| spectra::constant(&query.place(name), DEFAULT_ALPHA)))
    };
    let alpha = match (of("alpha"), of("alpha_u"), of("alpha_v")) {
        (Some(alpha), None, None) => Alpha::Isotropic(alpha),
        (None, Some(u), Some(v)) => Alpha::Anisotropic([u, v]),
        (alpha, u, v) => {
            if alpha.is_some() || u.is_some() || v.is_some() {
                refuse(query);
            }
            Alpha::Isotropic(spectra::constant(&query.object.place, DEFAULT_ALPHA))
        }
    };
    Roughness { distribution, alpha }
}

/// `roughplastic` has one number for its roughness.
fn read_coat(query: &Query<'_>) -> CoatRoughness {
    let distribution = distribution().read(query).unwrap_or(Distribution::Beckmann);
    let of = |name| {
        let alpha = query.float(name)?;
        if alpha >= 0.0 {
            return Some(alpha);
        }
        let problem = format!("The roughness \"{name}\" is {alpha}");
        query.error(SceneError::at(&query.place(name), problem, "expected a number of at least 0"));
        Some(DEFAULT_ALPHA)
    };
    let alpha = match (of("alpha"), of("alpha_u"), of("alpha_v")) {
        (None, None, None) => DEFAULT_ALPHA,
        (Some(alpha), None, None) => alpha,
        (None, Some(u), Some(v)) if u == v => u,
        (None, Some(u), Some(v)) => {
            query.error(
                SceneError::at(
                    &query.place("alpha_v"),
                    format!("The coat's roughness is {u} along the surface and {v} across it"),
                    "expected one roughness, as alpha",
                )
                .with_remedy("\"roughplastic\" is never anisotropic; \"principled\" can be"),
            );
            DEFAULT_ALPHA
        }
        _ => {
            refuse(query);
            DEFAULT_ALPHA
        }
    };
    CoatRoughness { distribution, alpha }
}

fn refuse(query: &Query<'_>) {
    let given = if query.has("alpha_u") { "alpha_u" } else { "alpha_v" };
    query.error(SceneError::at(
        &query.place(given),
        "The roughness is not clear",
        "expected either alpha, or both alpha_u and alpha_v",
    ));
}
