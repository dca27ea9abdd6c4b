//! Coincident surfaces, which a ray crosses in one interface event, and hidden surfaces, which it passes.
//!
//! **Precedence.** Where transparent bodies overlap, only the one of highest priority counts, and among equal
//! ones the one that the ray entered last (see [`MediumStack`]). A ray that enters or leaves a body beneath
//! one that counts more passes that surface by null transmission. Bodies whose file states both of their
//! indices stand by themselves and take no part in this (see [`Refraction`]).
//!
//! **Contact.** Where bodies share a face, the distances along a ray do not tell the order of their surfaces:
//! they are known only up to error bounds. All crossings that may coincide by these bounds form one interface
//! event: the ray leaves all bodies that it leaves there and enters all that it enters, and the interface is
//! that between the body that counts before and the one that counts after. A surface that scatters, such as
//! the table under a glass, is in optical contact: the ray meets it from within the body. Lengths are
//! compared with error bounds alone.
//!
//! **Back to back.** Two sheets in the same place are a way to give a surface two sides, such as a lamp that
//! shines to both. A ray meets the one that faces it, and of a lamp and a wall the lamp.
//!
//! After such an event the ray starts within its error of the place, so it may meet again, or never meet, a
//! surface that has been handled. The bodies that it is inside of decide which: right where it starts, it
//! cannot enter a closed body from within nor leave one from without.

use super::intersection::Intersection;
use super::scene::{Role, Scene};
use crate::geometry::{Bounds, Ray, SurfacePoint, Vec3};
use crate::medium::{Entered, Media, MediumStack, Refraction, refracting};
use crate::shape::{Hit, NO_INSTANCE};
use smallvec::{SmallVec, smallvec};
use std::cmp::Reverse;

/// Which shapes may have faces in common with others, where at least one of the two is the surface of a
/// transparent body, or one is a lamp, or both are sheets that lie back to back.
#[derive(Clone, Debug, Default)]
pub(super) struct Contacts {
    /// Contact of each shape; empty where nothing touches.
    pub of: Vec<Contact>,
    pub partners: Vec<Partner>,
}

#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Contact {
    /// How far the surface may lie from where its file puts it.
    pub rounding: f64,
    /// Its range of partners.
    pub first: u32,
    pub count: u32,
}

/// Something that a shape touches.
#[derive(Clone, Copy, Debug)]
pub(super) struct Partner {
    /// Box around the shape and all its errors.
    pub bounds: Bounds,
    /// How far from a surface it has to be looked for.
    pub reach: f64,
    /// The scene's shape that it is, if it stands where its file puts it.
    pub shape: Option<u32>,
}

/// One of several surfaces that coincide.
struct CoincidentSurface {
    hit: Hit,
    enters: bool,
    /// Whether it may lie where the ray begins.
    at_start: bool,
    /// Whether crossing it changes what the ray is inside of. True for a surface that bounds no body.
    effective: bool,
}

/// Leads a ray past surfaces that it passes, or has crossed already.
#[derive(Default)]
pub(super) struct Onward {
    /// What was met last, and whether from its front.
    last: Option<(Hit, bool)>,
    /// How often in a row.
    times: u32,
}

impl Onward {
    /// So often a ray may meet a surface from the same side before its steps grow.
    const OFTEN: u32 = 4;

    /// The rest of a ray beyond a hit. A ray that has met a surface comes to its other side next. Where it
    /// meets the same side again and again, as that of a body thinner than the rounding of distances, steps
    /// grow by powers of two: no surface holds a ray for ever.
    pub fn rest(&mut self, hit: &Intersection, ray: &Ray) -> Ray {
        let rest = hit.point.rest_of(ray);
        let same =
            |(last, from_front): &(Hit, bool)| last.is_on_part_of(&hit.hit) && *from_front == hit.from_front;
        self.times = if self.last.as_ref().is_some_and(same) { self.times + 1 } else { 0 };
        self.last = Some((hit.hit, hit.from_front));
        let Some(doublings) = self.times.checked_sub(Self::OFTEN) else { return rest };
        let step = hit.point.error * f64::from(doublings).exp2();
        let origin = rest.origin + rest.direction * step;
        Ray { origin, t_max: (rest.t_max - step).max(0.0), ..rest }
    }
}

