//! Rays through media that scatter: where they end, and what each wavelength would have done.

use super::counting::RayKind;
use super::intersection::Intersection;
use super::passage::transmittance;
use super::scene::Scene;
use crate::geometry::{Ray, Vec3};
use crate::lanes::Real;
use crate::medium::{Extinction, FreeFlight, Media, Medium, MediumStack, Scattering, Segment};
use crate::spectrum::{Sampled, Wavelengths};

/// What a ray comes to first.
pub enum Event<'a> {
    /// A surface.
    Surface(Intersection),
    /// A place in a medium that scatters.
    Medium(Collision<'a>),
    /// It leaves the scene.
    Nothing,
}

/// A place between surfaces where a ray is scattered or absorbed.
#[derive(Clone, Copy)]
pub struct Collision<'a> {
    /// Where it is, in scene units.
    pub position: Vec3,
    /// How the medium scatters.
    pub scattering: &'a Scattering,
}

/// What a flight is worth, for each wavelength.
#[derive(Clone, Copy, Debug)]
pub struct Flight<const C: usize> {
    /// What is carried, over the hero's density: of what ends in a medium as if all of it were scattered.
    pub carried: Sampled<C>,
    /// The density over the hero's.
    pub ratio: Sampled<C>,
    /// The probability of having come as far.
    pub flown: Sampled<C>,
    /// What media send out on the way, over what the path carried before and weighed over its wavelengths.
    pub emitted: Sampled<C>,
    /// How far the medium reaches in which the ray begins.
    pub first: f64,
    /// How far the ray comes if it ends in that medium, and the hero's density of that distance.
    pub ended: Option<[f64; 2]>,
}

/// What decides a flight.
#[derive(Clone, Copy, Debug)]
pub struct FlightPlan<const C: usize> {
    /// The hero's optical depth in media that scatter at which it ends.
    pub target: f64,
    /// The densities of the path before the flight, over the hero's.
    pub prior: Sampled<C>,
    /// Where in its stretch of the way light from media is looked up, from 0 to 1.
    pub place: f64,
    /// Whether it has to be known how far the first medium reaches, even if the ray ends before.
    pub looks_ahead: bool,
}

impl Scene {
    /// What a ray comes to first if it ends where its plan says; `media` are then those around it there.
    pub fn fly<const C: usize>(
        &self,
        ray: &Ray,
        time: f64,
        kind: RayKind,
        plan: &FlightPlan<C>,
        media: &mut Media,
        wavelengths: &Wavelengths<C>,
    ) -> (Event<'_>, Flight<C>) {
        let target = plan.target;
        let mut flown =
            Flown { target, plan, wavelengths, flight: Flight::BEGINNING, begins: true, collision: None };
        let reach = match plan.looks_ahead {
            true => ray.t_max,
            false => self.reach(ray, target, media, wavelengths),
        };
        let hit = self.intersect_within(ray, reach, time, kind, media, |media, segment| {
            flown.cross(self.medium(media), media, segment);
        });
        let Flown { flight, collision, .. } = flown;
        let event = match (collision, hit) {
            (Some((position, scattering, around)), hit) => {
                let position = hit.map_or(position, |hit| before(&hit, position, ray.direction));
                media.here = around;
                Event::Medium(Collision { position, scattering })
            }
            (None, Some(hit)) => Event::Surface(hit),
            (None, None) => Event::Nothing,
        };
        (event, flight)
    }

    /// The distance at which a ray ends if it meets no surface before.
    fn reach<const C: usize>(
        &self,
        ray: &Ray,
        target: f64,
        media: &Media,
        wavelengths: &Wavelengths<C>,
    ) -> f64 {
        /// A surface that is so much farther away than the end is looked for all the same: the place is kept
        /// off it.
        const MARGIN: f64 = 1e-9;
        match self.medium(&media.here) {
            Some(
                medium @ Medium { extinction: Extinction::Homogeneous(spectrum), scattering: Some(_), .. },
            ) => {
                let extinction = spectrum.at(wavelengths.nm[0]) * medium.projected_area(ray.direction);
                let distance = target / extinction;
                // Where both are zero, it is no number: `min` takes the other.
                (distance * (1.0 + MARGIN)).min(ray.t_max)
            }
            _ => ray.t_max,
        }
    }
}

