//! By which numbers images tell the shapes of a scene apart.

use super::groups::Groups;
use crate::geometry::Transform;
use crate::scene::description::{Description, ShapeDescription};
use crate::scene::scene::ShapeNumbers;
use std::collections::BTreeMap;

/// From 1 in the order in which the scene is told: shapes, solids, instances.
pub(super) fn of(description: &Description, groups: &Groups<'_>) -> ShapeNumbers {
    let (shapes, solids) = (description.shapes.len() as u32, description.solids.len() as u32);
    let mut known: BTreeMap<*const ShapeDescription, u32> = BTreeMap::new();
    for (shape, number) in description.shapes.iter().zip(1..) {
        known.insert(shape, number);
    }
    for (solid, number) in description.solids.iter().zip(shapes + 1..) {
        for leaf in solid.leaves() {
            known.entry(leaf).or_insert(number);
        }
    }
    let traced = groups.shapes(&Transform::IDENTITY);
    let of_surface = |shape: &ShapeDescription| known.get(&std::ptr::from_ref(shape)).copied().unwrap_or(0);
    // What else is an instance is a thing that moves, and has a number of its own.
    let first = shapes + solids + 1;
    let instances = groups.instance_numbers().map(|number| number.map_or(0, |number| first + number as u32));
    ShapeNumbers {
        surfaces: traced.iter().map(|traced| of_surface(traced.shape)).collect(),
        instances: std::iter::repeat_n(0, groups.moving_parts()).chain(instances).collect(),
    }
}
