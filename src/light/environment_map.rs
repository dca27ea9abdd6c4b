//! Light from a picture that surrounds the scene, as Mitsuba 3's `envmap`.
//!
//! The picture covers the sphere by longitude and latitude. The middle of column c lies at longitude
//! 2π (c + ½) / width, counted from −z towards +x; row r lies at the angle π r / (height − 1) from +y, so
//! that the first and the last row are the poles.
//!
//! Each texel is a reflectance times a factor, S(λ) m, and what is interpolated bilinearly are S and m apart:
//!
//! L(λ) = E(λ) · Σ wᵢ Sᵢ(λ) · Σ wᵢ mᵢ,
//!
//! with the illuminant E. That is not the interpolation of their product, but what Mitsuba 3 does.

use crate::geometry::{Transform, Vec3, angle};
use crate::lanes::{
    Mask, REGISTERS, Real, Register, Row, Vec3Lanes, Vector, WIDTH, ZERO, get, lanes_of, registers_of, set,
};
use crate::sampling::PiecewiseBilinearGrid;
use crate::sampling::quadrature::midpoints;
use crate::spectrum::{Extrapolation, Sampled, SampledLanes, Sigmoid, Spectrum, Wavelengths, upsample};
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};
use std::ops::Range;

/// A texel: a reflectance S and its factor m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Texel {
    /// Coefficients of the reflectance's [`Sigmoid`].
    pub coefficients: [f32; 3],
    /// Factor on the spectrum of the coefficients, at least 0.
    pub factor: f32,
}

impl Texel {
    /// Black at all wavelengths.
    pub const BLACK: Self = Self { coefficients: [0.0, 0.0, f32::NEG_INFINITY], factor: 0.0 };

    /// From values of at least 0, proportional to light, for the primaries of sRGB: a reflectance whose
    /// greatest component is ½.
    pub fn from_rgb(rgb: [f64; 3]) -> Self {
        let factor = 2.0 * rgb.into_iter().fold(0.0, f64::max);
        // Also what is too little to be divided by.
        if factor < f64::from(f32::MIN_POSITIVE) {
            return Self::BLACK;
        }
        let Sigmoid { coefficients } = upsample(rgb.map(|value| value / factor));
        Self { coefficients: coefficients.map(|c| c as f32), factor: factor as f32 }
    }

    fn reflectance(&self, nm: f64) -> f64 {
        reflectance(self.coefficients.map(f64::from), f64::from(self.factor), nm)
    }
}

/// The reflectance of texels by their coefficients and factors.
#[inline(always)]
fn reflectance<R: Real>(coefficients: [R; 3], factor: R, nm: R) -> R {
    let zero = R::of(0.0);
    R::choose(factor.eq(zero), zero, Sigmoid::value(coefficients, nm))
}

/// A picture at infinity.
#[derive(Clone, Debug)]
pub struct EnvironmentMap {
    width: usize,
    height: usize,
    texels: Vec<Texel>,
    illuminant: Spectrum,
    to_world: Transform,
    from_world: Transform,
    /// Cells of equal steps in longitude and in the angle from +y, in the picture's own frame; the first
    /// column begins in the middle of the picture's first.
    grid: PiecewiseBilinearGrid,
    columns: usize,
    /// Cosines of the angles from +y at the edges of the rows of cells.
    cosines: Vec<f64>,
    /// Mean radiance over the sphere.
    mean: Spectrum,
}

/// Where a picture has fewer columns than this, the density over directions is finer than the picture.
const LEAST_COLUMNS: usize = 256;

/// Pictures of fewer texels have four cells for each: a product of two interpolated factors is not bilinear,
/// but nearly so in a quarter of a texel.
const FINE: usize = 1 << 20;

/// Rows of cells that a thread takes at once: the corners between two such parts are found twice.
const ROWS_AT_ONCE: usize = 32;

