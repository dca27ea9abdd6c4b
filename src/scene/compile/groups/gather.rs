//! From a description to groups.

use super::{Group, Groups, Instance, Piece, centre, lamps, placing};
use crate::geometry::{Bounds, Transform};
use crate::scene::compile::solids::Flat;
use crate::scene::compile::{sensors, shapes};
use crate::scene::description::{self, Animation, Description, ShapeDescription, ShapeGroup};
use crate::scene::source::Place;
use crate::shape;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// A mesh that reaches this many times its own size from the middle of the scene gets coordinates of its own.
/// Rounding moves vertices by up to 2⁻²⁴ of how far they are from the middle of their coordinates: up to here
/// by 10⁻⁴ of the mesh.
const FARTHEST: f64 = 2048.0;

/// Whether a shape is a mesh that is too small for the coordinates of the scene around it.
fn is_apart(shape: &ShapeDescription, own: Bounds, scene: Bounds) -> bool {
    let middle = centre(scene);
    let reach = (own.min - middle).abs().max((own.max - middle).abs()).max_element();
    let size = (own.max - own.min).max_element();
    let is_mesh = || {
        let placed = shapes::place(shape, &shape.to_world, false, false);
        matches!(placed, Ok(shape::Shape::Mesh(_)))
    };
    size > 0.0 && reach.is_finite() && reach > FARTHEST * size && is_mesh()
}

impl<'a> Groups<'a> {
    pub fn new(description: &'a Description) -> Self {
        let all = Self::with_apart(description, |_| false);
        let scene = all.scene_bounds();
        let own = all.own.pieces.iter().zip(&all.own.boxes).filter(|(piece, _)| !piece.part);
        let apart: BTreeSet<*const ShapeDescription> = own
            .filter(|(piece, bounds)| is_apart(piece.shape, **bounds, scene))
            .map(|(piece, _)| std::ptr::from_ref(piece.shape))
            .collect();
        if apart.is_empty() {
            return all;
        }
        Self::with_apart(description, |shape| apart.contains(&std::ptr::from_ref(shape)))
    }

    /// With some of the shapes that stand still in groups of their own.
    fn with_apart(description: &'a Description, is_apart: impl Fn(&ShapeDescription) -> bool) -> Self {
        let shutter = description.sensor.shutter.during();
        let mut gathering = Gathering { groups: Vec::new(), known: BTreeMap::new(), shutter };
        let (moving, still): (Vec<&ShapeDescription>, Vec<&ShapeDescription>) =
            description.shapes.iter().partition(|shape| shape.motion.is_some());
        let mut own = Flat { eyes: Some(sensors::eyes(&description.sensor)), ..Flat::default() };
        let (apart, still): (Vec<&ShapeDescription>, Vec<&ShapeDescription>) =
            still.into_iter().partition(|shape| is_apart(shape));
        own.pieces.extend(still.into_iter().map(|shape| Piece::whole(shape, shape.to_world)));
        let mut instances = Vec::new();
        for (number, shown) in description.instances.iter().enumerate() {
            instances.push(gathering.instance(shown, Some(number)));
        }
        for shape in moving {
            instances.push(gathering.moving(shape));
        }
        for shape in apart {
            let group = gathering.single(Piece::whole(shape, shape.to_world));
            instances.push(show(&shape.place, group, true, &Transform::IDENTITY, None));
        }
        for solid in &description.solids {
            match solid.motion {
                None => own.add(solid, solid.to_world, shutter),
                Some(_) => instances.push(gathering.moving_solid(solid)),
            }
        }
        // Parts that move of unions that are nothing but their parts.
        for (mut piece, keys) in std::mem::take(&mut own.moving) {
            piece.part = false;
            let (place, to_world, to_keys) = (&piece.shape.place, piece.shape.to_world, piece.to_keys);
            let group = gathering.single(piece);
            instances.push(Instance {
                place,
                number: None,
                group,
                of_group: false,
                to_world,
                keys: Some(keys),
                to_keys,
            });
        }
        let (lamps, errors) = lamps::of(description);
        for lamp in lamps {
            let group = gathering.single(Piece::whole(lamp.shape, lamp.to_group));
            instances.push(Instance {
                place: &lamp.shape.place,
                number: Some(lamp.number),
                group,
                of_group: false,
                to_world: lamp.to_world,
                keys: lamp.keys,
                to_keys: lamp.to_keys,
            });
        }
        let own = gathering.group(own, instances);
        let mut groups = gathering.groups;
        let mut start = own.pieces.len();
        for group in &mut groups {
            group.start = start;
            start += group.pieces.len();
        }
        Self { own, groups, shutter, errors }
    }
}

