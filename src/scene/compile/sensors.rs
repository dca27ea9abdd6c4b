//! The sensor: which rays it measures, on which film, and which wavelengths matter to it.

use super::{Compiler, place, spectra};
use crate::camera::{
    Camera, Distant, IrradianceMeter, Projection, Projective, ProjectiveSettings, RadianceMeter, Rays,
    ThinLens, View, Window,
};
use crate::geometry::{Bounds, Transform, Vec3};
use crate::scene::description::{
    self, DistantTarget, FieldOfView, FilmContent, FovAxis, Sensor, SensorKind, SpectrumKind,
};
use crate::scene::source::SceneError;
use crate::scene::traceable::{FilmChannel, FilmPlan};
use crate::shape::Shape;
use crate::spectrum::{Extrapolation, Spectrum};
use crate::units::WavelengthRange;

/// By this factor Mitsuba 3 enlarges the sphere around a scene that a distant sensor looks at.
const SPHERE_MARGIN: f64 = 1.0 + 1500.0 / 16_777_216.0;

impl description::Film {
    /// All wavelengths that can be seen or that the film has a response to.
    pub fn wavelength_range(&self) -> WavelengthRange {
        let visible = WavelengthRange::VISIBLE;
        let FilmContent::Responses(channels) = &self.content else { return visible };
        channels.iter().fold(visible, |range, channel| {
            let (min, max) = match &channel.response.kind {
                SpectrumKind::Irregular { nm, .. } => (nm[0], nm[nm.len() - 1]),
                SpectrumKind::Regular { min_nm, max_nm, .. } => (*min_nm, *max_nm),
                _ => return range,
            };
            WavelengthRange { min: range.min.min(min), max: range.max.max(max) }
        })
    }
}

/// A film as a sensor is told of it: one of a batch has one of its own, which its column shows.
#[derive(Clone, Copy)]
struct FilmShare {
    /// Pixels of the whole film.
    size: [f64; 2],
    exposed: Window,
}