impl EnvironmentMap {
    /// From texels row by row, at least 2 columns and 2 rows of them, seen under an illuminant. `to_world`
    /// must keep lengths. `None` for a picture without any light.
    pub fn new(
        [width, height]: [usize; 2],
        texels: Vec<Texel>,
        illuminant: Spectrum,
        to_world: Transform,
    ) -> Option<Self> {
        let parts = if width * height <= FINE { 2 } else { 1 };
        let finer = |cells: usize, least: usize| cells * least.div_ceil(cells).max(parts);
        let columns = finer(width, LEAST_COLUMNS);
        let rows = finer(height - 1, LEAST_COLUMNS / 2);
        let cosines: Vec<f64> = (0..=rows).map(|edge| (PI * edge as f64 / rows as f64).cos()).collect();
        let picture = Picture { width, height, texels: &texels };
        let (integrals, corners) = picture.cells(columns, &cosines);
        let grid = PiecewiseBilinearGrid::new(columns, &integrals, &corners)?;
        let mut map = Self {
            width,
            height,
            texels,
            illuminant,
            from_world: to_world.inverse(),
            to_world,
            grid,
            columns,
            cosines,
            mean: Spectrum::ZERO,
        };
        map.mean = map.mean_radiance();
        Some(map)
    }

    /// Radiance from a direction (unit length, away from the scene).
    pub fn radiance<const C: usize>(&self, direction: Vec3, nm: &[f64; C]) -> Sampled<C> {
        self.radiance_at(self.angles(self.from_world.vector(direction).into()), nm)
    }

    fn radiance_at<const C: usize>(&self, angles: [f64; 2], nm: &[f64; C]) -> Sampled<C> {
        let (reflectance, factor) = self.interpolate(angles, nm);
        if factor == 0.0 { Sampled::ZERO } else { reflectance * self.illuminant.sample(nm) * factor }
    }

    /// A direction toward the light and its density per steradian.
    pub fn sample(&self, u: [f64; 2]) -> (Vec3, f64) {
        let Sample { direction, density, .. } = self.find(u);
        (direction.into(), density)
    }

    /// See [`super::Environment::sample_radiance`].
    pub fn sample_radiance<const C: usize>(
        &self,
        u: [f64; 2],
        facing: Vec3,
        nm: &[f64; C],
    ) -> Option<(Vec3, f64, Sampled<C>)> {
        let sample = self.find(u);
        let direction: Vec3 = sample.direction.into();
        // Texels lie far apart in memory.
        let counts = direction.dot(facing) >= 0.0;
        counts.then(|| (direction, sample.density, self.radiance_at(sample.angles(), nm)))
    }

