//! The sensor: which rays it measures, on which film, and which wavelengths matter to it.

use super::{Compiler, Crop, shapes, spectra};
use crate::camera::{
    Angular, Aperture, Camera, DirectionMap, Distant, IrradianceMeter, Projection, Projective,
    ProjectiveSettings, RadianceMeter, Rays, SensorPlane, ThinLens, View, Window,
};
use crate::film::{Extent, Region};
use crate::geometry::{Bounds, Motion, Placed, Transform, Vec3};
use crate::scene::description::{
    self, AngularMap, DistantTarget, FieldOfView, FilmContent, FovAxis, Lens, Sensor, SensorKind,
    SpectrumKind,
};
use crate::scene::scene::{FilmChannel, FilmPlan};
use crate::scene::source::SceneError;
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
        let error = SceneError::at(
            &film.place,
            format!("The part to render, {}, is not within the {what}", told(shown)),
            format!("expected a part of its {}", told(window)),
        );
        self.errors.push(match film.crop {
            Some(_) => {
                error.with_remedy("parts are counted from the corner of the whole film, not of the window")
            }
            None => error,
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

    fn sensor_spectrum(&mut self, source: &description::SpectrumSource) -> Option<Spectrum> {
        spectra::spectrum(source).map_err(|error| self.errors.push(error)).ok()
    }

    /// `None` where the sensor is wrong, which is reported. `scene` bounds all shapes, once moved by `shift`.
    pub(super) fn camera(&mut self, shift: &Transform, scene: Bounds) -> Option<Camera> {
        let sensor = &self.description.sensor;
        let film = &sensor.film;
        let size = [film.width, film.height].map(f64::from);
        let window = film.window();
        let exposed = Window { offset: window.offset.map(f64::from), size: window.size.map(f64::from) };
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
        let projective = |projection, placed, half_width, principal_point, clips: [f64; 2]| {
            Rays::Projective(Box::new(Projective::new(ProjectiveSettings {
                placed,
                projection,
                film: film.size,
                half_width,
                principal_point,
                near_clip: clips[0],
                far_clip: clips[1],
            })))
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
                // In a batch the angle is that on the sensor's own film, which else does not count (Mitsuba
                // 3.9.1).
                let own_film = [sensor.film.width, sensor.film.height].map(f64::from);
                let half_width = tan_half_width(*field_of_view, own_film);
                let placed = self.camera_placed(sensor, to_world, shift)?;
                let projection = lens.map_or(Projection::Pinhole, |lens| {
                    let focus_distance = lens.focus_distance;
                    let aperture = aperture(&lens, focal_length(half_width, own_film));
                    Projection::ThinLens(ThinLens { aperture, focus_distance })
                });
                projective(projection, placed, half_width, *principal_point, [*near_clip, *far_clip])
            }
            SensorKind::Orthographic { to_world, near_clip, far_clip } => {
                let placed = self.camera_placed(sensor, to_world, shift)?;
                projective(Projection::Orthographic, placed, 1.0, [0.0; 2], [*near_clip, *far_clip])
            }
            SensorKind::Angular { to_world, map, near_clip, far_clip } => {
                let placed = self.camera_placed(sensor, to_world, shift)?;
                let map = match *map {
                    AngularMap::Fisheye { projection, fov } => {
                        DirectionMap::Fisheye { projection, half_angle: 0.5 * fov.to_radians() }
                    }
                    AngularMap::Panorama { fov } => {
                        DirectionMap::Panorama { angles: fov.map(f64::to_radians) }
                    }
                };
                Rays::Angular(Box::new(Angular::new(placed, map, film.size, [*near_clip, *far_clip])))
            }
            SensorKind::Plane { to_world, width, stop } => {
                let placed = self.camera_placed(sensor, to_world, shift)?;
                Rays::Plane(Box::new(SensorPlane::new(placed, film.size, *width, *stop)))
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

    /// Where a camera stands over time.
    fn camera_placed(&mut self, sensor: &Sensor, to_world: &Transform, shift: &Transform) -> Option<Placed> {
        let placed = match sensor.motion.as_ref().and_then(|motion| Motion::new(&motion.keys).ok()) {
            None => Placed::still(&to_world.then(shift)),
            Some(motion) => Placed::moving(motion.recentred(Vec3::ZERO, shift.point(Vec3::ZERO))),
        };
        if placed.is_none() {
            self.errors.push(SceneError::at(
                &sensor.place,
                "The transform of the camera distorts too much to compute with",
                "expected one that only rotates, moves and scales a little",
            ));
        }
        placed
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
    fn measured_surface(
        &mut self,
        shape: &description::ShapeDescription,
        shift: &Transform,
    ) -> Option<Shape> {
        if let Some(motion) = &shape.motion {
            let problem = "A sensor measures on a shape that moves";
            let error = SceneError::at(&motion.place, problem, "expected a shape that stands still");
            self.errors.push(error.with_remedy("give it a <transform> in place of the <animation>"));
            return None;
        }
        let surface = shapes::place(shape, &shape.to_world.then(shift), shape.flip_normals, false);
        let surface = self.keep(&shape.place, surface)?;
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
        // Half of the diagonal of 36 mm × 24 mm over the focal length, along the film's own diagonal (Mitsuba
        // 3).
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

/// The focal length in millimetres that sees this half width at distance 1: the inverse of
/// [`tan_half_width`], whatever the field of view was told by.
fn focal_length(half_width: f64, [width, height]: [f64; 2]) -> f64 {
    0.5 * 36f64.hypot(24.0) / half_width * width / width.hypot(height)
}

fn aperture(lens: &Lens, focal_length_mm: f64) -> Aperture {
    let radius = match lens.aperture {
        description::Aperture::Radius(radius) => radius,
        description::Aperture::Stop(stop) => 1e-3 * focal_length_mm / (2.0 * stop),
    };
    match lens.blades {
        0 => Aperture::Disk { radius },
        blades => Aperture::Polygon { radius, blades, rotation: lens.rotation.to_radians() },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{CompileOptions, ReadOptions, Scene, compile, read_str};
    use std::path::Path;

    fn scene(content: &str) -> Scene {
        let text = format!(r#"<scene version="3.0.0">{content}</scene>"#);
        let description = read_str(text, Path::new("scene.xml"), &ReadOptions::default());
        let description = description.unwrap_or_else(|errors| panic!("{errors}"));
        compile(&description, &CompileOptions::default()).unwrap_or_else(|errors| panic!("{errors}"))
    }

    const FILM: &str =
        r#"<film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="4"/></film>"#;
    const PIXEL: &str =
        r#"<film type="hdrfilm"><integer name="width" value="1"/><integer name="height" value="1"/></film>"#;

    /// Origin, direction and weight of the ray at a place of the exposed film, and its length.
    fn ray(scene: &Scene, place: [f64; 2], second: [f64; 2]) -> ([f64; 3], [f64; 3], f64, f64) {
        let window = scene.film.extent.window;
        let film = [0, 1].map(|i| f64::from(window.offset[i]) + place[i] * f64::from(window.size[i]));
        let seen = scene.camera.ray(film, second, scene.shutter.open).unwrap();
        (seen.ray.origin.into(), seen.ray.direction.into(), seen.weight, seen.ray.t_max)
    }

    /// Plugin, content of the sensor, and origin, direction and length of a ray.
    type Case = (&'static str, String, [f64; 3], [f64; 3], f64);

    #[track_caller]
    fn assert_near(found: [f64; 3], seen: [f64; 3], tolerance: f64) {
        assert!(found.iter().zip(seen).all(|(a, b)| (a - b).abs() < tolerance), "{found:?} {seen:?}");
    }

    #[test]
    fn cameras_have_mitsubas_rays() {
        // `sensor.sample_ray` of Mitsuba 3.9.1 (scalar_spectral) for the place (.25, .25) of the film and
        // (.3, .9) of the lens.
        let crop = r#"<film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="4"/>
            <integer name="crop_width" value="4"/><integer name="crop_height" value="2"/>
            <integer name="crop_offset_x" value="1"/><integer name="crop_offset_y" value="2"/></film>"#;
        let fov = r#"<float name="fov" value="40"/>"#;
        let principal = r#"<float name="principal_point_offset_x" value=".25"/>
            <float name="principal_point_offset_y" value=".125"/>"#;
        let lens = r#"<float name="aperture_radius" value="1"/><float name="focus_distance" value="3"/>"#;
        let stretched = r#"<transform name="to_world"><scale x="2" y="3" z="4"/></transform>"#;
        let cases: [Case; 8] = [
            (
                "perspective",
                format!("{fov}{FILM}"),
                [0.00181985, 0.00090993, 0.01],
                [0.17833126, 0.08916563, 0.9799222],
                10204.8818359375,
            ),
            (
                "perspective",
                format!(r#"<float name="near_clip" value="1"/><float name="far_clip" value="5"/>{FILM}"#),
                [0.19349422, 0.09674711, 1.0],
                [0.18911943, 0.09455971, 0.9773906],
                4.092529773712158,
            ),
            (
                "perspective",
                format!("{fov}{crop}"),
                [0.00181985, -0.00045496, 0.01],
                [0.17886531, -0.04471631, 0.9828568],
                10174.412109375,
            ),
            (
                "perspective",
                format!(r#"{fov}<string name="fov_axis" value="y"/>{crop}"#),
                [0.0036397, -0.00090993, 0.01],
                [0.34077668, -0.08519413, 0.9362762],
                10680.59765625,
            ),
            (
                "perspective",
                format!("{principal}{crop}"),
                [0.0, -0.00096747, 0.01],
                [0.0, -0.09629744, 0.99535263],
                10046.6806640625,
            ),
            (
                "thinlens",
                format!("{lens}{FILM}"),
                [-0.30319133, 0.73760736, 0.01],
                [0.28055096, -0.14203086, 0.9492725],
                10534.3720703125,
            ),
            ("orthographic", FILM.to_owned(), [0.5, 0.25, 0.01], [0.0, 0.0, 1.0], 9999.990234375),
            (
                "orthographic",
                format!("{stretched}{FILM}"),
                [1.0, 0.75, 0.04],
                [0.0, 0.0, 1.0],
                9999.990234375,
            ),
        ];
        for (plugin, content, origin, direction, length) in cases {
            let scene = scene(&format!(r#"<sensor type="{plugin}">{content}</sensor>"#));
            let found = ray(&scene, [0.25, 0.25], [0.3, 0.9]);
            assert_near(found.0, origin, 1e-6);
            assert_near(found.1, direction, 1e-6);
            assert!((found.3 / length - 1.0).abs() < 1e-6 && found.2 == 1.0, "{plugin} {content} {found:?}");
        }
    }

    #[test]
    fn an_f_stop_is_the_focal_length_over_the_diameter_in_metres() {
        let widest = |content: &str| {
            let scene = scene(&format!(
                r#"<sensor type="thinlens"><float name="near_clip" value="1e-12"/>
                   <float name="f_stop" value="2"/>{content}{FILM}</sensor>"#
            ));
            let (origin, ..) = ray(&scene, [0.5, 0.5], [0.5, 1.0]);
            origin
        };
        assert_near(widest(""), [0.0, 0.0125, 0.0], 1e-9);
        assert_near(widest(r#"<string name="focal_length" value="85mm"/>"#), [0.0, 0.02125, 0.0], 1e-9);
        // The vertical angle of 8 × 4 pixels, whose diagonal is that of 36 mm × 24 mm: 19.349 mm high, so
        // that f = 19.349 / 2.
        let fov = r#"<float name="fov" value="90"/><string name="fov_axis" value="y"/>"#;
        assert_near(widest(fov), [0.0, 0.25e-3 * 36f64.hypot(24.0) / 5f64.sqrt() / 2.0, 0.0], 1e-9);
        let blades = r#"<integer name="aperture_blades" value="4"/>"#;
        assert_near(widest(blades), [0.0, 0.0125, 0.0], 1e-9);
        let turned = format!(r#"{blades}<float name="aperture_rotation" value="90"/>"#);
        assert_near(widest(&turned), [0.0125, 0.0, 0.0], 1e-9);
    }

    #[test]
    fn irradiance_is_measured_where_mitsuba_puts_a_film_on_a_shape() {
        // Places of four points of the film on five shapes, for directions along the normal (Mitsuba 3.9.1).
        let places = [[0.1, 0.2], [0.3, 0.4], [0.8, 0.35], [0.45, 0.95]];
        let shapes: [(&str, [[f64; 3]; 4]); 5] = [
            (
                "sphere",
                [
                    [0.647272, 0.47027, 0.600054],
                    [-0.302801, 0.931925, 0.200018],
                    [0.29481, -0.907331, 0.300027],
                    [-0.414593, 0.134709, -0.90008],
                ],
            ),
            (
                "cylinder",
                [
                    [0.309045, 0.951142, 0.1],
                    [-0.809089, 0.587838, 0.3],
                    [-0.587838, 0.809089, 0.8],
                    [0.951142, -0.309045, 0.45],
                ],
            ),
            (
                "disk",
                [
                    [-0.665176, -0.444456, 0.0],
                    [-0.369552, -0.153073, 0.0],
                    [0.554328, -0.22961, 0.0],
                    [-0.07844, 0.896575, 0.0],
                ],
            ),
            ("rectangle", [[-0.8, -0.6, 0.0], [-0.4, -0.2, 0.0], [0.6, -0.3, 0.0], [-0.1, 0.9, 0.0]]),
            (
                "cube",
                [
                    [0.13842, 1.0, -0.241053],
                    [1.0, 0.665336, 0.338656],
                    [1.0, 0.284458, -0.821115],
                    [-0.48324, 0.406705, -1.0],
                ],
            ),
        ];
        for (shape, seen) in shapes {
            let scene = scene(&format!(
                r#"<shape type="{shape}"><sensor type="irradiancemeter">{PIXEL}</sensor></shape>"#
            ));
            let centre = if shape == "cylinder" { 0.5 } else { 0.0 };
            for (place, [x, y, z]) in places.into_iter().zip(seen) {
                let (origin, _, weight, _) = ray(&scene, place, [0.5, 0.5]);
                // There, rays start 1e-4 above the surface.
                assert_near(origin, [x, y, z - centre], 1.2e-4);
                assert!((weight / std::f64::consts::PI - 1.0).abs() < 1e-12, "{shape} {weight}");
            }
        }
    }

    #[test]
    fn distant_sensors_look_at_a_sphere_a_point_or_a_surface() {
        // A sphere of radius 2 has a bounding box of half diagonal √12, which Mitsuba 3.9.1 enlarges to
        // 3.464411.
        let rays = |content: &str, second: [f64; 2]| {
            let scene = scene(&format!(
                r#"<shape type="sphere"><float name="radius" value="2"/></shape>
                   <sensor type="distant"><vector name="direction" value="0 0 -3"/>{content}{PIXEL}</sensor>"#
            ));
            ray(&scene, [0.1, 0.2], second)
        };
        let (origin, direction, weight, _) = rays("", [0.5, 0.5]);
        assert_near(origin, [0.0, 0.0, 3.464411], 1e-6);
        assert_eq!((direction, weight), ([0.0, 0.0, -1.0], 1.0));
        let (origin, ..) = rays("", [0.9, 0.5]);
        // 0.8 of the radius from the axis; around the axis it may lie anywhere.
        assert!((origin[0].hypot(origin[1]) - 2.771529).abs() < 1e-6 && (origin[2] - 3.464411).abs() < 1e-6);
        let (origin, ..) = rays(r#"<point name="target" value=".5 .25 0"/>"#, [0.3, 0.7]);
        assert_near(origin, [0.5, 0.25, 6.928823], 1e-6);
        let target = r#"<shape type="rectangle" name="target"><transform name="to_world"><scale x="3"/>
            <rotate y="1" angle="60"/></transform></shape>"#;
        let (origin, _, weight, _) = rays(target, [0.9, 0.2]);
        // Evenly over the surface, whatever its slope.
        assert!(weight == 1.0 && origin[0].abs() <= 1.5 && origin[1].abs() <= 1.0);
    }

    #[test]
    fn a_batch_shows_each_sensor_in_its_column() {
        let lookat = |from: &str| {
            format!(
                r#"<transform name="to_world"><lookat origin="{from}" target="0 0 0" up="0 1 0"/></transform>"#
            )
        };
        let first =
            format!(r#"<sensor type="perspective"><float name="fov" value="40"/>{}"#, lookat("0 0 -5"));
        let second = format!(r#"<sensor type="orthographic">{}"#, lookat("5 0 0"));
        let film = |width: u32, height: u32, crop: &str| {
            format!(
                r#"<film type="hdrfilm"><integer name="width" value="{width}"/><integer name="height" value="{height}"/>{crop}</film>"#
            )
        };
        let batch = |film: &str| {
            scene(&format!(r#"<sensor type="batch">{first}</sensor>{second}</sensor>{film}</sensor>"#))
        };
        let alone = |sensor: &str| scene(&format!("{sensor}{}</sensor>", film(4, 4, "")));
        let both = batch(&film(8, 4, ""));
        // A crop window takes all of both, squeezed (Mitsuba 3.9.1).
        let squeezed = batch(&film(
            8,
            4,
            r#"<integer name="crop_width" value="3"/><integer name="crop_offset_x" value="2"/>"#,
        ));
        for place in [[0.1, 0.3], [0.49, 0.9], [0.51, 0.0], [1.0, 1.0]] {
            let column = if place[0] < 0.5 { 0.0 } else { 1.0 };
            let single = alone(if column == 0.0 { &first } else { &second });
            let (origin, direction, ..) = ray(&single, [2.0 * place[0] - column, place[1]], [0.5; 2]);
            for batch in [&both, &squeezed] {
                let found = ray(batch, place, [0.5; 2]);
                assert_near(found.0, origin, 1e-12);
                assert_near(found.1, direction, 1e-12);
            }
        }
    }

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