impl Compiler<'_> {
    pub(super) fn film(&mut self) -> FilmPlan {
        let film = &self.description.sensor.film;
        let full_size = [film.width, film.height];
        let (size, offset) = match film.crop {
            Some(crop) => ([crop.width, crop.height], [crop.x, crop.y]),
            None => (full_size, [0, 0]),
        };
        let (alpha, channels) = match &film.content {
            FilmContent::Colour { alpha, .. } => (*alpha, Vec::new()),
            FilmContent::Responses(channels) => {
                (false, channels.iter().filter_map(|channel| self.channel(channel)).collect())
            }
        };
        let (filter, sample_border) = (film.filter, film.sample_border);
        FilmPlan { size, offset, full_size, filter, sample_border, alpha, channels }
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

    fn sensor_spectrum(&mut self, source: &description::SpectrumSource) -> Option<Spectrum> {
        spectra::spectrum(source).map_err(|error| self.errors.push(error)).ok()
    }

    /// `None` where the sensor is wrong, which is reported. `scene` bounds all shapes, once moved by `shift`.
    pub(super) fn camera(&mut self, shift: &Transform, scene: Bounds) -> Option<Camera> {
        let sensor = &self.description.sensor;
        let film = &sensor.film;
        let size = [film.width, film.height].map(f64::from);
        let exposed = film.crop.map_or(Window { offset: [0.0; 2], size }, |crop| Window {
            offset: [crop.x, crop.y].map(f64::from),
            size: [crop.width, crop.height].map(f64::from),
        });
        let SensorKind::Batch(sensors) = &sensor.kind else {
            return self.view(sensor, FilmShare { size, exposed }, shift, scene).map(Camera::single);
        };
        let column = [size[0] / sensors.len() as f64, size[1]];
        let share = FilmShare { size: column, exposed: Window { offset: [0.0; 2], size: column } };
        let views: Vec<_> = sensors.iter().map(|sensor| self.view(sensor, share, shift, scene)).collect();
        let views: Option<Vec<View>> = views.into_iter().collect();
        Some(Camera::side_by_side(views?, exposed, column))
    }

    fn view(&mut self, sensor: &Sensor, film: FilmShare, shift: &Transform, scene: Bounds) -> Option<View> {
        let response = match &sensor.response {
            Some(response) => Some(self.sensor_spectrum(response)?),
            None => None,
        };
        let projective = |projection, to_world: &Transform, half_width, principal_point, clips: [f64; 2]| {
            Rays::Projective(Projective::new(ProjectiveSettings {
                to_world: to_world.then(shift),
                projection,
                film: film.size,
                half_width,
                principal_point,
                near_clip: clips[0],
                far_clip: clips[1],
            }))
        };
        let rays = match &sensor.kind {
            SensorKind::Perspective {
                to_world,
                field_of_view,
                principal_point,
                near_clip,
                far_clip,
                lens,
            } => {
                let projection = lens.map_or(Projection::Pinhole, |lens| {
                    let (aperture_radius, focus_distance) = (lens.aperture_radius, lens.focus_distance);
                    Projection::ThinLens(ThinLens { aperture_radius, focus_distance })
                });
                let half_width = tan_half_width(*field_of_view, film.size);
                projective(projection, to_world, half_width, *principal_point, [*near_clip, *far_clip])
            }
            SensorKind::Orthographic { to_world, near_clip, far_clip } => {
                projective(Projection::Orthographic, to_world, 1.0, [0.0; 2], [*near_clip, *far_clip])
            }
            SensorKind::RadianceMeter { origin, direction } => {
                Rays::Radiance(RadianceMeter::new(shift.point(*origin), *direction))
            }
            SensorKind::IrradianceMeter { surface } => {
                let surface = self.measured_surface(surface, shift)?;
                Rays::Irradiance(Box::new(IrradianceMeter::new(surface, film.exposed)))
            }
            SensorKind::Distant { direction, target } => {
                Rays::Distant(Box::new(self.distant(*direction, target, shift, scene)?))
            }
            // The reader refuses a batch in a batch.
            SensorKind::Batch(_) => return None,
        };
        Some(View { rays, response })
    }

    fn distant(
        &mut self,
        direction: Vec3,
        target: &DistantTarget,
        shift: &Transform,
        scene: Bounds,
    ) -> Option<Distant> {
        let (centre, radius) = if scene.is_empty() {
            (Vec3::ZERO, 1.0)
        } else {
            (scene.centre(), 0.5 * scene.diameter() * SPHERE_MARGIN)
        };
        Some(match target {
            DistantTarget::Scene => Distant::at_sphere(direction, centre, radius),
            DistantTarget::Point(point) => Distant::at_point(direction, shift.point(*point), 2.0 * radius),
            DistantTarget::Surface(surface) => {
                Distant::at_surface(direction, self.measured_surface(surface, shift)?, 2.0 * radius)
            }
        })
    }

    /// A surface that a sensor measures at, where points can be chosen.
    fn measured_surface(&mut self, shape: &description::Shape, shift: &Transform) -> Option<Shape> {
        let surface = self.keep(&shape.place, place(shape, &shape.to_world.then(shift)))?;
        let area = surface.area();
        if area > 0.0 && area.is_finite() {
            return Some(surface);
        }
        self.errors.push(SceneError::at(
            &shape.place,
            "The shape has no area to measure at",
            "expected a surface of positive, finite area",
        ));
        None
    }

    /// What the sensor sees of each wavelength: for each of its channels a response and its share.
    pub(super) fn responses(&self, camera: &Camera, film: &FilmPlan) -> Vec<(Spectrum, f64)> {
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
    pub(super) fn product(&self, a: &Spectrum, b: &Spectrum) -> Spectrum {
        let range = self.options.range;
        let steps = range.width().ceil().max(1.0) as usize;
        let grid = (0..=steps).map(|i| range.min + range.width() * i as f64 / steps as f64);
        let mut nm: Vec<f64> =
            grid.chain(a.nodes()).chain(b.nodes()).filter(|nm| range.contains(*nm)).collect();
        nm.sort_by(f64::total_cmp);
        nm.dedup();
        let values: Vec<f64> = nm.iter().map(|&nm| a.at(nm) * b.at(nm)).collect();
        Spectrum::irregular(&nm, &values, Extrapolation::Zero).unwrap_or(Spectrum::ONE)
    }
}

/// Tangent of half the horizontal field of view, for a film of this width and height.
pub(super) fn tan_half_width(fov: FieldOfView, [width, height]: [f64; 2]) -> f64 {
    let diagonal = width.hypot(height);
    match fov {
        // Half of the diagonal of 36 mm × 24 mm over the focal length, along the film's own diagonal (Mitsuba 3).
        FieldOfView::FocalLength(mm) => 0.5 * 36f64.hypot(24.0) / mm * width / diagonal,
        FieldOfView::Degrees { angle, axis } => {
            let edge = match axis {
                FovAxis::X => width,
                FovAxis::Y => height,
                FovAxis::Diagonal => diagonal,
                FovAxis::Smaller => width.min(height),
                FovAxis::Larger => width.max(height),
            };
            (0.5 * angle).to_radians().tan() * width / edge
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Horizontal field of view in degrees.
    fn x_fov(fov: FieldOfView, film: [f64; 2]) -> f64 {
        2.0 * tan_half_width(fov, film).atan().to_degrees()
    }

    #[test]
    fn fields_of_view_are_mitsubas() {
        // Seen in Mitsuba 3.9.1 (validation/mitsuba/FACTS.md, 4 to 6).
        assert!((x_fov(FieldOfView::FocalLength(50.0), [768.0, 576.0]) - 38.1848).abs() < 1e-4);
        assert!((x_fov(FieldOfView::FocalLength(35.0), [200.0, 100.0]) - 57.8712).abs() < 1e-4);
        let degrees = |axis| x_fov(FieldOfView::Degrees { angle: 30.0, axis }, [200.0, 100.0]);
        assert!((degrees(FovAxis::X) - 30.0).abs() < 1e-12);
        assert!((degrees(FovAxis::Y) - 56.3736).abs() < 1e-4);
        assert!((degrees(FovAxis::Smaller) - 56.3736).abs() < 1e-4);
        assert!((degrees(FovAxis::Larger) - 30.0).abs() < 1e-12);
        assert!((degrees(FovAxis::Diagonal) - 26.9547).abs() < 1e-4);
    }
}
