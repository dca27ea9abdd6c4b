//! Surfaces that are met together, and surfaces that are none.
//!
//! **Precedence.** Where transparent bodies overlap, the one of highest priority counts alone, and of equal
//! ones that entered last (see [`MediumStack`]). A surface that is entered or left beneath a body that counts
//! more changes nothing: the ray goes straight on. Bodies whose file states both of their indices are what
//! they are by themselves and take no part in this (see [`Refraction`]).
//!
//! **Contact.** Where bodies share a face, no order of their surfaces can be told from the distances along a
//! ray: these are known up to bounds on their errors only. All crossings that may lie in the same place by
//! these bounds are taken as one event: the ray leaves all bodies that it leaves there and enters all that it
//! enters, and the interface is that between the body that counts before and the one that counts after. What
//! scatters, such as the table under a glass, is in optical contact: it is met from within the body. No
//! length is compared with anything but bounds on errors.
//!
//! After such an event the ray starts within its error of the place, so that it may meet again, or never
//! meet, what it has dealt with already. Which of the two it is follows from what it is inside of: right
//! where it starts, a closed body cannot be entered from within nor be left from without.

use super::traceable::{Intersection, Role, Scene};
use crate::geometry::{Bounds, Ray, SurfacePoint, Vec3};
use crate::medium::{Entered, Media, MediumStack, Refraction, refracting};
use crate::shape::{Hit, NO_INSTANCE};
use smallvec::{SmallVec, smallvec};
use std::cmp::Reverse;

/// Which shapes may have faces in common with others, where at least one of the two is the surface of a
/// transparent body.
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
}

/// One of several surfaces that are met together.
struct Met {
    hit: Hit,
    enters: bool,
    /// Whether it may lie where the ray begins.
    at_start: bool,
    /// Whether passing it changes what the ray is inside of. Also of what is no body's.
    effective: bool,
}

/// What a ray does where it meets surfaces.
pub(super) enum Meeting {
    /// It meets the one that the intersection now is.
    Surface,
    /// It goes straight on, past surfaces that change nothing but the media.
    Straight,
    /// It has been here already.
    Nothing,
}

impl Scene {
    /// What a hit means where surfaces can be hidden or in contact, and what is beyond it.
    pub(super) fn meeting(&self, ray: &Ray, time: f64, hit: &mut Intersection, media: &mut Media) -> Meeting {
        let mut together = self.together(ray, time, hit);
        media.beyond.clone_from(&media.here);
        let toggled = self.toggle(&mut together, media);
        hit.joined = toggled > 1;
        if let [own] = &together[..] {
            let passes = || self.needs.precedence && (self.hidden(own, media) || self.is_seam(own, media));
            return match own.effective {
                true if passes() => Meeting::Straight,
                true => Meeting::Surface,
                false => Meeting::Nothing,
            };
        }
        let chosen = match self.scatterer(&together, media).or_else(|| self.interface(&together, media)) {
            Some(chosen) => chosen,
            None if together.iter().any(|met| met.effective) => return Meeting::Straight,
            None => return Meeting::Nothing,
        };
        if chosen != hit.hit {
            let joined = hit.joined;
            *hit = self.intersection(&chosen, ray, time);
            hit.joined = joined;
        }
        Meeting::Surface
    }

    /// What may lie in the same place as a hit, itself included.
    fn together(&self, ray: &Ray, time: f64, hit: &Intersection) -> SmallVec<[Met; 4]> {
        let enters = |point: &SurfacePoint| ray.direction.dot(point.normal) < 0.0;
        let mut found: SmallVec<[Met; 4]> =
            smallvec![Met { hit: hit.hit, enters: enters(&hit.point), at_start: false, effective: true }];
        let Some(contact) = self.contacts.of.get(hit.hit.shape as usize) else { return found };
        let partners = &self.contacts.partners[contact.first as usize..][..contact.count as usize];
        let margin = Vec3::splat(hit.point.error + contact.rounding);
        let here = Bounds { min: hit.point.position - margin, max: hit.point.position + margin };
        let near = partners.iter().filter(|partner| partner.bounds.overlaps(here));
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
        let stretch = [hit.hit.t - far, hit.hit.t + far];
        self.accel.crossings(ray, time, stretch, &mut |other, t_error| {
            let same =
                |a: &Hit, b: &Hit| (a.shape, a.instance, a.triangle) == (b.shape, b.instance, b.triangle);
            let point = self.accel.surface(&self.shapes, &other, ray, time).point;
            let enters = enters(&point);
            if same(&other, &hit.hit) && enters == found[0].enters {
                return;
            }
            let t_error = error(other.shape, other.t, &point).max(t_error.unwrap_or(0.0));
            if (other.t - hit.hit.t).abs() <= own + t_error {
                let at_start = at_start(other.shape, other.t, &point);
                found.push(Met { hit: other, enters, at_start, effective: true });
            }
        });
        // The later body in the file counts where a ray enters bodies of equal priority at once.
        found.sort_by_key(|met| (met.hit.shape, met.hit.instance));
        found
    }

