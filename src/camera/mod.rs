//! Sensors: from a film position to a ray.
//!
//! A pixel's value is the mean over its rays of the radiance along them × the ray's weight × the sensor's
//! response to the wavelength, as in Mitsuba 3: no cos⁴ falloff, no vignetting.

mod angular;
mod meters;
mod plane;
mod projective;
mod shutter;

pub use angular::{Angular, DirectionMap, FisheyeProjection};
pub use meters::{Distant, IrradianceMeter, LitPoint, RadianceMeter};
pub use plane::{SensorPlane, Stop};
pub use projective::{Aperture, Projection, Projective, ProjectiveSettings, ThinLens};
pub use shutter::{Shutter, ShutterKind};

use crate::geometry::{Bounds, Ray, SurfacePoint, Vec3};
use crate::spectrum::Spectrum;

/// One view of the scene, or several side by side on one film.
#[derive(Clone, Debug)]
pub struct Camera {
    views: Vec<View>,
    /// Where there are several, each has a column of the film.
    columns: Option<Columns>,
}

/// A part of a film, in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Column and row of its upper left corner, in pixels of the whole film.
    pub offset: [f64; 2],
    /// Columns and rows.
    pub size: [f64; 2],
}

impl Window {
    /// A film position as fractions of the window.
    pub fn fractions(&self, film: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|i| (film[i] - self.offset[i]) / self.size[i])
    }
}

/// How several views share a film.
#[derive(Clone, Copy, Debug)]
struct Columns {
    /// The exposed part of the film, which all views together fill.
    window: Window,
    /// Size in pixels of the film that each view is given positions on.
    film: [f64; 2],
}

/// A sensor's rays and how it weighs wavelengths.
#[derive(Clone, Debug)]
pub struct View {
    /// Which ray belongs to a position on the film.
    pub kind: ViewKind,
    /// Factor on what is measured; `None` is 1 everywhere.
    pub response: Option<Spectrum>,
}

/// Kinds of sensors, by the rays that they measure.
#[derive(Clone, Debug)]
pub enum ViewKind {
    /// A pinhole, a thin lens, or parallel rays.
    Projective(Box<Projective>),
    /// A fisheye or a panorama.
    Angular(Box<Angular>),
    /// A film in the scene itself.
    Plane(Box<SensorPlane>),
    /// A single ray.
    Radiance(RadianceMeter),
    /// All rays that arrive at a surface.
    Irradiance(Box<IrradianceMeter>),
    /// Parallel rays from infinity.
    Distant(Box<Distant>),
}

/// Where a point of the scene is seen.
#[derive(Clone, Copy, Debug)]
pub struct Projected<'a> {
    /// Position on the film, in pixels from its top left corner.
    pub film: [f64; 2],
    /// Where rays from the lens begin to see.
    pub begins: Vec3,
    /// Unit vector from the point to the lens, and how far that is.
    pub toward_lens: Vec3,
    /// Distance from the point to the lens, in scene units.
    pub distance: f64,
    /// The film's area for a solid angle at the lens.
    pub pixels_per_steradian: f64,
    /// Response of the sensor, as in [`SensorRay`].
    pub response: Option<&'a Spectrum>,
}

impl Projected<'_> {
    /// Pixels for a unit of area of a surface at the point.
    pub fn pixels_per_area(&self, normal: Vec3) -> f64 {
        let slant = self.toward_lens.dot(normal).abs();
        self.pixels_per_steradian * slant / (self.distance * self.distance)
    }

    /// Where a segment from the point to the lens ends.
    pub fn end(&self) -> SurfacePoint {
        SurfacePoint { position: self.begins, normal: self.toward_lens, error: 0.0 }
    }
}

/// A ray that a sensor measures.
#[derive(Clone, Copy, Debug)]
pub struct SensorRay<'a> {
    /// The ray, from the sensor into the scene.
    pub ray: Ray,
    /// Factor on the radiance along it.
    pub weight: f64,
    /// Factor by wavelength, where there is one.
    pub response: Option<&'a Spectrum>,
    /// The place at which the irradiance is measured, where that is done.
    pub lit: Option<LitPoint>,
}

impl Camera {
    /// A camera with one view on its whole film.
    pub fn single(view: View) -> Self {
        Self { views: vec![view], columns: None }
    }

    /// Several views on columns of equal width of a film's exposed part. Each is made for a film of `film`
    /// pixels, the whole of which its column shows.
    pub fn side_by_side(views: Vec<View>, window: Window, film: [f64; 2]) -> Self {
        Self { views, columns: Some(Columns { window, film }) }
    }