    /// [`Self::sample_radiance`] for the lanes asked for, each with wavelengths of its own; and the lanes
    /// whose direction is on the side from which light counts, as [`super::Receivers::facing`] has it.
    pub fn sample_in_lanes<'w, const C: usize>(
        &self,
        u: &[Row; 2],
        asked: Mask,
        facing: &[Vec3Lanes; REGISTERS],
        wavelengths: impl Fn(usize) -> &'w Wavelengths<C>,
    ) -> (EnvironmentSamples<C>, Mask) {
        let ([x, y], density) = self.grid.sample_in_lanes(u, asked);
        let (mut rows, mut edges) = (ZERO, [ZERO; 2]);
        for lane in lanes_of(asked) {
            let row = self.row(get(&y, lane));
            set(&mut rows, lane, row as f64);
            edges.iter_mut().zip(self.edges(row)).for_each(|(row, edge)| set(row, lane, edge));
        }
        let mut samples = EnvironmentSamples::NONE;
        let (mut angles, mut counts) = ([ZERO; 2], 0);
        for register in registers_of(asked) {
            let edges = edges.each_ref().map(|edge| edge[register]);
            let place = [x[register], y[register]];
            let sample = self.toward(place, rows[register], edges, density[register]);
            samples.direction[register] = sample.direction;
            samples.density[register] = sample.density;
            [angles[0][register], angles[1][register]] = sample.angles();
            let above = sample.direction.dot(facing[register]).ge(Register::ZERO);
            counts |= above.mask() << (WIDTH * register) & asked;
        }
        self.radiance_in_lanes(&angles, counts, wavelengths, &mut samples.radiance);
        (samples, counts)
    }

    /// [`Self::radiance`] and [`Self::density`] for the lanes asked for, each with wavelengths of its own.
    pub fn seen_in_lanes<'w, const C: usize>(
        &self,
        directions: &[Vec3Lanes; REGISTERS],
        asked: Mask,
        wavelengths: impl Fn(usize) -> &'w Wavelengths<C>,
    ) -> EnvironmentSamples<C> {
        let mut seen = EnvironmentSamples { direction: *directions, ..EnvironmentSamples::NONE };
        let (mut heights, mut angles) = (ZERO, [ZERO; 2]);
        for register in registers_of(asked) {
            let local = self.from_world.vectors(directions[register]);
            heights[register] = local.y;
            [angles[0][register], angles[1][register]] = self.angles(local);
        }
        let (mut rows, mut edges) = (ZERO, [ZERO; 2]);
        for lane in lanes_of(asked) {
            let row = self.row_at_angle(get(&angles[1], lane));
            set(&mut rows, lane, row as f64);
            edges.iter_mut().zip(self.edges(row)).for_each(|(row, edge)| set(row, lane, edge));
        }
        let mut place = [ZERO; 2];
        for register in registers_of(asked) {
            let edges = edges.each_ref().map(|edge| edge[register]);
            [place[0][register], place[1][register]] =
                self.place(angles[0][register], heights[register], rows[register], edges);
        }
        let density = self.grid.density_in_lanes(&place, asked);
        for register in registers_of(asked) {
            let edges = edges.each_ref().map(|edge| edge[register]);
            seen.density[register] = self.per_steradian(edges, density[register]);
        }
        self.radiance_in_lanes(&angles, asked, wavelengths, &mut seen.radiance);
        seen
    }

    /// [`Self::radiance_at`] for some lanes.
    fn radiance_in_lanes<'w, const C: usize>(
        &self,
        angles: &[Row; 2],
        asked: Mask,
        wavelengths: impl Fn(usize) -> &'w Wavelengths<C>,
        radiance: &mut SampledLanes<C>,
    ) {
        let mut corners = [Corner::NONE; 4];
        let mut nm = SampledLanes::ZERO;
        let mut illuminant: Option<(&Wavelengths<C>, Sampled<C>)> = None;
        for lane in lanes_of(asked) {
            let around = self.picture().around(self.texel_place(angles.each_ref().map(|row| get(row, lane))));
            for (corner, (weight, texel)) in corners.iter_mut().zip(around) {
                corner.set(lane, weight, texel);
            }
            let of_lane = wavelengths(lane);
            // Lanes that share their wavelengths share what is looked up by them.
            let emitted = match illuminant {
                Some((known, emitted)) if std::ptr::eq(known, of_lane) => emitted,
                _ => self.illuminant.sample(&of_lane.nm),
            };
            illuminant = Some((of_lane, emitted));
            nm.set(lane, &Sampled(of_lane.nm));
            radiance.set(lane, &emitted);
        }
        for register in registers_of(asked) {
            let factor = corners
                .iter()
                .fold(Register::ZERO, |sum, corner| sum + corner.weight[register] * corner.factor[register]);
            for wavelength in 0..C {
                let nm = nm.0[wavelength][register];
                let reflectance = corners.iter().fold(Register::ZERO, |sum, corner| {
                    let coefficients = corner.coefficients.each_ref().map(|row| row[register]);
                    sum + corner.weight[register] * reflectance(coefficients, corner.factor[register], nm)
                });
                let value = &mut radiance.0[wavelength][register];
                *value = reflectance * *value * factor;
            }
        }
    }

    fn find(&self, u: [f64; 2]) -> Sample<f64> {
        let (place, density) = self.grid.sample(u);
        let row = self.row(place[1]);
        self.toward(place, row as f64, self.edges(row), density)
    }

    /// From places on the grid, by the rows that they are in and the cosines at the edges of those, to
    /// directions. `density`: per cell.
    #[inline(always)]
    fn toward<R: Real>(&self, [x, y]: [R; 2], row: R, [above, below]: [R; 2], density: R) -> Sample<R> {
        let one = R::of(1.0);
        let cos = above + (y - row) * (below - above);
        let longitude = x / R::of(self.columns as f64) + R::of(0.5 / self.width as f64);
        let sin = (one - cos * cos).greater(R::of(0.0)).sqrt();
        let (sin_longitude, cos_longitude) = angle::sin_cos(R::of(TAU) * longitude);
        let local = Vector::new(sin * sin_longitude, cos, -sin * cos_longitude);
        Sample {
            direction: self.to_world.vectors(local),
            density: self.per_steradian([above, below], density),
            longitude,
            cos,
        }
    }

    /// The row of cells that a place is in.
    fn row(&self, y: f64) -> usize {
        (y as usize).min(self.cosines.len() - 2)
    }

    /// The density of [`Self::sample`] at a direction: above 0 wherever light comes from.
    pub fn density(&self, direction: Vec3) -> f64 {
        let local = self.from_world.vector(direction);
        let [longitude, angle] = self.angles(local.into());
        let row = self.row_at_angle(angle);
        let edges = self.edges(row);
        let place = self.place(longitude, local.y, row as f64, edges);
        self.per_steradian(edges, self.grid.density(place))
    }

    /// The row of cells at an angle from +y over π.
    fn row_at_angle(&self, angle: f64) -> usize {
        let rows = self.cosines.len() - 1;
        ((angle * rows as f64) as usize).min(rows - 1)
    }

    /// Places on the grid of directions, by their longitudes over 2π, the cosines of their angles from +y,
    /// the rows of cells that they are in and the cosines at the edges of those.
    #[inline(always)]
    fn place<R: Real>(&self, longitude: R, cos: R, row: R, [above, below]: [R; 2]) -> [R; 2] {
        let (zero, one) = (R::of(0.0), R::of(1.0));
        let x = longitude - R::of(0.5 / self.width as f64);
        let x = R::choose(x.lt(zero), x + one, x);
        let down = ((above - cos) / (above - below)).greater(zero).lesser(R::of(1f64.next_down()));
        [x * R::of(self.columns as f64), row + down]
    }

    /// Mean radiance over the sphere.
    pub fn mean(&self) -> &Spectrum {
        &self.mean
    }

    /// Density per steradian, from one per cell, by the cosines at the edges of the row.
    #[inline(always)]
    fn per_steradian<R: Real>(&self, [above, below]: [R; 2], density: R) -> R {
        density * R::of(self.columns as f64) / (R::of(TAU) * (above - below))
    }

    /// Cosines of the angles from +y at the upper and lower edge of a row of cells.
    fn edges(&self, row: usize) -> [f64; 2] {
        [self.cosines[row], self.cosines[row + 1]]
    }

    /// Longitude over 2π and angle from +y over π of a direction in the picture's frame.
    #[inline(always)]
    fn angles<R: Real>(&self, local: Vector<R>) -> [R; 2] {
        let longitude = angle::atan2(local.x, -local.z) / R::of(TAU);
        let longitude = R::choose(longitude.lt(R::of(0.0)), longitude + R::of(1.0), longitude);
        [longitude, angle::acos(local.y) / R::of(PI)]
    }

    fn picture(&self) -> Picture<'_> {
        Picture { width: self.width, height: self.height, texels: &self.texels }
    }

    /// From angles as [`Self::angles`] gives them to columns and rows from the middle of the first texel.
    fn texel_place(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        [u * self.width as f64 - 0.5, v * (self.height - 1) as f64]
    }

    fn interpolate<const C: usize>(&self, angles: [f64; 2], nm: &[f64; C]) -> (Sampled<C>, f64) {
        let mut reflectance = Sampled::ZERO;
        let mut factor = 0.0;
        for (weight, texel) in self.picture().around(self.texel_place(angles)) {
            factor += weight * f64::from(texel.factor);
            for (value, &nm) in reflectance.0.iter_mut().zip(nm) {
                *value += weight * texel.reflectance(nm);
            }
        }
        (reflectance, factor)
    }

    /// Estimated from directions that are spread by the density: a small sun is not missed.
    fn mean_radiance(&self) -> Spectrum {
        const NODES: usize = 107;
        const STRATA: usize = 64;
        let nm: [f64; NODES] = std::array::from_fn(|i| 300.0 + 5.0 * i as f64);
        let mut sum = Sampled::<NODES>::ZERO;
        for u in midpoints(STRATA) {
            let sample = self.find(u);
            let (reflectance, factor) = self.interpolate(sample.angles(), &nm);
            sum += reflectance * (factor / sample.density);
        }
        let mean = sum * self.illuminant.sample(&nm) / ((STRATA * STRATA) as f64 * 2.0 * TAU);
        Spectrum::regular(nm[0], nm[NODES - 1], &mean.0, Extrapolation::Zero).unwrap_or(Spectrum::ZERO)
    }
}

