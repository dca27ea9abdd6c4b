//! Deformed meshes: twisted, tapered and bent along z (Barr, "Global and local deformations of solid
//! primitives", SIGGRAPH 1984; Glassner, *An Introduction to Ray Tracing*, ch. 3, 3.3).
//!
//! It is the vertices that move: triangles stay flat, so what is to be bent must have been cut finely enough.

use super::{MeshAttribute, MeshData, to_f64};
use crate::geometry::Vec3;
use crate::shape::ShapeError;
use glam::DMat3;

/// A change of a mesh in its own coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Deformation {
    /// Each triangle becomes four, as often as it says.
    Subdivide(u32),
    /// Turned around z, in radians per unit of z.
    Twist(f64),
    /// x and y multiplied by one and `Taper` times z, which must stay above 0.
    Taper(f64),
    /// Along z, between two heights, bent toward x by so many radians per unit; what is beyond them stays
    /// straight.
    Bend {
        /// Radians per unit of z.
        rate: f64,
        /// Height at which the bend begins.
        from: f64,
        /// Height at which the bend ends.
        to: f64,
    },
}

impl Deformation {
    /// Most triangles that [`Deformation::Subdivide`] may make of a mesh: a word of a file must not fill the
    /// memory.
    pub const MOST_TRIANGLES: usize = 1 << 20;

    /// The image of a point, and the derivative there.
    pub fn at(&self, point: Vec3) -> (Vec3, DMat3) {
        let Vec3 { x, y, z } = point;
        let columns = DMat3::from_cols;
        match *self {
            Self::Subdivide(_) => (point, DMat3::IDENTITY),
            Self::Twist(rate) => {
                let (sin, cos) = (rate * z).sin_cos();
                let turned = Vec3::new(x * cos - y * sin, x * sin + y * cos, z);
                let along = Vec3::new(-rate * turned.y, rate * turned.x, 1.0);
                (turned, columns(Vec3::new(cos, sin, 0.0), Vec3::new(-sin, cos, 0.0), along))
            }
            Self::Taper(slope) => {
                let width = 1.0 + slope * z;
                let along = Vec3::new(slope * x, slope * y, 1.0);
                (Vec3::new(width * x, width * y, z), columns(Vec3::X * width, Vec3::Y * width, along))
            }
            Self::Bend { rate: 0.0, .. } => (point, DMat3::IDENTITY),
            Self::Bend { rate, from, to } => {
                let bent = z.clamp(from, to);
                let (sin, cos) = (rate * (bent - from)).sin_cos();
                // In the frame of the rod of radius 1 / rate that the mesh is bent around.
                let (off, straight) = (x - 1.0 / rate, z - bent);
                let place =
                    Vec3::new(off * cos + 1.0 / rate + straight * sin, y, from - off * sin + straight * cos);
                let stretch = if z == bent { 1.0 - rate * x } else { 1.0 };
                let along = Vec3::new(sin, 0.0, cos) * stretch;
                (place, columns(Vec3::new(cos, 0.0, -sin), Vec3::Y, along))
            }
        }
    }
}

impl MeshData {
    /// The mesh after one deformation after the other. Vertex normals go by the inverse transpose of the
    /// derivative.
    ///
    /// # Errors
    /// Where a deformation folds the mesh over, or there would be too many triangles.
    pub fn deformed(&self, deformations: &[Deformation]) -> Result<Self, ShapeError> {
        let mut mesh = self.clone();
        for deformation in deformations {
            if let Deformation::Subdivide(times) = *deformation {
                let most = Deformation::MOST_TRIANGLES;
                for _ in 0..times {
                    if 4 * mesh.indices.len() > most {
                        return Err(ShapeError::TooFine { most });
                    }
                    // Nothing is not made more.
                    if mesh.indices.is_empty() {
                        break;
                    }
                    mesh = mesh.subdivided();
                }
                continue;
            }
            for (vertex, position) in mesh.positions.iter_mut().enumerate() {
                let (moved, derivative) = deformation.at(to_f64(*position));
                let image = moved.as_vec3();
                // What a taper turns over along x and y has kept its volume's sign.
                let upright = derivative.determinant() > 0.0
                    && !matches!(deformation, Deformation::Taper(slope) if 1.0 + slope * f64::from(position[2]) <= 0.0);
                if !upright || !image.is_finite() {
                    return Err(ShapeError::Folded { vertex });
                }
                *position = image.to_array();
                if let Some(normals) = &mut mesh.normals {
                    let turned = derivative.inverse().transpose() * to_f64(normals[vertex]);
                    normals[vertex] = turned.normalize_or_zero().as_vec3().to_array();
                }
            }
        }
        Ok(mesh)
    }

