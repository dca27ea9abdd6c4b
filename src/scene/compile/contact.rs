//! Which shapes may have faces in common, and whether bodies may overlap, going by planes that part them.

use super::groups::Groups;
use crate::geometry::{Bounds, Transform, Vec3};
use crate::medium::{Body, Refraction};
use crate::scene::coincident::{Contact, Contacts, Partner};
use crate::scene::scene::Surface;
use crate::shape::Shape;
use std::ops::Range;

/// Something that stands by itself: one of the scene's own shapes, or all that an instance shows.
struct Item {
    shapes: Range<usize>,
    partner: Partner,
    /// How far its surfaces may be from where they are met.
    error: f64,
    /// Whether it holds a closed body, and whether it holds any surface that encloses something.
    has_closed: bool,
    has_body: bool,
}

/// What the shapes of a scene may do to one another.
pub(super) struct Nearness {
    /// None where nothing touches a closed transparent body.
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

const EVERYWHERE: Bounds = Bounds { min: Vec3::NEG_INFINITY, max: Vec3::INFINITY };

pub(super) fn nearness(
    groups: &Groups<'_>,
    shift: &Transform,
    shapes: &[Shape],
    surfaces: &[Surface],
    bodies: &[Body],
) -> Nearness {
    let is_body = |shape: usize| surfaces[shape].body.is_some();
    let is_closed = |shape: usize| surfaces[shape].body.is_some_and(|body| bodies[body as usize].closed);
    if !(0..shapes.len()).any(is_body) {
        return Nearness::none();
    }
    let moved = shift.point(Vec3::ZERO).length();
    let rounding: Vec<f64> = shapes.iter().map(|shape| shape.placement_error(moved)).collect();
    let errors: Vec<f64> = shapes.iter().map(Shape::typical_error).collect();
    let own = (0..groups.own()).map(|i| Item {
        shapes: i..i + 1,
        partner: match groups.moves(i) {
            true => Partner::new(EVERYWHERE, errors[i], rounding[i]),
            false => Partner::new(shapes[i].bounds(), errors[i], rounding[i]),
        },
        error: errors[i] + rounding[i],
        has_closed: is_closed(i),
        has_body: is_body(i),
    });
    let instances = groups.placed_boxes(shapes, shift).into_iter().map(|(shapes_of, bounds, stretch)| {
        let largest = |of: &dyn Fn(usize) -> f64| shapes_of.clone().map(of).fold(0.0, f64::max);
        let error = stretch * largest(&|i| errors[i]);
        let placed = 64.0 * f64::EPSILON * (bounds.min.abs().max(bounds.max.abs()).length() + moved);
        let rounding = stretch * largest(&|i| rounding[i]) + placed;
        Item {
            has_closed: shapes_of.clone().any(is_closed),
            has_body: shapes_of.clone().any(is_body),
            partner: Partner::new(bounds, error, rounding),
            error: error + rounding,
            shapes: shapes_of,
        }
    });
    let items: Vec<Item> = own.chain(instances).filter(|item| !item.partner.bounds.is_empty()).collect();
    // The scene's own shape that an item is, where it stands still.
    let single = |item: &Item| {
        let shape = item.shapes.start;
        (item.shapes.len() == 1 && shape < groups.own() && !groups.moves(shape)).then(|| &shapes[shape])
    };
    let own_body = |item: &Item| match item.shapes.start < groups.own() {
        true => surfaces[item.shapes.start].body,
        false => None,
    };
    let mut found: Vec<Vec<Partner>> = vec![Vec::new(); shapes.len()];
    let mut near = Nearness::none();
    // Where one box holds the other, the bodies most often lie within one another, the inner one entered last
    // from everywhere.
    let cross = |a: Bounds, b: Bounds| !a.contains(b) && !b.contains(a);
    let unordered = |a: usize, b: usize| {
        let [Some(a), Some(b)] = [a, b].map(|shape| surfaces[shape].body.map(|body| &bodies[body as usize]))
        else {
            return false;
        };
        let accounts = [a, b].iter().any(|body| body.refraction == Refraction::Surroundings);
        accounts && a.priority == b.priority && a.index_class != b.index_class
    };
    for (a, b) in touching(&items) {
        let (a, b) = (&items[a], &items[b]);
        // Parts of one solid have nothing between them.
        if own_body(a).is_some() && own_body(a) == own_body(b) {
            continue;
        }
        let reach = a.partner.reach + b.partner.reach;
        let gap = match (single(a), single(b)) {
            (Some(one), Some(other)) => one.gap(other),
            // These boxes are wider by the reach.
            _ => a.partner.bounds.gap(b.partner.bounds) + reach,
        };
        // Each axis of a box is as much wider.
        if gap > 2.0 * reach {
            continue;
        }
        let bodies = a.has_body && b.has_body;
        near.adjoin |= bodies;
        if bodies && gap < -(a.error + b.error) {
            near.overlap = true;
            if cross(a.partner.bounds, b.partner.bounds) {
                for i in a.shapes.clone() {
                    let others = b.shapes.clone().filter(|&j| unordered(i, j));
                    near.one_way.extend(others.flat_map(|j| [i, j]));
                }
            }
        }
        if !(a.has_closed || b.has_closed) {
            continue;
        }
        for (one, other) in [(a, b), (b, a)] {
            // A group's shapes don't lie where the instance shows them.
            let is_own = one.shapes.len() == 1 && one.shapes.start < groups.own();
            let bounds = if is_own { other.partner.bounds } else { EVERYWHERE };
            one.shapes.clone().for_each(|shape| found[shape].push(Partner { bounds, ..other.partner }));
        }
    }
    for item in items.iter().filter(|item| item.has_body && item.shapes.len() > 1) {
        // Shapes of one group may touch one another.
        if item.has_closed {
            item.shapes.clone().for_each(|shape| {
                found[shape].push(Partner { bounds: EVERYWHERE, ..item.partner });
            });
        }
        let of_group: Vec<usize> = item.shapes.clone().filter(|&i| is_body(i)).collect();
        for (later, &i) in of_group.iter().enumerate() {
            for &j in of_group[..later].iter().filter(|&&j| surfaces[i].body != surfaces[j].body) {
                let gap = shapes[i].gap(&shapes[j]);
                near.adjoin = true;
                if gap < -(errors[i] + rounding[i] + errors[j] + rounding[j]) {
                    near.overlap = true;
                    if unordered(i, j) && cross(shapes[i].bounds(), shapes[j].bounds()) {
                        near.one_way.extend([i, j]);
                    }
                }
            }
        }
    }
    if found.iter().all(Vec::is_empty) {
        return near;
    }
    for (partners, rounding) in found.into_iter().zip(rounding) {
        let (first, count) = (near.contacts.partners.len() as u32, partners.len() as u32);
        near.contacts.of.push(Contact { rounding, first, count });
        near.contacts.partners.extend(partners);
    }
    near
}

/// Around each transparent body, or each instance of a group that holds some.
pub(super) fn body_boxes<'a>(
    groups: &'a Groups<'_>,
    shift: &'a Transform,
    shapes: &'a [Shape],
    surfaces: &'a [Surface],
    bodies: &'a [Body],
) -> impl Iterator<Item = Bounds> + 'a {
    let is_body = |shape: usize| surfaces[shape].body.is_some_and(|body| bodies[body as usize].closed);
    let bounds = |i: usize| if groups.moves(i) { EVERYWHERE } else { shapes[i].bounds() };
    let own = (0..groups.own()).filter(move |&i| is_body(i)).map(bounds);
    let instances = groups.placed_boxes(shapes, shift).into_iter();
    own.chain(instances.filter(move |(range, ..)| range.clone().any(is_body)).map(|(_, bounds, _)| bounds))
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
