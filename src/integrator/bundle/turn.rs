use crate::lanes::LANES;
use crate::sampling::Stream;
use crate::scene::Scene;
use crate::spectrum::{Sampled, Wavelengths};
use smallvec::SmallVec;

/// One sample of each pixel of a group, with what is known of its wavelengths before the paths are followed.
pub(in crate::integrator) struct Turn<'a, const C: usize> {
    pub wavelengths: &'a Wavelengths<C>,
    pub time: f64,
    /// Sample values of each lane; those without a path have some, too.
    pub streams: [Stream<'a>; LANES],
    /// Reflectances of even surfaces, by their numbers: those of few, once and for all.
    reflectances: SmallVec<[Sampled<C>; LOOKED_UP]>,
    /// See [`crate::light::Lights::only_radiance`].
    pub only_radiance: Sampled<C>,
}

/// Up to this number of reflectances are looked up before any is asked for.
const LOOKED_UP: usize = 8;

impl<'a, const C: usize> Turn<'a, C> {
    pub fn new(
        scene: &Scene,
        time: f64,
        wavelengths: &'a Wavelengths<C>,
        streams: [Stream<'a>; LANES],
    ) -> Self {
        let reflectances = scene.reflectances().iter().take(LOOKED_UP);
        Self {
            wavelengths,
            time,
            streams,
            reflectances: reflectances.map(|spectrum| spectrum.sample(&wavelengths.nm)).collect(),
            only_radiance: scene.lights.only_radiance(&wavelengths.nm),
        }
    }

    pub fn reflectance(&self, scene: &Scene, number: u32) -> Sampled<C> {
        match self.reflectances.get(number as usize) {
            Some(reflectance) => *reflectance,
            None => scene.reflectances()[number as usize].sample(&self.wavelengths.nm),
        }
    }
}
