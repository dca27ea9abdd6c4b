//! Groups of shapes, and the instances that show them. A shape that moves is a group of its own, with one
//! instance, and so is a mesh so small beside the scene that vertices in single precision would bend it.

use super::shapes;
use super::solids::{self, Plan};
use crate::accel::{self, Accel};
use crate::geometry::{Bounds, Motion, Placed, Transform, Vec3};
use crate::scene::description::{self, Animation, Description, ShapeDescription, ShapeGroup};
use crate::scene::source::Place;
use crate::shape;
use crate::shape::solid::{Carried, Leaf, Solid, Tree};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::sync::Arc;

/// The groups that some instance shows, and what moves. Like the scene, each is moved so that its centre lies
/// at the origin.
pub(super) struct Groups<'a> {
    /// What stands still.
    own: Group<'a>,
    groups: Vec<Group<'a>>,
    instances: Vec<Instance<'a>>,
    shutter: [f64; 2],
}

struct Group<'a> {
    pieces: Vec<Piece<'a>>,
    /// Solids, by the places of their leaves among the pieces.
    solids: Vec<Plan>,
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
    /// Whether it is a part of a solid, and, then, whether it is cut away.
    pub part: bool,
    pub subtracted: bool,
    /// Keyframes of a part of a solid that moves by itself.
    pub keys: Option<Keys>,
}

/// What a transform is at some times.
pub(super) type Keys = Vec<(f64, Transform)>;

/// A group and where it stands.
struct Instance<'a> {
    place: &'a Place,
    group: usize,
    /// Whether its textures lie in the group's coordinates: not where a single thing moves.
    of_group: bool,
    to_world: Transform,
    keys: Option<Keys>,
}

/// A shape to be traced.
pub(super) struct Traced<'a> {
    pub shape: &'a ShapeDescription,
    /// Transform to the coordinates that it is traced in.
    pub to_traced: Transform,
    pub flip_normals: bool,
    /// Whether it is a part of a solid.
    pub part: bool,
    /// Where it is carried to from there, if it moves or has coordinates of its own, and shines.
    pub carried: Option<Placed>,
}

/// Where the shapes of one solid are in the scene's list.
pub(super) struct Assembled {
    pub solid: Arc<Solid>,
    /// Whether it moves as a whole.
    pub moves: bool,
}

impl<'a> Piece<'a> {
    pub fn whole(shape: &'a ShapeDescription, to_group: Transform) -> Self {
        Self { shape, to_group, part: false, subtracted: false, keys: None }
    }

    /// Bounds in the coordinates that [`Self::to_group`] leads to.
    fn bounds(&self) -> Bounds {
        shapes::bounds(self.shape, &self.to_group)
    }

    fn motion(&self) -> Option<Motion> {
        self.keys.as_deref().and_then(|keys| Motion::new(keys).ok())
    }
}

impl<'a> Group<'a> {
    fn new(pieces: Vec<Piece<'a>>, solids: Vec<Plan>, shutter: [f64; 2]) -> Self {
        let boxes: Vec<Bounds> = pieces
            .iter()
            .map(|piece| match piece.motion() {
                None => piece.bounds(),
                Some(motion) => motion.bounds(piece.bounds(), shutter),
            })
            .collect();
        let shapes = pieces.iter().zip(&boxes).filter(|(piece, _)| !piece.part).map(|(_, bounds)| *bounds);
        let bounds = Bounds::of_all(shapes.chain(solids.iter().map(|plan| plan.bounds(&boxes))));
        Self { pieces, solids, boxes, bounds, start: 0 }
    }

