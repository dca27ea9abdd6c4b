//! Transmittance between two points: through media, and through surfaces with null transmission.

use super::Intersection;
use super::coincident::{InterfaceEvent, Onward};
use super::counting::RayKind;
use super::scene::{Role, Scene};
use crate::geometry::Ray;
use crate::medium::{Media, Medium, MediumStack};
use crate::spectrum::{Sampled, Wavelengths};

/// Transmission along a ray.
#[derive(Clone, Copy, Debug)]
pub struct Passage<const C: usize> {
    /// The fraction of the light that gets through.
    pub transmittance: Sampled<C>,
    /// The probability with which a path that goes the same way passes all media that scatter, for each
    /// wavelength as its hero.
    pub flown: Sampled<C>,
}

impl Scene {
    /// The medium that surrounds a ray, if there is one that does anything.
    pub fn medium(&self, media: &MediumStack) -> Option<&Medium> {
        self.media[media.medium(&self.bodies)? as usize].as_ref()
    }

    /// The number of that medium, from 0.
    pub fn medium_number(&self, media: &MediumStack) -> Option<u32> {
        media.medium(&self.bodies).filter(|&medium| self.media[medium as usize].is_some())
    }

    /// Transmittance of the medium that surrounds a ray, from its beginning to its end. `None` where there is
    /// no medium.
    pub fn transmittance<const C: usize>(
        &self,
        media: &MediumStack,
        segment: &Ray,
        wavelengths: &Wavelengths<C>,
    ) -> Option<Sampled<C>> {
        if !self.features.absorption {
            return None;
        }
        Some(transmittance(self.medium(media)?, segment, wavelengths))
    }

    /// Transmittance along a ray that begins in `media`: that of the media, and of at most `crossings`
    /// surfaces with null transmission. Zero where another surface is in the way. And the probability of
    /// passing the media that scatter.
    pub fn passage<const C: usize>(
        &self,
        ray: &Ray,
        time: f64,
        media: &MediumStack,
        wavelengths: &Wavelengths<C>,
        crossings: u32,
    ) -> Passage<C> {
        self.transmission(ray, time, media, wavelengths, crossings, RayKind::Shadow)
    }

    /// Transmittance of a segment that several paths share, where every surface blocks light.
    pub fn transmittance_between_surfaces<const C: usize>(
        &self,
        ray: &Ray,
        time: f64,
        media: &MediumStack,
        wavelengths: &Wavelengths<C>,
    ) -> Sampled<C> {
        self.transmission(ray, time, media, wavelengths, 0, RayKind::Shared).transmittance
    }

    #[inline(always)]
    fn transmission<const C: usize>(
        &self,
        ray: &Ray,
        time: f64,
        media: &MediumStack,
        wavelengths: &Wavelengths<C>,
        mut crossings: u32,
        kind: RayKind,
    ) -> Passage<C> {
        let none = Passage { transmittance: Sampled::ZERO, flown: Sampled::ZERO };
        let mut passage = Passage { transmittance: Sampled::ONE, flown: Sampled::ONE };
        let within = |passage: &mut Passage<C>, media: &MediumStack, segment: &Ray| {
            passage.attenuate(self, media, segment, wavelengths);
        };
        if crossings == 0 && !self.features.interface_events() {
            if self.occluded(kind.begins(), ray, time) {
                return none;
            }
            within(&mut passage, media, ray);
            return passage;
        }
        let (mut ray, mut media) = (*ray, Media::of(media.clone()));
        let (mut query, mut onward) = (kind.begins(), Onward::default());
        while let Some(mut hit) = self.meet(query, &ray, time) {
            query.begins = false;
            let event = match self.features.interface_events() {
                true => self.interface_event(&ray, time, &mut hit, &mut media),
                false => InterfaceEvent::Surface,
            };
            let before = Ray { t_max: hit.t, ..ray };
            match event {
                InterfaceEvent::Surface => {
                    // What ends the way is in contact with the light that it leads to.
                    if hit.light.is_some() && hit.t >= ray.t_max {
                        break;
                    }
                    let surface = self.surface(&hit);
                    if crossings == 0 || !surface.null_transmission {
                        return none;
                    }
                    crossings -= 1;
                    // Light passes a mere boundary of media as it is.
                    if surface.role != Role::Null {
                        passage.transmittance *= self.null_transmittance(&hit, &ray, &media, wavelengths);
                        if passage.transmittance.is_zero() {
                            return none;
                        }
                    }
                    within(&mut passage, &media.here, &before);
                    self.pass_through(&hit, ray.direction, &mut media);
                }
                InterfaceEvent::NullTransmission => {
                    within(&mut passage, &media.here, &before);
                    media.cross();
                }
                InterfaceEvent::Handled => within(&mut passage, &media.here, &before),
            }
            ray = onward.rest(&hit, &ray);
        }
        within(&mut passage, &media.here, &ray);
        passage
    }

    /// Null transmittance of a surface that a ray has met within some media.
    fn null_transmittance<const C: usize>(
        &self,
        hit: &Intersection,
        ray: &Ray,
        media: &Media,
        wavelengths: &Wavelengths<C>,
    ) -> Sampled<C> {
        let (material, at) = (self.surface(hit).material, self.shading_point(hit));
        let exterior = self.exterior(hit, media);
        self.materials.null_transmittance(material, &at, -ray.direction, &wavelengths.nm, exterior)
    }
}

impl<const C: usize> Passage<C> {
    /// On through the medium that surrounds a segment, if there is one.
    #[inline(always)]
    fn attenuate(&mut self, scene: &Scene, media: &MediumStack, segment: &Ray, wavelengths: &Wavelengths<C>) {
        if !scene.features.absorption {
            return;
        }
        let Some(medium) = scene.medium(media) else { return };
        let part = transmittance(medium, segment, wavelengths);
        self.transmittance *= part;
        if medium.scattering.is_some() {
            self.flown *= part;
        }
    }
}

/// Transmittance of a medium along a ray (Beer and Lambert).
pub(super) fn transmittance<const C: usize>(
    medium: &Medium,
    segment: &Ray,
    wavelengths: &Wavelengths<C>,
) -> Sampled<C> {
    (-medium.optical_depths(segment, &wavelengths.nm)).exp()
}
