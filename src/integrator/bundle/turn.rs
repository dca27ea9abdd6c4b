use crate::bsdf::RoughConductor;
use crate::lanes::LANES;
use crate::light::LampLight;
use crate::sampling::Stream;
use crate::scene::Scene;
use crate::spectrum::{Sampled, Wavelengths};
use smallvec::SmallVec;

/// One sample of each pixel of a group, with what is known of its wavelengths before the paths are followed.
pub(in crate::integrator) struct Turn<'a, const C: usize> {
    /// Those of each lane.
    wavelengths: [&'a Wavelengths<C>; LANES],
    pub time: f64,
    /// Sample values of each lane; those without a path have some, too.
    pub streams: [Stream<'a>; LANES],
    /// Reflectances of even surfaces, by their numbers: those of few, once and for all lanes.
    reflectances: SmallVec<[Sampled<C>; LOOKED_UP]>,
    /// The same of even rough metals.
    metals: SmallVec<[RoughConductor<C>; METALS_LOOKED_UP]>,
    /// What lamps emit.
    pub lamp_light: LampLight<C>,
}

/// Wavelengths of the lanes.
pub(in crate::integrator) enum Each<'a, const C: usize> {
    Same(&'a Wavelengths<C>),
    Own([&'a Wavelengths<C>; LANES]),
}

/// Up to this number of reflectances are looked up before any is asked for.
const LOOKED_UP: usize = 8;

/// And of metals.
const METALS_LOOKED_UP: usize = 4;

impl<'a, const C: usize> Turn<'a, C> {
    pub fn new(scene: &Scene, time: f64, wavelengths: Each<'a, C>, streams: [Stream<'a>; LANES]) -> Self {
        let (mut reflectances, mut metals) = (SmallVec::new(), SmallVec::new());
        let (wavelengths, are_same) = match wavelengths {
            Each::Same(wavelengths) => {
                let first = scene.reflectances().iter().take(LOOKED_UP);
                reflectances.extend(first.map(|spectrum| spectrum.sample(&wavelengths.nm)));
                let first = scene.metals().iter().take(METALS_LOOKED_UP);
                metals.extend(first.map(|metal| metal.sample(&wavelengths.nm)));
                ([wavelengths; LANES], true)
            }
            Each::Own(each) => (each, false),
        };
        let lamp_light = LampLight::new(&scene.lights, |lane| wavelengths[lane], are_same);
        Self { wavelengths, time, streams, reflectances, metals, lamp_light }
    }

    /// Those of a lane.
    pub fn wavelengths(&self, lane: usize) -> &'a Wavelengths<C> {
        self.wavelengths[lane % LANES]
    }

    pub fn reflectance(&self, scene: &Scene, number: u32, lane: usize) -> Sampled<C> {
        match self.reflectances.get(number as usize) {
            Some(reflectance) => *reflectance,
            None => scene.reflectances()[number as usize].sample(&self.wavelengths(lane).nm),
        }
    }

    pub fn metal(&self, scene: &Scene, number: u32, lane: usize) -> RoughConductor<C> {
        match self.metals.get(number as usize) {
            Some(metal) => *metal,
            None => scene.metals()[number as usize].sample(&self.wavelengths(lane).nm),
        }
    }
}