/// A place in front of a surface that lies farther along the ray, off it by the bound on its error.
fn before(hit: &Intersection, position: Vec3, direction: Vec3) -> Vec3 {
    let normal = hit.point.normal;
    let normal = if direction.dot(normal) > 0.0 { -normal } else { normal };
    let height = (position - hit.point.position).dot(normal);
    position + normal * (hit.point.error - height).max(0.0)
}

impl<const C: usize> Flight<C> {
    const BEGINNING: Self = Self {
        carried: Sampled::ONE,
        ratio: Sampled::ONE,
        flown: Sampled::ONE,
        emitted: Sampled::ZERO,
        first: 0.0,
        ended: None,
    };
}

/// A flight under way.
struct Flown<'a, 'b, const C: usize> {
    /// What is left of the hero's optical depth.
    target: f64,
    plan: &'b FlightPlan<C>,
    wavelengths: &'b Wavelengths<C>,
    flight: Flight<C>,
    /// Whether nothing is crossed yet.
    begins: bool,
    /// Where it has ended, and in what.
    collision: Option<(Vec3, &'a Scattering, MediumStack)>,
}

impl<'a, const C: usize> Flown<'a, '_, C> {
    fn cross(&mut self, medium: Option<&'a Medium>, media: &MediumStack, segment: &Ray) {
        let begins = std::mem::replace(&mut self.begins, false);
        if begins {
            self.flight.first = segment.t_max;
        }
        let Some(medium) = medium.filter(|_| self.collision.is_none()) else { return };
        let Some(scattering) = &medium.scattering else {
            self.gather(medium, segment);
            self.flight.carried *= transmittance(medium, segment, self.wavelengths);
            return;
        };
        // The hero's depth is at most its target, so that neither can overflow.
        let over_hero = |depths: Sampled<C>| (Sampled::splat(depths.hero()) - depths).exp();
        let hero_survives = |depths: Sampled<C>| Real::exp(-depths.hero());
        let flight = medium.fly(segment, self.target, &self.wavelengths.nm);
        match flight {
            FreeFlight::Passed { .. } => self.gather(medium, segment),
            FreeFlight::Ended { distance, .. } => self.gather(medium, &Ray { t_max: distance, ..*segment }),
        }
        let Flight { carried, ratio, flown, .. } = &mut self.flight;
        match flight {
            FreeFlight::Passed { depths } => {
                self.target -= depths.hero();
                let over_hero = over_hero(depths);
                *carried *= over_hero;
                *ratio *= over_hero;
                *flown *= over_hero * hero_survives(depths);
            }
            FreeFlight::Ended { distance, depths, extinction } => {
                let (over_hero, hero_survives) = (over_hero(depths), hero_survives(depths));
                let density = over_hero * extinction / extinction.hero();
                *carried *= density;
                *ratio *= density;
                *flown *= over_hero * hero_survives;
                self.flight.ended = begins.then_some([distance, extinction.hero() * hero_survives]);
                self.collision = Some((segment.at(distance), scattering, media.clone()));
            }
        }
    }

    /// Adds what a medium sends out on a segment that is flown through.
    fn gather(&mut self, medium: &Medium, segment: &Ray) {
        if medium.emission.is_none() {
            return;
        }
        let FlightPlan { prior, place, .. } = *self.plan;
        let Flight { carried, ratio, .. } = self.flight;
        let nm = &self.wavelengths.nm;
        self.flight.emitted +=
            medium.emission_along(&Segment { ray: segment, carried, ratio: prior * ratio, place, nm });
    }
}
