//! Which light a light sample goes to.
//!
//! Few lights are each estimated for the place that is lit, at the path's wavelengths. Of many, all that have
//! a place are in one [`Tree`]. So are the triangles of each emissive mesh. Estimates take all of the path's
//! wavelengths alike, so the choice is the same whichever of them is the hero.

use super::tree::{Tree, Viewpoint};
use super::{Light, Lights, Receiver};
use crate::sampling::PiecewiseConstant;
use crate::sampling::warp::{below_one, pick};
use crate::spectrum::{Spectrum, WavelengthDensity, Wavelengths};
use crate::units::WavelengthRange;
use rayon::prelude::*;
use std::f64::consts::PI;

/// What the mean radiance of the environment is multiplied by for its estimate: half of it is above a
/// surface, at a slant.
pub(super) const ENVIRONMENT_WEIGHT: f64 = PI;

/// Up to this number of lights each is estimated at each vertex.
const FEW: usize = 32;

/// What the choice among lights is made for.
#[derive(Clone, Copy, Debug)]
pub struct Setting<'a> {
    /// When the shutter opens and closes.
    pub during: [f64; 2],
    /// How paths choose their wavelengths: so the light's spectrum is weighed.
    pub density: &'a WavelengthDensity,
}

impl Setting<'_> {
    /// Wavelengths that paths are as likely to have as one another, nm.
    pub(super) fn nm<const N: usize>(&self) -> [f64; N] {
        self.density.sample(0.5 / N as f64).nm
    }
}

/// Wavelengths at which a light of many is weighed.
const WEIGHED: usize = 64;

/// About the mean over the wavelengths of paths, above 0 where the spectrum is so anywhere.
fn mean(spectrum: &Spectrum, nm: &[f64; WEIGHED]) -> f64 {
    let least = 1e-6 * spectrum.bounds(WavelengthRange::WIDEST).1;
    (spectrum.sample(nm).sum() / WEIGHED as f64).max(least)
}

/// What a light sample goes to.
pub(super) struct Chosen {
    /// A light, or the number of lights for the environment.
    pub light: usize,
    pub part: u32,
    pub probability: f64,
}

/// What is chosen among.
#[derive(Clone, Debug, Default)]
pub(super) struct Choice {
    heads: Vec<Head>,
    /// Head of each light.
    homes: Vec<u32>,
    /// Whether a head may stand for many lights, so that estimates are rough.
    rough: bool,
}

/// What is estimated at each vertex.
#[derive(Clone, Debug)]
pub(super) enum Head {
    Light(u32),
    /// A light of many parts.
    Divided {
        light: u32,
        parts: Box<Tree>,
    },
    /// Many lights that each have a place.
    Near(Box<Near>),
    /// Many lights that each shine from one direction, by their irradiance.
    Distant(Box<Distant>),
    Environment,
}

#[derive(Clone, Debug)]
pub(super) struct Near {
    tree: Tree,
    /// Light and part of each emitter.
    emitters: Vec<(u32, u32)>,
    /// First emitter of each light.
    first: Vec<u32>,
}

#[derive(Clone, Debug)]
pub(super) struct Distant {
    lights: Vec<u32>,
    choice: PiecewiseConstant,
    irradiance: f64,
}

impl Choice {
    pub fn is_empty(&self) -> bool {
        self.heads.is_empty()
    }

    pub fn heads(&self) -> &[Head] {
        &self.heads
    }

