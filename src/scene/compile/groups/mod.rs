//! Groups of shapes, and the instances that show them. A shape that moves is a group of its own, with one
//! instance, and so is a mesh so small beside the scene that vertices in single precision would bend it, and
//! each light that an instance shows.

mod gather;
mod lamps;
#[cfg(test)]
mod tests;

use super::shapes::{self, Facing};
use super::solids::Plan;
use crate::accel::{self, Accel};
use crate::geometry::{Bounds, Motion, Placed, Transform, Vec3};
use crate::scene::description::ShapeDescription;
use crate::scene::source::{Place, SceneError};
use crate::shape;
use crate::shape::solid::{Carried, Leaf, Solid, Tree};
use glam::DMat4;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::rc::Rc;
use std::sync::Arc;

/// The groups that some instance shows, and what moves. Like the scene, each is moved so that its centre lies
/// at the origin.
pub(super) struct Groups<'a> {
    /// What the scene itself holds and shows.
    own: Group<'a>,
    /// Each comes after those that it shows.
    groups: Vec<Group<'a>>,
    shutter: [f64; 2],
    errors: Vec<SceneError>,
}

struct Group<'a> {
    pieces: Vec<Piece<'a>>,
    /// Solids, by the places of their leaves among the pieces.
    solids: Vec<Plan>,
    instances: Vec<Instance<'a>>,
    /// Box around each piece.
    boxes: Vec<Bounds>,
    bounds: Bounds,
    /// Index of the first piece among the scene's shapes.
    start: usize,
}

/// A shape of a group, or of a solid in it.
#[derive(Clone)]
pub(super) struct Piece<'a> {
    pub shape: &'a ShapeDescription,
    /// To the coordinates of the group, or, where it moves within a solid, to those that its motion takes
    /// further.
    pub to_group: Transform,
    /// Whether it is traced as a part of a solid.
    pub part: bool,
    pub facing: Facing,
    /// Keyframes of a part of a solid that moves by itself.
    pub keys: Option<Keys>,
    /// From the coordinates that [`Self::to_group`] leads to, to those that the keyframes carry.
    pub to_keys: Transform,
}

/// What a transform is at some times.
pub(super) type Keys = Vec<(f64, Transform)>;

/// What a thing that moves is placed by before it is carried: for most things nothing; where they
/// [depend on it](shapes::depends_on), the linear part of where they are in the middle of the exposure. So
/// they then are what they would be at rest. To be carried further this has to be undone first.
pub(super) fn placing(keys: &Keys, shutter: [f64; 2], depends: impl Fn(&Transform) -> bool) -> Transform {
    let linear = || {
        let pose = Motion::new(keys).ok()?.at(0.5 * (shutter[0] + shutter[1]));
        Transform::new(DMat4::from_mat3(pose.linear))
    };
    linear().filter(depends).unwrap_or(Transform::IDENTITY)
}

/// A group and where another shows it.
struct Instance<'a> {
    place: &'a Place,
    /// Which of the scene's instances shows it, by its place in the file; `None` for what moves by itself.
    number: Option<usize>,
    group: usize,
    /// Whether its textures lie in the group's coordinates: not where a single thing moves.
    of_group: bool,
    to_world: Transform,
    keys: Option<Keys>,
    /// From the group's coordinates to those that the keyframes carry.
    to_keys: Transform,
}

/// A shape to be traced.
pub(super) struct Traced<'a> {
    pub shape: &'a ShapeDescription,
    /// Transform to the coordinates that it is traced in.
    pub to_traced: Transform,
    /// Whether it is traced as a part of a solid.
    pub part: bool,
    pub facing: Facing,
    /// Where it is carried to from there, if it moves or has coordinates of its own, and shines.
    pub carried: Option<Placed>,
}

/// What one of the instances of the scene, or of a group, shows.
pub(super) struct Shown {
    pub group: usize,
    /// The scene's shapes that it shows, those of groups within it included.
    pub shapes: Rc<[usize]>,
    /// A box around it while the shutter is open, in the coordinates of what shows it.
    pub bounds: Bounds,
    /// By how much at most it stretches lengths.
    pub stretch: f64,
}

