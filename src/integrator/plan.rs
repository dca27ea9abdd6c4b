//! What the samples of a picture have in common.

use crate::lanes::{ALL, Mask};

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
            Self::Four => 0b1111 << (lane / 4 * 4),
            Self::Sixteen => ALL,
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::{LANES, lanes_of};

    #[test]
    fn a_suffix_serves_the_pixels_that_share_it() {
        for (sharing, pixels) in [(Sharing::Nothing, 1), (Sharing::Four, 4), (Sharing::Sixteen, 16)] {
            assert_eq!(sharing.pixels(), pixels);
            for lane in 0..LANES {
                let partners = sharing.partners(lane);
                assert!(lanes_of(partners).all(|partner| sharing.partners(partner) == partners));
                assert!(partners >> lane & 1 == 1);
            }
        }
    }
}