    pub fn new(lights: &Lights, setting: &Setting) -> Self {
        let mut choice = Self { homes: vec![0; lights.lights.len()], ..Self::default() };
        let environment = lights.sampled_environment().map(|_| Head::Environment);
        if lights.lights.len() + usize::from(environment.is_some()) <= FEW {
            for light in 0..lights.lights.len() as u32 {
                choice.homes[light as usize] = light;
                choice.heads.push(match divided(lights, light, setting) {
                    Some(parts) => Head::Divided { light, parts: Box::new(parts) },
                    None => Head::Light(light),
                });
            }
        } else {
            choice.rough = true;
            let (distant, near): (Vec<u32>, Vec<u32>) = (0..lights.lights.len() as u32)
                .partition(|&light| matches!(lights.lights[light as usize], Light::Directional { .. }));
            let heads = [
                (Near::new(lights, &near, setting).map(|near| Head::Near(Box::new(near))), &near),
                (
                    Distant::new(lights, &distant, setting).map(|distant| Head::Distant(Box::new(distant))),
                    &distant,
                ),
            ];
            for (head, members) in heads {
                members.iter().for_each(|&light| choice.homes[light as usize] = choice.heads.len() as u32);
                choice.heads.extend(head);
            }
        }
        choice.heads.extend(environment);
        choice
    }
}

/// The tree of the parts of a light that has several.
fn divided(lights: &Lights, light: u32, setting: &Setting) -> Option<Tree> {
    let parts = lights.lights[light as usize].parts();
    let brightness = mean(lights.lights[light as usize].spectrum(), &setting.nm());
    let bound = |part| lights.bound(light, part, brightness, setting.during);
    (parts > 1).then(|| Tree::new((0..parts).into_par_iter().map(bound).collect()))?
}

impl Near {
    /// `None` where none emits.
    fn new(lights: &Lights, members: &[u32], setting: &Setting) -> Option<Self> {
        let nm = setting.nm();
        let mut first = vec![0; lights.lights.len()];
        let mut emitters = Vec::with_capacity(members.len());
        for &light in members {
            first[light as usize] = emitters.len() as u32;
            emitters.extend((0..lights.lights[light as usize].parts()).map(|part| (light, part)));
        }
        let brightness: Vec<f64> =
            lights.lights.par_iter().map(|light| mean(light.spectrum(), &nm)).collect();
        let bound = |&(light, part): &(u32, u32)| {
            lights.bound(light, part, brightness[light as usize], setting.during)
        };
        let tree = Tree::new(emitters.par_iter().map(bound).collect())?;
        Some(Self { tree, emitters, first })
    }
}

impl Distant {
    /// `None` where none emits.
    fn new(lights: &Lights, members: &[u32], setting: &Setting) -> Option<Self> {
        let nm = setting.nm();
        let irradiances: Vec<f64> =
            members.iter().map(|&light| mean(lights.lights[light as usize].spectrum(), &nm)).collect();
        let edges = (0..=members.len()).map(|i| i as f64).collect();
        let choice = PiecewiseConstant::new(edges, &irradiances)?;
        Some(Self { lights: members.to_vec(), choice, irradiance: irradiances.iter().sum() })
    }

    fn choose(&self, u: &mut f64) -> (u32, f64) {
        let (place, probability) = self.choice.sample(*u);
        let index = (place as usize).min(self.lights.len() - 1);
        *u = below_one(place - index as f64);
        (self.lights[index], probability)
    }
}

impl Lights {
    /// The binary logarithm of the number of emitters in the largest tree.
    pub fn tree_levels(&self) -> f64 {
        let levels = |head: &Head| match head {
            Head::Divided { parts, .. } => parts.levels(),
            Head::Near(near) => near.tree.levels(),
            Head::Light(_) | Head::Distant(_) | Head::Environment => 0.0,
        };
        self.choice.heads.iter().map(levels).fold(0.0, f64::max)
    }

