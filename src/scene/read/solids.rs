//! Solids: `union`, `intersection` and `difference` of closed shapes, which Mitsuba 3 does not have.

use super::super::description::{Bsdf, Medium, Part, Priority, Solid};
use super::super::plugins::{bsdfs, shapes};
use super::super::source::{Place, SceneError};
use super::Reader;
use super::query::{Query, capital};
use super::tree::{Class, ObjectId};
use crate::geometry::Transform;
use crate::shape::solid::Operation;
use std::sync::Arc;

const OPERATIONS: [(&str, Operation); 3] = [
    ("union", Operation::Union),
    ("intersection", Operation::Intersection),
    ("difference", Operation::Difference),
];

/// What a plugin does with the shapes in it, if it makes a solid of them.
pub(in crate::scene) fn operation(plugin: &str) -> Option<Operation> {
    OPERATIONS.iter().find(|(name, _)| *name == plugin).map(|&(_, operation)| operation)
}

/// The name of an operation in a scene file.
pub(in crate::scene) fn word(operation: Operation) -> &'static str {
    OPERATIONS.iter().find(|(_, known)| *known == operation).map_or("union", |&(name, _)| name)
}

/// What a part has where it says nothing of its own: what the solid around it says.
#[derive(Clone, Default)]
pub(in crate::scene) struct Inherited {
    pub bsdf: Option<Arc<Bsdf>>,
    /// Media inside and outside.
    pub media: [Option<Medium>; 2],
    pub priority: Option<Priority>,
}

/// Where a solid stands in others.
#[derive(Clone, Default)]
struct Enclosing {
    inherited: Inherited,
    /// Whether one of them moves.
    moving: bool,
    /// Whether one of them changes shapes by more than their size.
    stretched: bool,
}

/// `None` where the solid is wrong, which is reported.
pub(in crate::scene) fn read(reader: &Reader, id: ObjectId) -> Option<Solid> {
    read_within(reader, id, &Enclosing::default())
}

fn read_within(reader: &Reader, id: ObjectId, around: &Enclosing) -> Option<Solid> {
    let query = Query::new(reader, id);
    let object = query.object;
    let place = &object.place;
    let operation = operation(&object.plugin)?;
    if !reader.merges.borrow_mut().insert(id) {
        // References could double it as often as they liked.
        let problem = format!("{} is used in two places", capital(&query.title()));
        let error = SceneError::at(place, problem, "expected one use of each solid");
        query.error(error.with_remedy("put it into a shapegroup and use instances of that"));
        return None;
    }
    reader.extension(place, format!("{}: constructive solid geometry", object.plugin));
    let (to_world, motion) = query.placement();
    let mut inner = around.clone();
    check_motion(&query, &mut inner, motion.as_ref().map(|motion| &motion.place), &to_world);
    if let Some((_, id)) = query.object(Class::Bsdf) {
        inner.inherited.bsdf = Some(bsdfs::read_once(reader, id));
    }
    let media = shapes::media(&query);
    for (own, inherited) in media.iter().zip(&mut inner.inherited.media) {
        if own.is_some() {
            inherited.clone_from(own);
        }
    }
    if let Some(priority) = shapes::priority(&query) {
        inner.inherited.priority = Some(priority);
    }
    for (entry, _) in query.objects(Class::Emitter) {
        let problem = format!("{} has no surface of its own", capital(&query.title()));
        let error = SceneError::at(&entry.place, problem, "expected emitters in the shapes that shine");
        query.error(error.with_remedy("put the emitter into those of the shapes inside that emit light"));
    }
    if !query.objects(Class::Sensor).is_empty() {
        refuse_sensor(&query);
    }
    let found = query.objects(Class::Shape);
    if found.is_empty() && !query.has_broken() {
        let problem = format!("{} is made of nothing", capital(&query.title()));
        query.error(SceneError::at(place, problem, "expected shapes in it"));
    }
    let parts = found.iter().filter_map(|&(entry, id)| part(&query, &entry.place, id, &inner)).collect();
    query.finish();
    let solid = Solid { place: place.clone(), id: object.id.clone(), operation, parts, to_world, motion };
    let clear = solid.leaves().iter().any(|leaf| leaf.bsdf.kind.transmits());
    if let Some(medium) = media.into_iter().flatten().next().filter(|_| !clear) {
        let problem = "No ray ever gets into this medium";
        let expected = "expected a medium in or around surfaces that let light through";
        reader.error(SceneError::at(&medium.place, problem, expected).with_remedy(
            "give the solid a BSDF that lets light through, such as `dielectric` or `null`, or leave the medium out",
        ));
    }
    Some(solid)
}

fn part(query: &Query<'_>, place: &Place, id: ObjectId, around: &Enclosing) -> Option<Part> {
    let reader = query.reader;
    let plugin = reader.tree.get(id).plugin.as_str();
    if operation(plugin).is_some() {
        return read_within(reader, id, around).map(Part::Solid);
    }
    if ["merge", "shapegroup", "instance"].contains(&plugin) {
        let problem = format!("A shape \"{plugin}\" within a solid");
        let error =
            SceneError::at(place, problem, "expected closed shapes, unions, intersections or differences");
        query.error(match plugin {
            "merge" => error.with_remedy("use \"union\""),
            _ => error.with_remedy("put the shapes themselves here; a solid may be put into a shapegroup"),
        });
        return None;
    }
    let shape = shapes::of_solid(reader, id, &around.inherited)?;
    check_motion(
        query,
        &mut around.clone(),
        shape.motion.as_ref().map(|motion| &motion.place),
        &shape.to_world,
    );
    Some(Part::Shape(shape))
}

/// A sensor measures on a single shape.
pub(in crate::scene) fn refuse_sensor(query: &Query<'_>) {
    let problem = format!("A sensor on a shape \"{}\"", query.object.plugin);
    let error = SceneError::at(&query.object.place, problem, "expected a single shape");
    query.error(error.with_remedy("put the sensor on a shape of its own"));
}

/// What moves within something that moves, or within something that is stretched, has no motion from keyframe
/// to keyframe.
fn check_motion(query: &Query<'_>, around: &mut Enclosing, motion: Option<&Place>, to_world: &Transform) {
    let Some(place) = motion else {
        around.stretched |= to_world.uniform_scale().is_none();
        return;
    };
    let expected = "expected parts that stand still in it";
    if around.moving {
        let problem = "A part that moves within a solid that moves";
        let error = SceneError::at(place, problem, expected);
        query.error(error.with_remedy("let either the whole or its parts move"));
    } else if around.stretched {
        let problem = "A part that moves within a solid that is stretched";
        let error = SceneError::at(place, problem, expected);
        query.error(error.with_remedy(
            "scale the solid alike in all directions, or put the whole transform into the keyframes",
        ));
    }
    around.moving = true;
}

/// The first animation of a part of a solid, or within that part.
pub(in crate::scene) fn motion_within(part: &Part) -> Option<&Place> {
    match part {
        Part::Shape(shape) => shape.motion.as_ref().map(|motion| &motion.place),
        Part::Solid(solid) => {
            let own = solid.motion.as_ref().map(|motion| &motion.place);
            own.or_else(|| solid.parts.iter().find_map(motion_within))
        }
    }
}
