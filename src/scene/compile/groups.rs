//! Groups of shapes, and the instances that show them. A shape that moves is a group of its own, with one instance.

use super::place;
use crate::accel::{self, Accel};
use crate::geometry::{Bounds, Motion, Placed, Transform, Vec3};
use crate::scene::description::{self, Animation, Description, Shape, ShapeGroup, ShapeKind};
use crate::scene::source::Place;
use crate::scene::traceable::Surface;
use crate::shape;
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

/// The groups that some instance shows, and the shapes that move. Like the scene, each is moved so that its centre lies at
/// the origin.
pub(super) struct Groups<'a> {
    /// Shapes that stand still.
    own: Vec<&'a Shape>,
    groups: Vec<Group<'a>>,
    instances: Vec<Instance<'a>>,
    shutter: [f64; 2],
}

struct Group<'a> {
    /// In coordinates of the group, but for their own `to_world`.
    shapes: Vec<&'a Shape>,
    /// Whether a shape's own `to_world` puts it where it belongs in the group: that of a moving shape is part of the motion.
    placed: bool,
    bounds: Bounds,
    /// Which of the scene's shapes are the group's.
    range: Range<usize>,
}

/// A group and where it stands.
struct Instance<'a> {
    place: &'a Place,
    group: usize,
    to_world: &'a Transform,
    motion: Option<&'a Animation>,
}

impl<'a> Groups<'a> {
    pub fn new(description: &'a Description) -> Self {
        let (moving, own): (Vec<&Shape>, Vec<&Shape>) =
            description.shapes.iter().partition(|shape| shape.motion.is_some());
        let shutter = description.sensor.shutter.during();
        let mut all = Self { own, groups: Vec::new(), instances: Vec::new(), shutter };
        let mut known: BTreeMap<*const ShapeGroup, usize> = BTreeMap::new();
        for description::Instance { place, group, to_world, motion, .. } in &description.instances {
            let group = *known
                .entry(Arc::as_ptr(group))
                .or_insert_with(|| all.group(group.shapes.iter().collect(), true));
            all.instances.push(Instance { place, group, to_world, motion: motion.as_deref() });
        }
        for shape in moving {
            let group = all.group(vec![shape], false);
            let motion = shape.motion.as_deref();
            all.instances.push(Instance { place: &shape.place, group, to_world: &shape.to_world, motion });
        }
        all
    }

    /// The index of a new group.
    fn group(&mut self, shapes: Vec<&'a Shape>, placed: bool) -> usize {
        let start = self.groups.last().map_or(self.own.len(), |last| last.range.end);
        let range = start..start + shapes.len();
        let bounds = bounds(&shapes, placed);
        self.groups.push(Group { shapes, placed, bounds, range });
        self.groups.len() - 1
    }

    /// Whether anything moves while the shutter is open.
    pub fn move_while_open(&self) -> bool {
        self.shutter[0] < self.shutter[1] && self.instances.iter().any(|instance| instance.motion.is_some())
    }

    /// The box around all shapes and instances while the shutter is open, in the file's coordinates.
    pub fn scene_bounds(&self) -> Bounds {
        let instances = self.instances.iter().map(|instance| {
            let group = self.groups[instance.group].bounds;
            match instance.motion.and_then(|motion| Motion::new(&motion.keys).ok()) {
                None => Bounds::of(group.corners().map(|corner| instance.to_world.point(corner))),
                Some(motion) => motion.bounds(group, self.shutter),
            }
        });
        bounds(&self.own, true).union(Bounds::of_all(instances))
    }

    /// How many shapes stand still: they come first.
    pub fn own(&self) -> usize {
        self.own.len()
    }

