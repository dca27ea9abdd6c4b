//! Clear sky and sun by the model of Hosek and Wilkie ("An Analytic Model for Full Spectral Sky-Dome
//! Radiance", ACM TOG 31(4), 2012; "Adding a Solar-Radiance Function to the Hosek–Wilkie Skylight Model",
//! IEEE CG&A 33(3), 2013), as Mitsuba 3's `sunsky`.
//!
//! Over the dome, with the angles θ from the zenith and γ from the sun,
//!
//! L = R (1 + c₀ exp(c₁ / (cos θ + 0.01))) (c₂ + c₃ exp(c₄ γ) + c₅ cos² γ + c₆ χ(γ) + c₇ √cos θ),
//! χ(γ) = (1 + cos² γ) / (1 + c₈² − 2 c₈ cos γ)^1.5,
//!
//! at 320 to 720 nm in steps of 40 nm, linear between, and nothing beyond: the model knows no more.

mod position;
mod tables;

pub use position::{SunTime, sun_direction};

use crate::geometry::{Frame, Transform, Vec3, angle};
use crate::sampling::PiecewiseConstantGrid;
use crate::sampling::quadrature::midpoints;
use crate::spectrum::{Extrapolation, Sampled, Spectrum};
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use tables::{Disc, Dome};

/// How many wavelengths the model has.
const WAVELENGTHS: usize = 11;
const FIRST_NM: f64 = 320.0;
const STEP_NM: f64 = 40.0;

/// Wavelengths at which a ground albedo is asked for, nm.
pub fn wavelengths() -> [f64; WAVELENGTHS] {
    std::array::from_fn(|i| FIRST_NM + STEP_NM * i as f64)
}

/// What a sky is made from.
#[derive(Clone, Debug)]
pub struct SkySettings {
    /// Turbidity from 1 (no haze) to 10.
    pub turbidity: f64,
    /// Albedo of the ground, from 0 to 1, at [`wavelengths`].
    pub albedo: [f64; WAVELENGTHS],
    /// In the sky's frame, in which the zenith is +z. Unit length.
    pub sun_direction: Vec3,
    /// Factor on the radiance of the sky, at least 0.
    pub sky_scale: f64,
    /// Factor on the radiance of the sun, at least 0.
    pub sun_scale: f64,
    /// Angle across the sun, degrees. The sun's irradiance does not depend on it.
    pub sun_aperture: f64,
    /// Whether the sun darkens toward its limb and toward the horizon; otherwise it is the same all over.
    pub complex_sun: bool,
}

/// Light from a clear sky and from the sun.
#[derive(Clone, Debug)]
pub struct Sky {
    dome: [Dome; WAVELENGTHS],
    sun: Option<Sun>,
    sun_direction: Vec3,
    to_world: Transform,
    from_world: Transform,
    /// Grid over azimuth and over the square root of cos θ.
    grid: PiecewiseConstantGrid,
    /// Probability with which a direction to the sun is sampled.
    sun_probability: f64,
    mean: Spectrum,
}

#[derive(Clone, Debug)]
struct Sun {
    /// Cosine of half its angle; `sin_edge` is the sine.
    cos_edge: f64,
    sin_edge: f64,
    surface: SunSurface,
    scale: f64,
}

#[derive(Clone, Debug)]
enum SunSurface {
    Even([f64; WAVELENGTHS]),
    Darkened(Box<Disc>),
}

const COLUMNS: usize = 128;
const ROWS: usize = 64;

/// Angle across the sun for which the model holds, degrees.
const SUN_APERTURE: f64 = 0.5358;

/// cos of half the angle across a sun. That of the sun itself is as single precision has it: 1 − cos is off
/// by 0.2 % there, and with it the radiance of the disc in Mitsuba 3.
fn cos_half(degrees: f64) -> f64 {
    if degrees == SUN_APERTURE {
        return f64::from((0.5 * degrees as f32).to_radians().cos());
    }
    (0.5 * degrees).to_radians().cos()
}

