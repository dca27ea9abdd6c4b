//! How the surfaces that the paths of a bundle have met scatter. Diffuse ones do it in lanes, all others one
//! by one.

use super::metals::{Metals, Reflected};
use crate::bsdf::{Evaluation, RoughConductor, Scatter};
use crate::geometry::axes_around;
use crate::lanes::{
    LANES, Mask, REGISTERS, Real, Register, Row, Truth, Vec3Lanes, WIDTH, ZERO, get, lanes_of, part,
    registers_of, set,
};
use crate::light::Receivers;
use crate::material::Shading;
use crate::sampling::{Density, warp};
use crate::scene::Intersections;
use crate::spectrum::SampledLanes;
use std::f64::consts::FRAC_1_PI;

/// Where the rays of some lanes have met surfaces, and how these scatter.
pub(super) struct Surfaces<const C: usize> {
    pub hits: Intersections,
    /// Diffuse ones that are seen from the side on which they scatter.
    pub diffuse: Mask,
    /// All that are not, rough metals among them.
    pub others: Mask,
    pub metals: Metals<C>,
    /// The side from which light counts: of the diffuse ones their normal. And their reflectance.
    pub normal: [Vec3Lanes; REGISTERS],
    pub reflectance: SampledLanes<C>,
    /// By lane; empty where there are no others.
    shadings: Vec<Option<Shading<C>>>,
}

/// Values of BSDFs; see [`Evaluation`].
pub(super) struct Evaluations<const C: usize> {
    pub f_cos: SampledLanes<C>,
    pub density: SampledLanes<C>,
}

impl<const C: usize> Evaluations<C> {
    pub const ZERO: Self = Self { f_cos: SampledLanes::ZERO, density: SampledLanes::ZERO };

    /// Makes all of them zero.
    pub fn clear(&mut self) {
        for rows in [&mut self.f_cos, &mut self.density] {
            rows.0.fill(ZERO);
        }
    }
}

/// Sampled directions; see [`Scatter`].
pub(super) struct Scatters<const C: usize> {
    /// Lanes that scatter with a density.
    pub spread: Mask,
    /// Those of them that scatter to the other side.
    pub transmitted: Mask,
    /// Lanes that scatter in a single direction: their path goes on alone.
    pub apart: Vec<(usize, Scatter<C>)>,
    pub toward_light: [Vec3Lanes; REGISTERS],
    pub weight: SampledLanes<C>,
    /// The hero's.
    pub density: Row,
    pub ratio: SampledLanes<C>,
}

impl<const C: usize> Surfaces<C> {
    pub fn new() -> Self {
        Self {
            hits: Intersections::NONE,
            diffuse: 0,
            others: 0,
            metals: Metals::new(),
            normal: [Vec3Lanes::ZERO; REGISTERS],
            reflectance: SampledLanes::ZERO,
            shadings: Vec::new(),
        }
    }

    /// Leaves out how surfaces scatter that were met before.
    pub fn clear(&mut self) {
        (self.diffuse, self.others, self.metals.lanes) = (0, 0, 0);
        self.shadings.clear();
    }

    /// Puts in how the surface of a lane scatters.
    pub fn set(&mut self, lane: usize, shading: Shading<C>) {
        let normal = &mut self.normal[lane / WIDTH % REGISTERS];
        if let Some((towards_eye, reflectance)) = shading.diffuse() {
            self.diffuse |= 1 << lane;
            normal.set(lane, towards_eye);
            self.reflectance.set(lane, &reflectance);
            return;
        }
        self.others |= 1 << lane;
        normal.set(lane, shading.receiving_side());
        if let Some(metal) = shading.rough_metal() {
            self.metals.set(lane, &metal);
        }
        self.shadings.resize_with(LANES, || None);
        self.shadings[lane] = Some(shading);
    }

    /// Puts in an even rough metal; see [`Metals::set_bsdf`].
    pub fn set_metal(&mut self, lane: usize, metal: &RoughConductor<C>) {
        self.others |= 1 << lane;
        self.metals.set_bsdf(lane, metal);
    }

    /// How a lane scatters that is neither diffuse nor an even rough metal.
    pub fn shading(&self, lane: usize) -> Option<&Shading<C>> {
        self.shadings.get(lane)?.as_ref()
    }

    /// Takes out the mirror reflection of a lane's coat; see [`Shading::take_mirror`].
    pub fn take_mirror(&mut self, lane: usize) -> Option<Scatter<C>> {
        self.shadings.get_mut(lane)?.as_mut()?.take_mirror()
    }

    /// Whether paths are shared between the surface of a lane and others: it scatters with a density, back to
    /// the side that light comes from.
    pub fn shares(&self, lane: usize) -> bool {
        self.shading(lane).is_none_or(|shading| !shading.bsdf.is_discrete() && !shading.bsdf.transmits())
    }

