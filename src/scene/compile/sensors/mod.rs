//! The sensor: which rays it measures.

mod film;
#[cfg(test)]
mod tests;

use super::{Compiler, shapes};
use crate::camera::{
    Angular, Aperture, Camera, DirectionMap, Distant, IrradianceMeter, Projection, Projective,
    ProjectiveSettings, RadianceMeter, SensorPlane, ThinLens, View, ViewKind, Window,
};
use crate::geometry::{Bounds, Motion, Placed, Transform, Vec3};
use crate::scene::description::{
    self, AngularMap, DistantTarget, FieldOfView, FovAxis, Lens, Sensor, SensorKind, ShapeKind,
};
use crate::scene::source::SceneError;
use crate::shape::Shape;

/// By this factor Mitsuba 3 enlarges the sphere around a scene that a distant sensor looks at.
const SPHERE_MARGIN: f64 = 1.0 + 1500.0 / 16_777_216.0;

/// A film as a sensor is told of it: one of a batch has one of its own, which its column shows.
#[derive(Clone, Copy)]
struct FilmShare {
    /// Pixels of the whole film.
    size: [f64; 2],
    exposed: Window,
}

impl Compiler<'_> {
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
            ViewKind::Projective(Box::new(Projective::new(ProjectiveSettings {
                placed,
                projection,
                film: film.size,
                half_width,
                principal_point,
                near_clip: clips[0],
                far_clip: clips[1],
            })))
        };
        let kind = match &sensor.kind {
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
                ViewKind::Angular(Box::new(Angular::new(placed, map, film.size, [*near_clip, *far_clip])))
            }
            SensorKind::Plane { to_world, width, stop } => {
                let placed = self.camera_placed(sensor, to_world, shift)?;
                ViewKind::Plane(Box::new(SensorPlane::new(placed, film.size, *width, *stop)))
            }
            SensorKind::RadianceMeter { origin, direction } => {
                ViewKind::Radiance(RadianceMeter::new(shift.point(*origin), *direction))
            }
            SensorKind::IrradianceMeter { surface } => {
                let surface = self.measured_surface(surface, shift)?;
                ViewKind::Irradiance(Box::new(IrradianceMeter::new(surface, film.exposed)))
            }
            SensorKind::Distant { direction, target } => {
                ViewKind::Distant(Box::new(self.distant(*direction, target, shift, scene)?))
            }
            // The reader refuses a batch in a batch.
            SensorKind::Batch(_) => return None,
        };
        Some(View { kind, response })
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
        if let ShapeKind::Curves { .. } = shape.kind {
            let problem = "A sensor cannot measure on curves, here as in Mitsuba 3";
            let error = SceneError::at(&shape.place, problem, "expected a shape whose area is known");
            self.errors.push(error.with_remedy("a sweptsphere of the same file can be measured on"));
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
}

/// A box around where the rays of a sensor begin, in the file's coordinates: for cameras a cube that reaches
/// as far as the near clipping plane.
pub(super) fn eyes(sensor: &Sensor) -> Bounds {
    let (to_world, reach) = match &sensor.kind {
        SensorKind::Perspective { to_world, near_clip, .. }
        | SensorKind::Angular { to_world, near_clip, .. } => (to_world, *near_clip),
        SensorKind::Orthographic { to_world, near_clip, .. } => (to_world, near_clip.max(1.0)),
        SensorKind::Plane { to_world, width, .. } => (to_world, 0.5 * width),
        SensorKind::RadianceMeter { origin, .. } => return Bounds::of([*origin]),
        SensorKind::IrradianceMeter { surface } => return shapes::bounds(surface, &surface.to_world),
        SensorKind::Distant { .. } => return Bounds::EMPTY,
        SensorKind::Batch(sensors) => return Bounds::of_all(sensors.iter().map(eyes)),
    };
    let cube = Bounds::of([Vec3::splat(-reach), Vec3::splat(reach)]);
    let keys = sensor.motion.iter().flat_map(|motion| motion.keys.iter().map(|(_, to_world)| to_world));
    let placed = std::iter::once(to_world).chain(keys);
    Bounds::of(placed.flat_map(|to_world| cube.corners().map(|corner| to_world.point(corner))))
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