/// Sampled directions, one or several.
struct Sample<R> {
    direction: Vector<R>,
    /// Per steradian.
    density: R,
    /// Longitude over 2π, which may be a little above 1, and cosine of the angle from +y, in the picture's
    /// frame.
    longitude: R,
    cos: R,
}

impl<R: Real> Sample<R> {
    /// As [`EnvironmentMap::angles`] gives them.
    #[inline(always)]
    fn angles(&self) -> [R; 2] {
        [self.longitude, angle::acos(self.cos) / R::of(PI)]
    }
}

/// Directions toward an environment, one for each lane; those of lanes that were not asked for mean nothing.
#[derive(Clone, Debug)]
pub struct EnvironmentSamples<const C: usize> {
    /// Unit vectors toward the light.
    pub direction: [Vec3Lanes; REGISTERS],
    /// The density of light samples there, per steradian.
    pub density: Row,
    /// Radiance from there, W·m⁻²·sr⁻¹·nm⁻¹.
    pub radiance: SampledLanes<C>,
}

impl<const C: usize> EnvironmentSamples<C> {
    /// No lane has a direction.
    pub const NONE: Self =
        Self { direction: [Vec3Lanes::ZERO; REGISTERS], density: ZERO, radiance: SampledLanes::ZERO };
}

