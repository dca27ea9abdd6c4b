//! How much light gets from one place to another: through media, and past surfaces that let it pass straight.

use super::coincident::InterfaceEvent;
use super::scene::Scene;
use crate::geometry::Ray;
use crate::medium::{Media, Medium, MediumStack};
use crate::spectrum::{Sampled, Wavelengths};

/// What gets along a ray.
#[derive(Clone, Copy, Debug)]
pub struct Passage<const C: usize> {
    /// The share of the light.
    pub share: Sampled<C>,
    /// The probability with which a path that goes the same way passes all media that scatter, for each
    /// wavelength as its hero.
    pub flown: Sampled<C>,
}

impl Scene {
    /// The medium that surrounds a ray, if there is one that does anything.
    pub fn medium(&self, media: &MediumStack) -> Option<&Medium> {
        self.media[media.medium(&self.bodies)? as usize].as_ref()
    }

    /// The share that what surrounds a ray lets through from its beginning to its end; `None` where that is
    /// nothing.
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

    /// The share of light that gets along a ray that begins in `media`: through media, and through surfaces
    /// that let light pass straight where the scene has shadow rays go on through them. Zero where anything
    /// is in the way.
    pub fn visibility<const C: usize>(
        &self,
        ray: &Ray,
        time: f64,
        media: &MediumStack,
        wavelengths: &Wavelengths<C>,
    ) -> Sampled<C> {
        self.transmission(ray, time, media, wavelengths, self.features.transparent_shadows).share
    }

    /// The same, with the part that media which scatter have in it.
    pub fn passage<const C: usize>(
        &self,
        ray: &Ray,
        time: f64,
        media: &MediumStack,
        wavelengths: &Wavelengths<C>,
    ) -> Passage<C> {
        self.transmission(ray, time, media, wavelengths, self.features.transparent_shadows)
    }

    /// The share of light where every surface is in the way.
    pub fn transmittance_between_surfaces<const C: usize>(
        &self,
        ray: &Ray,
        time: f64,
        media: &MediumStack,
        wavelengths: &Wavelengths<C>,
    ) -> Sampled<C> {
        self.transmission(ray, time, media, wavelengths, false).share
    }

    #[inline(always)]
    fn transmission<const C: usize>(
        &self,
        ray: &Ray,
        time: f64,
        media: &MediumStack,
        wavelengths: &Wavelengths<C>,
        transparent_shadows: bool,
    ) -> Passage<C> {
        let none = Passage { share: Sampled::ZERO, flown: Sampled::ZERO };
        let mut passage = Passage { share: Sampled::ONE, flown: Sampled::ONE };
        let within = |passage: &mut Passage<C>, media: &MediumStack, segment: &Ray| {
            if !self.features.absorption {
                return;
            }
            let Some(medium) = self.medium(media) else { return };
            let part = transmittance(medium, segment, wavelengths);
            passage.share *= part;
            if medium.scattering.is_some() {
                passage.flown *= part;
            }
        };
        if !transparent_shadows && !self.features.interface_events() {
            if self.accel.occluded(ray, time) {
                return none;
            }
            within(&mut passage, media, ray);
            return passage;
        }
        let (mut ray, mut media) = (*ray, Media::of(media.clone()));
        while let Some(mut hit) = self.meet(&ray, time) {
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
                    if !(transparent_shadows && surface.null_transmission) {
                        return none;
                    }
                    let exterior = self.exterior(&hit, &media);
                    let at = self.shading_point(&hit);
                    let toward_eye = -ray.direction;
                    passage.share *= self.materials.null_transmittance(
                        surface.material,
                        &at,
                        toward_eye,
                        &wavelengths.nm,
                        exterior,
                    );
                    if passage.share.is_zero() {
                        return none;
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
            ray = hit.point.rest_of(&ray);
        }
        within(&mut passage, &media.here, &ray);
        passage
    }
}

/// The share that a medium lets through along a ray (Beer and Lambert).
pub(super) fn transmittance<const C: usize>(
    medium: &Medium,
    segment: &Ray,
    wavelengths: &Wavelengths<C>,
) -> Sampled<C> {
    medium.optical_depths(segment, &wavelengths.nm).map(|depth| (-depth).exp())
}
