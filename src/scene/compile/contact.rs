//! Which shapes may have faces in common, and whether bodies may overlap, going by planes that part them.

use super::groups::{Assembled, Content, Groups, Shown};
use crate::accel::Accel;
use crate::geometry::{Bounds, Ray, Transform, Vec3};
use crate::medium::{Body, Refraction};
use crate::sampling::quadrature::midpoints;
use crate::scene::coincident::{Contact, Contacts, Partner};
use crate::scene::scene::{Role, Surface};
use crate::shape::solid::Solid;
use crate::shape::{NO_INSTANCE, Shape};
use rayon::prelude::*;
use std::rc::Rc;

/// Something that stands by itself: a shape of the scene or of a group, or all that an instance shows.
struct Item {
    shapes: Shapes,
    partner: Partner,
    /// How far its surfaces may be from where they are met, and from where the file puts them.
    error: f64,
    rounding: f64,
    /// Whether it holds a closed body, and whether it holds any surface that encloses something.
    has_closed: bool,
    has_body: bool,
    /// Whether it shows more than one surface, or one more than once.
    several: bool,
}

enum Shapes {
    One(usize),
    All(Rc<[usize]>),
}

impl Shapes {
    fn list(&self) -> &[usize] {
        match self {
            Self::One(shape) => std::slice::from_ref(shape),
            Self::All(shapes) => shapes,
        }
    }
}

/// What is known of shapes by themselves.
struct Known<'a> {
    shapes: &'a [Shape],
    /// Boxes around what is left of them.
    boxes: &'a [Bounds],
    /// The solids that they are parts of.
    solids: &'a [Option<&'a Solid>],
    surfaces: &'a [Surface],
    bodies: &'a [Body],
    /// Typical errors and placement errors.
    errors: Vec<f64>,
    rounding: Vec<f64>,
}

/// The largest errors within a group, in its coordinates, and whether it shows more than one surface.
#[derive(Clone, Copy)]
struct Errors {
    error: f64,
    rounding: f64,
    several: bool,
}

