//! Choosing points on patches evenly by their area.
//!
//! Each patch is cut into cells, over each of which |∂p/∂u × ∂p/∂v| is bounded by the coefficients of that
//! vector, a polynomial of the fifth degree along both parameters. A cell is chosen in proportion to its
//! bound, a place in it evenly, and that is kept in proportion to what of the bound is reached there. So the
//! density is the same everywhere, and for some u there is no point.

use super::bicubic::Bicubic;
use super::{Patches, Shared};
use crate::geometry::Vec3;
use crate::sampling::quadrature::gauss_legendre;
use crate::shape::AreaSample;
use crate::shape::areas::AreaDistribution;

/// Along both parameters of a patch.
const CELLS: usize = 8;

const CELL: f64 = 1.0 / CELLS as f64;

#[derive(Debug)]
pub struct Table {
    /// Bounds of cells times their share of the parameters, patch by patch.
    areas: AreaDistribution,
    area: f64,
}

/// The ranges of parameters of a cell.
fn ranges(cell: usize) -> [[f64; 2]; 2] {
    [cell % CELLS, cell / CELLS].map(|i| [i as f64 * CELL, (i + 1) as f64 * CELL])
}

/// A bound on |∂p/∂u × ∂p/∂v| over the unit square.
fn bound(Bicubic(c): &Bicubic<Vec3>) -> f64 {
    const SECOND: [f64; 3] = [1.0, 2.0, 1.0];
    const THIRD: [f64; 4] = [1.0, 3.0, 3.0, 1.0];
    const FIFTH: [f64; 6] = [1.0, 5.0, 10.0, 10.0, 5.0, 1.0];
    let mut product = [[Vec3::ZERO; 6]; 6];
    for i in 0..3 {
        for j in 0..4 {
            let along_u = (c[i + 1][j] - c[i][j]) * (9.0 * SECOND[i] * THIRD[j]);
            for k in 0..4 {
                for l in 0..3 {
                    let along_v = (c[k][l + 1] - c[k][l]) * (THIRD[k] * SECOND[l]);
                    product[i + k][j + l] += along_u.cross(along_v) / (FIFTH[i + k] * FIFTH[j + l]);
                }
            }
        }
    }
    product.iter().flatten().fold(0.0, |most: f64, vector| most.max(vector.length()))
}

impl Table {
    fn new(shared: &Shared) -> Self {
        const NODES: usize = 4;
        let nodes: Vec<(f64, f64)> = gauss_legendre(NODES).map(|(x, w)| (0.5 * (x + 1.0), 0.5 * w)).collect();
        let (mut bounds, mut area) = (Vec::new(), 0.0);
        for patch in &shared.patches {
            for cell in 0..CELLS * CELLS {
                let part = patch.anchored.points.part(ranges(cell));
                // A little more than rounding takes.
                bounds.push(bound(&part) * (1.0 + 1e-12));
                for &(u, wu) in &nodes {
                    for &(v, wv) in &nodes {
                        let [along_u, along_v] = part.slopes([u, v]);
                        area += wu * wv * along_u.cross(along_v).length();
                    }
                }
            }
        }
        Self { areas: AreaDistribution::new(bounds), area }
    }
}

impl Patches {
    fn table(&self) -> &Table {
        self.shared.table.get_or_init(|| Table::new(&self.shared))
    }

    /// Area by Gauss–Legendre quadrature over cells.
    pub fn area(&self) -> f64 {
        self.table().area
    }

    /// For some `u` there is no point.
    pub fn sample(&self, u: [f64; 2]) -> Option<AreaSample> {
        // The last digits of the place in a cell, on which nothing else depends, decide whether it is kept.
        const STRIPS: f64 = 65536.0;
        let areas = &self.table().areas;
        let (choice, fraction) = areas.choose(u[0]);
        let (patch, cell) = ((choice / (CELLS * CELLS)) as u32, choice % (CELLS * CELLS));
        let [[from_u, _], [from_v, _]] = ranges(cell);
        let at = [from_u + fraction * CELL, from_v + u[1] * CELL];
        let [along_u, along_v] = self.patch(patch).points.slopes(at);
        let reached = along_u.cross(along_v).length() * CELL * CELL;
        (reached > (fraction * STRIPS).fract() * areas.of(choice)).then(|| AreaSample {
            surface: self.surface_at(patch, at),
            triangle: patch,
            barycentric: at,
            density: 1.0 / areas.total(),
        })
    }

    /// The same everywhere.
    pub fn area_density(&self) -> f64 {
        1.0 / self.table().areas.total()
    }
}
