//! Solids of a description, taken apart into their leaves.

use super::groups::{Keys, Piece, placing};
use super::shapes::{self, Facing};
use crate::geometry::{Bounds, Transform};
use crate::scene::description::{Part, ShapeDescription, Solid};
use crate::shape::solid::{Operation, Tree};

/// How a solid is made of pieces, by their places in a list.
pub(super) enum Plan {
    Leaf(usize),
    Node(Operation, Vec<Plan>),
}

/// What a group's shapes and solids come to.
#[derive(Default)]
pub(super) struct Flat<'a> {
    pub pieces: Vec<Piece<'a>>,
    pub solids: Vec<Plan>,
    /// Shapes that are no part of anything and move, with their motion.
    pub moving: Vec<(Piece<'a>, Keys)>,
    /// A box around where rays begin, as far as that is known in the coordinates of the group.
    pub eyes: Option<Bounds>,
}

/// What stands above a part within its solid.
#[derive(Clone)]
struct Above {
    /// From the coordinates of the node to those of the group, or to those that a motion takes further.
    to_group: Transform,
    keys: Option<Keys>,
    subtracted: bool,
    shutter: [f64; 2],
}

impl Plan {
    /// A box around it, given those of the pieces.
    pub fn bounds(&self, boxes: &[Bounds]) -> Bounds {
        let (operation, parts) = match self {
            Self::Leaf(piece) => return boxes[*piece],
            Self::Node(operation, parts) => (operation, parts),
        };
        let mut bounds = parts.iter().map(|part| part.bounds(boxes));
        let first = bounds.next().unwrap_or(Bounds::EMPTY);
        match operation {
            Operation::Union => bounds.fold(first, Bounds::union),
            Operation::Intersection => bounds.fold(first, Bounds::common),
            Operation::Difference => first,
        }
    }

    /// The places of its leaves, in order.
    pub fn leaves(&self) -> Vec<usize> {
        match self {
            Self::Leaf(piece) => vec![*piece],
            Self::Node(_, parts) => parts.iter().flat_map(Self::leaves).collect(),
        }
    }

    pub fn tree(&self, leaf: &impl Fn(usize) -> Tree) -> Tree {
        match self {
            Self::Leaf(piece) => leaf(*piece),
            Self::Node(operation, parts) => {
                Tree::Node(*operation, parts.iter().map(|part| part.tree(leaf)).collect())
            }
        }
    }
}

impl<'a> Flat<'a> {
    /// Adds a solid that `to_group` places. Its own motion, if it has one, is that of the group.
    pub fn add(&mut self, solid: &'a Solid, to_group: Transform, shutter: [f64; 2]) {
        let above = Above { to_group, keys: None, subtracted: false, shutter };
        self.split(solid, &above);
    }

    /// A union whose inside cannot be seen is compiled as its parts, and costs no more than these.
    ///
    /// That is exact for all light that begins outside: what lies within another part is hidden by it. Where
    /// two faces coincide that look the same way, either may be met, as with any shapes; light samples would
    /// find both, if they shine.
    fn split(&mut self, solid: &'a Solid, above: &Above) {
        let leaves = solid.leaves();
        if solid.operation != Operation::Union
            || leaves.iter().any(|leaf| leaf.bsdf.kind.transmits())
            || leaves.iter().filter(|leaf| leaf.emission.is_some()).count() > 1
            || self.may_begin_in(solid, above)
        {
            let plan = self.plan(solid, above);
            self.solids.push(plan);
            return;
        }
        for part in &solid.parts {
            match part {
                Part::Solid(inner) => {
                    let above = above.with(inner);
                    // What moves together here is several shapes there, so it is left together.
                    if above.keys.is_some() {
                        let plan = self.plan(inner, &above);
                        self.solids.push(plan);
                    } else {
                        self.split(inner, &above);
                    }
                }
                Part::Shape(shape) => {
                    let piece = Piece { part: false, ..above.piece(shape) };
                    match piece.keys.clone() {
                        Some(keys) => self.moving.push((Piece { keys: None, ..piece }, keys)),
                        None => self.pieces.push(piece),
                    }
                }
            }
        }
    }

    /// Whether rays may begin within one of the parts, from where the inner faces of others can be seen.
    fn may_begin_in(&self, solid: &'a Solid, above: &Above) -> bool {
        let Some(eyes) = self.eyes else { return false };
        let mut parts = Flat::default();
        parts.plan(solid, above);
        parts.pieces.iter().any(|piece| piece.bounds_during(above.shutter).gap(eyes) <= 0.0)
    }

    fn plan(&mut self, solid: &'a Solid, above: &Above) -> Plan {
        let mut parts = Vec::new();
        for (number, part) in solid.parts.iter().enumerate() {
            let cuts = solid.operation == Operation::Difference && number > 0;
            let above = Above { subtracted: above.subtracted != cuts, ..above.clone() };
            parts.push(match part {
                Part::Solid(inner) => self.plan(inner, &above.with(inner)),
                Part::Shape(shape) => {
                    self.pieces.push(above.piece(shape));
                    Plan::Leaf(self.pieces.len() - 1)
                }
            });
        }
        Plan::Node(solid.operation, parts)
    }
}

impl Above {
    fn with(&self, solid: &Solid) -> Self {
        let keys = solid.motion.as_ref().map(|motion| &motion.keys);
        let (to_group, keys) = self.placed(&solid.to_world, keys);
        Self { to_group, keys, ..*self }
    }

    fn piece<'a>(&self, shape: &'a ShapeDescription) -> Piece<'a> {
        let keys = shape.motion.as_ref().map(|motion| &motion.keys);
        let (to_group, keys) = self.placed(&shape.to_world, keys);
        let depends = |transform: &Transform| shapes::depends_on(shape, transform);
        let placed = keys.as_ref().map_or(Transform::IDENTITY, |keys| placing(keys, self.shutter, depends));
        let (to_group, to_keys) = (to_group.then(&placed), placed.inverse());
        let facing = if self.subtracted { Facing::Inward } else { Facing::Outward };
        Piece { shape, to_group, part: true, facing, keys, to_keys }
    }

    /// What is above does not move where something below does. To turn, move and scale all of a motion alike
    /// leaves the way between its keyframes what it is.
    fn placed(&self, to_world: &Transform, keys: Option<&Keys>) -> (Transform, Option<Keys>) {
        match keys {
            None => (to_world.then(&self.to_group), self.keys.clone()),
            Some(keys) => {
                let keys = keys.iter().map(|(time, to_world)| (*time, to_world.then(&self.to_group)));
                (Transform::IDENTITY, Some(keys.collect()))
            }
        }
    }
}