/// What the shapes of a group come to, and those of the groups within it.
pub(super) struct Content {
    /// In the order of the scene's shapes.
    pub shapes: Rc<[usize]>,
    /// Around all while the shutter is open, in the group's coordinates.
    pub bounds: Bounds,
    /// The range of the group's own shapes.
    pub own: Range<usize>,
    /// What it shows.
    pub shown: Vec<Shown>,
    /// How far its middle is from the origin of the file's coordinates.
    pub moved: f64,
}

/// Where the shapes of one solid are in the scene's list.
pub(super) struct Assembled {
    pub solid: Arc<Solid>,
    /// Whether it moves as a whole.
    pub moves: bool,
}

impl<'a> Piece<'a> {
    pub fn whole(shape: &'a ShapeDescription, to_group: Transform) -> Self {
        let to_keys = Transform::IDENTITY;
        Self { shape, to_group, part: false, facing: Facing::AsGiven, keys: None, to_keys }
    }

    /// Bounds in the coordinates that [`Self::to_group`] leads to.
    fn bounds(&self) -> Bounds {
        shapes::bounds(self.shape, &self.to_group)
    }

    fn motion(&self) -> Option<Motion> {
        motion(self.keys.as_ref(), &self.to_keys)
    }

    /// Bounds in the coordinates of the group, from one time to another.
    pub fn bounds_during(&self, during: [f64; 2]) -> Bounds {
        let placed = self.bounds();
        self.motion().map_or(placed, |motion| motion.bounds(placed, during))
    }
}

impl<'a> Instance<'a> {
    fn motion(&self) -> Option<Motion> {
        motion(self.keys.as_ref(), &self.to_keys)
    }
}

fn motion(keys: Option<&Keys>, to_keys: &Transform) -> Option<Motion> {
    keys.and_then(|keys| Motion::new(keys).ok()).map(|motion| motion.carrying(to_keys))
}

impl<'a> Group<'a> {
    fn range(&self) -> Range<usize> {
        self.start..self.start + self.pieces.len()
    }

    /// To the coordinates in which it is traced.
    fn to_traced(&self) -> Transform {
        Transform::translation(-centre(self.bounds))
    }
}

/// Hits tell instances apart by a number of 32 bits, one of which means none.
pub(super) const MOST_INSTANCES: u64 = u32::MAX as u64;

impl<'a> Groups<'a> {
    /// What of the file can't be shown.
    pub fn errors(&mut self) -> Vec<SceneError> {
        std::mem::take(&mut self.errors)
    }