impl Known<'_> {
    fn is_body(&self, shape: usize) -> bool {
        self.surfaces[shape].body.is_some()
    }

    fn is_closed(&self, shape: usize) -> bool {
        self.surfaces[shape].body.is_some_and(|body| self.bodies[body as usize].closed)
    }

    /// What a shape of the scene is to those that it touches, within a box.
    fn partner(&self, shape: usize, bounds: Bounds) -> Partner {
        Partner::new(bounds, self.errors[shape], self.rounding[shape])
    }

    /// Pairs of the scene's own shapes at rest of which [`Self::coincide_with`] tells, each in both orders.
    fn coinciding(&self, groups: &Groups<'_>, accel: &Accel) -> Vec<(usize, usize)> {
        let own = (0..groups.own()).into_par_iter().filter(|&shape| {
            let alone = self.surfaces[shape].role == Role::Other && self.solids[shape].is_none();
            alone && !groups.moves(shape)
        });
        let found = own.flat_map_iter(|shape| {
            self.coincide_with(shape, accel)
                .into_iter()
                .flat_map(move |other| [(shape, other), (other, shape)])
        });
        let mut pairs: Vec<(usize, usize)> = found.collect();
        pairs.sort_unstable();
        pairs.dedup();
        pairs
    }

    /// The shapes that have faces in the same place as a shape that is no body, where it matters which of the
    /// two is met: one is a lamp, or they are sheets that lie back to back. Found at some of its points.
    fn coincide_with(&self, shape: usize, accel: &Accel) -> Vec<usize> {
        const ROOT: usize = 4;
        let emits = |shape: usize| self.surfaces[shape].light.is_some();
        let is_sheet = |shape: usize| self.shapes[shape].is_closed().is_err();
        let reach = |shape: usize| self.partner(shape, self.boxes[shape]).reach;
        let mut found = Vec::new();
        for sample in midpoints(ROOT).filter_map(|u| self.shapes[shape].sample(u)) {
            let point = sample.surface.point;
            let before = 64.0 * reach(shape);
            let ray = Ray::new(point.position - point.normal * before, point.normal);
            accel.crossings(&ray, 0.0, [0.0, 2.0 * before], &mut |hit, _| {
                let other = hit.shape as usize;
                if hit.instance != NO_INSTANCE
                    || self.surfaces[other].role != Role::Other
                    || self.solids[other].is_some()
                    || (hit.t - before).abs() > reach(shape) + reach(other)
                    || found.contains(&other)
                {
                    return;
                }
                let cosine = accel.surface(self.shapes, &hit, &ray, 0.0).point.normal.dot(point.normal);
                let matters = if cosine < -0.9 {
                    let sheets = shape == other || is_sheet(shape) && is_sheet(other);
                    sheets || emits(shape) || emits(other)
                } else {
                    cosine > 0.9 && emits(shape) != emits(other)
                };
                if matters {
                    found.push(other);
                }
            });
        }
        found
    }

    fn single(&self, shape: usize, bounds: Bounds) -> Item {
        Item {
            shapes: Shapes::One(shape),
            partner: self.partner(shape, bounds),
            error: self.errors[shape] + self.rounding[shape],
            rounding: self.rounding[shape],
            has_closed: self.is_closed(shape),
            has_body: self.is_body(shape),
            several: false,
        }
    }

    /// What an instance shows, in coordinates whose origin has been moved so far.
    fn shown(&self, shown: &Shown, within: &[Errors], moved: f64) -> Item {
        let Errors { error, rounding, several } = within[shown.group];
        let error = shown.stretch * error;
        let bounds = shown.bounds;
        let placed = 64.0 * f64::EPSILON * (bounds.min.abs().max(bounds.max.abs()).length() + moved);
        let rounding = shown.stretch * rounding + placed;
        let any = |of: &dyn Fn(usize) -> bool| shown.shapes.iter().any(|&shape| of(shape));
        Item {
            has_closed: any(&|shape| self.is_closed(shape)),
            has_body: any(&|shape| self.is_body(shape)),
            partner: Partner::new(bounds, error, rounding),
            error: error + rounding,
            rounding,
            shapes: Shapes::All(shown.shapes.clone()),
            several,
        }
    }

    /// For each group, in whose order those within it come first.
    fn errors_within(&self, contents: &[Content]) -> Vec<Errors> {
        let mut within: Vec<Errors> = Vec::new();
        for content in contents {
            let largest = |of: &[f64]| of[content.own.clone()].iter().copied().fold(0.0, f64::max);
            let (mut error, mut rounding) = (largest(&self.errors), largest(&self.rounding));
            for shown in content.shown.iter().filter(|shown| !shown.bounds.is_empty()) {
                let item = self.shown(shown, &within, content.moved);
                let inner = shown.stretch * within[shown.group].error;
                error = error.max(inner);
                rounding = rounding.max(item.error - inner);
            }
            let inner = content.shown.iter().map(|shown| 1 + usize::from(within[shown.group].several));
            let several = content.own.len() + inner.sum::<usize>() > 1;
            within.push(Errors { error, rounding, several });
        }
        within
    }

    /// [`Shape::gap`] of what is left of two shapes.
    fn gap(&self, a: usize, b: usize) -> f64 {
        let of_solids = self.solids[a].zip(self.solids[b]).map_or(f64::NEG_INFINITY, |(a, b)| a.gap(b));
        self.shapes[a].gap(&self.shapes[b]).max(self.boxes[a].gap(self.boxes[b])).max(of_solids)
    }

    /// Whether nothing but the direction of the light says which of two bodies counts.
    fn unordered(&self, a: usize, b: usize) -> bool {
        let body = |shape: usize| self.surfaces[shape].body.map(|body| &self.bodies[body as usize]);
        let (Some(a), Some(b)) = (body(a), body(b)) else { return false };
        let accounts = [a, b].iter().any(|body| body.refraction == Refraction::Surroundings);
        let differ = accounts && a.index_class != b.index_class || a.interior != b.interior;
        a.priority == b.priority && differ
    }

    /// Whether the surfaces of two shapes in the same coordinates may cross. Those of parts of solids are
    /// taken for whole.
    fn cross(&self, a: usize, b: usize) -> bool {
        if !nested(self.boxes[a], self.boxes[b]) {
            return true;
        }
        // What is open has no inside that it could lie in.
        [a, b].iter().all(|&shape| self.is_closed(shape)) && self.shapes[a].crosses(&self.shapes[b])
    }
}