    /// A part of a light for a place, by the sample value `u`; what is left of which is uniform again.
    pub(super) fn choose<const C: usize>(
        &self,
        from: &Receiver,
        time: f64,
        wavelengths: &Wavelengths<C>,
        u: &mut f64,
    ) -> Option<Chosen> {
        let (head, head_probability) = match self.choice.heads.as_slice() {
            [] => return None,
            [only] => (only, 1.0),
            heads => {
                let (estimates, all) = self.estimates(from, time, wavelengths);
                let (index, head_probability) = pick(&estimates[..heads.len()], all, u)?;
                (&heads[index], head_probability)
            }
        };
        let whole = |light| Some(Chosen { light, part: 0, probability: head_probability });
        match head {
            Head::Light(light) => whole(*light as usize),
            Head::Environment => whole(self.lights.len()),
            Head::Divided { light, parts } => {
                let (part, probability) = parts.choose(&from.view(), u)?;
                Some(Chosen { light: *light as usize, part, probability: head_probability * probability })
            }
            Head::Near(near) => {
                let (emitter, probability) = near.tree.choose(&from.view(), u)?;
                let (light, part) = near.emitters[emitter as usize];
                Some(Chosen { light: light as usize, part, probability: head_probability * probability })
            }
            Head::Distant(distant) => {
                let (light, probability) = distant.choose(u);
                Some(Chosen { light: light as usize, part: 0, probability: head_probability * probability })
            }
        }
    }

    /// The probability with which [`Self::choose`] takes a part of a light, or of the environment.
    pub(super) fn probability<const C: usize>(
        &self,
        light: usize,
        part: u32,
        from: &Receiver,
        time: f64,
        wavelengths: &Wavelengths<C>,
    ) -> f64 {
        let heads = &self.choice.heads;
        let index = self.choice.homes.get(light).map_or(heads.len() - 1, |&head| head as usize);
        let head_probability = if heads.len() == 1 {
            1.0
        } else {
            let (estimates, all) = self.estimates(from, time, wavelengths);
            if estimates[index] > 0.0 { estimates[index] / all } else { return 0.0 }
        };
        match heads.get(index) {
            None => 0.0,
            Some(Head::Light(_) | Head::Environment) => head_probability,
            Some(Head::Divided { parts, .. }) => head_probability * parts.probability(&from.view(), part),
            Some(Head::Near(near)) => {
                head_probability * near.tree.probability(&from.view(), near.first[light] + part)
            }
            // No ray ever meets one.
            Some(Head::Distant(_)) => 0.0,
        }
    }

    /// What each head weighs, and the sum.
    fn estimates<const C: usize>(
        &self,
        from: &Receiver,
        time: f64,
        wavelengths: &Wavelengths<C>,
    ) -> ([f64; FEW], f64) {
        let heads = &self.choice.heads;
        let mut estimates = [0.0; FEW];
        let mut all = 0.0;
        for (estimate, head) in estimates.iter_mut().zip(heads) {
            *estimate = self.estimate(head, from, time, wavelengths);
            all += *estimate;
        }
        if self.choice.rough && all > 0.0 {
            // By halves as estimated and each alike.
            let count = estimates.iter().filter(|&&estimate| estimate > 0.0).count() as f64;
            for estimate in estimates.iter_mut().filter(|estimate| **estimate > 0.0) {
                *estimate = 0.5 * *estimate / all + 0.5 / count;
            }
            all = 1.0;
        }
        (estimates, all)
    }

    /// Order of magnitude of the irradiance that a place receives from a head, summed over the wavelengths.
    /// Zero only where it brings nothing.
    fn estimate<const C: usize>(
        &self,
        head: &Head,
        from: &Receiver,
        time: f64,
        wavelengths: &Wavelengths<C>,
    ) -> f64 {
        match head {
            Head::Light(light) | Head::Divided { light, .. } => {
                let light = *light as usize;
                self.lights[light].estimate(from, time, self.placed(light), wavelengths)
            }
            Head::Near(near) => C as f64 * near.tree.estimate(&from.view()),
            Head::Distant(distant) => C as f64 * distant.irradiance,
            Head::Environment => self.environment.as_ref().map_or(0.0, |environment| {
                ENVIRONMENT_WEIGHT * environment.mean().sample(&wavelengths.nm).sum()
            }),
        }
    }
}

impl Receiver {
    fn view(&self) -> Viewpoint {
        Viewpoint { position: self.point.position, facing: self.facing }
    }
}