/// What happens to a ray at coincident surfaces.
pub(super) enum InterfaceEvent {
    /// It interacts with the surface that the intersection now is.
    Surface,
    /// It passes straight on through surfaces that change nothing but the media.
    NullTransmission,
    /// It has crossed these surfaces already.
    Handled,
}

impl Scene {
    /// The event at a hit where surfaces can be hidden or in contact. Sets the media beyond it.
    pub(super) fn interface_event(
        &self,
        ray: &Ray,
        time: f64,
        hit: &mut Intersection,
        media: &mut Media,
    ) -> InterfaceEvent {
        let mut coincident = self.coincident_surfaces(ray, time, hit);
        media.beyond.clone_from(&media.here);
        let crossed = self.cross_bodies(&mut coincident, media);
        hit.coincident = crossed > 1;
        if let [own] = &coincident[..] {
            let passes = || self.features.precedence && (self.hidden(own, media) || self.is_seam(own, media));
            return match own.effective {
                true if passes() => InterfaceEvent::NullTransmission,
                true => InterfaceEvent::Surface,
                false => InterfaceEvent::Handled,
            };
        }
        let chosen = match self.scatterer(&coincident, media).or_else(|| self.interface(&coincident, media)) {
            Some(chosen) => chosen,
            None if coincident.iter().any(|surface| surface.effective) => {
                return InterfaceEvent::NullTransmission;
            }
            None => return InterfaceEvent::Handled,
        };
        if chosen != hit.hit {
            let coincident = hit.coincident;
            *hit = self.intersection(&chosen, ray, time);
            hit.coincident = coincident;
        }
        InterfaceEvent::Surface
    }

    /// The surfaces that may coincide with a hit, itself included.
    fn coincident_surfaces(
        &self,
        ray: &Ray,
        time: f64,
        hit: &Intersection,
    ) -> SmallVec<[CoincidentSurface; 4]> {
        let enters = |point: &SurfacePoint| ray.direction.dot(point.normal) < 0.0;
        let mut found: SmallVec<[CoincidentSurface; 4]> = smallvec![CoincidentSurface {
            hit: hit.hit,
            enters: enters(&hit.point),
            at_start: false,
            effective: true
        }];
        let near = self.partners_near(hit.hit.shape, &hit.point);
        let Some(reach) = near.map(|partner| partner.reach).reduce(f64::max) else { return found };
        let slope = |point: &SurfacePoint| ray.direction.dot(point.normal).abs();
        // A surface seen from afar is met with errors in proportion to the distance.
        let height = |shape: u32, t: f64, point: &SurfacePoint| {
            point.error + self.contacts.of[shape as usize].rounding + 16.0 * f64::EPSILON * t
        };
        let error = |shape: u32, t: f64, point: &SurfacePoint| height(shape, t, point) / slope(point);
        // What the ray has left is one of the partners.
        let at_start =
            |shape: u32, t: f64, point: &SurfacePoint| t * slope(point) <= height(shape, t, point) + reach;
        found[0].at_start = at_start(hit.hit.shape, hit.hit.t, &hit.point);
        let own = error(hit.hit.shape, hit.hit.t, &hit.point);
        let slope = slope(&hit.point);
        let far = own + (reach + 16.0 * f64::EPSILON * hit.hit.t) / slope;
        let range = [hit.hit.t - far, hit.hit.t + far];
        self.crossings(ray, time, range, &mut |other, t_error| {
            let point = self.accel.surface(&self.shapes, &other, ray, time).point;
            let enters = enters(&point);
            if other.is_on_part_of(&hit.hit) && enters == found[0].enters {
                return;
            }
            let t_error = error(other.shape, other.t, &point).max(t_error.unwrap_or(0.0));
            if (other.t - hit.hit.t).abs() <= own + t_error {
                let at_start = at_start(other.shape, other.t, &point);
                found.push(CoincidentSurface { hit: other, enters, at_start, effective: true });
            }
        });
        // The later body in the file counts where a ray enters bodies of equal priority at once.
        found.sort_by_key(|surface| (surface.hit.shape, surface.hit.instance));
        found
    }