impl Sky {
    /// `to_world` must keep lengths. `None` where there is no light: the sun is below the horizon, or all is
    /// scaled by 0.
    pub fn new(settings: &SkySettings, to_world: Transform) -> Option<Self> {
        let sun_direction = settings.sun_direction;
        if sun_direction.z < 0.0 {
            return None;
        }
        let elevation = sun_direction.z.min(1.0).asin();
        let mut dome = tables::dome(settings.turbidity, &settings.albedo, elevation);
        dome.iter_mut().for_each(|dome| dome.radiance *= settings.sky_scale);
        let sun = (settings.sun_scale > 0.0).then(|| Sun::new(settings, elevation));
        let mut sky = Self {
            grid: grid(&dome, sun_direction)?,
            dome,
            sun,
            sun_direction,
            from_world: to_world.inverse(),
            to_world,
            sun_probability: 0.0,
            mean: Spectrum::ZERO,
        };
        sky.sun_probability = sky.best_sun_probability(settings.sky_scale)?;
        sky.mean = sky.mean_radiance();
        Some(sky)
    }

    /// Radiance from a direction (unit length, away from the scene). The sky ends at the horizon.
    pub fn radiance<const C: usize>(&self, direction: Vec3, nm: &[f64; C]) -> Sampled<C> {
        let local = self.from_world.vector(direction);
        if local.z < 0.0 {
            return Sampled::ZERO;
        }
        let mut radiance = self.interpolated(nm, dome_at(local, self.sun_direction, &self.dome));
        if let Some(sun) = &self.sun
            && local.dot(self.sun_direction) >= sun.cos_edge
        {
            let elevation = FRAC_PI_2 - angle::acos(local.z.min(1.0));
            let disc = match &sun.surface {
                SunSurface::Even(radiance) => self.interpolated(nm, |i| radiance[i]),
                SunSurface::Darkened(disc) => {
                    let sin = local.cross(self.sun_direction).length() / sun.sin_edge;
                    let cos = (1.0 - sin * sin).max(0.0).sqrt();
                    self.interpolated(nm, |i| disc.radiance(i, elevation))
                        * self.interpolated(nm, |i| disc.limb(i, cos))
                }
            };
            radiance += disc * sun.scale;
        }
        radiance
    }

    /// A direction toward the light and its density per steradian.
    pub fn sample(&self, u: [f64; 2]) -> (Vec3, f64) {
        let local = match &self.sun {
            Some(sun) if u[0] < self.sun_probability => {
                sun.sample(self.sun_direction, [u[0] / self.sun_probability, u[1]])
            }
            _ => {
                let rest = ((u[0] - self.sun_probability) / (1.0 - self.sun_probability))
                    .clamp(0.0, 1.0 - f64::EPSILON);
                let ([x, y], _) = self.grid.sample([rest, u[1]]);
                let row = (y as usize).min(ROWS - 1);
                let [low, high] = heights(row);
                let z = low + (y - row as f64) * (high - low);
                let (sin, cos) = (TAU * x / COLUMNS as f64).sin_cos();
                let radius = (1.0 - z * z).max(0.0).sqrt();
                Vec3::new(radius * cos, radius * sin, z)
            }
        };
        let direction = self.to_world.vector(local);
        (direction, self.density(direction))
    }

    /// The density of [`Self::sample`] at a direction: above 0 wherever light comes from.
    pub fn density(&self, direction: Vec3) -> f64 {
        let local = self.from_world.vector(direction);
        let mut density = 0.0;
        if local.z >= 0.0 {
            let azimuth = (angle::atan2(local.y, local.x) / TAU).rem_euclid(1.0);
            let column = ((azimuth * COLUMNS as f64) as usize).min(COLUMNS - 1);
            let row = ((local.z.sqrt() * ROWS as f64) as usize).min(ROWS - 1);
            let [low, high] = heights(row);
            let solid_angle = TAU / COLUMNS as f64 * (high - low);
            density += (1.0 - self.sun_probability) * self.grid.probability(column, row) / solid_angle;
        }
        if let Some(sun) = &self.sun
            && local.dot(self.sun_direction) >= sun.cos_edge
        {
            density += self.sun_probability / sun.solid_angle();
        }
        density
    }

