//! The film of a scene, and which wavelengths matter to the sensor.

use super::super::{Compiler, Crop, spectra};
use crate::camera::{Camera, View};
use crate::film::{Extent, Region};
use crate::scene::description::{self, FilmContent, SpectrumKind};
use crate::scene::source::SceneError;
use crate::scene::{FilmChannel, FilmPlan};
use crate::spectrum::{Extrapolation, Spectrum};
use crate::units::WavelengthRange;

impl description::Film {
    /// All wavelengths that can be seen or that the film has a response to.
    pub fn wavelength_range(&self) -> WavelengthRange {
        let visible = WavelengthRange::VISIBLE;
        let FilmContent::Responses(channels) = &self.content else { return visible };
        let all = channels.iter().fold(visible, |range, channel| {
            let (min, max) = match &channel.response.kind {
                SpectrumKind::Irregular { nm, .. } => (nm[0], nm[nm.len() - 1]),
                SpectrumKind::Regular { min_nm, max_nm, .. } => (*min_nm, *max_nm),
                _ => return range,
            };
            WavelengthRange { min: range.min.min(min), max: range.max.max(max) }
        });
        all.common(WavelengthRange::WIDEST)
    }
}

impl Compiler<'_> {
    pub(in crate::scene::compile) fn film(&mut self) -> FilmPlan {
        let film = &self.description.sensor.film;
        let window = film.window();
        let (shown, margin, square) = match self.options.part {
            Some(Crop { shown, margin, square }) => (self.within_window(shown, window), margin, square),
            None => (window, 0, 1),
        };
        let measured = shown.grown(margin, window).aligned(square, window).grown(margin, window);
        let extent = Extent { whole: [film.width, film.height], window, measured, shown };
        let (alpha, channels) = match &film.content {
            FilmContent::Colour { alpha, .. } => (*alpha, Vec::new()),
            FilmContent::Responses(channels) => {
                (false, channels.iter().filter_map(|channel| self.channel(channel)).collect())
            }
        };
        let (filter, sample_border) = (film.filter, film.sample_border);
        let moments = self.description.integrator.moments.is_some();
        FilmPlan { extent, filter, sample_border, alpha, moments, channels }
    }

    /// The part that is asked for, if there is such a part.
    fn within_window(&mut self, shown: Region, window: Region) -> Region {
        if shown.pixel_count() > 0 && window.holds(shown) {
            return shown;
        }
        let film = &self.description.sensor.film;
        let told = |Region { offset: [x, y], size: [width, height] }: Region| {
            format!("{width}×{height} pixels at {x},{y}")
        };
        let what = if film.crop.is_some() { "crop window" } else { "film" };
        let remedy = match film.crop {
            Some(_) => "parts are counted from the corner of the whole film, not of the window",
            None => "give another part, or --size another film",
        };
        self.errors.push(SceneError {
            // The file is right: it is the command line that asks for the part.
            place: None,
            problem: format!("--crop: the part to render, {}, is not within the {what}", told(shown)),
            expected: format!("expected a part of its {}", told(window)),
            remedy: Some(remedy.to_owned()),
        });
        window
    }

    fn channel(&mut self, channel: &description::FilmChannel) -> Option<FilmChannel> {
        let response = self.sensor_spectrum(&channel.response)?;
        let integral = response.integral(self.options.range);
        if integral > 0.0 {
            return Some(FilmChannel { name: channel.name.clone(), response, integral });
        }
        let range = self.options.range;
        self.errors.push(SceneError::at(
            &channel.response.place,
            format!(
                "The channel \"{}\" does not respond between {} and {} nm",
                channel.name, range.min, range.max
            ),
            "expected a response to some wavelength that is simulated",
        ));
        None
    }

    pub(super) fn sensor_spectrum(&mut self, source: &description::SpectrumSource) -> Option<Spectrum> {
        spectra::spectrum(source).map_err(|error| self.errors.push(error)).ok()
    }

    /// What the sensor sees of each wavelength: for each of its channels a response and its share.
    pub(in crate::scene::compile) fn responses(
        &self,
        camera: &Camera,
        film: &FilmPlan,
    ) -> Vec<(Spectrum, f64)> {
        let [x, y, z] = self.options.observer.spectra();
        let mut channels: Vec<(Spectrum, f64)> = if film.channels.is_empty() {
            // Luminance counts double.
            vec![(x, 1.0), (y, 2.0), (z, 1.0)]
        } else {
            // Colours are for the preview alone.
            let own = film.channels.iter().map(|channel| (channel.response.clone(), 1.0));
            own.chain([x, y, z].map(|spectrum| (spectrum, 0.03))).collect()
        };
        if self.options.spectral {
            // As much as all colours together.
            channels.push((Spectrum::ONE, 4.0));
        }
        let seen = |view: &View| -> Vec<(Spectrum, f64)> {
            match &view.response {
                None => channels.clone(),
                Some(factor) => {
                    channels.iter().map(|(channel, w)| (self.product(channel, factor), *w)).collect()
                }
            }
        };
        camera.views().iter().flat_map(seen).collect()
    }

    /// The product of two spectra, good enough to choose wavelengths by.
    pub(in crate::scene::compile) fn product(&self, a: &Spectrum, b: &Spectrum) -> Spectrum {
        let at = |nm: f64| a.at(nm) * b.at(nm);
        Spectrum::tabulated(self.options.range, 1.0, &[a, b], Extrapolation::Zero, at)
            .unwrap_or(Spectrum::ONE)
    }
}
