//! Lamps that light samples of several surfaces go to at once: rectangles and balls that emit evenly and stay
//! where they are. Beside them there may be an environment.

use super::area::Extent;
use super::choice::{ENVIRONMENT_WEIGHT, Head};
use super::{Light, LightHit, Lights, Lit};
use crate::accel::NO_FACET;
use crate::geometry::Points;
use crate::lanes::{
    LANES, Mask, REGISTERS, Real, Register, Row, Truth, Vec3Lanes, WIDTH, ZERO, get, part, registers_of, set,
};
use crate::sampling::warp::below_one;
use crate::shape::{RectangleSurface, Shape, Sphere};
use crate::spectrum::{Sampled, SampledLanes, Spectrum, Wavelengths};
use smallvec::SmallVec;

/// Each lamp is estimated for each surface: more go one by one.
const MOST: usize = 8;

/// All that light samples go to.
#[derive(Clone, Debug)]
pub(super) struct Lamps {
    pub lamps: Vec<Lamp>,
    /// Whether they go to the environment, too.
    has_environment: bool,
}

/// One of them.
#[derive(Clone, Debug)]
pub(super) struct Lamp {
    pub light: usize,
    /// The same from all over it.
    radiance: Spectrum,
    /// What it weighs by in the choice; see [`Light::Area`].
    mean: Spectrum,
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
    /// The sample values. What is left of the first, which has chosen, is uniform again.
    pub u: [Row; 2],
}

/// Points on lamps as lanes see them.
pub(super) struct Targets {
    pub points: Points<Register>,
    /// Per steradian.
    pub density: Register,
    /// Where this means nothing.
    pub unknown: Mask,
}

