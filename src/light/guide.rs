//! Where light samples go on a textured surface: to each place as often as it is bright.
//!
//! A guide is a density over a chart of the surface (see [`Shape::chart`]). Its lines are those between which
//! the texture is bilinear, or the same, so that density and radiance agree wherever that can be had;
//! otherwise they are so close together that the texture differs little from one to the next. A mesh has a
//! guide for each triangle on which it differs.

use super::AreaGeometry;
use crate::geometry::UvTransform;
use crate::sampling::{PiecewiseBilinearGrid, PiecewiseConstantGrid};
use crate::shape::{AreaSample, ChartAxes, Shape};
use crate::texture::{Lines, Texture};
use rayon::prelude::*;

/// A density over the unit square.
#[derive(Clone, Debug)]
struct Guide {
    /// Edges of columns and rows, from 0 to 1.
    edges: [Vec<f64>; 2],
    cells: Cells,
}

#[derive(Clone, Debug)]
enum Cells {
    Even(PiecewiseConstantGrid),
    Bilinear(PiecewiseBilinearGrid),
}

/// The guides of a surface.
#[derive(Clone, Debug)]
pub enum Guides {
    One(Box<Guided>),
    /// By triangle.
    Triangles(Vec<Guided>),
}

/// A part of a surface.
#[derive(Clone, Debug, Default)]
pub struct Guided {
    /// `None` where its texture is all but the same.
    guide: Option<Guide>,
    /// Its mean over that of the surface's.
    pub brightness: f64,
}

/// How many times as much the mean square of the radiance must be as the square of the mean for a guide to be
/// made: then it gains more than sampling by solid angle does, which it replaces.
const WORTH_GUIDING: f64 = 1.25;

/// The same for a sphere, half of which is hidden: samples by solid angle are all on the other half.
const WORTH_GUIDING_SPHERE: f64 = 2.5;

/// Most cells of a guide, and of all guides of a mesh.
const MOST_CELLS: usize = 1 << 22;

/// Columns and rows where the texture says nothing of its lines.
const UNKNOWN: usize = 128;

/// Most columns and rows for a triangle.
const TRIANGLE: usize = 128;

/// What a guide must give to each cell, over the mean of all: there may be more between the places that it
/// looked at.
const LEAST_SHARE: f64 = 0.01;

impl Guides {
    /// `None` where the texture differs too little to be followed, and for surfaces without a chart. `value`:
    /// what the radiance amounts to at a place of a chart, by triangle.
    pub fn new(
        shape: &Shape,
        divided: bool,
        texture: &Texture,
        value: impl Fn(u32, [f64; 2]) -> f64 + Sync,
    ) -> Option<Self> {
        shape.chart(0, [0.5; 2])?;
        if let Shape::Mesh(mesh) = shape
            && divided
        {
            let count = mesh.triangle_count();
            let [width, height] = texture.resolution().map(f64::from);
            let most = (MOST_CELLS as f64 / count as f64).sqrt().clamp(1.0, TRIANGLE as f64);
            let of = |triangle: u32| {
                let uv = |place| mesh.parametrisation(triangle, place).uv;
                let [a, b, c] = [uv([0.0; 2]), uv([1.0, 0.0]), uv([0.0, 1.0])];
                let reach = |p: [f64; 2], q: [f64; 2]| ((p[0] - q[0]) * width).hypot((p[1] - q[1]) * height);
                // Two for each texel, or what else there is to see.
                let across = 2.0 * reach(a, b).max(reach(b, c)).max(reach(c, a));
                let cells = across.max(4.0).min(most).ceil() as usize;
                let (mean, guide) = Guide::even([even(cells), even(cells)], &|place| value(triangle, place));
                (mean, guide.filter(|guide| guide.gain > WORTH_GUIDING).map(|found| found.guide))
            };
            let found: Vec<(f64, Option<Guide>)> = (0..count as u32).into_par_iter().map(of).collect();
            let areas = (0..count as u32).map(|triangle| mesh.triangle_area(triangle));
            let whole: f64 =
                areas.zip(&found).map(|(area, (mean, _))| area * mean).sum::<f64>() / mesh.area();
            let guided = |(mean, guide)| Guided { guide, brightness: mean / whole };
            return (whole > 0.0).then(|| Self::Triangles(found.into_iter().map(guided).collect()));
        }
        let least = if matches!(shape, Shape::Sphere(_)) { WORTH_GUIDING_SPHERE } else { WORTH_GUIDING };
        let value = |place| value(0, place);
        let found =
            match shape.chart_axes().zip(texture.lines()).and_then(|(axes, lines)| edges(&axes, &lines)) {
                Some((edges, true)) => Guide::bilinear(edges, &value),
                Some((edges, false)) => Guide::even(edges, &value).1,
                None => Guide::even([even(UNKNOWN), even(UNKNOWN)], &value).1,
            };
        let Found { guide, .. } = found.filter(|found| found.gain > least)?;
        Some(Self::One(Box::new(Guided { guide: Some(guide), brightness: 1.0 })))
    }

