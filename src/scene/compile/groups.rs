//! Groups of shapes, and the instances that show them.

use super::place;
use crate::accel::{Accel, Instance};
use crate::geometry::{Bounds, Transform, Vec3};
use crate::scene::description::{self, Description, Shape, ShapeGroup, ShapeKind};
use crate::scene::traceable::Surface;
use crate::shape::{self, ShapeError};
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

/// The groups that some instance shows. Like the scene, each is moved so that its centre lies at the origin.
pub(super) struct Groups<'a> {
    description: &'a Description,
    groups: Vec<Group<'a>>,
    /// Indices into `groups`, by the address of the description.
    known: BTreeMap<*const ShapeGroup, usize>,
}

struct Group<'a> {
    group: &'a ShapeGroup,
    bounds: Bounds,
    /// Which of the scene's shapes are the group's.
    range: Range<usize>,
}

impl<'a> Groups<'a> {
    pub fn new(description: &'a Description) -> Self {
        let (mut groups, mut known) = (Vec::new(), BTreeMap::new());
        let mut end = description.shapes.len();
        for instance in &description.instances {
            if known.contains_key(&Arc::as_ptr(&instance.group)) {
                continue;
            }
            known.insert(Arc::as_ptr(&instance.group), groups.len());
            let range = end..end + instance.group.shapes.len();
            end = range.end;
            groups.push(Group { group: &instance.group, bounds: bounds(&instance.group.shapes), range });
        }
        Self { description, groups, known }
    }

    fn index(&self, instance: &description::Instance) -> usize {
        self.known[&Arc::as_ptr(&instance.group)]
    }

    /// The box around all shapes and instances, in the file's coordinates.
    pub fn scene_bounds(&self) -> Bounds {
        let instances = self.description.instances.iter().map(|instance| {
            let group = &self.groups[self.index(instance)];
            Bounds::of(group.bounds.corners().map(|corner| instance.to_world.point(corner)))
        });
        bounds(&self.description.shapes).union(Bounds::of_all(instances))
    }

    /// The groups' shapes, as they follow the scene's own, each with what moves its group to the origin.
    pub fn shapes(&self) -> impl Iterator<Item = (&'a Shape, Transform)> + use<'a, '_> {
        self.groups.iter().flat_map(|group| {
            let shift = Transform::translation(-centre(group.bounds));
            group.group.shapes.iter().map(move |shape| (shape, shift))
        })
    }

    /// Whether some group has a surface of a body, which may then lie within another.
    pub fn hold_bodies(&self, surfaces: &[Surface]) -> bool {
        self.groups.iter().any(|group| surfaces[group.range.clone()].iter().any(|s| s.body.is_some()))
    }

    /// The tree of the scene whose shapes, those of groups included, are `shapes`. `shift` moves the scene to the origin.
    ///
    /// # Errors
    /// For each instance, by its index, that its transform makes too thin or too large.
    pub fn accel(
        &self,
        shapes: &[shape::Shape],
        shift: &Transform,
    ) -> Result<Accel, Vec<(usize, ShapeError)>> {
        let trees: Vec<Arc<Accel>> = self
            .groups
            .iter()
            .map(|group| Arc::new(Accel::of_group(&shapes[group.range.clone()], group.range.start as u32)))
            .collect();
        let (mut instances, mut errors) = (Vec::new(), Vec::new());
        for (index, instance) in self.description.instances.iter().enumerate() {
            let group = self.index(instance);
            let back = Transform::translation(centre(self.groups[group].bounds));
            let to_world = back.then(&instance.to_world).then(shift);
            match Instance::new(trees[group].clone(), &to_world) {
                Ok(instance) => instances.push(instance),
                Err(error) => errors.push((index, error)),
            }
        }
        let own = &shapes[..self.description.shapes.len()];
        if errors.is_empty() { Ok(Accel::with_instances(own, instances)) } else { Err(errors) }
    }
}

/// The middle of a box, or the origin where there is none.
pub(super) fn centre(bounds: Bounds) -> Vec3 {
    if bounds.is_empty() || !bounds.centre().is_finite() { Vec3::ZERO } else { bounds.centre() }
}

/// The box around shapes, in the coordinates of their file.
fn bounds(shapes: &[Shape]) -> Bounds {
    Bounds::of_all(shapes.iter().map(|shape| match &shape.kind {
        ShapeKind::Mesh { mesh, .. } => {
            Bounds::of(mesh.positions.iter().map(|p| shape.to_world.point(p.map(f64::from).into())))
        }
        _ => place(shape, &shape.to_world).map_or(Bounds::EMPTY, |placed| placed.bounds()),
    }))
}
