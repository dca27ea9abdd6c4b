//! Plastic, smooth and rough.

use crate::scene::description::{BsdfKind, CoatRoughness, IndexKind, IndexSource};
use crate::scene::read::indices;
use crate::scene::read::query::Query;
use crate::scene::read::spectra::{self, Use};

/// The index of Mitsuba 3's default for the `int_ior` of plastic, `polypropylene`.
const POLYPROPYLENE: f64 = 1.49;

pub(super) fn read(query: &Query<'_>, coat: Option<CoatRoughness>) -> BsdfKind {
    let polypropylene =
        || IndexSource { place: query.object.place.clone(), kind: IndexKind::Constant(POLYPROPYLENE) };
    BsdfKind::Plastic {
        interior: indices::read(query, "int_ior").unwrap_or_else(polypropylene),
        exterior: indices::read(query, "ext_ior"),
        diffuse_reflectance: spectra::read_or(query, "diffuse_reflectance", Use::Reflectance, 0.5),
        specular_reflectance: spectra::read_or(query, "specular_reflectance", Use::Reflectance, 1.0),
        nonlinear: query.boolean("nonlinear", false),
        coat,
    }
}
