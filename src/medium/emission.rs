//! Light that a medium sends out.
//!
//! A path that flies through a medium adds what the medium sends toward it from all places that it passes. A
//! place at t brings, at the wavelength i, ε_i(t) · f_i(t) / Σ_j p_j(t): f_i is what the path carries there
//! and p_j the density with which the wavelength j would have come as far, both over the hero's. That is the
//! balance heuristic, as for what surfaces emit. Places beyond the end of the flight are left to those paths
//! that fly farther. The integral over the places is estimated at points at equal distances, the first one at
//! random.

use super::grid::span;
use super::{Extinction, Medium};
use crate::geometry::{Ray, Vec3};
use crate::spectrum::{Sampled, Spectrum, blackbody_radiance};
use crate::texture::{Texture, TexturePoint, Volume};
use crate::units::WavelengthRange;

/// What a medium sends out into all directions.
#[derive(Clone, Debug)]
pub enum Emission {
    /// Radiance per unit of length, W·m⁻²·sr⁻¹·nm⁻¹.
    Radiance(Texture),
    /// The radiance of a black body of this temperature, K, times what the medium absorbs per unit of length
    /// (Kirchhoff).
    Thermal(Texture),
}

/// A part of a path within a medium.
#[derive(Clone, Copy, Debug)]
pub struct Segment<'a, const C: usize> {
    /// It ends where the part does.
    pub ray: &'a Ray,
    /// What is carried at the beginning, over the hero's density.
    pub carried: Sampled<C>,
    /// The densities at the beginning, over the hero's.
    pub ratio: Sampled<C>,
    /// Where in its stretch each point lies, from 0 to 1.
    pub place: f64,
    /// Wavelengths, nm.
    pub nm: &'a [f64; C],
}

impl Emission {
    /// About the most that is seen of it through a depth of `length`, for the choice of wavelengths and of
    /// the film's quantum.
    pub fn typical(&self, range: WavelengthRange, length: f64) -> Spectrum {
        match self {
            Self::Radiance(texture) => texture.mean_spectrum(range).scaled(length),
            Self::Thermal(kelvin) => Spectrum::blackbody(kelvin.max_bound(range)).unwrap_or(Spectrum::ZERO),
        }
    }

    fn texture(&self) -> &Texture {
        match self {
            Self::Radiance(texture) | Self::Thermal(texture) => texture,
        }
    }

    /// Whether it sends out nothing within a range of wavelengths.
    pub fn is_zero(&self, range: WavelengthRange) -> bool {
        self.texture().is_zero(range)
    }
}

impl Medium {
    /// What the medium sends out at a place along a ray, per unit of length. Zero outside of grids.
    pub fn emitted_at<const C: usize>(&self, position: Vec3, direction: Vec3, nm: &[f64; C]) -> Sampled<C> {
        let Some(emission) = &self.emission else { return Sampled::ZERO };
        let at = TexturePoint::in_space(position);
        if grid_of(emission.texture()).is_some_and(|grid| !grid.holds(position)) {
            return Sampled::ZERO;
        }
        match emission {
            Emission::Radiance(texture) => texture.sample(&at, nm),
            Emission::Thermal(temperature) => {
                let kelvin = temperature.value(&at);
                if kelvin <= 0.0 {
                    return Sampled::ZERO;
                }
                let albedo = match &self.scattering {
                    Some(scattering) => scattering.albedo(position, nm),
                    None => Sampled::ZERO,
                };
                let absorbed = self.extinction_at(position, direction, nm) * (Sampled::ONE - albedo);
                absorbed * Sampled::from_fn(|lane| blackbody_radiance(nm[lane], kelvin))
            }
        }
    }

    /// What a path finds of the medium's light on a segment of its flight, weighed over its wavelengths.
    pub fn emission_along<const C: usize>(&self, segment: &Segment<C>) -> Sampled<C> {
        let Segment { ray, carried, ratio, place, nm } = *segment;
        let Some([start, end]) = self.emitting_part(ray) else { return Sampled::ZERO };
        if !end.is_finite() {
            return self.along_endless(segment, start);
        }
        // More points lower the noise where little is scattered, which is where paths fly far.
        const POINTS: u32 = 4;
        let step = (end - start) / f64::from(POINTS);
        let (mut sum, mut depths, mut reached) = (Sampled::ZERO, Sampled::ZERO, 0.0);
        for point in 0..POINTS {
            let t = start + step * (f64::from(point) + place);
            depths += self
                .optical_depths(&Ray { t_max: t - reached, ..Ray::new(ray.at(reached), ray.direction) }, nm);
            reached = t;
            let emitted = self.emitted_at(ray.at(t), ray.direction, nm);
            sum += emitted * self.weighed(carried, ratio, depths);
        }
        sum * step
    }

    /// Along a ray without end, by a point at a distance that is distributed exponentially.
    fn along_endless<const C: usize>(&self, segment: &Segment<C>, start: f64) -> Sampled<C> {
        let Segment { ray, carried, ratio, place, nm } = *segment;
        let near = self.extinction_at(ray.at(start), ray.direction, nm);
        let least = near.0.into_iter().filter(|&sigma| sigma > 0.0).fold(f64::INFINITY, f64::min);
        let rate = if least.is_finite() { least } else { 1.0 };
        let distance = -(1.0 - place).ln() / rate;
        let depths = self.optical_depths(&Ray { t_max: start + distance, ..*ray }, nm);
        let emitted = self.emitted_at(ray.at(start + distance), ray.direction, nm);
        emitted * self.weighed(carried, ratio, depths) * ((rate * distance).exp() / rate)
    }

    /// What is carried behind some optical depths over the sum of the densities there.
    fn weighed<const C: usize>(
        &self,
        carried: Sampled<C>,
        ratio: Sampled<C>,
        depths: Sampled<C>,
    ) -> Sampled<C> {
        if self.scattering.is_none() {
            return carried * (-depths).exp() * (1.0 / ratio.sum());
        }
        let over_hero = (Sampled::splat(depths.hero()) - depths).exp();
        carried * over_hero * (1.0 / (ratio * over_hero).sum())
    }

    /// The part of a ray outside of which nothing is sent out. `None` where nothing is at all.
    fn emitting_part(&self, ray: &Ray) -> Option<[f64; 2]> {
        let emission = self.emission.as_ref()?;
        let whole = Some([0.0, ray.t_max]);
        let lit = match grid_of(emission.texture()) {
            Some(volume) => span(volume, ray),
            None => whole,
        };
        let thick = match (emission, &self.extinction) {
            (Emission::Thermal(_), Extinction::Grid(grid)) => grid.span(ray),
            (Emission::Thermal(_), Extinction::Diluted(diluted)) => diluted.density.span(ray),
            _ => whole,
        };
        let ([a, b], [c, d]) = (lit?, thick?);
        let (start, end) = (a.max(c), b.min(d));
        (start < end).then_some([start, end])
    }
}

/// The grid that a texture shows, if it is one.
fn grid_of(texture: &Texture) -> Option<&Volume> {
    match texture {
        Texture::Volume(volume) => Some(volume),
        Texture::Filtered { texture, .. } => grid_of(texture),
        _ => None,
    }
}