    /// Its views, from left to right.
    pub fn views(&self) -> &[View] {
        &self.views
    }

    /// Whether what it sees depends on the time.
    pub fn is_moving(&self) -> bool {
        self.views.iter().any(|view| match &view.kind {
            ViewKind::Projective(camera) => camera.is_moving(),
            ViewKind::Angular(camera) => camera.is_moving(),
            ViewKind::Plane(plane) => plane.is_moving(),
            ViewKind::Radiance(_) | ViewKind::Irradiance(_) | ViewKind::Distant(_) => false,
        })
    }

    /// Whether [`Self::project`] tells of points where they are seen.
    pub fn projects(&self) -> bool {
        matches!(&self.views[..], [View { kind: ViewKind::Projective(camera), .. }] if camera.has_eye())
            && self.columns.is_none()
    }

    /// Where a point is seen through the point of the lens that `lens_u` chooses: the reverse of
    /// [`Self::ray`]. `None` where it is not in view.
    pub fn project(&self, point: Vec3, lens_u: [f64; 2], time: f64) -> Option<Projected<'_>> {
        let [View { kind: ViewKind::Projective(camera), response }] = &self.views[..] else { return None };
        camera.project(point, lens_u, time).map(|seen| Projected { response: response.as_ref(), ..seen })
    }

    /// The circle of confusion: the radius, in pixels, of the disk over which a lens spreads a point of the
    /// scene. `None` where there is no lens, and where [`Self::project`] gives none.
    pub fn circle_of_confusion_radius(&self, point: Vec3, time: f64) -> Option<f64> {
        let [View { kind: ViewKind::Projective(camera), .. }] = &self.views[..] else { return None };
        camera.circle_of_confusion_radius(point, time)
    }

    /// A box around where its rays begin, from one time to another. Empty for what looks from outside of the
    /// scene.
    pub fn origins(&self, during: [f64; 2]) -> Bounds {
        Bounds::of_all(self.views.iter().map(|view| match &view.kind {
            ViewKind::Projective(projective) => projective.origins(during),
            ViewKind::Angular(camera) => camera.origins(during),
            ViewKind::Plane(plane) => plane.origins(during),
            ViewKind::Radiance(meter) => Bounds::of([meter.ray().origin]),
            ViewKind::Irradiance(meter) => meter.origins(),
            ViewKind::Distant(_) => Bounds::EMPTY,
        }))
    }

    /// Whether it measures irradiance on a surface, so that light may be sought from there.
    pub fn measures_irradiance(&self) -> bool {
        self.views.iter().any(|view| matches!(view.kind, ViewKind::Irradiance(_)))
    }

    /// Whether [`Self::ray`] uses its second sample.
    pub fn uses_lens(&self) -> bool {
        self.views.iter().any(|view| match &view.kind {
            ViewKind::Projective(projective) => projective.has_lens(),
            ViewKind::Angular(_) | ViewKind::Radiance(_) => false,
            ViewKind::Plane(_) | ViewKind::Irradiance(_) | ViewKind::Distant(_) => true,
        })
    }

    /// The ray seen at a film position (pixels from the top left corner of the film). `lens_u` chooses what a
    /// position leaves open: the point of the lens or the stop, the direction toward an irradiance meter.
    /// `time` says where a camera that moves is. `None` where there is nothing to measure: outside the circle
    /// of a fisheye, or where a surface to measure at has no area.
    pub fn ray(&self, film: [f64; 2], lens_u: [f64; 2], time: f64) -> Option<SensorRay<'_>> {
        let (view, film) = match &self.columns {
            None => (self.views.first()?, film),
            Some(columns) => {
                let [x, y] = columns.window.fractions(film);
                let place = x * self.views.len() as f64;
                let column = place.floor().clamp(0.0, self.views.len() as f64 - 1.0);
                let on_film = [(place - column) * columns.film[0], y * columns.film[1]];
                (&self.views[column as usize], on_film)
            }
        };
        let mut lit = None;
        let (ray, weight) = match &view.kind {
            ViewKind::Projective(projective) => (projective.ray(film, lens_u, time), 1.0),
            ViewKind::Angular(camera) => (camera.ray(film, time)?, 1.0),
            ViewKind::Plane(plane) => plane.ray(film, lens_u, time),
            ViewKind::Radiance(meter) => (meter.ray(), 1.0),
            ViewKind::Irradiance(meter) => {
                let (ray, weight, point) = meter.ray(film, lens_u)?;
                lit = Some(point);
                (ray, weight)
            }
            ViewKind::Distant(distant) => distant.ray(lens_u)?,
        };
        Some(SensorRay { ray, weight, response: view.response.as_ref(), lit })
    }
}