fn nested(a: Bounds, b: Bounds) -> bool {
    a.contains(b) || b.contains(a)
}

/// What the shapes of a scene may do to one another.
pub(super) struct Nearness {
    /// None where nothing touches a closed transparent body, and no lamps or sheets coincide.
    pub contacts: Contacts,
    /// Whether a ray may get from one body right into another.
    pub adjoin: bool,
    /// Whether it may be within two at once, by more than what bodies that touch have in common by rounding.
    pub overlap: bool,
    /// Shapes whose surfaces may cross those of others with nothing but the direction of the light to say
    /// which body counts. Light that goes the other way then sees another scene.
    pub one_way: Vec<usize>,
}

impl Nearness {
    fn none() -> Self {
        Self { contacts: Contacts::default(), adjoin: false, overlap: false, one_way: Vec::new() }
    }
}

pub(super) const EVERYWHERE: Bounds = Bounds { min: Vec3::NEG_INFINITY, max: Vec3::INFINITY };

/// Boxes around what is left of shapes, by those of the solids that some are parts of: of a large ball that
/// grinds a lens it is a small piece.
pub(super) fn boxes(shapes: &[Shape], solids: &[Option<&Solid>]) -> Vec<Bounds> {
    let left = |(shape, solid): (&Shape, &Option<&Solid>)| {
        let bounds = shape.bounds();
        solid.map_or(bounds, |solid| bounds.common(solid.bounds()))
    };
    shapes.iter().zip(solids).map(left).collect()
}

/// The solid of each shape that is a part of one.
pub(super) fn solids_of<'a>(
    groups: &Groups<'_>,
    shapes: &[Shape],
    assembled: &'a [Assembled],
) -> Vec<Option<&'a Solid>> {
    let mut of = vec![None; shapes.len()];
    for (Assembled { solid, .. }, parts) in assembled.iter().zip(groups.solids()) {
        parts.into_iter().for_each(|part| of[part] = Some(&**solid));
    }
    of
}