    /// All shapes, first those that stand still. With each what moves it to the coordinates that it is traced in, and where
    /// it is carried to from there if it moves; `shift` moves the scene to the origin.
    pub fn shapes(&self, shift: &Transform) -> Vec<(&'a Shape, Transform, Option<Placed>)> {
        let own = self.own.iter().map(|&shape| (shape, shape.to_world.then(shift), None));
        let grouped = self.groups.iter().enumerate().flat_map(|(index, group)| {
            let centre = Transform::translation(-centre(group.bounds));
            group.shapes.iter().map(move |&shape| {
                if group.placed {
                    return (shape, shape.to_world.then(&centre), None);
                }
                let mover = self.instances.iter().find(|instance| instance.group == index);
                (shape, centre, mover.and_then(|instance| self.placed(instance, shift)))
            })
        });
        own.chain(grouped).collect()
    }

    /// Where an instance stands over time; `None` where its transform makes it too thin or too large.
    fn placed(&self, instance: &Instance<'a>, shift: &Transform) -> Option<Placed> {
        let centre = centre(self.groups[instance.group].bounds);
        match instance.motion {
            None => {
                let to_world = Transform::translation(centre).then(instance.to_world).then(shift);
                Placed::still(&to_world)
            }
            Some(motion) => {
                let motion = Motion::new(&motion.keys).ok()?.recentred(centre, shift.point(Vec3::ZERO));
                Placed::moving(motion)
            }
        }
    }

    /// Whether some group has a surface of a body, which may then lie within another.
    pub fn hold_bodies(&self, surfaces: &[Surface]) -> bool {
        self.groups.iter().any(|group| surfaces[group.range.clone()].iter().any(|s| s.body.is_some()))
    }

    /// For each instance its group's range of all shapes, the box around it while the shutter is open, and by how much at most
    /// it stretches lengths. `shift` moves the scene to the origin.
    pub fn placed_boxes(
        &self,
        shapes: &[shape::Shape],
        shift: &Transform,
    ) -> Vec<(Range<usize>, Bounds, f64)> {
        let placed = |instance: &Instance<'a>| {
            let placed = self.placed(instance, shift)?;
            let range = self.groups[instance.group].range.clone();
            let group = Bounds::of_all(shapes[range.clone()].iter().map(shape::Shape::bounds));
            Some((range, placed.bounds(group, self.shutter), placed.largest_stretch()))
        };
        self.instances.iter().filter_map(placed).collect()
    }

    /// The tree of the scene whose shapes, those of groups included, are `shapes`. `shift` moves the scene to the origin.
    ///
    /// # Errors
    /// The places of instances whose transforms make them too thin or too large.
    pub fn accel(&self, shapes: &[shape::Shape], shift: &Transform) -> Result<Accel, Vec<&'a Place>> {
        let trees: Vec<Arc<Accel>> = self
            .groups
            .iter()
            .map(|group| Arc::new(Accel::of_group(&shapes[group.range.clone()], group.range.start as u32)))
            .collect();
        let (mut instances, mut errors) = (Vec::new(), Vec::new());
        for instance in &self.instances {
            match self.placed(instance, shift) {
                Some(placed) => instances.push(accel::Instance::new(trees[instance.group].clone(), placed)),
                None => errors.push(instance.place),
            }
        }
        let own = &shapes[..self.own.len()];
        if errors.is_empty() { Ok(Accel::with_instances(own, instances, self.shutter)) } else { Err(errors) }
    }
}

/// The middle of a box, or the origin where there is none.
pub(super) fn centre(bounds: Bounds) -> Vec3 {
    if bounds.is_empty() || !bounds.centre().is_finite() { Vec3::ZERO } else { bounds.centre() }
}

/// The box around shapes, in the coordinates of their file, or each in its own.
fn bounds(shapes: &[&Shape], placed: bool) -> Bounds {
    Bounds::of_all(shapes.iter().map(|shape| {
        let to_world = if placed { shape.to_world } else { Transform::IDENTITY };
        match &shape.kind {
            ShapeKind::Mesh { mesh, .. } => {
                Bounds::of(mesh.positions.iter().map(|p| to_world.point(p.map(f64::from).into())))
            }
            _ => place(shape, &to_world).map_or(Bounds::EMPTY, |placed| placed.bounds()),
        }
    }))
}