    pub fn of(&self, part: u32) -> &Guided {
        match self {
            Self::One(only) => only,
            Self::Triangles(triangles) => &triangles[part as usize],
        }
    }
}

impl Guided {
    /// A point of the part.
    pub fn sample(&self, shape: &Shape, triangle: u32, u: [f64; 2]) -> Option<AreaSample> {
        let Some(guide) = &self.guide else { return shape.chart(triangle, u) };
        let (place, density) = guide.sample(u);
        let sample = shape.chart(triangle, place)?;
        Some(AreaSample { density: sample.density * density, ..sample })
    }

    /// The density of [`Self::sample`] at a place of the chart, over what it would be if it were the same
    /// everywhere.
    pub fn density(&self, place: [f64; 2]) -> f64 {
        self.guide.as_ref().map_or(1.0, |guide| guide.density(place))
    }
}

/// A guide, and the mean square of what it follows over the square of the mean.
struct Found {
    guide: Guide,
    gain: f64,
}

impl Guide {
    /// Bilinear between lines.
    fn bilinear(edges: [Vec<f64>; 2], value: &(impl Fn([f64; 2]) -> f64 + Sync)) -> Option<Found> {
        let [x, y] = &edges;
        let columns = x.len() - 1;
        // On a closed surface the end is where it begins, and the texture need not be the same there.
        let within = |edge: f64| edge.clamp(1e-9, 1.0 - 1e-9);
        let corner = |i: usize| value([within(x[i % x.len()]), within(y[i / x.len()])]) as f32;
        let corners: Vec<f32> = (0..x.len() * y.len()).into_par_iter().map(corner).collect();
        let mean = |cell: usize| {
            let first = cell / columns * x.len() + cell % columns;
            let around = [first, first + 1, first + x.len(), first + x.len() + 1];
            0.25 * around.map(|corner| f64::from(corners[corner])).iter().sum::<f64>()
        };
        let means: Vec<f64> = (0..columns * (y.len() - 1)).map(mean).collect();
        let (_, gain, integrals) = weigh(&edges, &means);
        let cells = Cells::Bilinear(PiecewiseBilinearGrid::new(columns, &integrals, &corners)?);
        Some(Found { guide: Self { edges, cells }, gain })
    }

    /// The same throughout each cell; and the mean of all.
    fn even(edges: [Vec<f64>; 2], value: &(impl Fn([f64; 2]) -> f64 + Sync)) -> (f64, Option<Found>) {
        const LOOKS: usize = 3;
        let columns = edges[0].len() - 1;
        let mean = |cell: usize| {
            let at = [cell % columns, cell / columns];
            let look = |i: usize| {
                value([0, 1].map(|axis| {
                    let [from, to] = [0, 1].map(|side| edges[axis][at[axis] + side]);
                    let part = [i % LOOKS, i / LOOKS][axis] as f64 + 0.5;
                    from + (to - from) * part / LOOKS as f64
                }))
            };
            (0..LOOKS * LOOKS).map(look).sum::<f64>() / (LOOKS * LOOKS) as f64
        };
        let means: Vec<f64> = (0..columns * (edges[1].len() - 1)).into_par_iter().map(mean).collect();
        let (mean, gain, _) = weigh(&edges, &means);
        let raised: Vec<f64> = means.iter().map(|value| value.max(LEAST_SHARE * mean)).collect();
        let (_, _, integrals) = weigh(&edges, &raised);
        let cells = PiecewiseConstantGrid::new(columns, &integrals).map(Cells::Even);
        (mean, cells.map(|cells| Found { guide: Self { edges, cells }, gain }))
    }

    fn sample(&self, u: [f64; 2]) -> ([f64; 2], f64) {
        let (at, probability) = match &self.cells {
            Cells::Even(grid) => grid.sample(u),
            Cells::Bilinear(grid) => grid.sample(u),
        };
        let mut area = 1.0;
        let place = [0, 1].map(|axis| {
            let edges = &self.edges[axis];
            let index = (at[axis] as usize).min(edges.len() - 2);
            let width = edges[index + 1] - edges[index];
            area *= width;
            edges[index] + (at[axis] - index as f64) * width
        });
        (place, probability / area)
    }

