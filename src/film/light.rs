//! What light subpaths bring to a film, beside the samples of its pixels.

use super::{Film, FixedPoint, Sums};

/// What light subpaths brought. Any of them may have come to any pixel, so it is their number that their sums
/// are divided by.
#[derive(Debug)]
pub(super) struct LightPaths {
    /// Like the film's own; empty where there are none.
    pub sums: Sums,
    /// By replicate: how many there were.
    pub count: Vec<u64>,
    /// A path may bring to one pixel what comes to all of them.
    pub scale: FixedPoint,
}

impl LightPaths {
    pub fn is_empty(&self) -> bool {
        self.sums.of_first.is_empty()
    }

    /// What they brought to a replicate of a pixel, per path: a linear function of their sums, in the unit of
    /// contributions.
    #[inline]
    pub fn mean(&self, replicate: usize, of_sums: impl Fn(&Sums) -> f64) -> f64 {
        let count = self.count[replicate];
        if self.is_empty() || count == 0 {
            return 0.0;
        }
        of_sums(&self.sums) * self.scale.quantum / count as f64
    }
}

impl Film {
    /// Adds what one light subpath brought to channels of a replicate of a pixel.
    pub fn add_light(&mut self, [x, y]: [u32; 2], replicate: u32, sums: &[(u32, i64)]) {
        let cell = self.index(x, y) * self.replicates as usize + replicate as usize;
        for &(channel, sum) in sums {
            let is_lost = self.light.sums.add_to(cell, channel as usize, sum);
            self.bad.overflow += u64::from(is_lost);
        }
        // Each comes to a page of its own.
        self.light.sums.of_bins.uses(PAGE);
    }

    /// Counts further light subpaths of a replicate.
    pub fn count_light(&mut self, replicate: u32, paths: u64) {
        self.light.count[replicate as usize] += paths;
    }
}

/// Integers of a page of memory.
const PAGE: usize = 4096 / size_of::<i64>();