/// `boxes`: those of [`boxes`]; `solids`: those of [`solids_of`].
#[expect(clippy::too_many_arguments, reason = "all that was made of the shapes so far")]
pub(super) fn nearness(
    groups: &Groups<'_>,
    shift: &Transform,
    shapes: &[Shape],
    boxes: &[Bounds],
    solids: &[Option<&Solid>],
    surfaces: &[Surface],
    bodies: &[Body],
    accel: &Accel,
) -> Nearness {
    let moved = shift.point(Vec3::ZERO).length();
    let known = Known {
        shapes,
        boxes,
        solids,
        surfaces,
        bodies,
        errors: shapes.iter().map(Shape::typical_error).collect(),
        rounding: shapes.iter().map(|shape| shape.placement_error(moved)).collect(),
    };
    let coinciding = known.coinciding(groups, accel);
    if coinciding.is_empty() && !(0..shapes.len()).any(|shape| known.is_body(shape)) {
        return Nearness::none();
    }
    let contents = groups.contents(shapes);
    let within = known.errors_within(&contents);
    let own = (0..groups.own()).map(|i| {
        let bounds = if groups.moves(i) { EVERYWHERE } else { boxes[i] };
        known.single(i, bounds)
    });
    let shown = groups.shown(&contents, shift);
    let instances = shown.iter().map(|shown| known.shown(shown, &within, moved));
    let items: Vec<Item> = own.chain(instances).filter(|item| !item.partner.bounds.is_empty()).collect();
    // The scene's own shape that an item is.
    let single = |item: &Item| match item.shapes {
        Shapes::One(shape) => Some(shape),
        Shapes::All(_) => None,
    };
    let own_body = |item: &Item| single(item).and_then(|shape| surfaces[shape].body);
    let still = |item: &Item| single(item).filter(|&shape| !groups.moves(shape));
    let mut found: Vec<Vec<Partner>> = vec![Vec::new(); shapes.len()];
    let mut near = Nearness::none();
    for (a, b) in touching(&items) {
        let (a, b) = (&items[a], &items[b]);
        // Parts of one solid have nothing between them.
        if own_body(a).is_some() && own_body(a) == own_body(b) {
            continue;
        }
        let shapes = still(a).zip(still(b));
        if !near.meet(&known, a, b, shapes) || !(a.has_closed || b.has_closed) {
            continue;
        }
        for (one, other) in [(a, b), (b, a)] {
            // A group's shapes don't lie where the instance shows them.
            let bounds = if single(one).is_some() { other.partner.bounds } else { EVERYWHERE };
            let shape = single(one).and(still(other)).map(|shape| shape as u32);
            let partner = Partner { bounds, shape, ..other.partner };
            one.shapes.list().iter().for_each(|&shape| found[shape].push(partner));
        }
    }
    for (one, other) in coinciding {
        let partner = known.partner(other, boxes[other]);
        found[one].push(Partner { shape: Some(other as u32), ..partner });
    }
    for item in items.iter().filter(|item| item.has_closed && item.several) {
        // Surfaces of one group may touch one another.
        let partner = Partner { bounds: EVERYWHERE, ..item.partner };
        item.shapes.list().iter().for_each(|&shape| found[shape].push(partner));
    }
    for content in &contents {
        near.within_group(&known, content, &within);
    }
    if found.iter().all(Vec::is_empty) {
        return near;
    }
    // What a group shows is rounded as the instances are, which make it larger or smaller.
    let mut all_rounding = vec![0.0; shapes.len()];
    for item in &items {
        for &shape in item.shapes.list() {
            all_rounding[shape] = item.rounding.max(all_rounding[shape]);
        }
    }
    for (partners, rounding) in found.into_iter().zip(all_rounding) {
        let (first, count) = (near.contacts.partners.len() as u32, partners.len() as u32);
        near.contacts.of.push(Contact { rounding, first, count });
        near.contacts.partners.extend(partners);
    }
    near
}

impl Nearness {
    /// Takes note of two things, and returns whether they may touch. `shapes`: the two, where they are known
    /// to stand by themselves.
    fn meet(&mut self, known: &Known<'_>, a: &Item, b: &Item, shapes: Option<(usize, usize)>) -> bool {
        let reach = a.partner.reach + b.partner.reach;
        let gap = match shapes {
            Some((one, other)) => known.gap(one, other),
            // These boxes are wider by the reach.
            _ => a.partner.bounds.gap(b.partner.bounds) + reach,
        };
        // Each axis of a box is as much wider.
        if gap > 2.0 * reach {
            return false;
        }
        let bodies = a.has_body && b.has_body;
        self.adjoin |= bodies;
        if bodies && gap < -(a.error + b.error) {
            self.overlap = true;
            let cross = !nested(a.partner.bounds, b.partner.bounds);
            for &i in a.shapes.list() {
                let others = b.shapes.list().iter().filter(|&&j| known.unordered(i, j));
                let others = others.filter(|&&j| shapes.map_or(cross, |_| known.cross(i, j)));
                self.one_way.extend(others.flat_map(|&j| [i, j]));
            }
        }
        // No plane parts what lies within something else.
        shapes.is_none_or(|(one, other)| known.shapes[one].clearance(&known.shapes[other]) <= 2.0 * reach)
    }

