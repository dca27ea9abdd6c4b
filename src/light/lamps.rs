//! Lamps that light samples of several surfaces go to at once: rectangles and balls that emit evenly and stay
//! where they are. Beside them there may be an environment.

use super::area::Extent;
use super::choice::{Head, below_one};
use super::{Light, LightHit, Lights, Receivers};
use crate::accel::NO_FACET;
use crate::geometry::Points;
use crate::lanes::{LANES, Mask, REGISTERS, Real, Row, Truth, Vec3Lanes, WIDTH, ZERO, get, part, set};
use crate::shape::{RectangleSurface, Shape, Sphere};
use crate::spectrum::{Sampled, SampledLanes, Wavelengths};
use smallvec::SmallVec;
use std::f64::consts::PI;
use wide::f64x4;

/// Each lamp is estimated for each surface: more go one by one.
const MOST: usize = 8;

/// All that light samples go to.
#[derive(Clone, Debug)]
pub(super) struct Lamps {
    lamps: Vec<Lamp>,
    /// Whether they go to the environment, too.
    has_environment: bool,
}

/// One of them.
#[derive(Clone, Debug)]
pub(super) struct Lamp {
    pub light: usize,
    form: Form,
    extent: Extent,
    /// The facet that it is, where the scene consists of few; see [`crate::accel::Rays::arrives`].
    pub facet: f64,
}

#[derive(Clone, Debug)]
enum Form {
    Rectangle(RectangleSurface),
    /// It fills a cone.
    Ball(Sphere),
}

/// What lamps emit at the wavelengths of paths, by lane.
#[derive(Clone, Debug)]
pub struct LampLight<const C: usize> {
    /// Radiance, the same from all over a lamp.
    pub(super) radiance: SmallVec<[SampledLanes<C>; 1]>,
    /// What the lamps and, at last, the environment weigh in the choice among them, if there is one.
    spectral: SmallVec<[Row; 1]>,
}

/// Where the light samples of some lanes go.
pub(super) struct Choices {
    /// By lamp, and at last the environment.
    pub lanes: [Mask; MOST + 1],
    pub probability: Row,
    /// What is left of the sample value that has chosen: it is uniform again.
    pub u: Row,
}

/// Points on lamps as lanes see them.
pub(super) struct Targets {
    pub points: Points<f64x4>,
    /// Per steradian.
    pub density: f64x4,
    /// Where this means nothing.
    pub unknown: Mask,
}

impl Lamp {
    fn new(lights: &Lights, light: usize) -> Option<Self> {
        let Light::Area { geometry, radiance, .. } = &lights.lights[light] else { return None };
        let is_plain = geometry.stands_alone() && geometry.guides.is_none() && radiance.uniform().is_some();
        if !is_plain || geometry.area() <= 0.0 {
            return None;
        }
        let form = match &geometry.shape {
            Shape::Mesh(mesh) => Form::Rectangle(mesh.rectangle_surface()?),
            Shape::Sphere(sphere) => {
                sphere.cone_radius()?;
                Form::Ball(sphere.clone())
            }
            _ => return None,
        };
        Some(Self { light, form, extent: *geometry.extent(), facet: NO_FACET })
    }

    /// Points on it for the lanes of a register that are asked for: by solid angle where that pays, and else
    /// by area.
    #[inline(always)]
    pub fn sample(&self, from: Vec3Lanes, u: [f64x4; 2], wanted: Mask) -> Targets {
        match &self.form {
            Form::Rectangle(surface) => {
                let rectangle = surface.rectangle();
                let near = rectangle.is_near(from);
                let (mut place, mut density, mut by_angle) = (u, f64x4::ZERO, near);
                if near.mask() & wanted != 0 {
                    let (seen, usable) = rectangle.project(from);
                    by_angle = by_angle & usable;
                    let of_angle = seen.sample(u);
                    place = [0, 1].map(|axis| f64x4::choose(by_angle, of_angle[axis], u[axis]));
                    density = f64x4::ONE / seen.solid_angle();
                }
                let points = surface.points(place);
                density = f64x4::choose(by_angle, density, self.density_of_area(from, &points));
                Targets { points, density, unknown: 0 }
            }
            Form::Ball(sphere) => {
                let (points, density, is_outside) = sphere.cone_points(from, u);
                Targets { points, density, unknown: wanted & !is_outside.mask() }
            }
        }
    }

