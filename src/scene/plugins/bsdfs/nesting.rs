//! BSDFs that hold others.

use crate::scene::description::{Bsdf, BsdfKind, SpectrumSource};
use crate::scene::plugins::{Field, Parameter, Takes, bsdfs};
use crate::scene::read::query::capital;
use crate::scene::read::spectra::{self, Use};
use crate::scene::read::{Class, Query, Value};
use crate::scene::source::SceneError;
use crate::scene::write::{Node, Writer};
use std::sync::Arc;

/// The one BSDF that a BSDF holds.
pub struct Held(pub &'static str);

impl Field for Held {
    type Value = Arc<Bsdf>;

    fn parameters(&self) -> Vec<Parameter> {
        vec![Parameter { doc: self.0, is_required: true, ..Parameter::new("", Takes::Object("bsdf")) }]
    }

    fn read(&self, query: &Query<'_>) -> Option<Arc<Bsdf>> {
        held(query).map(|[nested]| nested)
    }

    fn write(&self, node: Node, nested: &Arc<Bsdf>, writer: &mut Writer) -> Node {
        node.child(bsdfs::node(nested, writer))
    }
}

/// The two BSDFs of a mixture.
pub struct Mixed;

impl Field for Mixed {
    type Value = (Arc<Bsdf>, Arc<Bsdf>);

    fn parameters(&self) -> Vec<Parameter> {
        [Held("the first BSDF").parameters(), Held("the second").parameters()].concat()
    }

    fn read(&self, query: &Query<'_>) -> Option<Self::Value> {
        held(query).map(<_>::from)
    }

    fn write(&self, node: Node, (first, second): &Self::Value, writer: &mut Writer) -> Node {
        let node = node.child(bsdfs::node(first, writer)).child(bsdfs::node(second, writer));
        node.remark("the weight is that of the second")
    }
}

/// A BSDF on both sides, or one on either.
pub struct Sides;

impl Field for Sides {
    type Value = (Arc<Bsdf>, Option<Arc<Bsdf>>);

    fn parameters(&self) -> Vec<Parameter> {
        let back = Parameter {
            doc: "that of the back, where it is another",
            ..Parameter::new("", Takes::Object("bsdf"))
        };
        [Held("the BSDF of the front").parameters(), vec![back]].concat()
    }

    fn read(&self, query: &Query<'_>) -> Option<Self::Value> {
        let nested = query.objects(Class::Bsdf);
        if nested.is_empty() && query.has_broken() {
            return None;
        }
        if !(1..=2).contains(&nested.len()) {
            refuse_count(query, "BSDF", nested.len(), "one for both sides, or two: front, back");
            return None;
        }
        let mut sides = nested.into_iter().map(|(_, id)| bsdfs::read_once(query.reader, id));
        Some((sides.next()?, sides.next()))
    }

    fn write(&self, node: Node, (front, back): &Self::Value, writer: &mut Writer) -> Node {
        let node = node.child(bsdfs::node(front, writer));
        match back {
            None => node.remark("the same on both sides"),
            Some(back) => {
                node.child(bsdfs::node(back, writer)).remark("the first is in front, the second behind")
            }
        }
    }
}

/// The one texture of a bump map, whatever its name.
pub struct Map;

impl Field for Map {
    type Value = SpectrumSource;

    fn parameters(&self) -> Vec<Parameter> {
        let heights = Parameter::new("texture", Takes::Spectrum(Use::Height));
        vec![Parameter { doc: "heights, under any name", is_required: true, ..heights }]
    }

    fn read(&self, query: &Query<'_>) -> Option<SpectrumSource> {
        match query.object(Class::Spectrum) {
            Some((_, id)) => spectra::plugin(query.reader, id)
                .filter(|source| spectra::check(query.reader, source, "texture", Use::Height)),
            None => {
                refuse_count(query, "texture", 0, "one texture of heights");
                None
            }
        }
    }

    fn write(&self, node: Node, height: &SpectrumSource, _: &mut Writer) -> Node {
        node.spectrum("texture", height)
    }
}

/// Refuses sides that let light through where that is not asked for. Either side is seen from its front: of
/// another `twosided`, that is the BSDF of its front alone.
pub fn opaque(query: &Query<'_>, kind: BsdfKind) -> Option<BsdfKind> {
    let BsdfKind::TwoSided { front, back, allow_transmission } = &kind else { return Some(kind) };
    let places = query.object.entries.iter().filter_map(|entry| match entry.value {
        Value::Object(id) if query.reader.tree.get(id).class == Class::Bsdf => Some((entry, id)),
        _ => None,
    });
    for ((entry, id), bsdf) in places.zip([front].into_iter().chain(back)) {
        let plugin = &query.reader.tree.get(id).plugin;
        if bsdf.kind.transmits() && !allow_transmission {
            let problem = format!("\"twosided\" cannot hold \"{plugin}\", which lets light through");
            query.error(
                SceneError::at(&entry.place, problem, "expected a BSDF that only reflects")
                    .with_remedy("use the nested BSDF by itself"),
            );
        }
    }
    let seen = |side: &Arc<Bsdf>| match &side.kind {
        BsdfKind::TwoSided { front, .. } => front.clone(),
        _ => side.clone(),
    };
    let back = back.as_ref().map(seen);
    Some(BsdfKind::TwoSided { front: seen(front), back, allow_transmission: *allow_transmission })
}

/// The BSDFs within one that holds a fixed number of them.
fn held<const N: usize>(query: &Query<'_>) -> Option<[Arc<Bsdf>; N]> {
    let nested = query.objects(Class::Bsdf);
    let found = nested.len();
    let bsdfs: Vec<Arc<Bsdf>> =
        nested.into_iter().map(|(_, id)| bsdfs::read_once(query.reader, id)).collect();
    let bsdfs = <[Arc<Bsdf>; N]>::try_from(bsdfs);
    if bsdfs.is_err() && !(found < N && query.has_broken()) {
        refuse_count(query, "BSDF", found, if N == 1 { "one" } else { "two" });
    }
    bsdfs.ok()
}

fn refuse_count(query: &Query<'_>, what: &str, found: usize, expected: &str) {
    let plural = if found == 1 { "" } else { "s" };
    query.error(SceneError::at(
        &query.object.place,
        format!("{} holds {found} {what}{plural}", capital(&query.title())),
        format!("expected {expected}"),
    ));
}
