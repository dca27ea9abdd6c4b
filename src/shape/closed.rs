//! Whether a shape encloses a volume: what is inside of it can then be told from how often a line has crossed it.

use super::{Mesh, Shape};
use crate::geometry::{Ray, Vec3};
use std::collections::HashMap;

impl Shape {
    /// Whether it is closed and its normals point outward, so that every line enters and leaves it by turns.
    pub fn encloses(&self) -> bool {
        match self {
            Self::Sphere(_) | Self::Torus(_) => self.faces_outward(),
            Self::Quadric(quadric) => quadric.is_closed() && self.faces_outward(),
            Self::Sampled(sampled) => sampled.is_closed() && self.faces_outward(),
            Self::Figure(figure) => figure.is_closed() && self.faces_outward(),
            Self::Mesh(mesh) => mesh.encloses(),
            Self::Disk(_) | Self::Cylinder(_) => false,
        }
    }

    /// Of a closed shape: whether lines enter it before they leave it.
    fn faces_outward(&self) -> bool {
        let probes = (0..16).filter_map(|i| self.sample([(f64::from(i) + 0.5) / 16.0, 0.3]));
        let first_crossing = |point: Vec3, normal: Vec3| {
            self.crossings(&Ray::new(point, -normal)).first().map(|crossing| crossing.enters)
        };
        let mut found = probes.filter_map(|probe| {
            let point = probe.surface.point;
            first_crossing(point.position, point.normal)
        });
        found.next().unwrap_or(false)
    }

    /// Bound on how far the surface lies from where its file puts it: meshes are rounded to single precision, everything
    /// by the transforms. `shift` is how far it was moved to the scene's own coordinates.
    pub fn placement_error(&self, shift: f64) -> f64 {
        let bounds = self.bounds();
        let reach = if bounds.is_empty() { 0.0 } else { bounds.min.abs().max(bounds.max.abs()).length() };
        // A point goes through few products of matrices and one of a matrix and a vector, of four terms each.
        let by_transforms = 32.0 * f64::EPSILON * (reach + shift);
        match self {
            Self::Mesh(_) => 0.5 * f64::from(f32::EPSILON) * reach + by_transforms,
            _ => by_transforms,
        }
    }

    /// The largest error bound of a point on it, as far as a grid of points tells. Not a bound: it says how far to look.
    pub fn typical_error(&self) -> f64 {
        let at = |i: u32| [(f64::from(i % 8) + 0.5) / 8.0, (f64::from(i / 8) + 0.5) / 8.0];
        let errors = (0..64).filter_map(|i| Some(self.sample(at(i))?.surface.point.error));
        errors.fold(0.0, f64::max)
    }
}

impl Mesh {
    /// Whether every edge is passed as often in one direction as in the other, vertices at the same place being the same, and
    /// the enclosed volume is positive.
    fn encloses(&self) -> bool {
        let data = self.data();
        let mut places: HashMap<[u32; 3], u32> = HashMap::new();
        let welded: Vec<u32> = data
            .positions
            .iter()
            .map(|position| {
                // Zero has two signs.
                let key = position.map(|x| (x + 0.0).to_bits());
                let next = places.len() as u32;
                *places.entry(key).or_insert(next)
            })
            .collect();
        let mut balance: HashMap<(u32, u32), i32> = HashMap::new();
        let mut volume = 0.0;
        for (triangle, indices) in (0u32..).zip(&data.indices) {
            let corners = indices.map(|index| welded[index as usize]);
            for i in 0..3 {
                let (from, to) = (corners[i], corners[(i + 1) % 3]);
                let (edge, way) = if from < to { ((from, to), 1) } else { ((to, from), -1) };
                if from != to {
                    *balance.entry(edge).or_default() += way;
                }
            }
            let [a, b, c] = self.triangle(triangle);
            volume += a.dot(b.cross(c));
        }
        let side = if data.flip_normals { -1.0 } else { 1.0 };
        !balance.is_empty() && balance.values().all(|&sum| sum == 0) && volume * side > 0.0
    }
}
