//! Surface coordinates on their way to a texture.

use crate::geometry::UvTransform;

/// Lines along both coordinates between which a texture is simple.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lines {
    /// Transform to the coordinates in which they lie.
    pub to_uv: UvTransform,
    /// So many of either kind for each unit.
    pub per_unit: [u32; 2],
    /// Place of the first line, in distances between two.
    pub offset: f64,
    /// Whether what is between them is bilinear; else it is the same.
    pub bilinear: bool,
}

/// What lies beyond the edges of an image or grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wrap {
    /// The picture begins anew.
    Repeat,
    /// The picture goes on as its mirror image.
    Mirror,
    /// The value at the edge goes on.
    Clamp,
}

impl Wrap {
    /// The texel that stands for the one at `index` in a row of `size`.
    #[inline]
    pub fn index(self, index: i64, size: usize) -> usize {
        let size = size as i64;
        let inside = match self {
            Self::Repeat => index.rem_euclid(size),
            Self::Clamp => index.clamp(0, size - 1),
            Self::Mirror => {
                let index = index.rem_euclid(2 * size);
                index.min(2 * size - 1 - index)
            }
        };
        inside as usize
    }

    /// The two texels between whose centres a coordinate (1 along the whole row) lies, and the fraction of
    /// the second.
    #[inline]
    pub fn between(self, coordinate: f64, size: usize) -> ([usize; 2], f64) {
        let place = coordinate * size as f64 - 0.5;
        let (cell, fraction) = cell(place);
        ([self.index(cell, size), self.index(cell + 1, size)], fraction)
    }

    /// The texel that a coordinate lies in.
    #[inline]
    pub fn nearest(self, coordinate: f64, size: usize) -> usize {
        self.index(cell(coordinate * size as f64).0, size)
    }
}

/// The cell of a number, and how far it lies into that. Coordinates too far away to tell, and what is no
/// number, are in cell 0.
#[inline]
fn cell(place: f64) -> (i64, f64) {
    const FARTHEST: f64 = (1u64 << 52) as f64;
    let floor = place.floor();
    if floor.abs() < FARTHEST { (floor as i64, place - floor) } else { (0, 0.0) }
}