/// Groups as they are found.
struct Gathering<'a> {
    groups: Vec<Group<'a>>,
    /// The indices of those of the file.
    known: BTreeMap<*const ShapeGroup, usize>,
    shutter: [f64; 2],
}

impl<'a> Gathering<'a> {
    fn group(&self, flat: Flat<'a>, instances: Vec<Instance<'a>>) -> Group<'a> {
        let boxes: Vec<Bounds> = flat.pieces.iter().map(|piece| piece.bounds_during(self.shutter)).collect();
        let Flat { pieces, solids, .. } = flat;
        let of_shapes = pieces.iter().zip(&boxes).filter(|(piece, _)| !piece.part).map(|(_, bounds)| *bounds);
        let of_solids = solids.iter().map(|plan| plan.bounds(&boxes));
        let of_instances = instances.iter().map(|instance| self.bounds(instance));
        let bounds = Bounds::of_all(of_shapes.chain(of_solids).chain(of_instances));
        Group { pieces, solids, instances, boxes, bounds, start: 0 }
    }

    /// The box around what an instance shows while the shutter is open.
    fn bounds(&self, instance: &Instance<'a>) -> Bounds {
        let group = self.groups[instance.group].bounds;
        match instance.motion() {
            _ if group.is_empty() => Bounds::EMPTY,
            None => Bounds::of(group.corners().map(|corner| instance.to_world.point(corner))),
            Some(motion) => motion.bounds(group, self.shutter),
        }
    }

    fn add(&mut self, flat: Flat<'a>, instances: Vec<Instance<'a>>) -> usize {
        self.groups.push(self.group(flat, instances));
        self.groups.len() - 1
    }

    /// The index of a group of a single shape.
    fn single(&mut self, piece: Piece<'a>) -> usize {
        self.add(Flat { pieces: vec![piece], ..Flat::default() }, Vec::new())
    }

    fn instance(&mut self, shown: &'a description::Instance, number: Option<usize>) -> Instance<'a> {
        let description::Instance { place, group, to_world, motion, .. } = shown;
        let group = self.of_file(group);
        Instance { number, ..show(place, group, true, to_world, motion.as_deref()) }
    }

    /// A group of the file, without its lights: each place where one of them is shown has one of its own.
    fn of_file(&mut self, group: &'a Arc<ShapeGroup>) -> usize {
        if let Some(known) = self.known.get(&Arc::as_ptr(group)) {
            return *known;
        }
        let mut flat = Flat::default();
        let mut instances: Vec<Instance<'a>> =
            group.instances.iter().map(|inner| self.instance(inner, None)).collect();
        for shape in group.shapes.iter().filter(|shape| shape.emission.is_none()) {
            match shape.motion {
                None => flat.pieces.push(Piece::whole(shape, shape.to_world)),
                Some(_) => instances.push(self.moving(shape)),
            }
        }
        for solid in &group.solids {
            match solid.motion {
                None => flat.add(solid, solid.to_world, self.shutter),
                Some(_) => instances.push(self.moving_solid(solid)),
            }
        }
        let index = self.add(flat, instances);
        self.known.insert(Arc::as_ptr(group), index);
        index
    }

    fn moving(&mut self, shape: &'a ShapeDescription) -> Instance<'a> {
        let motion = shape.motion.as_deref();
        let placed = self.placing(motion, |transform| shapes::depends_on(shape, transform));
        let group = self.single(Piece::whole(shape, placed));
        Instance { to_keys: placed.inverse(), ..show(&shape.place, group, false, &shape.to_world, motion) }
    }

    fn moving_solid(&mut self, solid: &'a description::Solid) -> Instance<'a> {
        let motion = solid.motion.as_deref();
        let placed = self.placing(motion, |transform| {
            solid.leaves().iter().any(|shape| shapes::depends_on(shape, transform))
        });
        let mut flat = Flat::default();
        flat.add(solid, placed, self.shutter);
        let group = self.add(flat, Vec::new());
        Instance { to_keys: placed.inverse(), ..show(&solid.place, group, false, &solid.to_world, motion) }
    }

    fn placing(&self, motion: Option<&Animation>, depends: impl Fn(&Transform) -> bool) -> Transform {
        motion.map_or(Transform::IDENTITY, |motion| placing(&motion.keys, self.shutter, depends))
    }
}

fn show<'a>(
    place: &'a Place,
    group: usize,
    of_group: bool,
    to_world: &Transform,
    motion: Option<&Animation>,
) -> Instance<'a> {
    let keys = motion.map(|motion| motion.keys.clone());
    Instance { place, number: None, group, of_group, to_world: *to_world, keys, to_keys: Transform::IDENTITY }
}
