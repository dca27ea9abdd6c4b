//! Lights in groups (an extension). Each place where instances show one is a light of its own, with a shape
//! of its own: light samples choose between places, and a hit says by its shape which of them was met.

use super::{Keys, placing};
use crate::geometry::Transform;
use crate::scene::compile::shapes;
use crate::scene::description::{Description, Instance, ShapeDescription, ShapeGroup};
use crate::scene::source::{Place, SceneError};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A shape that shines where a chain of instances shows it.
pub(super) struct Lamp<'a> {
    pub shape: &'a ShapeDescription,
    /// Which of the scene's instances shows it.
    pub number: usize,
    /// What the shape is placed by, in coordinates of its own.
    pub to_group: Transform,
    /// From there to the world, or from the coordinates of the keyframes to where they are at first.
    pub to_world: Transform,
    pub keys: Option<Keys>,
    /// From the coordinates that [`Self::to_group`] leads to, to those that the keyframes carry.
    pub to_keys: Transform,
}

/// The most lights that instances may show: each of them has memory of its own.
const MOST_LAMPS: usize = 1_000_000;

/// All that instances of the scene show, and what can't be one.
pub(super) fn of(description: &Description) -> (Vec<Lamp<'_>>, Vec<SceneError>) {
    let shutter = description.sensor.shutter.during();
    let (found, errors) = (Vec::new(), Vec::new());
    let mut search = Search { shining: BTreeMap::new(), found, errors, number: 0, shutter };
    for (number, instance) in description.instances.iter().enumerate() {
        search.number = number;
        if search.shines(&instance.group) {
            search.follow(instance, &Above { to_keys: Transform::IDENTITY, keys: None });
        }
    }
    (search.found, search.errors)
}

struct Search<'a> {
    /// Whether groups hold a light, or show one.
    shining: BTreeMap<*const ShapeGroup, bool>,
    found: Vec<Lamp<'a>>,
    errors: Vec<SceneError>,
    /// The scene's instance that is followed.
    number: usize,
    shutter: [f64; 2],
}

/// What stands above a group.
struct Above {
    /// From the group's coordinates to those of the keyframes, or to the world where there are none.
    to_keys: Transform,
    keys: Option<Keys>,
}

impl<'a> Search<'a> {
    fn shines(&mut self, group: &Arc<ShapeGroup>) -> bool {
        if let Some(known) = self.shining.get(&Arc::as_ptr(group)) {
            return *known;
        }
        let own = group.shapes.iter().any(|shape| shape.emission.is_some());
        let shines = own || group.instances.iter().any(|inner| self.shines(&inner.group));
        self.shining.insert(Arc::as_ptr(group), shines);
        shines
    }

    fn follow(&mut self, instance: &'a Instance, above: &Above) {
        let motion = instance.motion.as_ref().map(|motion| (&motion.place, &motion.keys));
        let Some(above) = self.below(above, &instance.to_world, motion) else { return };
        for shape in instance.group.shapes.iter().filter(|shape| shape.emission.is_some()) {
            if self.found.len() == MOST_LAMPS {
                // One error says it, and ends the search.
                if self.errors.is_empty() {
                    let problem = format!("Instances show more than {MOST_LAMPS} lights");
                    let expected =
                        "fewer lights in groups: each place where one is shown is a light of its own";
                    let error = SceneError::at(&shape.place, problem, expected);
                    self.errors.push(error.with_remedy("let a larger surface shine for many small ones"));
                }
                return;
            }
            let lamp = match &shape.motion {
                None => Some(self.lamp(shape, &shape.to_world, &above)),
                Some(motion) => {
                    let depends = |transform: &Transform| shapes::depends_on(shape, transform);
                    let placed = placing(&motion.keys, self.shutter, depends);
                    self.below(&above, &shape.to_world, Some((&motion.place, &motion.keys))).map(|above| {
                        let above = Above { to_keys: placed.inverse(), ..above };
                        self.lamp(shape, &placed, &above)
                    })
                }
            };
            self.found.extend(lamp);
        }
        for inner in &instance.group.instances {
            if self.found.len() < MOST_LAMPS && self.errors.len() < 10 && self.shines(&inner.group) {
                self.follow(inner, &above);
            }
        }
    }

    /// A shape that `to_group` takes to the coordinates of what is below `above`.
    fn lamp(&self, shape: &'a ShapeDescription, to_group: &Transform, above: &Above) -> Lamp<'a> {
        let (number, to_keys) = (self.number, Transform::IDENTITY);
        let Some(keys) = above.keys.clone() else {
            return Lamp { shape, number, to_group: *to_group, to_world: above.to_keys, keys: None, to_keys };
        };
        // Where it makes no difference, the shape is placed at once.
        let (to_group, to_keys) = match shapes::depends_on(shape, &above.to_keys) {
            true => (*to_group, above.to_keys),
            false => (to_group.then(&above.to_keys), to_keys),
        };
        let to_world = keys.first().map_or(Transform::IDENTITY, |(_, first)| *first);
        Lamp { shape, number, to_group, to_world, keys: Some(keys), to_keys }
    }

    /// What is above a group that stands, or moves, in what is above now.
    ///
    /// To turn, move and scale all of a motion alike leaves the way between its keyframes what it is; to
    /// stretch it does not, and two motions one upon the other are none by keyframes.
    fn below(
        &mut self,
        above: &Above,
        to_world: &Transform,
        motion: Option<(&Place, &Keys)>,
    ) -> Option<Above> {
        let Some((place, keys)) = motion else {
            return Some(Above { to_keys: to_world.then(&above.to_keys), keys: above.keys.clone() });
        };
        let (problem, remedy) = if above.keys.is_some() {
            ("A light that moves within an instance that moves", "let either the one or the other move")
        } else if above.to_keys.uniform_scale().is_none() {
            let remedy = "scale the instance alike in all directions";
            ("A light that moves within an instance that is stretched", remedy)
        } else {
            let keys = keys.iter().map(|(time, key)| (*time, key.then(&above.to_keys))).collect();
            return Some(Above { to_keys: Transform::IDENTITY, keys: Some(keys) });
        };
        let error = SceneError::at(place, problem, "one motion of a light, and no stretch around it");
        self.errors.push(error.with_remedy(remedy));
        None
    }
}