    fn range(&self) -> Range<usize> {
        self.start..self.start + self.pieces.len()
    }
}

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
        let (moving, still): (Vec<&ShapeDescription>, Vec<&ShapeDescription>) =
            description.shapes.iter().partition(|shape| shape.motion.is_some());
        let mut own = solids::Flat::default();
        let (apart, still): (Vec<&ShapeDescription>, Vec<&ShapeDescription>) =
            still.into_iter().partition(|shape| is_apart(shape));
        own.pieces.extend(still.into_iter().map(|shape| Piece::whole(shape, shape.to_world)));
        let mut all = Self {
            own: Group::new(Vec::new(), Vec::new(), shutter),
            groups: Vec::new(),
            instances: Vec::new(),
            shutter,
        };
        let mut known: BTreeMap<*const ShapeGroup, usize> = BTreeMap::new();
        for description::Instance { place, group, to_world, motion, .. } in &description.instances {
            let group = *known.entry(Arc::as_ptr(group)).or_insert_with(|| {
                let mut flat = solids::Flat::default();
                flat.pieces.extend(group.shapes.iter().map(|shape| Piece::whole(shape, shape.to_world)));
                group.solids.iter().for_each(|solid| flat.add(solid));
                all.group(flat)
            });
            all.show(place, group, true, to_world, motion.as_deref());
        }
        for shape in moving {
            let mut flat = solids::Flat::default();
            flat.pieces.push(Piece::whole(shape, Transform::IDENTITY));
            let group = all.group(flat);
            all.show(&shape.place, group, false, &shape.to_world, shape.motion.as_deref());
        }
        for shape in apart {
            let mut flat = solids::Flat::default();
            flat.pieces.push(Piece::whole(shape, shape.to_world));
            let group = all.group(flat);
            all.show(&shape.place, group, true, &Transform::IDENTITY, None);
        }
        for solid in &description.solids {
            if solid.motion.is_none() {
                own.add(solid);
                continue;
            }
            let mut flat = solids::Flat::default();
            flat.add(solid);
            let group = all.group(flat);
            all.show(&solid.place, group, false, &solid.to_world, solid.motion.as_deref());
        }
        // Parts that move of unions that are nothing but their parts.
        for (mut piece, keys) in std::mem::take(&mut own.moving) {
            piece.part = false;
            let (place, to_world) = (&piece.shape.place, piece.shape.to_world);
            let group = all.group(solids::Flat { pieces: vec![piece], ..solids::Flat::default() });
            all.instances.push(Instance { place, group, of_group: false, to_world, keys: Some(keys) });
        }
        all.own = Group::new(own.pieces, own.solids, shutter);
        let mut start = all.own.pieces.len();
        for group in &mut all.groups {
            group.start = start;
            start += group.pieces.len();
        }
        all
    }

    /// The index of a new group.
    fn group(&mut self, flat: solids::Flat<'a>) -> usize {
        self.groups.push(Group::new(flat.pieces, flat.solids, self.shutter));
        self.groups.len() - 1
    }

    fn show(
        &mut self,
        place: &'a Place,
        group: usize,
        of_group: bool,
        to_world: &Transform,
        motion: Option<&Animation>,
    ) {
        let keys = motion.map(|motion| motion.keys.clone());
        self.instances.push(Instance { place, group, of_group, to_world: *to_world, keys });
    }

    /// Whether anything moves while the shutter is open.
    pub fn move_while_open(&self) -> bool {
        self.shutter[0] < self.shutter[1]
            && (self.instances.iter().any(|instance| instance.keys.is_some())
                || self.own.pieces.iter().any(|piece| piece.keys.is_some()))
    }

    /// The box around all shapes and instances while the shutter is open, in the file's coordinates.
    pub fn scene_bounds(&self) -> Bounds {
        let instances = self.instances.iter().map(|instance| {
            let group = self.groups[instance.group].bounds;
            match instance.keys.as_deref().and_then(|keys| Motion::new(keys).ok()) {
                None => Bounds::of(group.corners().map(|corner| instance.to_world.point(corner))),
                Some(motion) => motion.bounds(group, self.shutter),
            }
        });
        self.own.bounds.union(Bounds::of_all(instances))
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
            flip_normals: piece.shape.flip_normals != piece.subtracted,
            part: piece.part,
            carried,
        };
        let own = self.own.pieces.iter().map(|piece| match &piece.keys {
            None => traced(piece, piece.to_group.then(shift), None),
            Some(_) => {
                let centre = Transform::translation(-centre(piece.bounds()));
                traced(piece, piece.to_group.then(&centre), part_placed(piece, shift))
            }
        });
        let grouped = self.groups.iter().enumerate().flat_map(|(index, group)| {
            let centre = Transform::translation(-centre(group.bounds));
            let mover = self.instances.iter().find(|instance| instance.group == index);
            // Only lights ask where a shape is carried to; the groups of the file hold none.
            let shines = group.pieces.iter().any(|piece| piece.shape.emission.is_some());
            let placed = mover.filter(|_| shines).and_then(|instance| self.placed(instance, shift));
            group.pieces.iter().map(move |piece| traced(piece, piece.to_group.then(&centre), placed.clone()))
        });
        own.chain(grouped).collect()
    }

    /// Where an instance stands over time; `None` where its transform makes it too thin or too large.
    fn placed(&self, instance: &Instance<'a>, shift: &Transform) -> Option<Placed> {
        let centre = centre(self.groups[instance.group].bounds);
        match &instance.keys {
            None => {
                let to_world = Transform::translation(centre).then(&instance.to_world).then(shift);
                Placed::still(&to_world)
            }
            Some(keys) => {
                let motion = Motion::new(keys).ok()?.recentred(centre, shift.point(Vec3::ZERO));
                Placed::moving(motion)
            }
        }
    }

    /// For each instance its group's range of all shapes, the box around it while the shutter is open, and by
    /// how much at most it stretches lengths. `shift` moves the scene to the origin.
    pub fn placed_boxes(
        &self,
        shapes: &[shape::Shape],
        shift: &Transform,
    ) -> Vec<(Range<usize>, Bounds, f64)> {
        let placed = |instance: &Instance<'a>| {
            let placed = self.placed(instance, shift)?;
            let range = self.groups[instance.group].range();
            let group = Bounds::of_all(shapes[range.clone()].iter().map(shape::Shape::bounds));
            Some((range, placed.bounds(group, self.shutter), placed.largest_stretch()))
        };
        self.instances.iter().filter_map(placed).collect()
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
        let all = std::iter::once(&self.own).chain(&self.groups);
        all.flat_map(|group| {
            let in_scene = |plan: &Plan| plan.leaves().into_iter().map(|leaf| group.start + leaf).collect();
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
        let trees: Vec<Arc<Accel>> = self
            .groups
            .iter()
            .map(|group| {
                let solids = assemble(group, &none, true);
                Arc::new(Accel::of_group(&shapes[group.range()], group.start as u32, &solids))
            })
            .collect();
        for instance in &self.instances {
            match self.placed(instance, shift) {
                Some(placed) => {
                    let shown = accel::Instance::new(trees[instance.group].clone(), placed);
                    let centre = centre(self.groups[instance.group].bounds);
                    instances.push(match instance.of_group {
                        true => shown.resting(&Transform::translation(centre).then(shift)),
                        false => shown,
                    });
                }
                None => errors.push(instance.place),
            }
        }
        if !errors.is_empty() {
            return Err(errors);
        }
        let own = &shapes[self.own.range()];
        Ok((Accel::with_instances(own, &own_solids, instances, self.shutter), assembled))
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