    fn density(&self, place: [f64; 2]) -> f64 {
        let mut area = 1.0;
        let at = [0, 1].map(|axis| {
            let edges = &self.edges[axis];
            let index = edges.partition_point(|&edge| edge <= place[axis]).clamp(1, edges.len() - 1) - 1;
            let width = edges[index + 1] - edges[index];
            area *= width;
            index as f64 + ((place[axis] - edges[index]) / width).clamp(0.0, 1f64.next_down())
        });
        let probability = match &self.cells {
            Cells::Even(grid) => grid.probability(at[0] as usize, at[1] as usize),
            Cells::Bilinear(grid) => grid.density(at),
        };
        probability / area
    }
}

/// The mean of what cells have, its mean square over the square of that, and the integral over each cell.
fn weigh([x, y]: &[Vec<f64>; 2], means: &[f64]) -> (f64, f64, Vec<f64>) {
    let columns = x.len() - 1;
    let area = |cell: usize| {
        let [i, j] = [cell % columns, cell / columns];
        (x[i + 1] - x[i]) * (y[j + 1] - y[j])
    };
    let integrals: Vec<f64> = means.iter().enumerate().map(|(cell, mean)| mean * area(cell)).collect();
    let mean: f64 = integrals.iter().sum();
    let square: f64 = integrals.iter().zip(means).map(|(integral, mean)| integral * mean).sum();
    (mean, square / (mean * mean), integrals)
}

fn even(cells: usize) -> Vec<f64> {
    (0..=cells).map(|i| i as f64 / cells as f64).collect()
}

/// The lines of a texture on a chart, and whether it is bilinear between them. `None` where they are aslant,
/// and where there are too many.
fn edges(axes: &ChartAxes, lines: &Lines) -> Option<([Vec<f64>; 2], bool)> {
    let UvTransform(outer) = lines.to_uv;
    let UvTransform(inner) = axes.to_uv;
    // One after the other: rows of a, b, c for a x + b y + c.
    let rows = outer.map(|[a, b, c]| {
        [
            a * inner[0][0] + b * inner[1][0],
            a * inner[0][1] + b * inner[1][1],
            a * inner[0][2] + b * inner[1][2] + c,
        ]
    });
    let straight = |row: [f64; 3], along: usize| row[1 - along].abs() <= 1e-12 * row[along].abs();
    let of_axis = if straight(rows[0], 0) && straight(rows[1], 1) {
        [0, 1]
    } else if straight(rows[0], 1) && straight(rows[1], 0) {
        [1, 0]
    } else {
        return None;
    };
    let mut count = 1;
    let mut all = [Vec::new(), Vec::new()];
    for axis in 0..2 {
        let coordinate = of_axis[axis];
        let (slope, start) = (rows[coordinate][axis], rows[coordinate][2]);
        let per_unit = f64::from(lines.per_unit[coordinate]);
        // In lines.
        let ends = [start, start + slope].map(|end| end * per_unit - lines.offset);
        let (first, last) = (ends[0].min(ends[1]).ceil(), ends[0].max(ends[1]).floor());
        if (last - first).is_nan() || last - first >= MOST_CELLS as f64 {
            return None;
        }
        let mut edges = vec![0.0, 1.0];
        let between = if last >= first { (last - first) as usize + 1 } else { 0 };
        edges.extend((0..between).map(|i| {
            let inner = ((first + i as f64 + lines.offset) / per_unit - start) / slope;
            (axes.to_chart[axis])(inner)
        }));
        edges.retain(|edge| (0.0..=1.0).contains(edge));
        edges.sort_by(f64::total_cmp);
        // The ends stay.
        edges.dedup_by(|b, a| *b - *a < 1e-9);
        if let Some(end) = edges.last_mut() {
            *end = 1.0;
        }
        count *= edges.len();
        all[axis] = edges;
    }
    (count <= MOST_CELLS && all.iter().all(|edges| edges.len() > 1)).then_some((all, lines.bilinear))
}

impl AreaGeometry {
    /// Light samples of the surface follow a texture, as it weighs at some wavelengths (nm).
    pub fn follow<const C: usize>(&mut self, texture: &Texture, nm: &[f64; C], time: f64) {
        let value = |triangle: u32, place: [f64; 2]| {
            let sample = self.shape.chart(triangle, place);
            sample.map_or(0.0, |sample| {
                texture.sample(&self.texture_point_at(&sample, time), nm).sum().max(0.0) / C as f64
            })
        };
        let guides = Guides::new(&self.shape, self.divided, texture, value);
        self.guides = guides;
    }
}