    /// Leaves and enters, from here to beyond, all bodies whose surfaces are met together, and returns how
    /// many. Surfaces that can't be where they are met are marked as without effect.
    fn toggle(&self, together: &mut [Met], media: &mut Media) -> u32 {
        let Media { here, beyond } = media;
        let bodies: SmallVec<[Option<Entered>; 4]> =
            together.iter().map(|met| self.body_of(&met.hit)).collect();
        let mut toggled = 0;
        for leaving in [true, false] {
            for i in 0..together.len() {
                let Some(body) = bodies[i] else { continue };
                let ways = |enters: bool| {
                    together
                        .iter()
                        .zip(&bodies)
                        .any(|(met, other)| *other == Some(body) && met.enters == enters)
                };
                let inside = match together[i].enters {
                    true => here.contains(body),
                    false => here.left_with(body, &self.bodies).is_some(),
                };
                let closed = self.bodies[body.body as usize].closed;
                let again = closed && together[i].at_start && inside == together[i].enters;
                // Between entering and leaving at once the ray only touches.
                let touches = ways(true) && ways(false);
                if touches || again {
                    together[i].effective = false;
                } else if leaving != together[i].enters && !bodies[..i].contains(&Some(body)) {
                    toggled += 1;
                    match leaving {
                        true => beyond.leave(body, &self.bodies),
                        false => beyond.enter(body, &self.bodies),
                    }
                }
            }
        }
        toggled
    }

    /// The first surface that is more than a boundary of bodies; lights come before others.
    fn scatterer(&self, together: &[Met], media: &Media) -> Option<Hit> {
        let scatters = |met: &&Met| {
            met.effective
                && self.role(met) == Role::Other
                && !(self.needs.precedence && self.hidden(met, media))
        };
        let order = |a: &&Met, b: &&Met| {
            let place = |met: &Met| (!self.shines(met), met.hit.shape);
            place(a).0.cmp(&place(b).0).then(a.hit.t.total_cmp(&b.hit.t)).then(place(a).1.cmp(&place(b).1))
        };
        together.iter().filter(scatters).min_by(order).map(|met| met.hit)
    }

    fn shines(&self, met: &Met) -> bool {
        met.enters && self.surfaces[met.hit.shape as usize].light.is_some()
    }

    /// The surface at which the index changes, or else one of no index that can be seen.
    fn interface(&self, together: &[Met], media: &Media) -> Option<Hit> {
        let effective = || together.iter().filter(|met| met.effective);
        let (above, sides) = media.here.parted(&media.beyond);
        let [before, after] = sides.map(|side| refracting(side, &self.bodies));
        let class =
            |body: Option<Entered>| body.map_or(0, |body| self.bodies[body.body as usize].index_class);
        if !self.covers(above) && before != after && class(before) != class(after) {
            let counts = effective().filter(|met| {
                let body = self.body_of(&met.hit);
                let own = match met.enters {
                    true => body,
                    false => body.and_then(|body| media.here.left_with(body, &self.bodies).or(Some(body))),
                };
                self.role(met) == Role::Interface && (own == before || own == after)
            });
            let rank = |met: &&Met| {
                let priority = self.body_of(&met.hit).map(|body| self.bodies[body.body as usize].priority);
                (priority, Reverse(met.hit.shape))
            };
            return counts.max_by_key(rank).map(|met| met.hit);
        }
        effective().find(|met| self.role(met) == Role::Veil && !self.hidden(met, media)).map(|met| met.hit)
    }

    /// Whether a body's surface is passed beneath a body that counts more. A light is never hidden.
    fn hidden(&self, met: &Met, media: &Media) -> bool {
        if self.surfaces[met.hit.shape as usize].light.is_some() {
            return false;
        }
        let Some(body) = self.body_of(&met.hit) else { return false };
        let above = if met.enters { &media.beyond } else { &media.here }.above(body, &self.bodies);
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
    fn is_seam(&self, met: &Met, media: &Media) -> bool {
        let Some(body) = self.body_of(&met.hit).filter(|_| self.role(met) == Role::Interface) else {
            return false;
        };
        let own = &self.bodies[body.body as usize];
        if !own.closed || own.refraction != Refraction::Surroundings {
            return false;
        }
        match media.index_outside(met.enters, &self.bodies) {
            None => own.index_class == 0,
            Some(index) => own.index.as_ref() == Some(index),
        }
    }

    fn role(&self, met: &Met) -> Role {
        self.surfaces[met.hit.shape as usize].role
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
        self.accel.crossings(&backward, time, [0.0, f64::INFINITY], &mut |hit, _| {
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
        Self { bounds: Bounds { min: bounds.min - margin, max: bounds.max + margin }, reach }
    }
}
