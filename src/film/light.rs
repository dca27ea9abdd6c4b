//! What light subpaths bring to a film, beside the samples of its pixels.

use super::{Film, FixedPoint};

/// What light subpaths brought. Any of them may have come to any pixel, so it is their number that their sums
/// are divided by.
#[derive(Clone, Debug)]
pub(super) struct LightPaths {
    /// Like the film's own; empty where there are none.
    pub sums: Vec<i64>,
    /// By replicate: how many there were.
    pub count: Vec<u64>,
    /// A path may bring to one pixel what comes to all of them.
    pub scale: FixedPoint,
}

impl LightPaths {
    /// What they brought to a replicate of a pixel, per path: a linear function of the channels, in the unit
    /// of contributions.
    pub fn mean(
        &self,
        index: usize,
        replicate: usize,
        channels: usize,
        of_sums: impl Fn(&[i64]) -> f64,
    ) -> f64 {
        let count = self.count[replicate];
        if self.sums.is_empty() || count == 0 {
            return 0.0;
        }
        let sums = &self.sums[(index * self.count.len() + replicate) * channels..][..channels];
        of_sums(sums) * self.scale.quantum / count as f64
    }
}

impl Film {
    /// Adds what one light subpath brought to a replicate of a pixel. `sums` are those of one replicate.
    pub fn add_light(&mut self, [x, y]: [u32; 2], replicate: u32, sums: &[i64]) {
        let channels = self.extras.channels();
        let first = (self.index(x, y) * self.replicates as usize + replicate as usize) * channels;
        for (sum, &value) in self.light.sums[first..first + channels].iter_mut().zip(sums) {
            match sum.checked_add(value) {
                Some(next) => *sum = next,
                None => self.bad.overflow += 1,
            }
        }
    }

    /// Says that a replicate has had so many light subpaths more.
    pub fn count_light(&mut self, replicate: u32, paths: u64) {
        self.light.count[replicate as usize] += paths;
    }
}
