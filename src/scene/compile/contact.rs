//! Which shapes may have faces in common, going by their boxes.

use super::groups::Groups;
use crate::geometry::{Bounds, Transform, Vec3};
use crate::medium::Body;
use crate::scene::meeting::{Contact, Contacts, Partner};
use crate::scene::traceable::Surface;
use crate::shape::Shape;
use std::ops::Range;

/// Something that stands by itself: one of the scene's own shapes, or all that an instance shows.
struct Item {
    shapes: Range<usize>,
    partner: Partner,
    has_body: bool,
}

const EVERYWHERE: Bounds = Bounds { min: Vec3::NEG_INFINITY, max: Vec3::INFINITY };

/// None where nothing touches a transparent body.
pub(super) fn contacts(
    groups: &Groups<'_>,
    shift: &Transform,
    shapes: &[Shape],
    surfaces: &[Surface],
    bodies: &[Body],
) -> Contacts {
    let is_body = |shape: usize| surfaces[shape].body.is_some_and(|body| bodies[body as usize].closed);
    if !(0..shapes.len()).any(is_body) {
        return Contacts::default();
    }
    let moved = shift.point(Vec3::ZERO).length();
    let rounding: Vec<f64> = shapes.iter().map(|shape| shape.placement_error(moved)).collect();
    let own = (0..groups.own()).map(|i| Item {
        shapes: i..i + 1,
        partner: match groups.moves(i) {
            true => Partner::new(EVERYWHERE, shapes[i].typical_error(), rounding[i]),
            false => Partner::of(&shapes[i], rounding[i]),
        },
        has_body: is_body(i),
    });
    let instances = groups.placed_boxes(shapes, shift).into_iter().map(|(shapes_of, bounds, stretch)| {
        let largest = |of: &dyn Fn(usize) -> f64| shapes_of.clone().map(of).fold(0.0, f64::max);
        let error = largest(&|i| shapes[i].typical_error());
        let placed = 64.0 * f64::EPSILON * (bounds.min.abs().max(bounds.max.abs()).length() + moved);
        Item {
            has_body: shapes_of.clone().any(is_body),
            partner: Partner::new(bounds, stretch * error, stretch * largest(&|i| rounding[i]) + placed),
            shapes: shapes_of,
        }
    });
    let items: Vec<Item> = own.chain(instances).filter(|item| !item.partner.bounds.is_empty()).collect();
    let mut found: Vec<Vec<Partner>> = vec![Vec::new(); shapes.len()];
    let own_body = |item: &Item| match item.shapes.start < groups.own() {
        true => surfaces[item.shapes.start].body,
        false => None,
    };
    for (a, b) in touching(&items) {
        // Parts of one solid have nothing between them.
        if own_body(&items[a]).is_some() && own_body(&items[a]) == own_body(&items[b]) {
            continue;
        }
        for (one, other) in [(&items[a], &items[b]), (&items[b], &items[a])] {
            let single = one.shapes.len() == 1 && one.shapes.start < groups.own();
            // A group's shapes don't lie where the instance shows them.
            let bounds = if single { other.partner.bounds } else { EVERYWHERE };
            one.shapes.clone().for_each(|shape| found[shape].push(Partner { bounds, ..other.partner }));
        }
    }
    // Shapes of one group may touch one another.
    for item in items.iter().filter(|item| item.has_body && item.shapes.len() > 1) {
        item.shapes.clone().for_each(|shape| {
            found[shape].push(Partner { bounds: EVERYWHERE, ..item.partner });
        });
    }
    if found.iter().all(Vec::is_empty) {
        return Contacts::default();
    }
    let mut contacts = Contacts::default();
    for (partners, rounding) in found.into_iter().zip(rounding) {
        let (first, count) = (contacts.partners.len() as u32, partners.len() as u32);
        contacts.of.push(Contact { rounding, first, count });
        contacts.partners.extend(partners);
    }
    contacts
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

/// Pairs of items with boxes that share a point, one of each with a body in it: by a sweep along x.
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