    /// Each triangle as four: its corners', and one between the middles of its sides.
    fn subdivided(&self) -> Self {
        let sides = |&[a, b, c]: &[u32; 3]| [[a, b], [b, c], [c, a]].map(|[p, q]| [p.min(q), p.max(q)]);
        let mut pairs: Vec<[u32; 2]> = self.indices.iter().flat_map(sides).collect();
        pairs.sort_unstable();
        pairs.dedup();
        // All of them are there.
        let middle = |side: [u32; 2]| {
            (self.positions.len() + pairs.binary_search(&side).unwrap_or_else(|place| place)) as u32
        };
        let parts = |triangle: &[u32; 3]| {
            let ([a, b, c], [ab, bc, ca]) = (*triangle, sides(triangle).map(middle));
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        let indices = self.indices.iter().flat_map(parts).collect();
        fn with_middles<const N: usize>(values: &[[f32; N]], pairs: &[[u32; 2]]) -> Vec<[f32; N]> {
            let mean = |&[a, b]: &[u32; 2]| {
                let (a, b) = (values[a as usize], values[b as usize]);
                std::array::from_fn(|i| (0.5 * (f64::from(a[i]) + f64::from(b[i]))) as f32)
            };
            values.iter().copied().chain(pairs.iter().map(mean)).collect()
        }
        let attribute = |attribute: &MeshAttribute| {
            let channels = attribute.channels;
            let values = if attribute.per_face {
                attribute.values.chunks(channels).flat_map(|value| value.repeat(4)).collect()
            } else {
                let value =
                    |vertex: u32, i: usize| f64::from(attribute.values[vertex as usize * channels + i]);
                let mean = |&[a, b]: &[u32; 2]| {
                    (0..channels).map(move |i| (0.5 * (value(a, i) + value(b, i))) as f32)
                };
                attribute.values.iter().copied().chain(pairs.iter().flat_map(mean)).collect()
            };
            MeshAttribute { values, ..attribute.clone() }
        };
        Self {
            positions: with_middles(&self.positions, &pairs),
            normals: self.normals.as_ref().map(|normals| with_middles(normals, &pairs)),
            uvs: self.uvs.as_ref().map(|uvs| with_middles(uvs, &pairs)),
            attributes: self.attributes.iter().map(attribute).collect(),
            indices,
            flip_normals: self.flip_normals,
            is_rewound: self.is_rewound,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg as Random;

    const ALL: [Deformation; 5] = [
        Deformation::Twist(0.7),
        Deformation::Taper(-0.3),
        Deformation::Bend { rate: 0.4, from: -0.5, to: 0.8 },
        Deformation::Bend { rate: -0.6, from: -0.5, to: 0.8 },
        Deformation::Bend { rate: 0.0, from: 0.0, to: 1.0 },
    ];

    /// Derivatives against differences, and determinants against what Barr says of volumes.
    #[test]
    fn derivatives_are_those_of_differences() {
        let mut random = Random::seed_from_u64(1);
        for deformation in ALL {
            for _ in 0..200 {
                let point = Vec3::from_array(std::array::from_fn(|_| random.random_range(-1.0..1.0)));
                let (_, derivative) = deformation.at(point);
                let h = 1e-6;
                // Not across the ends of what is bent.
                let smooth = match deformation {
                    Deformation::Bend { from, to, .. } => {
                        (point.z - from).abs() > h && (point.z - to).abs() > h
                    }
                    _ => true,
                };
                for axis in 0..3 {
                    let step = Vec3::AXES[axis] * h;
                    let by_difference =
                        (deformation.at(point + step).0 - deformation.at(point - step).0) / (2.0 * h);
                    let off = (derivative.col(axis) - by_difference).length();
                    assert!(!smooth || off < 1e-9, "{deformation:?} {point} {axis}: {off:e}");
                }
                let expected = match deformation {
                    Deformation::Twist(_) | Deformation::Subdivide(_) => 1.0,
                    Deformation::Taper(slope) => (1.0 + slope * point.z).powi(2),
                    Deformation::Bend { rate, from, to } if (from..=to).contains(&point.z) => {
                        1.0 - rate * point.x
                    }
                    Deformation::Bend { .. } => 1.0,
                };
                assert!((derivative.determinant() - expected).abs() < 1e-12, "{deformation:?}");
            }
        }
    }

    fn volume(mesh: &MeshData) -> f64 {
        let corner = |index: u32| to_f64(mesh.positions[index as usize]);
        let volume = |&[a, b, c]: &[u32; 3]| corner(a).dot(corner(b).cross(corner(c))) / 6.0;
        mesh.indices.iter().map(volume).sum()
    }

    /// A twist keeps the volume; finer meshes come nearer to it, fourfold with each step.
    #[test]
    fn twisting_keeps_the_volume() {
        let off = |fineness: u32| {
            let twisted = MeshData::cube(false)
                .deformed(&[Deformation::Subdivide(fineness), Deformation::Twist(1.0)])
                .unwrap();
            assert_eq!(twisted.indices.len(), 12 << (2 * fineness));
            (volume(&twisted) - 8.0).abs()
        };
        assert!(off(0) > 0.1 && off(5) < 0.01, "{} {}", off(0), off(5));
        assert!((3.0..5.0).contains(&(off(3) / off(4))), "{} {}", off(3), off(4));
        // A taper has the integral of its square: ∫ 4 (1 − 0.3 z)² over [−1, 1].
        let tapered =
            MeshData::cube(false).deformed(&[Deformation::Subdivide(5), Deformation::Taper(-0.3)]).unwrap();
        assert!((volume(&tapered) - 8.0 * (1.0 + 0.03)).abs() < 1e-4, "{}", volume(&tapered));
    }

    /// Vertex normals go with the surface: across the triangles about their vertices, up to the fineness.
    #[test]
    fn normals_stand_across_the_deformed_surface() {
        for deformation in ALL {
            let mesh = MeshData::cube(false).deformed(&[Deformation::Subdivide(6), deformation]).unwrap();
            let normals = mesh.normals.as_ref().unwrap();
            for &triangle in &mesh.indices {
                let [a, b, c] = triangle.map(|index| to_f64(mesh.positions[index as usize]));
                let across = (b - a).cross(c - a).normalize();
                for index in triangle {
                    let off = (to_f64(normals[index as usize]) - across).length();
                    assert!(off < 0.06, "{deformation:?}: {off}");
                }
            }
        }
    }

    #[test]
    fn what_is_cut_too_finely_is_refused() {
        let cut = |times: &[u32]| {
            let all: Vec<_> = times.iter().map(|&times| Deformation::Subdivide(times)).collect();
            MeshData::cube(false).deformed(&all)
        };
        assert_eq!(cut(&[4, 4]).unwrap().indices.len(), 12 << 16);
        for too_often in [&[9][..], &[8, 1], &[u32::MAX]] {
            assert!(matches!(cut(too_often), Err(ShapeError::TooFine { .. })));
        }
        let nothing = MeshData { indices: Vec::new(), ..MeshData::cube(false) };
        assert!(nothing.deformed(&[Deformation::Subdivide(u32::MAX)]).unwrap().indices.is_empty());
    }

    #[test]
    fn what_is_folded_over_is_refused() {
        let folded = |deformation| MeshData::cube(false).deformed(&[deformation]).err();
        assert!(matches!(folded(Deformation::Taper(1.5)), Some(ShapeError::Folded { .. })));
        let bend = Deformation::Bend { rate: 2.0, from: -1.0, to: 1.0 };
        assert!(matches!(folded(bend), Some(ShapeError::Folded { .. })));
        assert!(folded(Deformation::Twist(50.0)).is_none());
    }
}
