//! Reflection as it was measured.

use super::kept::Kept;
use super::{Evaluation, Scatter, reflected};
use crate::geometry::Vec3;
use crate::sampling::{Around, ParametricDensity, ParametricGrid};
use crate::spectrum::Sampled;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// A surface whose reflection was measured. Black from below. Mitsuba's `measured`.
///
/// The tables are those of Dupuy and Jakob, "An Adaptive Parameterization for Efficient Material Acquisition
/// and Rendering" (ACM Transactions on Graphics 37, 2018). A normal m of a facet at the angle θ and the
/// azimuth φ has the place (√(2 θ / π), (φ + π) / 2π) in the unit square. For each direction of the eye,
/// a density over these places is about that of the visible normals. Sample values that are uniform in the
/// unit square lead by it to m and to the direction of light, and for each sample value there is the measured
/// spectrum.
#[derive(Clone, Copy, Debug)]
pub struct Measured<const C: usize> {
    /// What was measured.
    pub table: &'static MeasuredTable,
    /// Where the wavelengths are among those of the table, as [`MeasuredTable::wavelength`] has them.
    pub wavelengths: Sampled<C>,
}

/// The tables of a measured surface. The parameters are the azimuth of the eye and its angle from the normal,
/// in radians, and for the spectra the wavelength in nm, too.
#[derive(Clone, Debug)]
pub struct MeasuredTable {
    /// Density of the normals, by the place of the normal.
    pub normals: ParametricGrid<0>,
    /// Area of the facets that an eye sees, per area of the surface, by the place of the eye's direction.
    pub visible_area: ParametricGrid<0>,
    /// Density of the visible normals, by their place.
    pub visible_normals: ParametricDensity<2>,
    /// Density of sample values, about in proportion to what they contribute, at the same directions of the
    /// eye.
    pub luminance: ParametricDensity<2>,
    /// What was measured, by the sample value: f cos θ of the light, or that over D / (4 σ) if
    /// [`Self::is_relative`].
    pub spectra: ParametricGrid<3>,
    /// Whether spectra are over D / (4 σ), of the normals' density and the visible area.
    pub is_relative: bool,
    /// Whether azimuths of normals are counted from that of the eye.
    pub is_isotropic: bool,
    /// Which part of all azimuths of the eye was measured, from −π on; the surface looks the same in the
    /// others.
    pub symmetry: Symmetry,
}

/// Directions in which a surface looks the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Symmetry {
    /// Each azimuth was measured.
    None,
    /// The surface may be turned by 180°.
    HalfTurn,
    /// It may be mirrored along x and along y.
    Mirrored,
}

/// The least Jacobian of the unit square: at the surface's own normal it is 0. Samples that fall there are so
/// few that it changes no mean by 1e-12.
const LEAST_JACOBIAN: f64 = 1e-12;

/// A direction of the eye.
struct View {
    eye: Vec3,
    azimuth: f64,
    /// Places of azimuth and angle on the axes of the tables.
    places: [f64; 2],
    /// The densities' grids around these.
    around: Around,
}