    /// Likewise of what a group holds.
    fn within_group(&mut self, known: &Known<'_>, content: &Content, within: &[Errors]) {
        let Known { boxes, surfaces, errors, rounding, .. } = known;
        let of_group: Vec<usize> = content.own.clone().filter(|&i| known.is_body(i)).collect();
        for (later, &i) in of_group.iter().enumerate() {
            for &j in of_group[..later].iter().filter(|&&j| surfaces[i].body != surfaces[j].body) {
                let gap = known.gap(i, j);
                self.adjoin = true;
                if gap < -(errors[i] + rounding[i] + errors[j] + rounding[j]) {
                    self.overlap = true;
                    if known.unordered(i, j) && known.cross(i, j) {
                        self.one_way.extend([i, j]);
                    }
                }
            }
        }
        if content.shown.is_empty() {
            return;
        }
        let own = content.own.clone().map(|i| known.single(i, boxes[i]));
        let shown = content.shown.iter().map(|shown| known.shown(shown, within, content.moved));
        let items: Vec<Item> = own.chain(shown).filter(|item| !item.partner.bounds.is_empty()).collect();
        for (a, b) in touching(&items) {
            let (a, b) = (&items[a], &items[b]);
            // Pairs of the group's own shapes are done.
            if matches!((&a.shapes, &b.shapes), (Shapes::One(_), Shapes::One(_))) {
                continue;
            }
            self.meet(known, a, b, None);
        }
    }
}

/// Around each transparent body, or each instance of a group that holds some.
pub(super) fn body_boxes<'a>(
    groups: &'a Groups<'_>,
    shift: &'a Transform,
    shapes: &'a [Shape],
    boxes: &'a [Bounds],
    surfaces: &'a [Surface],
    bodies: &'a [Body],
) -> impl Iterator<Item = Bounds> + 'a {
    let is_body = |shape: usize| surfaces[shape].body.is_some_and(|body| bodies[body as usize].closed);
    boxes_of(groups, shift, shapes, boxes, is_body)
}

/// Around each shape of some, or each instance of a group that holds one.
pub(super) fn boxes_of<'a>(
    groups: &'a Groups<'_>,
    shift: &'a Transform,
    shapes: &'a [Shape],
    boxes: &'a [Bounds],
    is_meant: impl Fn(usize) -> bool + Copy + 'a,
) -> impl Iterator<Item = Bounds> + 'a {
    let bounds = |i: usize| if groups.moves(i) { EVERYWHERE } else { boxes[i] };
    let own = (0..groups.own()).filter(move |&i| is_meant(i)).map(bounds);
    let shown = groups.shown(&groups.contents(shapes), shift).into_iter();
    let shown = shown.filter(move |shown| shown.shapes.iter().any(|&shape| is_meant(shape)));
    own.chain(shown.map(|shown| shown.bounds))
}

/// Pairs of items with boxes that share a point, one of each with a surface in it that encloses something: by
/// a sweep along x.
fn touching(items: &[Item]) -> Vec<(usize, usize)> {
    let mut order: Vec<usize> = (0..items.len()).collect();
    let bounds = |i: usize| items[i].partner.bounds;
    order.sort_by(|&a, &b| bounds(a).min.x.total_cmp(&bounds(b).min.x));
    let (mut pairs, mut bodies, mut others) = (Vec::new(), Vec::<usize>::new(), Vec::<usize>::new());
    for i in order {
        for open in [&mut bodies, &mut others] {
            open.retain(|&j| bounds(j).max.x >= bounds(i).min.x);
        }
        let candidates = bodies.iter().chain(others.iter().filter(|_| items[i].has_body));
        pairs.extend(candidates.filter(|&&j| bounds(i).overlaps(bounds(j))).map(|&j| (i, j)));
        if items[i].has_body { &mut bodies } else { &mut others }.push(i);
    }
    pairs
}
