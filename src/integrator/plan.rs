//! What the samples of a picture have in common.

/// How many pixels a suffix serves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sharing {
    /// One: nothing is shared.
    Nothing,
    /// All lanes.
    Sixteen,
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
