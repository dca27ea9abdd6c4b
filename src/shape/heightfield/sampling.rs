//! Choosing points on height fields.

use super::{BASE, HeightField, index, place, wall_normal};
use crate::geometry::{SurfacePoint, Vec3};
use crate::sampling::quadrature::gauss_legendre;
use crate::shape::AreaSample;
use crate::shape::areas::AreaDistribution;

/// Areas of patches (by the normals in their middles), of the sides' strips, and of the base.
pub(super) fn areas(field: &HeightField) -> AreaDistribution {
    let cells = field.data.pyramid.cells();
    let patches = (0..cells).map(|cell| {
        let patch = field.patch(place(field.size(), cell));
        field.element(field.upward(&patch, [0.5; 2])) * field.cell_area()
    });
    let strips = (0..field.strips()).map(|strip| {
        let (wall, [first, last], width) = field.strip(strip);
        field.element(wall_normal(wall)) * 0.5 * (first + last) * width
    });
    let base = field.solid.then(|| 4.0 * field.element(Vec3::Z));
    AreaDistribution::new(patches.chain(strips).chain(base))
}

impl HeightField {
    /// World area per area across a normal whose component along one axis is 1, of the field's own
    /// coordinates and projected along that axis.
    fn element(&self, normal: Vec3) -> f64 {
        self.placement.volume * self.placement.pose.world_normal(normal).length()
    }

    fn cell_area(&self) -> f64 {
        1.0 / self.density().iter().product::<f64>()
    }

    /// The strips between the base and the border of one patch: along x = −1, x = 1, y = −1, y = 1.
    fn strips(&self) -> usize {
        let [x, y] = self.size();
        if self.solid { 2 * (x + y) } else { 0 }
    }

    /// A strip's side, its heights above the base at both ends, and its width.
    fn strip(&self, strip: usize) -> (usize, [f64; 2], f64) {
        let (wall, cell) = self.strip_place(strip);
        let along = usize::from(wall < 2);
        let height = |further: usize| {
            let mut point = [0; 2];
            point[along] = cell + further;
            point[1 - along] = if wall % 2 == 0 { 0 } else { self.size()[1 - along] };
            self.at_point(point) + 1.0
        };
        (wall, [height(0), height(1)], 1.0 / self.density()[along])
    }

    fn strip_place(&self, strip: usize) -> (usize, usize) {
        let [x, y] = self.size();
        match strip {
            strip if strip < 2 * y => (strip / y, strip % y),
            strip => (2 + (strip - 2 * y) / x, (strip - 2 * y) % x),
        }
    }

    /// Area of all patches by Gauss–Legendre quadrature.
    pub fn area(&self) -> f64 {
        const NODES: usize = 5;
        let nodes: Vec<(f64, f64)> = gauss_legendre(NODES).collect();
        let cells = self.data.pyramid.cells();
        let mut sum = self.areas.total() - self.areas.below(cells);
        for cell in 0..cells {
            let patch = self.patch(place(self.size(), cell));
            for &(x, wx) in &nodes {
                for &(y, wy) in &nodes {
                    let at = [0.5 * (x + 1.0), 0.5 * (y + 1.0)];
                    sum += 0.25 * wx * wy * self.element(self.upward(&patch, at)) * self.cell_area();
                }
            }
        }
        sum
    }

    /// A patch or strip by its area, and a place: evenly over a patch's projection, and over a strip.
    pub fn sample(&self, u: [f64; 2]) -> AreaSample {
        let (choice, fraction) = self.areas.choose(u[0]);
        let cells = self.data.pyramid.cells();
        let density = self.density();
        let (local, part) = if choice < cells {
            let cell = place(self.size(), choice);
            let at = [fraction, u[1]];
            let [x, y] = [0, 1].map(|axis| (cell[axis] as f64 + at[axis]) / density[axis] - 1.0);
            (Vec3::new(x, y, 0.0), choice)
        } else if choice < cells + self.strips() {
            let (wall, [first, last], width) = self.strip(choice - cells);
            let (_, cell) = self.strip_place(choice - cells);
            // Up to the place s there is the area first s + (last − first) s² / 2.
            let root = (first * first + fraction * (last * last - first * first)).sqrt();
            let s = fraction * (first + last) / (first + root);
            let mut local = wall_normal(wall);
            local[usize::from(wall < 2)] = (cell as f64 + s) * width - 1.0;
            local.z = u[1] * (first + (last - first) * s) - 1.0;
            (local, cells + wall)
        } else {
            (Vec3::new(2.0 * fraction - 1.0, 2.0 * u[1] - 1.0, -1.0), cells + BASE)
        };
        let surface = self.surface_at(local, part);
        let density = self.part_density(local, part);
        AreaSample { surface, triangle: part as u32, barycentric: [0.0; 2], density }
    }

    /// Per world area at a point of a cell or another part.
    fn part_density(&self, local: Vec3, part: usize) -> f64 {
        let cells = self.data.pyramid.cells();
        if part < cells {
            let (cell, at) = self.locate(local, part);
            let element = self.element(self.upward(&self.patch(cell), at));
            return self.areas.of(part) / self.areas.total() / (self.cell_area() * element);
        }
        // All but patches have the same density everywhere.
        1.0 / self.areas.total()
    }

    /// Density per area with which a sample is the point.
    pub fn area_density(&self, point: &SurfacePoint) -> f64 {
        let local = self.placement.pose.local_point(point.position);
        let normal = self.placement.pose.local_normal(point.normal);
        let outward = normal * if self.inward { -1.0 } else { 1.0 };
        // Heights never face sideways or down.
        if self.solid && outward.z <= 1e-9 * outward.length() {
            return 1.0 / self.areas.total();
        }
        let (size, density) = (self.size(), self.density());
        let cell = [0, 1].map(|axis| {
            let at = (local[axis] + 1.0) * density[axis];
            (at.max(0.0) as usize).min(size[axis] - 1)
        });
        self.part_density(local, index(size, cell))
    }
}