    /// Whether the path of a lane goes on in its bundle: the surface scatters with a density. Where light is
    /// traced, what it transmits, or scatters by a frame that turns with the eye, is weighed against nothing
    /// and goes on alone.
    pub fn goes_along(&self, lane: usize, light_tracing: bool) -> bool {
        self.shading(lane).is_none_or(|shading| {
            let beside_nothing = shading.bsdf.transmits() || shading.turns_with_eye();
            !(shading.bsdf.is_discrete() || light_tracing && beside_nothing)
        })
    }

    /// All that scatter anything.
    pub fn scattering(&self) -> Mask {
        self.diffuse | self.others
    }

    /// As lights are chosen for them.
    pub fn receivers(&self) -> Receivers<'_> {
        Receivers { point: &self.hits.point, facing: &self.normal }
    }

    /// The values for light from a direction for each lane, and the densities of sampling it. Zero in lanes
    /// that are not asked for.
    #[inline(always)]
    pub fn evaluate(&self, toward_light: &[Vec3Lanes; REGISTERS], asked: Mask) -> Evaluations<C> {
        let mut values = Evaluations::ZERO;
        for register in registers_of(asked & self.diffuse) {
            let cos = self.normal[register].dot(toward_light[register]);
            let lit = Truth::of(part(asked & self.diffuse, register)) & cos.gt(Register::ZERO);
            let density = lit.only(cos * Register::splat(FRAC_1_PI));
            for wavelength in 0..C {
                values.density.0[wavelength][register] = density;
                values.f_cos.0[wavelength][register] = self.reflectance.0[wavelength][register] * density;
            }
        }
        self.metals.evaluate(toward_light, asked, &mut values);
        for lane in lanes_of(asked & self.others & !self.metals.lanes) {
            let Some(shading) = self.shading(lane) else { continue };
            let Evaluation { f_cos, density } =
                shading.evaluate(toward_light[lane / WIDTH % REGISTERS].get(lane));
            values.f_cos.set(lane, &f_cos);
            values.density.set(lane, &density);
        }
        values
    }

    /// A direction for each lane that is asked for; see [`Shading::sample`]. `u`: direction (0, 1), lobe (2).
    #[inline(always)]
    pub fn sample(&self, u: &[Row; 4], asked: Mask) -> Scatters<C> {
        let mut scatters = Scatters {
            spread: 0,
            transmitted: 0,
            apart: Vec::new(),
            toward_light: [Vec3Lanes::ZERO; REGISTERS],
            weight: self.reflectance.clone(),
            density: ZERO,
            ratio: SampledLanes::ONE,
        };
        for register in registers_of(asked & self.diffuse) {
            let wanted = part(asked & self.diffuse, register);
            let local = warp::cosine_hemisphere([u[0][register], u[1][register]]);
            let normal = self.normal[register];
            let [x, y] = axes_around(normal);
            scatters.toward_light[register] = (x * local.x + y * local.y + normal * local.z).normalize();
            scatters.density[register] = local.z * Register::splat(FRAC_1_PI);
            scatters.spread |= (local.z.gt(Register::ZERO).mask() & wanted) << (WIDTH * register);
        }
        for register in registers_of(asked & self.metals.lanes) {
            let wanted = part(asked & self.metals.lanes, register);
            let Reflected { lanes, toward_light, density, weight } =
                self.metals.sample(register, [u[0][register], u[1][register]], wanted);
            scatters.spread |= lanes << (WIDTH * register);
            let metals = Truth::of(wanted);
            let direction = &mut scatters.toward_light[register];
            *direction = Vec3Lanes::choose(metals, toward_light, *direction);
            scatters.density[register] = Register::choose(metals, density, scatters.density[register]);
            for (row, weight) in scatters.weight.0.iter_mut().zip(weight) {
                row[register] = Register::choose(metals, weight, row[register]);
            }
        }
        for lane in lanes_of(asked & self.others & !self.metals.lanes) {
            let [u, v, lobe] = [0, 1, 2].map(|value| get(&u[value], lane));
            let Some(scatter) = self.shading(lane).and_then(|shading| shading.sample(lobe, [u, v])) else {
                continue;
            };
            match scatter.density {
                Density::PerSolidAngle(density) => {
                    scatters.spread |= 1 << lane;
                    scatters.transmitted |= Mask::from(scatter.transmitted) << lane;
                    scatters.toward_light[lane / WIDTH % REGISTERS].set(lane, scatter.toward_light);
                    scatters.weight.set(lane, &scatter.weight);
                    scatters.ratio.set(lane, &scatter.ratio);
                    set(&mut scatters.density, lane, density);
                }
                Density::Discrete => scatters.apart.push((lane, scatter)),
            }
        }
        scatters
    }
}