    /// Mean radiance over the sphere.
    pub fn mean(&self) -> &Spectrum {
        &self.mean
    }

    fn interpolated<const C: usize>(&self, nm: &[f64; C], at: impl Fn(usize) -> f64) -> Sampled<C> {
        Sampled::from_fn(|lane| {
            let x = (nm[lane] - FIRST_NM) / STEP_NM;
            if !(0.0..=(WAVELENGTHS - 1) as f64).contains(&x) {
                return 0.0;
            }
            let below = (x as usize).min(WAVELENGTHS - 2);
            let fraction = x - below as f64;
            at(below) * (1.0 - fraction) + at(below + 1) * fraction
        })
    }

    /// By what either brings; `None` where neither brings anything.
    fn best_sun_probability(&self, sky_scale: f64) -> Option<f64> {
        let Some(sun) = &self.sun else { return (sky_scale > 0.0).then_some(0.0) };
        if sky_scale == 0.0 {
            return Some(1.0);
        }
        let at_sun = |nm: f64| self.radiance(self.to_world.vector(self.sun_direction), &[nm]).hero();
        let from_sun = at_sun(560.0) * sun.solid_angle();
        // Order of magnitude of the dome's mean over the half space.
        let from_sky = TAU * dome_at(Vec3::new(0.6, 0.0, 0.8), self.sun_direction, &self.dome)(6);
        Some((from_sun / (from_sun + from_sky)).clamp(0.2, 0.8))
    }

    fn mean_radiance(&self) -> Spectrum {
        const STRATA: usize = 48;
        let nm = wavelengths();
        let mut sum = Sampled::<WAVELENGTHS>::ZERO;
        for u in midpoints(STRATA) {
            let (direction, density) = self.sample(u);
            sum += self.radiance(direction, &nm) / density;
        }
        let mean = sum / ((STRATA * STRATA) as f64 * 4.0 * PI);
        Spectrum::regular(nm[0], nm[WAVELENGTHS - 1], &mean.0, Extrapolation::Zero).unwrap_or(Spectrum::ZERO)
    }
}

impl Sun {
    fn new(settings: &SkySettings, elevation: f64) -> Self {
        let cos_edge = cos_half(settings.sun_aperture);
        // The light of a larger sun is spread over a larger disc.
        let spread = (1.0 - cos_half(SUN_APERTURE)) / (1.0 - cos_edge);
        let surface = if settings.complex_sun {
            SunSurface::Darkened(Box::new(Disc::new(settings.turbidity)))
        } else {
            let solid_angle = TAU * (1.0 - cos_half(SUN_APERTURE));
            SunSurface::Even(tables::sun_irradiance(settings.turbidity, elevation).map(|e| e / solid_angle))
        };
        let sin_edge = (0.5 * settings.sun_aperture).to_radians().sin();
        Self { cos_edge, sin_edge, surface, scale: settings.sun_scale * spread }
    }

    fn solid_angle(&self) -> f64 {
        TAU * (1.0 - self.cos_edge)
    }

    /// Uniform over the disc.
    fn sample(&self, centre: Vec3, u: [f64; 2]) -> Vec3 {
        let below = u[0] * (1.0 - self.cos_edge);
        let radius = (below * (2.0 - below)).sqrt();
        let (sin, cos) = angle::sin_cos(TAU * u[1]);
        Frame::around(centre).to_world(Vec3::new(radius * cos, radius * sin, 1.0 - below))
    }
}

