//! Rectangles of pixels of a film, and which of them a picture is made of.

use serde::{Deserialize, Serialize};

/// A rectangle of pixels, in coordinates of the whole film: from its top left corner, x to the right and y
/// down.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Region {
    /// Column and row of its upper left corner.
    pub offset: [u32; 2],
    /// Columns and rows.
    pub size: [u32; 2],
}

impl Region {
    /// All of a film.
    pub const fn whole(size: [u32; 2]) -> Self {
        Self { offset: [0; 2], size }
    }

    /// The first column and row behind it.
    pub fn end(self) -> [u64; 2] {
        [0, 1].map(|axis| u64::from(self.offset[axis]) + u64::from(self.size[axis]))
    }

    /// Number of its pixels.
    pub fn pixel_count(self) -> u64 {
        u64::from(self.size[0]) * u64::from(self.size[1])
    }

    /// Whether it holds all of another.
    pub fn holds(self, other: Self) -> bool {
        (0..2).all(|axis| self.offset[axis] <= other.offset[axis] && other.end()[axis] <= self.end()[axis])
    }

    /// Grown by a number of pixels to each side, as far as `bounds` goes, which holds it.
    pub fn grown(self, margin: u32, bounds: Self) -> Self {
        let offset = [0, 1].map(|axis| self.offset[axis].saturating_sub(margin).max(bounds.offset[axis]));
        let end = [0, 1].map(|axis| (self.end()[axis] + u64::from(margin)).min(bounds.end()[axis]));
        Self { offset, size: [0, 1].map(|axis| (end[axis] - u64::from(offset[axis])) as u32) }
    }

    /// With all of the squares of an edge of so many pixels, on the grid of the whole film, that it has a
    /// part in, as far as `bounds` goes, which holds it.
    pub fn aligned(self, edge: u32, bounds: Self) -> Self {
        let edge = edge.max(1);
        let offset = [0, 1].map(|axis| (self.offset[axis] / edge * edge).max(bounds.offset[axis]));
        let end =
            [0, 1].map(|axis| self.end()[axis].next_multiple_of(u64::from(edge)).min(bounds.end()[axis]));
        Self { offset, size: [0, 1].map(|axis| (end[axis] - u64::from(offset[axis])) as u32) }
    }

    /// What it has in common with another; without pixels where that is nothing.
    pub fn common(self, other: Self) -> Self {
        let offset = [0, 1].map(|axis| self.offset[axis].max(other.offset[axis]));
        let end = [0, 1].map(|axis| self.end()[axis].min(other.end()[axis]));
        Self { offset, size: [0, 1].map(|axis| end[axis].saturating_sub(u64::from(offset[axis])) as u32) }
    }

    /// A pixel of the whole film, counted from the corner of the rectangle. `None` outside of it.
    pub fn within(self, pixel: [u32; 2]) -> Option<[u32; 2]> {
        let inside =
            |axis: usize| pixel[axis].checked_sub(self.offset[axis]).filter(|&place| place < self.size[axis]);
        Some([inside(0)?, inside(1)?])
    }

    /// Its pixels in coordinates of the whole film, row by row from the top.
    pub fn pixels(self) -> impl Iterator<Item = [u32; 2]> {
        let [left, top] = self.offset;
        let [width, height] = self.size;
        (top..top + height).flat_map(move |y| (left..left + width).map(move |x| [x, y]))
    }

    /// It, cut into squares of an edge of so many pixels and what is left of them at its borders.
    pub fn tiles(self, edge: u32) -> impl Iterator<Item = Self> {
        let [across, down] = self.size.map(|size| size.div_ceil(edge));
        Self::whole([across, down]).pixels().map(move |tile| {
            let from = tile.map(|place| place * edge);
            let size = [0, 1].map(|axis| edge.min(self.size[axis] - from[axis]));
            Self { offset: [0, 1].map(|axis| self.offset[axis] + from[axis]), size }
        })
    }
}

/// A film, and which parts of it there are. Each holds the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Extent {
    /// Width and height of the whole film.
    pub whole: [u32; 2],
    /// What the sensor exposes: all of it or its crop window. What the window leaves out is no part of the
    /// picture.
    pub window: Region,
    /// What is measured: what is shown, and pixels around it that something shown depends on.
    pub measured: Region,
    /// What is asked for. It is the same, bit by bit, as in a picture of the whole window.
    pub shown: Region,
}

impl Extent {
    /// All of a film.
    pub const fn whole(size: [u32; 2]) -> Self {
        let all = Region::whole(size);
        Self { whole: size, window: all, measured: all, shown: all }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regions_grow_within_others() {
        let film = Region::whole([10, 8]);
        let part = Region { offset: [7, 0], size: [2, 3] };
        assert!(film.holds(part) && film.holds(film) && !part.holds(film));
        assert_eq!(part.grown(2, film), Region { offset: [5, 0], size: [5, 5] });
        assert_eq!(part.grown(0, film), part);
        assert_eq!(part.aligned(4, film), Region { offset: [4, 0], size: [6, 4] });
        assert_eq!(part.aligned(1, film), part);
        let beyond = Region { offset: [u32::MAX, 0], size: [2, 1] };
        assert!(!film.holds(beyond));
    }

    #[test]
    fn pixels_are_counted_from_the_corner() {
        let part = Region { offset: [7, 1], size: [2, 3] };
        assert_eq!(part.within([8, 3]), Some([1, 2]));
        for outside in [[6, 1], [9, 1], [7, 0], [7, 4]] {
            assert_eq!(part.within(outside), None);
        }
        let pixels: Vec<_> = part.pixels().collect();
        assert_eq!((pixels[0], pixels[1], pixels[5], pixels.len()), ([7, 1], [8, 1], [8, 3], 6));
    }

    #[test]
    fn tiles_cover_each_pixel_once() {
        let part = Region { offset: [5, 2], size: [35, 17] };
        let mut covered: Vec<_> = part.tiles(16).flat_map(Region::pixels).collect();
        covered.sort();
        let mut all: Vec<_> = part.pixels().collect();
        all.sort();
        assert_eq!(covered, all);
    }
}