    /// The density of [`Self::sample`] at points of it.
    #[inline(always)]
    fn density(&self, from: Vec3Lanes, points: &Points<f64x4>, wanted: Mask) -> f64x4 {
        let of_area = self.density_of_area(from, points);
        let of_area = f64x4::choose(of_area.lt(f64x4::splat(f64::INFINITY)), of_area, f64x4::ZERO);
        let (density, by_angle) = match &self.form {
            Form::Rectangle(surface) => {
                let near = surface.rectangle().is_near(from);
                if near.mask() & wanted == 0 {
                    return of_area;
                }
                let (seen, usable) = surface.rectangle().project(from);
                (f64x4::ONE / seen.solid_angle(), near & usable)
            }
            Form::Ball(sphere) => sphere.cone_densities(from),
        };
        f64x4::choose(by_angle, density, of_area)
    }

    /// Per steradian, that of points uniform over the area.
    #[inline(always)]
    fn density_of_area(&self, from: Vec3Lanes, points: &Points<f64x4>) -> f64x4 {
        let toward = points.position - from;
        let squared = toward.length_squared();
        squared * squared.sqrt() / toward.dot(points.normal).abs() * f64x4::splat(1.0 / self.extent.area)
    }
}

impl Lamps {
    /// `None` where there are other lights, too, or many.
    pub fn new(lights: &Lights) -> Option<Self> {
        let (mut lamps, mut has_environment) = (Vec::new(), false);
        for head in lights.choice.heads() {
            match head {
                Head::Light(light) => lamps.push(Lamp::new(lights, *light as usize)?),
                Head::Environment => has_environment = true,
                Head::Divided { .. } | Head::Near(_) | Head::Distant(_) => return None,
            }
        }
        (1..=MOST).contains(&lamps.len()).then_some(Self { lamps, has_environment })
    }

    pub fn all(&self) -> &[Lamp] {
        &self.lamps
    }

    pub fn all_mut(&mut self) -> &mut [Lamp] {
        &mut self.lamps
    }

    /// How many a light sample chooses among.
    fn heads(&self) -> usize {
        self.lamps.len() + usize::from(self.has_environment)
    }

    /// The number of a light among the lamps, if it is one.
    pub fn number_of(&self, light: usize) -> Option<usize> {
        self.lamps.iter().position(|lamp| lamp.light == light)
    }

    /// That of the environment.
    pub fn environment(&self) -> usize {
        self.lamps.len()
    }

    /// What each brings to places, and the sum; see [`Lights::choose`].
    #[inline(always)]
    fn estimates<const C: usize>(
        &self,
        from: &Receivers,
        light: &LampLight<C>,
        register: usize,
    ) -> ([f64x4; MOST + 1], f64x4) {
        let (mut estimates, mut all) = ([f64x4::ZERO; MOST + 1], f64x4::ZERO);
        for (number, (estimate, spectral)) in estimates.iter_mut().zip(&light.spectral).enumerate() {
            let spectral = spectral[register];
            *estimate = match self.lamps.get(number) {
                Some(lamp) => {
                    let seen = lamp.extent.estimates(from.point[register].position, from.facing[register]);
                    spectral.gt(f64x4::ZERO).only(spectral * seen)
                }
                None => spectral,
            };
            all += *estimate;
        }
        (estimates, all)
    }

    /// Which of them light samples go to, by a sample value.
    pub fn choose<const C: usize>(
        &self,
        from: &Receivers,
        light: &LampLight<C>,
        asked: Mask,
        u: &Row,
    ) -> Choices {
        let mut choices = Choices { lanes: [0; MOST + 1], probability: [f64x4::ONE; REGISTERS], u: *u };
        if self.heads() == 1 {
            choices.lanes[0] = asked;
            return choices;
        }
        for register in 0..REGISTERS {
            let mut open = part(asked, register);
            if open == 0 {
                continue;
            }
            let (estimates, all) = self.estimates(from, light, register);
            let u = u[register];
            let mut remaining = u * all;
            for (lanes, weight) in choices.lanes.iter_mut().zip(estimates).take(self.heads()) {
                // The last that weighs anything takes what rounding leaves over.
                let left = (remaining - weight).le(f64x4::splat(1e-12) * all);
                let taken = weight.gt(f64x4::ZERO) & (remaining.lt(weight) | left);
                let taken = Truth::of(taken.mask() & open);
                let (probability, value) = (&mut choices.probability[register], &mut choices.u[register]);
                *value = f64x4::choose(taken, below_one(remaining / weight), *value);
                *probability = f64x4::choose(taken, weight / all, *probability);
                *lanes |= taken.mask() << (WIDTH * register);
                open &= !taken.mask();
                remaining -= weight;
            }
        }
        choices
    }