/// The dome's radiance in a direction, in the sky's frame, as a function of the wavelength's number.
fn dome_at(local: Vec3, sun: Vec3, dome: &[Dome; WAVELENGTHS]) -> impl Fn(usize) -> f64 {
    let cos_theta = local.z.clamp(0.0, 1.0);
    let cos_gamma = local.dot(sun).clamp(-1.0, 1.0);
    let gamma = angle::atan2(local.cross(sun).length(), cos_gamma);
    let squared = cos_gamma * cos_gamma;
    move |wavelength| {
        let Dome { radiance, c } = dome[wavelength];
        let spread = 1.0 + c[8] * c[8] - 2.0 * c[8] * cos_gamma;
        let chi = (1.0 + squared) / (spread * spread.sqrt());
        let horizon = 1.0 + c[0] * (c[1] / (cos_theta + 0.01)).exp();
        let sky = c[2] + c[3] * (c[4] * gamma).exp() + c[5] * squared + c[6] * chi + c[7] * cos_theta.sqrt();
        (radiance * horizon * sky).max(0.0)
    }
}

/// cos θ at the lower and upper edge of a row: finer toward the horizon, where the sky changes fastest.
fn heights(row: usize) -> [f64; 2] {
    [row, row + 1].map(|edge| (edge as f64 / ROWS as f64).powi(2))
}

