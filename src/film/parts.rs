//! The sums of a film as they are: what is kept of an unfinished picture, and what parts of a picture are put
//! together from.

use super::{Film, Region};

/// The sums of some pixels of a row.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Row {
    /// By pixel, replicate and channel.
    pub sums: Vec<i64>,
    /// What light subpaths brought, likewise; empty where there are none.
    pub light: Vec<i64>,
    /// By pixel: samples taken within it.
    pub samples: Vec<u32>,
}

impl Film {
    /// Integers of a pixel, in each of the sums of a [`Row`].
    pub fn sums_per_pixel(&self) -> usize {
        self.replicates as usize * self.extras.channels()
    }

    /// A row of the part that is measured, by its number in it.
    pub fn row(&self, y: u32) -> Row {
        let pixels = y as usize * self.width as usize..(y as usize + 1) * self.width as usize;
        let replicates = self.replicates as usize;
        let cells = pixels.start * replicates..pixels.end * replicates;
        Row {
            sums: self.sums.of_all(cells.clone()),
            light: if self.light.is_empty() { Vec::new() } else { self.light.sums.of_all(cells) },
            samples: self.samples[pixels].to_vec(),
        }
    }

    /// Adds a row of a film that measures the same, as far as its pixels are in `region` and in this film.
    /// `corner` is where the row begins on the whole film. A sum that does not fit is left out and counted.
    pub fn add_row(&mut self, corner: [u32; 2], row: &Row, region: Region) {
        let each = self.sums_per_pixel();
        let own = Region { offset: corner, size: [row.samples.len() as u32, 1] };
        let common = own.common(region).common(self.extent.measured);
        let Some([x, y]) = self.extent.measured.within(common.offset).filter(|_| common.pixel_count() > 0)
        else {
            return;
        };
        let (from, to) = ((common.offset[0] - corner[0]) as usize, self.index(x, y));
        let count = common.size[0] as usize;
        for (own, more) in self.samples[to..to + count].iter_mut().zip(&row.samples[from..from + count]) {
            *own += more;
        }
        let (cell, sums) = (to * self.replicates as usize, from * each..(from + count) * each);
        self.bad.overflow += self.sums.add(cell, &row.sums[sums.clone()]);
        self.sums.of_bins.uses(sums.len());
        if !self.light.is_empty() && !row.light.is_empty() {
            self.bad.overflow += self.light.sums.add(cell, &row.light[sums.clone()]);
            self.light.sums.of_bins.uses(sums.len());
        }
    }

    /// All samples of all pixels that are measured.
    pub fn measured_samples(&self) -> u64 {
        self.samples.iter().map(|&samples| u64::from(samples)).sum()
    }

    /// By replicate: how many light subpaths there were.
    pub fn light_counts(&self) -> &[u64] {
        &self.light.count
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{Extent, Extras, FixedPoint, Tristimulus};

    #[test]
    fn rows_go_where_they_belong() {
        let extras = Extras { light_paths: true, ..Extras::default() };
        let part = Region { offset: [2, 1], size: [3, 2] };
        let extent = Extent { measured: part, shown: part, ..Extent::whole([6, 4]) };
        let mut film = Film::part(extent, 2, extras.clone(), FixedPoint::for_reference(1.0));
        let mut tile = extras.tile([0, 0], [3, 2], 0..2);
        for place in 0..6 {
            tile.add_weighed(place, 1, &Tristimulus::BLACK, place as f64);
            tile.count(place, 1 + place as u32);
        }
        film.add(&tile);
        film.add_light([1, 1], 0, &[(0, 7)]);
        let mut whole = Film::new(6, 4, 2, extras, FixedPoint::for_reference(1.0));
        // All but its first column, twice.
        let region = Region { offset: [3, 0], size: [9, 9] };
        for y in [0, 1, 0, 1] {
            whole.add_row([2, 1 + y], &film.row(y), region);
        }
        let samples = |x, y| whole.samples(x, y);
        assert_eq!([samples(2, 1), samples(3, 1), samples(4, 2), samples(5, 1)], [0, 4, 12, 0]);
        let light = whole.row(2).light;
        assert_eq!((light[3 * 8], light.iter().sum::<i64>()), (14, 14));
        // Beyond the film.
        whole.add_row([5, 3], &film.row(0), region);
        assert_eq!((whole.samples(5, 3), whole.samples(0, 0)), (1, 0));
        assert_eq!(whole.bad.total(), 0);
    }
}