    /// The probability with which one of them is chosen.
    #[inline(always)]
    fn probability<const C: usize>(
        &self,
        number: usize,
        from: &Receivers,
        light: &LampLight<C>,
        register: usize,
    ) -> f64x4 {
        if self.heads() == 1 {
            return f64x4::ONE;
        }
        let (estimates, all) = self.estimates(from, light, register);
        let estimate = estimates[number.min(MOST)];
        estimate.gt(f64x4::ZERO).only(estimate / all)
    }

    /// That of the environment, in the lanes asked for.
    pub fn probabilities_of_environment<const C: usize>(
        &self,
        from: &Receivers,
        light: &LampLight<C>,
        asked: Mask,
    ) -> Row {
        let mut probabilities = ZERO;
        for register in (0..REGISTERS).filter(|&register| part(asked, register) != 0) {
            probabilities[register] = self.probability(self.environment(), from, light, register);
        }
        probabilities
    }

    /// The density with which light samples find a point of a lamp, in the lanes asked for.
    pub fn densities<const C: usize>(
        &self,
        number: usize,
        hit: &LightHit,
        from: &Receivers,
        light: &LampLight<C>,
        asked: Mask,
    ) -> Row {
        let points = Points::of(&hit.point);
        let mut densities = ZERO;
        for register in 0..REGISTERS {
            let wanted = part(asked, register);
            if wanted == 0 {
                continue;
            }
            let probability = self.probability(number, from, light, register);
            let density = self.lamps[number].density(from.point[register].position, &points, wanted);
            densities[register] = probability.gt(f64x4::ZERO).only(probability * density);
        }
        densities
    }
}

impl<const C: usize> LampLight<C> {
    /// At the wavelengths of the lanes; `are_same`: those of the first are those of all.
    pub fn new<'w>(
        lights: &Lights,
        wavelengths: impl Fn(usize) -> &'w Wavelengths<C>,
        are_same: bool,
    ) -> Self {
        let mut all = Self { radiance: SmallVec::new(), spectral: SmallVec::new() };
        let Some(lamps) = &lights.lamps else { return all };
        let lanes = |of: &dyn Fn(&[f64; C]) -> Sampled<C>| {
            if are_same {
                return SampledLanes::splat(&of(&wavelengths(0).nm));
            }
            let mut lanes = SampledLanes::ZERO;
            for lane in 0..LANES {
                lanes.set(lane, &of(&wavelengths(lane).nm));
            }
            lanes
        };
        let is_chosen = lamps.heads() > 1;
        for lamp in &lamps.lamps {
            let Light::Area { radiance, mean, .. } = &lights.lights[lamp.light] else { continue };
            let Some(radiance) = radiance.uniform() else { continue };
            all.radiance.push(lanes(&|nm| radiance.sample(nm)));
            if is_chosen {
                all.spectral.push(lanes(&|nm| mean.sample(nm)).sum_of_each());
            }
        }
        if let Some(environment) = lights.environment.as_ref().filter(|_| lamps.has_environment && is_chosen)
        {
            let sums = lanes(&|nm| environment.mean().sample(nm)).sum_of_each();
            all.spectral.push(sums.map(|sum| f64x4::splat(PI) * sum));
        }
        all
    }

    /// Takes what is a lane's of another.
    pub fn take(&mut self, lane: usize, other: &Self, from: usize) {
        for (own, other) in self.radiance.iter_mut().zip(&other.radiance) {
            own.set(lane, &other.get(from));
        }
        for (own, other) in self.spectral.iter_mut().zip(&other.spectral) {
            set(own, lane, get(other, from));
        }
    }
}