/// What comes from each cell of the dome, up to a factor.
fn grid(dome: &[Dome; WAVELENGTHS], sun: Vec3) -> Option<PiecewiseConstantGrid> {
    let unscaled =
        dome.map(|dome| Dome { radiance: if dome.radiance > 0.0 { dome.radiance } else { 1.0 }, ..dome });
    let mut cells = Vec::with_capacity(COLUMNS * ROWS);
    for row in 0..ROWS {
        let [low, high] = heights(row);
        let z = 0.5 * (low + high);
        for column in 0..COLUMNS {
            let (sin, cos) = (TAU * (column as f64 + 0.5) / COLUMNS as f64).sin_cos();
            let radius = (1.0 - z * z).sqrt();
            let at = dome_at(Vec3::new(radius * cos, radius * sin, z), sun, &unscaled);
            // Where blue, green and red are told apart.
            cells.push((high - low) * [3, 6, 8].map(at).iter().sum::<f64>());
        }
    }
    // A cell that is dark in its middle may not be so all over.
    let least = 1e-3 * cells.iter().sum::<f64>() / cells.len() as f64;
    cells.iter_mut().for_each(|cell| *cell = cell.max(least));
    PiecewiseConstantGrid::new(COLUMNS, &cells)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sky(turbidity: f64, albedo: f64, sun: Vec3, sun_aperture: f64, complex_sun: bool) -> Sky {
        let settings = SkySettings {
            turbidity,
            albedo: [albedo; WAVELENGTHS],
            sun_direction: sun.normalize(),
            sky_scale: 1.0,
            sun_scale: 1.0,
            sun_aperture,
            complex_sun,
        };
        Sky::new(&settings, Transform::IDENTITY).unwrap()
    }

    /// Mitsuba 3.9.1, `sunsky`, `emitter.eval` at 330, 450, 555, 610 and 719 nm: beside the sun, near the
    /// horizon, at the sun's middle, and six tenths of the way from there to its edge.
    #[test]
    fn radiances_are_mitsubas() {
        let nm = [330.0, 450.0, 555.0, 610.0, 719.0];
        for ((turbidity, albedo, sun, aperture, complex), seen) in [
            (
                (1.0, 0.0, [0.0, 0.0, 1.0], 0.5358, false),
                [
                    (
                        [0.115470054, 0.577350269, 0.808290377],
                        [0.0602111, 0.0932054, 0.0404544, 0.0240983, 0.00984425],
                    ),
                    (
                        [0.599520575, -0.799360767, 0.0399680383],
                        [0.0508851, 0.19992, 0.15419, 0.107415, 0.051909],
                    ),
                    ([0.0, 0.0, 1.0], [2385.36, 15769.3, 18251.4, 18535.3, 16110.5]),
                    (
                        [-0.0027915157, 0.00027915157, 0.999996065],
                        [2385.36, 15769.3, 18251.4, 18535.3, 16110.5],
                    ),
                ],
            ),
            (
                (3.0, 0.3, [0.341881729, 0.227921153, 0.911684612], 0.5358, false),
                [
                    (
                        [0.115470054, 0.577350269, 0.808290377],
                        [0.0780656, 0.153859, 0.0862116, 0.0653159, 0.0368232],
                    ),
                    (
                        [0.599520575, -0.799360767, 0.0399680383],
                        [0.0659098, 0.259527, 0.187849, 0.150131, 0.0833511],
                    ),
                    ([0.341881729, 0.227921153, 0.911684612], [2132.95, 14901.2, 17504.9, 17876.0, 15662.8]),
                    ([0.339248722, 0.22798951, 0.912650584], [2132.95, 14901.2, 17504.9, 17876.0, 15662.8]),
                ],
            ),
            (
                (2.5, 0.7, [0.970494959, 0.107832773, 0.215665546], 0.5358, true),
                [
                    (
                        [0.115470054, 0.577350269, 0.808290377],
                        [0.0172974, 0.0511734, 0.0280089, 0.0191916, 0.00840546],
                    ),
                    (
                        [0.599520575, -0.799360767, 0.0399680383],
                        [0.0115611, 0.124719, 0.142067, 0.125001, 0.0749893],
                    ),
                    ([0.970494959, 0.107832773, 0.215665546], [152.69, 7001.55, 13419.0, 15405.0, 15211.6]),
                    ([0.969943445, 0.107345509, 0.218372742], [132.294, 6152.83, 12062.0, 13980.0, 14003.5]),
                ],
            ),
            (
                (10.0, 1.0, [0.999950004, 0.0, 0.00999950004], 5.0, true),
                [
                    (
                        [0.115470054, 0.577350269, 0.808290377],
                        [0.00187975, 0.00915895, 0.008155, 0.00715701, 0.00455814],
                    ),
                    (
                        [0.599520575, -0.799360767, 0.0399680383],
                        [0.000661133, 0.00586472, 0.00725605, 0.00745019, 0.00686231],
                    ),
                    (
                        [0.999950004, 0.0, 0.00999950004],
                        [0.000684976, 0.00722105, 0.011717, 0.0173371, 0.0261187],
                    ),
                    (
                        [0.999350623, -0.00510878776, 0.0356683738],
                        [0.000884364, 0.00859836, 0.0134114, 0.0195618, 0.0330892],
                    ),
                ],
            ),
            (
                (6.3, 0.15, [0.298142397, -0.745355992, 0.596284794], 20.0, false),
                [
                    (
                        [0.115470054, 0.577350269, 0.808290377],
                        [0.0391148, 0.0801713, 0.0428278, 0.03052, 0.0148921],
                    ),
                    (
                        [0.599520575, -0.799360767, 0.0399680383],
                        [0.0485614, 0.381544, 0.441253, 0.42453, 0.322551],
                    ),
                    ([0.298142397, -0.745355992, 0.596284794], [0.901349, 8.2745, 10.5143, 11.0571, 10.0341]),
                    ([0.203016042, -0.741272854, 0.639764833], [0.887095, 8.19539, 10.408, 10.9333, 9.95032]),
                ],
            ),
        ] {
            let sky = sky(turbidity, albedo, Vec3::from(sun), aperture, complex);
            for (direction, expected) in seen {
                let found = sky.radiance(Vec3::from(direction).normalize(), &nm);
                for (found, expected) in found.0.into_iter().zip(expected) {
                    assert!(
                        (found - expected).abs() <= 1e-4 * expected,
                        "turbidity {turbidity}, {direction:?}: {found} {expected}"
                    );
                }
            }
        }
    }
}