    /// Whether a surface may coincide with another one at a point.
    pub(super) fn may_touch(&self, shape: u32, point: &SurfacePoint) -> bool {
        self.partners_near(shape, point).next().is_some()
    }

    /// What a shape touches near one of its points.
    fn partners_near(&self, shape: u32, point: &SurfacePoint) -> impl Iterator<Item = &Partner> {
        let contact = self.contacts.of.get(shape as usize).copied().unwrap_or_default();
        let (place, margin) = (point.position, point.error + contact.rounding);
        let here = Bounds { min: place - Vec3::splat(margin), max: place + Vec3::splat(margin) };
        // Rounding of a distance from a shape.
        let margin = margin + 64.0 * f64::EPSILON * place.abs().max_element();
        let distance = move |shape: u32| self.shapes[shape as usize].distance_from(place);
        let partners = &self.contacts.partners[contact.first as usize..][..contact.count as usize];
        partners.iter().filter(move |partner| {
            partner.bounds.overlaps(here)
                && partner.shape.is_none_or(|shape| distance(shape) <= margin + partner.reach)
        })
    }

    /// Leaves and enters, from here to beyond, all bodies whose surfaces coincide, and returns how many.
    /// Marks surfaces that cannot be where the hits report them as without effect.
    fn cross_bodies(&self, coincident: &mut [CoincidentSurface], media: &mut Media) -> u32 {
        let Media { here, beyond } = media;
        let bodies: SmallVec<[Option<Entered>; 4]> =
            coincident.iter().map(|surface| self.body_of(&surface.hit)).collect();
        let mut crossed = 0;
        for leaving in [true, false] {
            for i in 0..coincident.len() {
                let Some(body) = bodies[i] else { continue };
                let ways = |enters: bool| {
                    coincident
                        .iter()
                        .zip(&bodies)
                        .any(|(surface, other)| *other == Some(body) && surface.enters == enters)
                };
                let inside = match coincident[i].enters {
                    true => here.contains(body),
                    false => here.left_with(body, &self.bodies).is_some(),
                };
                let closed = self.bodies[body.body as usize].closed;
                let again = closed && coincident[i].at_start && inside == coincident[i].enters;
                // Between entering and leaving at once the ray only touches.
                let touches = ways(true) && ways(false);
                if touches || again {
                    coincident[i].effective = false;
                } else if leaving != coincident[i].enters && !bodies[..i].contains(&Some(body)) {
                    crossed += 1;
                    match leaving {
                        true => beyond.leave(body, &self.bodies),
                        false => beyond.enter(body, &self.bodies),
                    }
                }
            }
        }
        crossed
    }

    /// The first surface that is more than a boundary of bodies. Lights come before others, and what faces
    /// the ray before what is seen from its back: in most models the back is black.
    fn scatterer(&self, coincident: &[CoincidentSurface], media: &Media) -> Option<Hit> {
        let scatters = |surface: &&CoincidentSurface| {
            surface.effective
                && self.role(surface) == Role::Other
                && !(self.features.precedence && self.hidden(surface, media))
        };
        let order = |a: &&CoincidentSurface, b: &&CoincidentSurface| {
            let sides = |surface: &CoincidentSurface| (!self.shines(surface), !surface.enters);
            let by_place = a.hit.t.total_cmp(&b.hit.t).then(a.hit.shape.cmp(&b.hit.shape));
            sides(a).cmp(&sides(b)).then(by_place)
        };
        coincident.iter().filter(scatters).min_by(order).map(|surface| surface.hit)
    }

    fn shines(&self, surface: &CoincidentSurface) -> bool {
        surface.enters && self.surfaces[surface.hit.shape as usize].light.is_some()
    }

