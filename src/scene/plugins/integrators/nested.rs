//! Integrators that hold another: `aov` and `moment`.

use super::super::{Field, Parameter, Takes};
use super::Method;
use crate::scene::description::{Aov, Integrator, Moments};
use crate::scene::read::query::capital;
use crate::scene::read::{Class, Query, aovs};
use crate::scene::source::SceneError;
use crate::scene::write::{Node, Value, Writer};
use std::borrow::Cow;
use std::rc::Rc;

/// An integrator within another, with its name.
pub type Named = (String, Box<Integrator>);

/// The images that an `aov` lists.
pub struct Images;

impl Field for Images {
    type Value = Vec<Aov>;

    fn parameters(&self) -> Vec<Parameter> {
        let doc = "images `name:type`, apart by commas; the types are those of `--aov`";
        vec![Parameter { is_required: true, doc, ..Parameter::new("aovs", Takes::Text) }]
    }

    fn read(&self, query: &Query<'_>) -> Option<Vec<Aov>> {
        Some(aovs::read(query))
    }

    fn write(&self, node: Node, aovs: &Vec<Aov>, _: &mut Writer) -> Node {
        let pairs = aovs.iter().map(|aov| format!("{}:{}", aov.name, aov.kind.name()));
        node.text("aovs", pairs.collect::<Vec<_>>().join(", "))
    }
}

/// The integrator in another.
pub struct Within {
    pub is_required: bool,
}

impl Field for Within {
    type Value = Option<Named>;

    fn parameters(&self) -> Vec<Parameter> {
        let (is_required, doc) = match self.is_required {
            true => (true, "what makes the picture"),
            false => (false, "what makes the picture, which is black otherwise"),
        };
        vec![Parameter { is_required, doc, ..Parameter::new("", Takes::Object("integrator")) }]
    }

    fn read(&self, query: &Query<'_>) -> Option<Option<Named>> {
        let found = query.objects(Class::Integrator);
        if let Some((second, _)) = found.get(1) {
            let problem = format!("{} holds several integrators", capital(&query.title()));
            let error = SceneError::at(&second.place, problem, "expected one: a render has one picture");
            query.error(error.with_remedy("write a scene file for each of them"));
        }
        let Some(&(entry, id)) = found.first() else {
            self.miss(query);
            return Some(None);
        };
        let name = entry.name.clone().unwrap_or_else(|| query.unnamed(entry));
        Some(Some((name, Box::new(super::integrator(Query::new(query.reader, id))))))
    }

    fn write(&self, node: Node, inner: &Option<Named>, writer: &mut Writer) -> Node {
        let Some((name, inner)) = inner else { return node };
        let inner = Value::Object(Rc::new(super::node(inner, writer)));
        node.property(Some(Cow::Owned(name.clone())), inner, None)
    }
}

impl Within {
    fn miss(&self, query: &Query<'_>) {
        if !self.is_required {
            let text = "the picture is black: no integrator stands in \"aov\"";
            query.reader.remark(&query.object.plugin_place, text.to_owned());
        } else if !query.has_broken() {
            let problem = "The integrator \"moment\" holds none";
            let error = SceneError::at(&query.object.place, problem, "expected one integrator in it");
            query.error(error.with_remedy("put <integrator type=\"path\"/> into it"));
        }
    }
}

/// An integrator with images beside its picture. The names of what it has already begin with its own.
pub fn beside(mut aovs: Vec<Aov>, name: &str, mut inner: Integrator) -> Integrator {
    inner.aovs.iter_mut().for_each(|aov| aov.name = format!("{name}.{}", aov.name));
    if let Some(Moments { within, .. }) = &mut inner.moments {
        let inside = within.take().map_or(String::new(), |inside| format!(".{inside}"));
        *within = Some(format!("{name}{inside}"));
    }
    aovs.append(&mut inner.aovs);
    Integrator { aovs, ..inner }
}

/// Refuses a `moment` around what has images or moments of its own.
pub fn of_a_picture(query: &Query<'_>, method: Method) -> Option<Method> {
    let Method::Moment { inner: Some((_, inner)) } = &method else { return Some(method) };
    let refuse = |problem: &str, expected: &str, remedy: &str| {
        query.error(SceneError::at(&query.object.place, problem, expected).with_remedy(remedy));
    };
    if !inner.aovs.is_empty() {
        let expected = "moments are those of the picture alone";
        refuse("An \"aov\" within a \"moment\"", expected, "put the \"moment\" into the \"aov\"");
    }
    if inner.moments.is_some() {
        refuse("A \"moment\" within a \"moment\"", "expected one of them", "leave one of them out");
    }
    Some(method)
}