impl MeasuredTable {
    /// The table with a hash of its content, made the first time that it is asked for. Kept for the rest of
    /// the program.
    ///
    /// # Errors
    /// Those of `make`.
    pub fn shared<E>(content: u64, make: impl FnOnce() -> Result<Self, E>) -> Result<&'static Self, E> {
        static TABLES: Kept<u64, MeasuredTable> = Kept::new();
        TABLES.try_get(content, make)
    }

    /// Where a wavelength is among those of the table, with a fraction. Beyond them the ends hold.
    pub fn wavelength(&self, nm: f64) -> f64 {
        self.spectra.place(2, nm)
    }

    /// Signs of x and y that bring the eye into the azimuths that were measured.
    fn signs(&self, eye: Vec3) -> [f64; 2] {
        let sign = |component: f64| if component > 0.0 { -1.0 } else { 1.0 };
        match self.symmetry {
            Symmetry::None => [1.0, 1.0],
            Symmetry::HalfTurn => [sign(eye.y); 2],
            Symmetry::Mirrored => [sign(eye.x), sign(eye.y)],
        }
    }

    fn view(&self, eye: Vec3) -> View {
        let azimuth = eye.y.atan2(eye.x);
        let places = [self.luminance.place(0, azimuth), self.luminance.place(1, angle_from_normal(eye))];
        View { eye, azimuth, places, around: self.luminance.around(places) }
    }

    /// The place of a normal in the unit square.
    fn place_of(&self, m: Vec3, view: &View) -> [f64; 2] {
        let from = if self.is_isotropic { view.azimuth } else { 0.0 };
        let [x, y] = place(m, m.y.atan2(m.x) - from);
        [x, y - y.floor()]
    }

    /// The normal at a place in the unit square.
    fn normal_at(&self, [x, y]: [f64; 2], view: &View) -> Vec3 {
        let from = if self.is_isotropic { view.azimuth } else { 0.0 };
        let (sin_theta, cos_theta) = (FRAC_PI_2 * x * x).sin_cos();
        let (sin_phi, cos_phi) = (PI * (2.0 * y - 1.0) + from).sin_cos();
        Vec3::new(sin_theta * cos_phi, sin_theta * sin_phi, cos_theta)
    }
}

/// The angle of a direction from the normal. Without the cancellation that the arc cosine has near 0.
fn angle_from_normal(direction: Vec3) -> f64 {
    2.0 * (0.5 * (direction - Vec3::Z).length()).min(1.0).asin()
}

/// The place of a direction in the unit square, by its azimuth.
fn place(direction: Vec3, azimuth: f64) -> [f64; 2] {
    [(angle_from_normal(direction) / FRAC_PI_2).sqrt(), (azimuth + PI) / TAU]
}

/// x and y with other signs.
fn with_signs(v: Vec3, [x, y]: [f64; 2]) -> Vec3 {
    Vec3::new(v.x * x, v.y * y, v.z)
}

impl<const C: usize> Measured<C> {
    pub(super) fn evaluate(&self, toward_eye: Vec3, toward_light: Vec3) -> Evaluation<C> {
        if toward_eye.z <= 0.0 || toward_light.z <= 0.0 {
            return Evaluation::ZERO;
        }
        let table = self.table;
        let signs = table.signs(toward_eye);
        let [eye, light] = [toward_eye, toward_light].map(|direction| with_signs(direction, signs));
        let Some(m) = (eye + light).try_normalize() else { return Evaluation::ZERO };
        let view = table.view(eye);
        let place_of_m = table.place_of(m, &view);
        let (u, of_normals) = table.visible_normals.invert(&view.around, place_of_m);
        let of_samples = table.luminance.density(&view.around, u);
        // Solid angle of light per area of the unit square.
        let jacobian = TAU * PI * place_of_m[0] * m.x.hypot(m.y) * 4.0 * eye.dot(m);
        let relative_to = if table.is_relative {
            let area = table.visible_area.value(&table.visible_area.around([]), place(eye, view.azimuth));
            let normals = table.normals.value(&table.normals.around([]), place_of_m);
            if area > 0.0 { normals / (4.0 * area) } else { 0.0 }
        } else {
            1.0
        };
        let [azimuth, angle] = view.places;
        Evaluation {
            f_cos: self.wavelengths.map(|wavelength| {
                relative_to * table.spectra.value(&table.spectra.around([azimuth, angle, wavelength]), u)
            }),
            density: Sampled::from_fn(|_| of_normals * of_samples / jacobian.max(LEAST_JACOBIAN)),
        }
    }

    pub(super) fn sample(&self, toward_eye: Vec3, u: [f64; 2]) -> Option<Scatter<C>> {
        if toward_eye.z <= 0.0 {
            return None;
        }
        let table = self.table;
        let signs = table.signs(toward_eye);
        let view = table.view(with_signs(toward_eye, signs));
        let u = table.luminance.sample(&view.around, u);
        let place = table.visible_normals.sample(&view.around, u);
        let light = reflected(view.eye, table.normal_at(place, &view));
        let toward_light = with_signs(light, signs);
        let Evaluation { f_cos, density } = self.evaluate(toward_eye, toward_light);
        Scatter::with_density(toward_light, f_cos, density, false)
    }
}