/// One of the four texels around a place, for each lane.
#[derive(Clone, Copy)]
struct Corner {
    weight: Row,
    coefficients: [Row; 3],
    factor: Row,
}

impl Corner {
    const NONE: Self = Self { weight: ZERO, coefficients: [ZERO; 3], factor: ZERO };

    #[inline(always)]
    fn set(&mut self, lane: usize, weight: f64, texel: &Texel) {
        set(&mut self.weight, lane, weight);
        set(&mut self.factor, lane, f64::from(texel.factor));
        for (row, coefficient) in self.coefficients.iter_mut().zip(texel.coefficients) {
            set(row, lane, f64::from(coefficient));
        }
    }
}

/// The texels with their places.
struct Picture<'a> {
    width: usize,
    height: usize,
    texels: &'a [Texel],
}

impl<'a> Picture<'a> {
    /// The four texels around a place, given in columns and rows from the middle of the first texel, with
    /// their weights. Columns from -1 to twice as many as there are.
    fn around(&self, [x, y]: [f64; 2]) -> [(f64, &'a Texel); 4] {
        let left = x.floor();
        let top = (y as usize).min(self.height - 2);
        let (fx, fy) = (x - left, y - top as f64);
        let column = |c: isize| {
            let width = self.width as isize;
            let c = if c < 0 { c + width } else { c };
            (if c >= width { c - width } else { c }) as usize
        };
        let (left, right) = (column(left as isize), column(left as isize + 1));
        let at = |column: usize, row: usize| &self.texels[row * self.width + column];
        [
            ((1.0 - fx) * (1.0 - fy), at(left, top)),
            (fx * (1.0 - fy), at(right, top)),
            ((1.0 - fx) * fy, at(left, top + 1)),
            (fx * fy, at(right, top + 1)),
        ]
    }

    /// About the light that comes from each cell of a grid, up to a factor, zero only where none does; and
    /// from its corners.
    fn cells(&self, columns: usize, cosines: &[f64]) -> (Vec<f64>, Vec<f32>) {
        let rows = cosines.len() - 1;
        let strength = |x: f64, y: f64| {
            let (mut reflectance, mut factor) = (0.0, 0.0);
            for (weight, texel) in self.around([x, y]) {
                // Where blue, green and red are told apart.
                reflectance +=
                    weight * [450.0, 550.0, 610.0].map(|nm| texel.reflectance(nm)).iter().sum::<f64>();
                factor += weight * f64::from(texel.factor);
            }
            reflectance * factor
        };
        let step = [self.width as f64 / columns as f64, (self.height - 1) as f64 / rows as f64];
        let corner = |column: usize, row: usize| strength(column as f64 * step[0], row as f64 * step[1]);
        let line = |row: usize| (0..=columns).map(|column| corner(column, row)).collect::<Vec<f64>>();
        // The cells of some rows, and the corners above them.
        let of_rows = |rows: Range<usize>| {
            let (mut cells, mut corners) = (Vec::new(), Vec::new());
            let mut above = line(rows.start);
            for row in rows {
                let below = line(row + 1);
                let [top, bottom] = [cosines[row], cosines[row + 1]];
                cells.extend((0..columns).map(|column| {
                    let corners = above[column] + above[column + 1] + below[column] + below[column + 1];
                    let middle = strength((column as f64 + 0.5) * step[0], (row as f64 + 0.5) * step[1]);
                    // Where only one corner shines, interpolation leaves little of it in the middle.
                    (top - bottom) * (0.5 * middle + 0.125 * corners)
                }));
                corners.extend(above.iter().map(|&value| value as f32));
                above = below;
            }
            (cells, corners)
        };
        let starts = (0..rows).into_par_iter().step_by(ROWS_AT_ONCE);
        let parts: Vec<_> = starts.map(|start| of_rows(start..(start + ROWS_AT_ONCE).min(rows))).collect();
        let (mut cells, mut corners) = (Vec::with_capacity(columns * rows), Vec::new());
        for (of_cells, of_corners) in parts {
            cells.extend(of_cells);
            corners.extend(of_corners);
        }
        corners.extend(line(rows).iter().map(|&value| value as f32));
        (cells, corners)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mitsuba 3.9.1: a picture of 8 × 4 that is black but for one white texel, at the middle of that texel
    /// and beside it.
    #[test]
    fn texels_lie_where_mitsubas_do() {
        let bright = |row: usize, column: usize| {
            let mut texels = vec![Texel::BLACK; 32];
            texels[row * 8 + column] = Texel { coefficients: [0.0; 3], factor: 2.0 };
            EnvironmentMap::new([8, 4], texels, Spectrum::ONE, Transform::IDENTITY).unwrap()
        };
        let at = |map: &EnvironmentMap, direction: [f64; 3]| {
            map.radiance(Vec3::from(direction).normalize(), &[550.0]).hero()
        };
        // 0.9385 = (31/32)²: both factors are interpolated.
        for (row, column, direction, expected) in [
            (1, 0, [0.337_496_66, 0.471_396_74, -0.814_789_0], 0.986_336 / 1.050_997),
            (2, 2, [0.814_789_0, -0.471_396_74, 0.337_496_66], 0.986_335 / 1.050_997),
            (1, 4, [-0.337_496_66, 0.471_396_74, 0.814_789_0], 0.986_335 / 1.050_997),
            (0, 0, [0.037_509_54, 0.995_184_73, -0.090_556_03], 0.863_172 / 1.050_997),
        ] {
            let found = at(&bright(row, column), direction);
            assert!((found - expected).abs() < 1e-5, "{row} {column}: {found} {expected}");
        }
    }
}
