//! The roughness of surfaces made of small facets.

use crate::bsdf::microfacet::Distribution;
use crate::scene::description::{Alpha, CoatRoughness, Roughness};
use crate::scene::read::query::Query;
use crate::scene::read::spectra::{self, Use};
use crate::scene::source::SceneError;

/// Mitsuba 3's default for `alpha`.
const DEFAULT_ALPHA: f64 = 0.1;

/// `distribution`, and `alpha` or `alpha_u` and `alpha_v`, which may vary over the surface.
pub(super) fn read(query: &Query<'_>) -> Roughness {
    let distribution = distribution(query);
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
pub(super) fn read_coat(query: &Query<'_>) -> CoatRoughness {
    let distribution = distribution(query);
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

fn distribution(query: &Query<'_>) -> Distribution {
    const DISTRIBUTIONS: [(&str, Distribution); 2] =
        [("beckmann", Distribution::Beckmann), ("ggx", Distribution::Ggx)];
    if query.has("sample_visible") {
        query.boolean("sample_visible", true);
        query.reader.remark(
            &query.place("sample_visible"),
            "sample_visible changes nothing: visible normals are always sampled".to_owned(),
        );
    }
    query.choice("distribution", &DISTRIBUTIONS, true).unwrap_or(Distribution::Beckmann)
}
