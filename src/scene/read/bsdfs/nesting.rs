//! BSDFs that hold others.

use super::read;
use crate::scene::description::{Bsdf, BsdfKind, NormalMapShading, SpectrumSource};
use crate::scene::read::query::{Query, capital};
use crate::scene::read::spectra::{self, Use};
use crate::scene::read::tree::{Class, Value};
use crate::scene::source::SceneError;
use std::collections::BTreeSet;
use std::sync::Arc;

pub(super) fn mask(query: &Query<'_>) -> Option<BsdfKind> {
    let opacity = spectra::read_or(query, "opacity", Use::Weight, 0.5);
    let [nested] = held(query)?;
    Some(BsdfKind::Mask { opacity, nested })
}

pub(super) fn blend(query: &Query<'_>) -> Option<BsdfKind> {
    let weight = query.required("weight", spectra::read(query, "weight", Use::Weight));
    let nested = held(query)?;
    Some(BsdfKind::Blend { weight: weight?, nested })
}

pub(super) fn bump_map(query: &Query<'_>) -> Option<BsdfKind> {
    let scale = query.float("scale").unwrap_or(1.0);
    let shading = shading(query);
    let height = map(query);
    let [nested] = held(query)?;
    Some(BsdfKind::BumpMap { height: height?, scale, shading, nested })
}

pub(super) fn normal_map(query: &Query<'_>) -> Option<BsdfKind> {
    let shading = shading(query);
    let normals = query.required("normalmap", spectra::read(query, "normalmap", Use::Normals));
    let [nested] = held(query)?;
    Some(BsdfKind::NormalMap { normals: normals?, shading, nested })
}

fn shading(query: &Query<'_>) -> NormalMapShading {
    NormalMapShading {
        flip_invalid_normals: query.boolean("flip_invalid_normals", true),
        use_shadowing_function: query.boolean("use_shadowing_function", true),
    }
}

/// The one texture of a bump map, whatever its name.
fn map(query: &Query<'_>) -> Option<SpectrumSource> {
    match query.object(Class::Spectrum) {
        Some((_, id)) => spectra::plugin(query.reader, id)
            .filter(|source| spectra::check(query.reader, source, "texture", Use::Height)),
        None => {
            refuse_count(query, "texture", 0, "one texture of heights");
            None
        }
    }
}

/// A BSDF on both sides, or one on either.
pub(super) fn two_sided(query: &Query<'_>) -> Option<BsdfKind> {
    let allow_transmission = query.boolean("allow_transmission", false);
    let nested = query.objects(Class::Bsdf);
    if nested.is_empty() && is_broken(query) {
        return None;
    }
    if !(1..=2).contains(&nested.len()) {
        refuse_count(query, "BSDF", nested.len(), "one for both sides, or two: front, back");
        return None;
    }
    let mut sides = nested.into_iter().map(|(entry, id)| {
        let bsdf = read(query.reader, id);
        let plugin = &query.reader.tree.get(id).plugin;
        let problem = if transmits(&bsdf, &mut BTreeSet::new()) && !allow_transmission {
            Some(format!("\"twosided\" cannot hold \"{plugin}\", which lets light through"))
        } else if matches!(bsdf.kind, BsdfKind::TwoSided { .. }) {
            Some("\"twosided\" cannot hold another \"twosided\"".to_owned())
        } else {
            None
        };
        if let Some(problem) = problem {
            query.error(
                SceneError::at(&entry.place, problem, "expected a BSDF that only reflects")
                    .with_remedy("use the nested BSDF by itself"),
            );
        }
        bsdf
    });
    let front = sides.next()?;
    Some(BsdfKind::TwoSided { front, back: sides.next(), allow_transmission })
}

/// Whether light can get through. What several BSDFs share is looked at once: `met` are those that were.
fn transmits(bsdf: &Arc<Bsdf>, met: &mut BTreeSet<*const Bsdf>) -> bool {
    if !met.insert(Arc::as_ptr(bsdf)) {
        return false;
    }
    match &bsdf.kind {
        BsdfKind::Null
        | BsdfKind::Mask { .. }
        | BsdfKind::Dielectric { .. }
        | BsdfKind::DiffuseTransmitter { .. }
        | BsdfKind::ThinDielectric { .. }
        | BsdfKind::PrincipledThin { .. } => true,
        BsdfKind::Principled { base, .. } => base.spec_trans.constant() != Some(0.0),
        BsdfKind::Diffuse { .. }
        | BsdfKind::Conductor { .. }
        | BsdfKind::Plastic { .. }
        | BsdfKind::TwoSided { .. } => false,
        BsdfKind::Blend { nested, .. } => nested.iter().any(|nested| transmits(nested, met)),
        BsdfKind::BumpMap { nested, .. } | BsdfKind::NormalMap { nested, .. } => transmits(nested, met),
    }
}

/// The BSDFs within one that holds a fixed number of them.
fn held<const N: usize>(query: &Query<'_>) -> Option<[Arc<Bsdf>; N]> {
    let nested = query.objects(Class::Bsdf);
    let found = nested.len();
    let bsdfs: Vec<Arc<Bsdf>> = nested.into_iter().map(|(_, id)| read(query.reader, id)).collect();
    let bsdfs = <[Arc<Bsdf>; N]>::try_from(bsdfs);
    if bsdfs.is_err() && !(found < N && is_broken(query)) {
        refuse_count(query, "BSDF", found, if N == 1 { "one" } else { "two" });
    }
    bsdfs.ok()
}

/// Whether something within was refused already, which may be what seems to be missing.
fn is_broken(query: &Query<'_>) -> bool {
    query.object.entries.iter().any(|entry| matches!(entry.value, Value::Broken))
}

fn refuse_count(query: &Query<'_>, what: &str, found: usize, expected: &str) {
    let plural = if found == 1 { "" } else { "s" };
    query.error(SceneError::at(
        &query.object.place,
        format!("{} holds {found} {what}{plural}", capital(&query.title())),
        format!("expected {expected}"),
    ));
}
