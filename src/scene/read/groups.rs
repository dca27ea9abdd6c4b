//! Shapes that hold shapes and are none themselves: `merge`, `shapegroup`, and the `instance` that shows a
//! group somewhere. Groups that show other groups, and lights and motion in groups, are extensions.

use super::super::description::{Instance, ShapeDescription, ShapeGroup, Solid};
use super::super::plugins::shapes;
use super::super::source::SceneError;
use super::query::{Query, capital};
use super::tree::{Class, ObjectId};
use super::{Reader, solids};
use std::collections::BTreeSet;
use std::sync::Arc;

/// What an object holds, and what is merged into it.
#[derive(Default)]
pub(super) struct Found {
    pub shapes: Vec<ShapeDescription>,
    pub solids: Vec<Solid>,
    pub instances: Vec<Instance>,
    /// Whether the object is a shapegroup.
    of_group: bool,
}

pub(super) fn read(reader: &Reader, query: &Query<'_>) -> Found {
    let of_group = query.object.plugin == "shapegroup";
    let mut found = Found { of_group, ..Found::default() };
    collect(reader, query, &mut found);
    found
}

fn collect(reader: &Reader, query: &Query<'_>, found: &mut Found) {
    for (_, id) in query.objects(Class::Shape) {
        match reader.tree.get(id).plugin.as_str() {
            "merge" => merge(reader, id, found),
            // What an instance shows; by itself it shows nothing.
            "shapegroup" if found.of_group => {
                let problem = "A shapegroup within a shapegroup shows nothing";
                let expected = "expected shapes and instances in a group";
                let error = SceneError::at(&reader.tree.get(id).place, problem, expected);
                query.error(error.with_remedy("put a <shape type=\"instance\"> around it to show it here"));
            }
            "shapegroup" => drop(group(reader, id)),
            "instance" => found.instances.extend(instance(reader, id)),
            plugin if solids::operation(plugin).is_some() => found.solids.extend(solids::read(reader, id)),
            _ => {
                if found.of_group {
                    refuse_sensors(&Query::new(reader, id));
                }
                found.shapes.extend(shapes::of_scene(reader, id));
            }
        }
    }
}

/// A sensor measures where its shape stands, which a group leaves open.
fn refuse_sensors(query: &Query<'_>) {
    for (entry, _) in query.objects(Class::Sensor) {
        let problem = "A sensor on a shape within a shapegroup";
        let error = SceneError::at(&entry.place, problem, "expected no sensor in a group, as in Mitsuba 3");
        query.error(error.with_remedy("put the shape directly into the scene"));
    }
}

/// `merge` is nothing but its children: that Mitsuba 3 makes one mesh of those that can be one changes no
/// picture.
fn merge(reader: &Reader, id: ObjectId, found: &mut Found) {
    let query = Query::new(reader, id);
    if !reader.merges.borrow_mut().insert(id) {
        // References could double it as often as they liked.
        let problem = "A merge is used in two places";
        let error = SceneError::at(&query.object.place, problem, "expected one use of each merge");
        query.error(error.with_remedy("put it into a shapegroup and use instances of that"));
        return;
    }
    collect(reader, &query, found);
    refuse_surface(&query);
    query.finish();
}

/// What a surface is made of belongs to the shapes inside.
fn refuse_surface(query: &Query<'_>) {
    for class in [Class::Bsdf, Class::Emitter, Class::Medium] {
        for (entry, _) in query.objects(class) {
            let problem = format!("{} has no surface of its own", capital(&query.title()));
            let error = SceneError::at(&entry.place, problem, "expected shapes, each with its own");
            query
                .error(error.with_remedy(format!("put the {} into each of the shapes inside", class.word())));
        }
    }
}

fn instance(reader: &Reader, id: ObjectId) -> Option<Instance> {
    let query = Query::new(reader, id);
    let found = query.objects(Class::Shape);
    refuse_surface(&query);
    let (to_world, motion) = query.placement();
    let place = query.object.place.clone();
    let object_id = query.object.id.clone();
    let wrong = |problem: &str| {
        let error = SceneError::at(&place, problem, "expected one <ref> to a shapegroup");
        reader.error(
            error.with_remedy("write <shape type=\"shapegroup\" id=\"...\"> and <ref id=\"...\"/> in here"),
        );
    };
    let is_told = query.has_broken();
    query.finish();
    match found[..] {
        [(_, id)] if reader.tree.get(id).plugin == "shapegroup" => {
            Some(Instance { place, id: object_id, group: group(reader, id), to_world, motion })
        }
        [_] => {
            wrong("An instance shows a shapegroup, no other shape");
            None
        }
        // What is wrong with the reference is told already.
        [] if is_told => None,
        [] => {
            wrong("The instance shows nothing");
            None
        }
        _ => {
            wrong("The instance shows several shapes");
            None
        }
    }
}

/// The groups that instances show, and those that these show, each once.
pub(super) fn shown(instances: &[Instance]) -> Vec<Arc<ShapeGroup>> {
    let mut found = Vec::new();
    let mut known = BTreeSet::new();
    let mut waiting: Vec<&Instance> = instances.iter().rev().collect();
    while let Some(Instance { group, .. }) = waiting.pop() {
        if known.insert(Arc::as_ptr(group)) {
            found.push(group.clone());
            waiting.extend(group.instances.iter().rev());
        }
    }
    found
}

/// A group, read once however many instances show it.
fn group(reader: &Reader, id: ObjectId) -> Arc<ShapeGroup> {
    if let Some(known) = reader.groups.borrow().get(&id) {
        return known.clone();
    }
    let query = Query::new(reader, id);
    if query.has("to_world") {
        query.entry("to_world");
        let problem = "Mitsuba 3 ignores the transform of a shapegroup";
        let error = SceneError::at(&query.place("to_world"), problem, "expected none");
        query.error(error.with_remedy("transform its shapes or its instances"));
    }
    let Found { shapes, solids, instances, .. } = read(reader, &query);
    refuse_surface(&query);
    for inner in &instances {
        reader.extension(&inner.place, "an instance within a shapegroup".to_owned());
    }
    for shape in &shapes {
        if let Some(emission) = &shape.emission {
            reader.extension(&emission.place, "a light within a shapegroup".to_owned());
        }
    }
    // A solid may move as a whole, but its surfaces neither move nor shine by themselves.
    for place in solids.iter().flat_map(|solid| &solid.parts).filter_map(solids::motion_within) {
        let problem = "A part of a solid that moves within a shapegroup";
        let error = SceneError::at(place, problem, "expected solids whose parts stand still in a group");
        query.error(error.with_remedy("let the whole solid move, or put it directly into the scene"));
    }
    for emission in solids.iter().flat_map(Solid::leaves).filter_map(|leaf| leaf.emission.as_ref()) {
        let problem = "A light on a part of a solid within a shapegroup";
        let error = SceneError::at(&emission.place, problem, "expected no emitter in a solid of a group");
        query.error(error.with_remedy("put the solid directly into the scene, or the light on a shape"));
    }
    query.finish();
    let group = Arc::new(ShapeGroup {
        place: reader.tree.get(id).place.clone(),
        id: reader.tree.get(id).id.clone(),
        shapes,
        solids,
        instances,
    });
    reader.groups.borrow_mut().insert(id, group.clone());
    group
}
