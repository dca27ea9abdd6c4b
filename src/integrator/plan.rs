//! What the samples of a picture have in common.

use crate::lanes::{Mask, WIDTH, part};

/// How many pixels a suffix serves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sharing {
    /// One: nothing is shared.
    Nothing,
    /// The four lanes of a register.
    Four,
    /// All lanes.
    Sixteen,
}

impl Sharing {
    /// How many pixels a suffix serves.
    pub fn pixels(self) -> u32 {
        self.partners(0).count_ones()
    }

    /// The lanes that share with one, itself among them.
    pub(super) fn partners(self, lane: usize) -> Mask {
        match self {
            Self::Nothing => 1 << lane,
            Self::Four => part(Mask::MAX, 0) << (lane / WIDTH * WIDTH),
            Self::Sixteen => Mask::MAX,
        }
    }
}

/// What the samples of a picture have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// How many pixels a suffix serves.
    pub sharing: Sharing,
    /// Light samples at the first surface of a path.
    pub light_samples: u32,
}

impl Plan {
    /// Nothing: each pixel pays for its own light.
    pub const PLAIN: Self = Self { sharing: Sharing::Nothing, light_samples: 1 };

    /// What pays in most scenes.
    pub const USUAL: Self = Self { sharing: Sharing::Sixteen, light_samples: 1 };
}