    /// The scene and its groups, the latter in their order.
    fn all(&self) -> impl Iterator<Item = &Group<'a>> {
        std::iter::once(&self.own).chain(&self.groups)
    }

    /// Whether anything moves while the shutter is open.
    pub fn move_while_open(&self) -> bool {
        let mut instances = self.all().flat_map(|group| &group.instances);
        self.shutter[0] < self.shutter[1]
            && (instances.any(|instance| instance.keys.is_some())
                || self.own.pieces.iter().any(|piece| piece.keys.is_some()))
    }

    /// The box around all shapes and instances while the shutter is open, in the file's coordinates.
    pub fn scene_bounds(&self) -> Bounds {
        self.own.bounds
    }

    /// How many shapes stand still or are parts of what does: they come first.
    pub fn own(&self) -> usize {
        self.own.pieces.len()
    }

    /// All shapes, first those that stand still. `shift` moves the scene to the origin.
    pub fn shapes(&self, shift: &Transform) -> Vec<Traced<'a>> {
        let traced = |piece: &Piece<'a>, to_traced: Transform, carried: Option<Placed>| Traced {
            shape: piece.shape,
            to_traced,
            part: piece.part,
            facing: piece.facing,
            carried,
        };
        let own = self.own.pieces.iter().map(|piece| match &piece.keys {
            None => traced(piece, piece.to_group.then(shift), None),
            Some(_) => {
                let centre = Transform::translation(-centre(piece.bounds()));
                traced(piece, piece.to_group.then(&centre), part_placed(piece, shift))
            }
        });
        // Only lights ask where a shape is carried to. What holds one is shown by the scene, and once.
        let mut movers: Vec<Option<&Instance<'a>>> = vec![None; self.groups.len()];
        for instance in &self.own.instances {
            movers[instance.group].get_or_insert(instance);
        }
        let grouped = self.groups.iter().zip(movers).flat_map(|(group, mover)| {
            let to_traced = group.to_traced();
            let shines = group.pieces.iter().any(|piece| piece.shape.emission.is_some());
            let placed = mover.filter(|_| shines).and_then(|instance| self.placed(instance, shift));
            let pieces = group.pieces.iter();
            pieces.map(move |piece| traced(piece, piece.to_group.then(&to_traced), placed.clone()))
        });
        own.chain(grouped).collect()
    }

    /// Where an instance stands over time, where `shift` leads from the coordinates of what shows it to those
    /// in which that is traced; `None` where its transform makes it too thin or too large.
    fn placed(&self, instance: &Instance<'a>, shift: &Transform) -> Option<Placed> {
        let centre = centre(self.groups[instance.group].bounds);
        match &instance.keys {
            None => {
                let to_world = Transform::translation(centre).then(&instance.to_world).then(shift);
                Placed::still(&to_world)
            }
            Some(_) => Placed::moving(instance.motion()?.recentred(centre, shift.point(Vec3::ZERO))),
        }
    }

    /// What each group holds. `shapes` are all of the scene's.
    pub fn contents(&self, shapes: &[shape::Shape]) -> Vec<Content> {
        let mut contents: Vec<Content> = Vec::new();
        for group in &self.groups {
            let to_traced = group.to_traced();
            let own = group.range();
            let shown = self.shown_by(group, &contents, &to_traced);
            let of_own = shapes[own.clone()].iter().map(shape::Shape::bounds);
            let bounds = Bounds::of_all(of_own.chain(shown.iter().map(|shown| shown.bounds)));
            let mut all: Vec<usize> = own.clone().collect();
            let within: BTreeSet<usize> = shown.iter().map(|shown| shown.group).collect();
            within.iter().for_each(|&inner| all.extend(&contents[inner].shapes[..]));
            all.sort_unstable();
            all.dedup();
            let moved = to_traced.point(Vec3::ZERO).length();
            contents.push(Content { shapes: all.into(), bounds, own, shown, moved });
        }
        contents
    }

    /// What the scene's instances show. `shift` moves the scene to the origin.
    pub fn shown(&self, contents: &[Content], shift: &Transform) -> Vec<Shown> {
        self.shown_by(&self.own, contents, shift)
    }

    fn shown_by(&self, group: &Group<'a>, contents: &[Content], shift: &Transform) -> Vec<Shown> {
        let shown = |instance: &Instance<'a>| {
            let placed = self.placed(instance, shift)?;
            let content = &contents[instance.group];
            let bounds = match content.bounds.is_empty() {
                true => Bounds::EMPTY,
                false => placed.bounds(content.bounds, self.shutter),
            };
            let (group, shapes) = (instance.group, content.shapes.clone());
            Some(Shown { group, shapes, bounds, stretch: placed.largest_stretch() })
        };
        group.instances.iter().filter_map(shown).collect()
    }

    /// For each instance of the scene which of the file's it is, if it is one.
    pub fn instance_numbers(&self) -> impl Iterator<Item = Option<usize>> {
        self.own.instances.iter().map(|instance| instance.number)
    }

    /// The place of the first instance beyond the most that hits can tell apart, if there are so many.
    pub fn beyond_numbers(&self) -> Option<&'a Place> {
        let mut counts: Vec<u64> = Vec::new();
        let mut beyond = None;
        for group in self.groups.iter().chain([&self.own]) {
            let mut count = 0_u64;
            for instance in &group.instances {
                count = count.saturating_add(counts[instance.group].saturating_add(1));
                if count >= MOST_INSTANCES && beyond.is_none() {
                    beyond = Some(instance.place);
                }
            }
            counts.push(count);
        }
        beyond
    }

    /// How many parts of solids move by themselves: their instances come first.
    pub fn moving_parts(&self) -> usize {
        self.own.pieces.iter().filter(|piece| piece.keys.is_some()).count()
    }

    /// Whether one of the scene's own shapes is a part of a solid that moves by itself.
    pub fn moves(&self, shape: usize) -> bool {
        self.own.pieces[shape].keys.is_some()
    }

    /// For each solid the range of the scene's shapes that are its parts.
    pub fn solids(&self) -> Vec<Vec<usize>> {
        self.all()
            .flat_map(|group| {
                let in_scene =
                    |plan: &Plan| plan.leaves().into_iter().map(|leaf| group.start + leaf).collect();
                group.solids.iter().map(in_scene).collect::<Vec<_>>()
            })
            .collect()
    }

    /// The tree of the scene whose shapes, those of groups included, are `shapes`, and the solids in the
    /// order of [`Self::solids`]. `shift` moves the scene to the origin.
    ///
    /// # Errors
    /// The places of instances whose transforms make them too thin or too large.
    pub fn accel(
        &self,
        shapes: &[shape::Shape],
        shift: &Transform,
    ) -> Result<(Accel, Vec<Assembled>), Vec<&'a Place>> {
        let (mut instances, mut errors, mut assembled) = (Vec::new(), Vec::new(), Vec::new());
        let mut carried = BTreeMap::new();
        for (index, piece) in self.own.pieces.iter().enumerate().filter(|(_, piece)| piece.keys.is_some()) {
            match part_placed(piece, shift) {
                Some(placed) => {
                    let instance = instances.len() as u32;
                    instances.push(accel::Instance::of_part(shapes[index].bounds(), placed.clone()));
                    carried.insert(index, Carried { placed, instance });
                }
                None => errors.push(&piece.shape.place),
            }
        }
        let mut assemble = |group: &Group<'a>, carried: &BTreeMap<usize, Carried>, moves: bool| {
            let solids: Vec<Arc<Solid>> = group
                .solids
                .iter()
                .map(|plan| {
                    let leaf = |piece: usize| {
                        let index = group.start + piece;
                        let carried = carried.get(&index).cloned();
                        Tree::Leaf(Leaf { shape: shapes[index].clone(), index: index as u32, carried })
                    };
                    Arc::new(Solid::new(plan.tree(&leaf), self.shutter))
                })
                .collect();
            assembled.extend(solids.iter().map(|solid| Assembled { solid: solid.clone(), moves }));
            solids
        };
        let own_solids = assemble(&self.own, &carried, false);
        let none = BTreeMap::new();
        let mut trees: Vec<Arc<Accel>> = Vec::new();
        for group in &self.groups {
            let solids = assemble(group, &none, true);
            let shown = self.place_all(group, &trees, &group.to_traced(), shift, &mut errors);
            let own = &shapes[group.range()];
            let tree = Accel::of_group_with_instances(own, group.start as u32, &solids, shown, self.shutter);
            trees.push(Arc::new(tree));
        }
        instances.extend(self.place_all(&self.own, &trees, shift, shift, &mut errors));
        if !errors.is_empty() {
            return Err(errors);
        }
        let own = &shapes[self.own.range()];
        Ok((Accel::with_instances(own, &own_solids, instances, self.shutter), assembled))
    }

    /// What a group shows, where `to_traced` leads to the coordinates in which the group is traced, and
    /// `shift` to those of the scene.
    fn place_all(
        &self,
        group: &Group<'a>,
        trees: &[Arc<Accel>],
        to_traced: &Transform,
        shift: &Transform,
        errors: &mut Vec<&'a Place>,
    ) -> Vec<accel::Instance> {
        let mut placed_all = Vec::new();
        for instance in &group.instances {
            let Some(placed) = self.placed(instance, to_traced) else {
                errors.push(instance.place);
                continue;
            };
            let shown = accel::Instance::new(trees[instance.group].clone(), placed);
            if shown.bounds(self.shutter).reach() > shape::FARTHEST {
                errors.push(instance.place);
                continue;
            }
            let centre = centre(self.groups[instance.group].bounds);
            let nested = !std::ptr::eq(group, &self.own);
            placed_all.push(match instance.of_group {
                true => shown.resting(&Transform::translation(centre).then(shift)),
                // A thing that moves in a group rests where the group would have it in the scene.
                false if nested => {
                    let to_keys = Transform::translation(centre).then(&instance.to_keys);
                    shown.resting(&to_keys.then(&instance.to_world).then(shift))
                }
                false => shown,
            });
        }
        placed_all
    }
}

/// Where a part of a solid that moves by itself is carried to.
fn part_placed(piece: &Piece<'_>, shift: &Transform) -> Option<Placed> {
    let motion = piece.motion()?.recentred(centre(piece.bounds()), shift.point(Vec3::ZERO));
    Placed::moving(motion)
}

/// The middle of a box, or the origin where there is none.
pub(super) fn centre(bounds: Bounds) -> Vec3 {
    if bounds.is_empty() || !bounds.centre().is_finite() { Vec3::ZERO } else { bounds.centre() }
}