    /// The surface at which the index changes, or else one of no index that can be seen.
    fn interface(&self, coincident: &[CoincidentSurface], media: &Media) -> Option<Hit> {
        let effective = || coincident.iter().filter(|surface| surface.effective);
        let (above, sides) = media.here.parted(&media.beyond);
        let [before, after] = sides.map(|side| refracting(side, &self.bodies));
        let class =
            |body: Option<Entered>| body.map_or(0, |body| self.bodies[body.body as usize].index_class);
        if !self.covers(above) && before != after && class(before) != class(after) {
            let counts = effective().filter(|surface| {
                let body = self.body_of(&surface.hit);
                let own = match surface.enters {
                    true => body,
                    false => body.and_then(|body| media.here.left_with(body, &self.bodies).or(Some(body))),
                };
                self.role(surface) == Role::Interface && (own == before || own == after)
            });
            let rank = |surface: &&CoincidentSurface| {
                let priority =
                    self.body_of(&surface.hit).map(|body| self.bodies[body.body as usize].priority);
                (priority, Reverse(surface.hit.shape))
            };
            return counts.max_by_key(rank).map(|surface| surface.hit);
        }
        effective()
            .find(|surface| self.role(surface) == Role::Null && !self.hidden(surface, media))
            .map(|surface| surface.hit)
    }

    /// Whether a body's surface is passed beneath a body that counts more. A light is never hidden.
    fn hidden(&self, surface: &CoincidentSurface, media: &Media) -> bool {
        if self.surfaces[surface.hit.shape as usize].light.is_some() {
            return false;
        }
        let Some(body) = self.body_of(&surface.hit) else { return false };
        let above = if surface.enters { &media.beyond } else { &media.here }.above(body, &self.bodies);
        match self.bodies[body.body as usize].refraction {
            Refraction::None => !above.is_empty(),
            Refraction::Surroundings | Refraction::Stated => self.covers(above),
        }
    }

    /// Whether what bodies are made of hides all that is beneath them.
    fn covers(&self, above: &[Entered]) -> bool {
        above.iter().any(|entered| self.bodies[entered.body as usize].refraction == Refraction::Surroundings)
    }

    /// Whether the interface of a closed body parts it from another one of the same index.
    fn is_seam(&self, surface: &CoincidentSurface, media: &Media) -> bool {
        let Some(body) = self.body_of(&surface.hit).filter(|_| self.role(surface) == Role::Interface) else {
            return false;
        };
        let own = &self.bodies[body.body as usize];
        if !own.closed || own.refraction != Refraction::Surroundings {
            return false;
        }
        match media.index_outside(surface.enters, &self.bodies) {
            None => own.index_class == 0,
            Some(index) => own.index.as_ref() == Some(index),
        }
    }

    fn role(&self, surface: &CoincidentSurface) -> Role {
        self.surfaces[surface.hit.shape as usize].role
    }

    pub(super) fn body_of(&self, hit: &Hit) -> Option<Entered> {
        let surface = &self.surfaces[hit.shape as usize];
        let instance = if surface.part { NO_INSTANCE } else { hit.instance };
        surface.body.map(|body| Entered { body, instance })
    }

    /// The bodies that a sensor's ray begins in: those that it would leave first if it went backward. The
    /// farther away a body is left, the earlier it was entered.
    pub(super) fn bodies_around(&self, ray: &Ray, time: f64, media: &mut MediumStack) {
        let backward = Ray::new(ray.origin, -ray.direction);
        let mut crossed: Vec<(f64, Entered, bool)> = Vec::new();
        self.crossings(&backward, time, [0.0, f64::INFINITY], &mut |hit, _| {
            let Some(body) = self.body_of(&hit).filter(|body| self.bodies[body.body as usize].closed) else {
                return;
            };
            let normal = self.accel.surface(&self.shapes, &hit, &backward, time).point.normal;
            crossed.push((hit.t, body, backward.direction.dot(normal) > 0.0));
        });
        crossed.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut inside: Vec<Entered> = Vec::new();
        let mut known: Vec<Entered> = Vec::new();
        for (_, body, leaves) in crossed {
            if !known.contains(&body) {
                known.push(body);
                inside.extend(leaves.then_some(body));
            }
        }
        inside.into_iter().rev().for_each(|body| media.enter(body, &self.bodies));
    }
}

impl Partner {
    /// In the scene's own coordinates; `rounding` is the placement error.
    pub fn new(bounds: Bounds, error: f64, rounding: f64) -> Self {
        // Errors are known at a few points only, and are nearly the same at all.
        let reach = 4.0 * error + rounding;
        let margin = Vec3::splat(reach);
        let bounds = Bounds { min: bounds.min - margin, max: bounds.max + margin };
        Self { bounds, reach, shape: None }
    }
}
