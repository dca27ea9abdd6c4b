//! How many samples a pixel has, and how they are dealt.

use crate::sampling::SamplerKind;

/// How the samples of a pixel are dealt: into replicates, whose spread tells the error, of a few nets.
///
/// A net is one sequence of the sampler, well spread as a whole, and independent of the other nets. The
/// replicates of a net are equal runs of it. Runs of one net complete each other, so they differ more than
/// independent ones of that length would differ from their mean: the error that they tell is that of the
/// picture or above it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Schedule {
    /// Replicates in all.
    pub replicates: u32,
    /// Replicates of each net: a divisor of their number.
    pub per_net: u32,
    /// Samples of a pixel in each replicate, from 1 to [`Schedule::LONGEST_REPLICATE`].
    pub samples_per_replicate: u32,
}

impl Schedule {
    /// Most samples of a pixel in a replicate: sums of more, integers of 64 bits, may not hold them.
    pub const LONGEST_REPLICATE: u32 = 1 << 22;

    /// Deals `samples` per pixel, or the next larger number that can be dealt, into replicates of equal
    /// length.
    ///
    /// More replicates tell the error more surely, longer ones are better stratified: about eight is a
    /// compromise. Where the number allows, replicates are powers of two long, as the Sobol sampler likes
    /// best.
    pub fn new(samples: u32) -> Self {
        let samples = samples.max(1);
        if samples < 8 {
            return Self::independent(samples, 1).of_two_nets();
        }
        let dealt = (samples..=u32::MAX).find_map(|total| {
            let fitting = (4..=16).filter(|replicates| total % replicates == 0);
            let best = fitting.min_by_key(|&replicates| {
                let length = total / replicates;
                (!length.is_power_of_two(), replicates.abs_diff(8), replicates)
            })?;
            Some(Self::independent(best, total / best))
        });
        dealt.unwrap_or(Self::independent(samples, 1)).of_two_nets()
    }

    /// `replicates` replicates of `samples_per_replicate` samples, each a net of its own.
    pub fn independent(replicates: u32, samples_per_replicate: u32) -> Self {
        Self { replicates, per_net: 1, samples_per_replicate }
    }

    /// Deals `samples` per pixel, or the next larger number that can be dealt, into so many independent
    /// replicates. One is best stratified and has no error bars.
    pub fn with_replicates(samples: u32, replicates: u32) -> Self {
        let replicates = replicates.max(1);
        Self::independent(replicates, samples.max(1).div_ceil(replicates))
    }

    /// Deals `samples` per pixel as a sampler allows. Where nothing is random they are one sequence, and
    /// there are no error bars. Runs of a sequence tell its error only where each is well spread by itself.
    pub fn of(sampler: SamplerKind, samples: u32) -> Self {
        let dealt = Self::new(samples);
        match sampler {
            SamplerKind::Regular => Self::independent(1, samples.max(1)),
            SamplerKind::Sobol | SamplerKind::BlueNoise => dealt,
            SamplerKind::Independent | SamplerKind::Jittered | SamplerKind::Poisson => {
                Self::independent(dealt.replicates, dealt.samples_per_replicate)
            }
        }
    }

    /// The same replicates as runs of two nets, where they can be halved.
    fn of_two_nets(self) -> Self {
        let per_net = if self.replicates.is_multiple_of(2) { self.replicates / 2 } else { self.replicates };
        Self { per_net, ..self }
    }

    /// Samples of a pixel in all.
    pub fn samples(self) -> u64 {
        u64::from(self.replicates) * u64::from(self.samples_per_replicate)
    }

    /// Number of nets.
    pub fn nets(self) -> u32 {
        self.replicates / self.per_net
    }

    /// The length of a net's sequence.
    pub fn samples_per_net(self) -> u32 {
        self.per_net * self.samples_per_replicate
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_dealt_into_replicates_of_equal_length() {
        let dealt = |samples| {
            let schedule = Schedule::new(samples);
            (schedule.replicates, schedule.per_net, schedule.samples_per_replicate)
        };
        assert_eq!(dealt(1), (1, 1, 1));
        assert_eq!(dealt(4), (4, 2, 1));
        assert_eq!(dealt(64), (8, 4, 8));
        assert_eq!(dealt(1024), (8, 4, 128));
        assert_eq!(dealt(96), (6, 3, 16));
        assert_eq!(dealt(100), (10, 5, 10));
        // No prime can be dealt: the next number that can.
        assert_eq!(dealt(101), (6, 3, 17));
        // An odd number of replicates makes a single net.
        assert_eq!(dealt(5), (5, 5, 1));
        // As many as are asked for, and the next number of samples that allows it.
        assert_eq!(Schedule::with_replicates(64, 1), Schedule::independent(1, 64));
        assert_eq!(Schedule::with_replicates(30, 4), Schedule::independent(4, 8));
        assert_eq!(Schedule::with_replicates(2, 8), Schedule::independent(8, 1));
        assert_eq!(Schedule::of(SamplerKind::Jittered, 64), Schedule::independent(8, 8));
        for samples in 8..2000 {
            let schedule = Schedule::new(samples);
            assert!(schedule.samples() - u64::from(samples) < 8, "{samples}");
            assert_eq!(schedule.nets() * schedule.per_net, schedule.replicates);
        }
    }
}
