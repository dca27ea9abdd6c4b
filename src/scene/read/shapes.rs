//! Shapes.

use super::super::description::{Medium, Priority, ShapeDescription, ShapeKind};
use super::super::plugins::bsdfs;
use super::super::source::SceneError;
use super::query::Query;
use super::solids::{self, Inherited};
use super::tree::{Class, ObjectId};
use super::{Reader, curves, grids, lights, media, meshes, patches, profile_or_implicit, quadrics};
use crate::geometry::Vec3;
use std::sync::Arc;

/// `None` where the shape is wrong, which is reported.
pub(super) fn read(reader: &Reader, id: ObjectId) -> Option<ShapeDescription> {
    let query = Query::new(reader, id);
    // It is read with the scene's other sensors.
    query.object(Class::Sensor);
    one(query, &Inherited::default())
}

/// A part of a solid.
pub(super) fn read_part(reader: &Reader, id: ObjectId, around: &Inherited) -> Option<ShapeDescription> {
    one(Query::new(reader, id), around)
}

fn one(query: Query<'_>, around: &Inherited) -> Option<ShapeDescription> {
    let reader = query.reader;
    let object = query.object;
    let kind = match object.plugin.as_str() {
        "sphere" => Some(ShapeKind::Sphere {
            centre: query.vector("center").unwrap_or(Vec3::ZERO),
            radius: query.positive("radius", 1.0),
        }),
        "rectangle" | "cube" => {
            // They are flat anyway.
            query.boolean("face_normals", false);
            Some(if object.plugin == "cube" { ShapeKind::Cube } else { ShapeKind::Rectangle })
        }
        "disk" => Some(ShapeKind::Disk),
        "cylinder" => Some(cylinder(&query)),
        "cone" | "paraboloid" | "hyperboloid" | "quadric" => quadrics::read(&query),
        "torus" => Some(torus(&query)),
        "sdfgrid" => grids::distances(&query),
        "heightfield" => grids::heights(&query),
        "polygon" | "extrusion" | "revolution" | "superquadric" | "blobs" => {
            profile_or_implicit::read(&query)
        }
        "bezierpatch" => patches::read(&query),
        "linearcurve" | "bsplinecurve" | "sweptsphere" => curves::read(&query),
        "obj" | "ply" | "serialized" => meshes::read(&query),
        plugin if solids::operation(plugin).is_some() => {
            solids::refuse_sensor(&query);
            return None;
        }
        _ => {
            reader.unknown_plugin(object);
            return None;
        }
    };
    let (to_world, motion) = query.placement();
    let flip_normals = query.boolean("flip_normals", false);
    // Only derivatives depend on it.
    query.float("silhouette_sampling_weight");
    let emitter = query.object(Class::Emitter);
    let emission = emitter.and_then(|(_, id)| lights::area(reader, id));
    let bsdf = match (query.object(Class::Bsdf), &around.bsdf) {
        (Some((_, id)), _) => bsdfs::read_once(reader, id),
        (None, Some(inherited)) => Arc::clone(inherited),
        (None, None) => bsdfs::default(&object.place, emitter.is_some()),
    };
    let [interior, exterior] = media(&query);
    // Where light doesn't get in, it is not asked what is there.
    let [inside, outside] = if bsdf.kind.transmits() { around.media.clone() } else { [None, None] };
    let priority = priority(&query).or_else(|| around.priority.clone());
    query.finish();
    Some(ShapeDescription {
        place: object.place.clone(),
        id: object.id.clone(),
        kind: kind?,
        to_world,
        motion,
        flip_normals,
        bsdf,
        emission,
        interior: interior.or(inside),
        exterior: exterior.or(outside),
        priority,
    })
}

fn cylinder(query: &Query<'_>) -> ShapeKind {
    let [from, to] = axis(query);
    ShapeKind::Cylinder { from, to, radius: query.positive("radius", 1.0) }
}

fn torus(query: &Query<'_>) -> ShapeKind {
    query.reader.extension(&query.object.place, "torus: a ring with a round tube".to_owned());
    let (major_radius, minor_radius) =
        (query.positive("major_radius", 1.0), query.positive("minor_radius", 0.25));
    if minor_radius >= major_radius {
        let problem = format!("The tube of the torus has the radius {minor_radius}, its ring {major_radius}");
        let error =
            SceneError::at(&query.place("minor_radius"), problem, "expected minor_radius below major_radius");
        query.error(error.with_remedy("major_radius is measured to the middle of the tube"));
    }
    ShapeKind::Torus { major_radius, minor_radius }
}

/// Both ends of what has an axis.
pub(super) fn axis(query: &Query<'_>) -> [Vec3; 2] {
    let from = query.vector("p0").unwrap_or(Vec3::ZERO);
    let to = query.vector("p1").unwrap_or(Vec3::Z);
    if from == to {
        query.error(SceneError::at(
            &query.place("p1"),
            format!("The {} has no length", query.object.plugin),
            "expected p0 and p1 to differ",
        ));
    }
    [from, to]
}

/// Which of several bodies counts.
pub(super) fn priority(query: &Query<'_>) -> Option<Priority> {
    let value = query.integer("priority", i64::from(i32::MIN), i64::from(i32::MAX))?;
    let place = query.place("priority");
    let text = "priority: where transparent bodies overlap, the highest alone counts";
    query.reader.extension(&place, text.to_owned());
    Some(Priority { place, value: value as i32 })
}

/// The media inside and outside.
pub(super) fn media(query: &Query<'_>) -> [Option<Medium>; 2] {
    let mut sides = [None, None];
    for (entry, id) in query.objects(Class::Medium) {
        let side = match entry.name.as_deref() {
            Some("interior") => 0,
            Some("exterior") => 1,
            name => {
                let problem = match name {
                    Some(name) => format!("The medium is named \"{name}\", which Mitsuba 3 would ignore"),
                    None => "The medium has no name, so that Mitsuba 3 would ignore it".to_owned(),
                };
                let expected = "expected name=\"interior\" or name=\"exterior\"";
                query.error(SceneError::at(&entry.place, problem, expected));
                continue;
            }
        };
        sides[side] = media::read(query.reader, id);
    }
    sides
}