impl Lamp {
    fn new(lights: &Lights, light: usize) -> Option<Self> {
        let Light::Area { geometry, radiance, mean } = &lights.lights[light] else { return None };
        let radiance = radiance.uniform()?.clone();
        if !geometry.stands_alone() || geometry.guides.is_some() || geometry.area() <= 0.0 {
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
        Some(Self { light, radiance, mean: mean.clone(), form, extent: geometry.extent, facet: NO_FACET })
    }

    /// Points on it for the lanes of a register that are asked for: by solid angle where that pays, and else
    /// by area.
    #[inline(always)]
    pub fn sample(&self, from: Vec3Lanes, u: [Register; 2], wanted: Mask) -> Targets {
        match &self.form {
            Form::Rectangle(surface) => {
                let seen = surface.rectangle().seen_in_lanes(from, wanted);
                let place = seen.map_or(u, |(seen, by_angle)| {
                    let of_angle = seen.sample(u);
                    [0, 1].map(|axis| Register::choose(by_angle, of_angle[axis], u[axis]))
                });
                let points = surface.points(place);
                let of_area = self.density_of_area(from, &points);
                let density = seen.map_or(of_area, |(seen, by_angle)| {
                    Register::choose(by_angle, Register::ONE / seen.solid_angle(), of_area)
                });
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
    fn density(&self, from: Vec3Lanes, points: &Points<Register>, wanted: Mask) -> Register {
        let of_area = self.density_of_area(from, points);
        let of_area = Register::choose(of_area.lt(Register::splat(f64::INFINITY)), of_area, Register::ZERO);
        let (density, by_angle) = match &self.form {
            Form::Rectangle(surface) => match surface.rectangle().seen_in_lanes(from, wanted) {
                None => return of_area,
                Some((seen, by_angle)) => (Register::ONE / seen.solid_angle(), by_angle),
            },
            Form::Ball(sphere) => sphere.cone_densities(from),
        };
        Register::choose(by_angle, density, of_area)
    }

    /// Per steradian, that of points uniform over the area.
    #[inline(always)]
    fn density_of_area(&self, from: Vec3Lanes, points: &Points<Register>) -> Register {
        let toward = points.position - from;
        let squared = toward.length_squared();
        squared * squared.sqrt() / toward.dot(points.normal).abs() * Register::splat(1.0 / self.extent.area)
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
    fn estimates<F, const C: usize>(
        &self,
        lit: &Lit<F, C>,
        register: usize,
    ) -> ([Register; MOST + 1], Register) {
        let (position, facing) = (lit.from.point[register].position, lit.from.facing[register]);
        let (mut estimates, mut all) = ([Register::ZERO; MOST + 1], Register::ZERO);
        for (number, (estimate, spectral)) in estimates.iter_mut().zip(&lit.light.spectral).enumerate() {
            let spectral = spectral[register];
            *estimate = match self.lamps.get(number) {
                Some(lamp) => {
                    spectral.gt(Register::ZERO).only(spectral * lamp.extent.estimates(position, facing))
                }
                None => spectral,
            };
            all += *estimate;
        }
        (estimates, all)
    }

    /// Which of them light samples go to, by the first of their sample values.
    pub fn choose<F, const C: usize>(&self, lit: &Lit<F, C>, u: &[Row; 2]) -> Choices {
        let mut choices = Choices { lanes: [0; MOST + 1], probability: [Register::ONE; REGISTERS], u: *u };
        if self.heads() == 1 {
            choices.lanes[0] = lit.asked;
            return choices;
        }
        for register in registers_of(lit.asked) {
            let mut open = part(lit.asked, register);
            let (estimates, all) = self.estimates(lit, register);
            let mut remaining = u[0][register] * all;
            for (lanes, &weight) in choices.lanes.iter_mut().zip(&estimates).take(self.heads()) {
                // The last that weighs anything takes what rounding leaves over.
                let left = (remaining - weight).le(Register::splat(1e-12) * all);
                let taken = weight.gt(Register::ZERO) & (remaining.lt(weight) | left);
                let taken = Truth::of(taken.mask() & open);
                let (probability, value) = (&mut choices.probability[register], &mut choices.u[0][register]);
                *value = Register::choose(taken, below_one(remaining / weight), *value);
                *probability = Register::choose(taken, weight / all, *probability);
                *lanes |= taken.mask() << (WIDTH * register);
                open &= !taken.mask();
                remaining -= weight;
            }
        }
        choices
    }

    /// The probability with which one of them is chosen.
    #[inline(always)]
    fn probability<F, const C: usize>(&self, number: usize, lit: &Lit<F, C>, register: usize) -> Register {
        if self.heads() == 1 {
            return Register::ONE;
        }
        let (estimates, all) = self.estimates(lit, register);
        let estimate = estimates[number];
        estimate.gt(Register::ZERO).only(estimate / all)
    }

    /// That of the environment.
    pub fn probabilities_of_environment<F, const C: usize>(&self, lit: &Lit<F, C>) -> Row {
        let mut probabilities = ZERO;
        for register in registers_of(lit.asked) {
            probabilities[register] = self.probability(self.environment(), lit, register);
        }
        probabilities
    }

    /// The density with which light samples find a point of a lamp.
    pub fn densities<F, const C: usize>(&self, number: usize, hit: &LightHit, lit: &Lit<F, C>) -> Row {
        let points = Points::of(&hit.point);
        let mut densities = ZERO;
        for register in registers_of(lit.asked) {
            let wanted = part(lit.asked, register);
            let probability = self.probability(number, lit, register);
            let density = self.lamps[number].density(lit.from.point[register].position, &points, wanted);
            densities[register] = probability.gt(Register::ZERO).only(probability * density);
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
        all.radiance.extend(lamps.lamps.iter().map(|lamp| lanes(&|nm| lamp.radiance.sample(nm))));
        if lamps.heads() > 1 {
            let means = lamps.lamps.iter().map(|lamp| lanes(&|nm| lamp.mean.sample(nm)).sum_of_each());
            all.spectral.extend(means);
        }
        if let Some(environment) = lights.environment.as_ref().filter(|_| lamps.has_environment) {
            let sums = lanes(&|nm| environment.mean().sample(nm)).sum_of_each();
            all.spectral.push(sums.map(|sum| Register::splat(ENVIRONMENT_WEIGHT) * sum));
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
