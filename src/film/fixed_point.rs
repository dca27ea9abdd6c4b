//! Numbers as integers: what a film adds.

use serde::{Deserialize, Serialize};

/// Between contributions and integers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(into = "f64", from = "f64")]
pub struct FixedPoint {
    /// A power of two.
    pub(super) quantum: f64,
    pub(super) per_quantum: f64,
}

/// Contributions from here on do not fit beside others, in quanta.
pub(super) const TOO_LARGE: f64 = 4_611_686_018_427_387_904.0;

impl FixedPoint {
    /// For fractions: numbers of the order of 1.
    pub const SHARE: Self = Self { quantum: 1.0 / (1u64 << 40) as f64, per_quantum: (1u64 << 40) as f64 };

    /// For contributions of the order of `reference`, the radiance of the brightest light.
    pub fn for_reference(reference: f64) -> Self {
        let exponent = if reference.is_normal() { reference.abs().log2().ceil() as i32 } else { 0 };
        let quantum = 2f64.powi(exponent.clamp(-900, 900) - 40);
        Self { quantum, per_quantum: 1.0 / quantum }
    }

    /// For the squares of such contributions, of which large ones are larger yet.
    pub(super) fn squared(self) -> Self {
        let quantum = self.quantum * self.quantum * (1u64 << 48) as f64;
        Self { quantum, per_quantum: 1.0 / quantum }
    }

    /// For contributions that are larger by about this factor.
    pub(super) fn coarser(self, times: u64) -> Self {
        let factor = times.next_power_of_two() as f64;
        Self { quantum: self.quantum * factor, per_quantum: self.per_quantum / factor }
    }
}

impl From<FixedPoint> for f64 {
    fn from(scale: FixedPoint) -> f64 {
        scale.quantum
    }
}

impl From<f64> for FixedPoint {
    /// The numbers whose quantum this is.
    fn from(quantum: f64) -> Self {
        Self { quantum, per_quantum: 1.0 / quantum }
    }
}
