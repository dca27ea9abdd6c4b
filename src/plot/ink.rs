use std::fmt;

/// What lines, areas and letters are drawn with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ink {
    /// One of sixteen greys, from 0 (black) to 15 (white).
    Grey(u8),
    /// Red, green and blue, encoded for sRGB.
    Rgb([u8; 3]),
}

impl Ink {
    /// The ink of letters and axes.
    pub const TEXT: Self = Self::Grey(2);
    /// The ink of remarks.
    pub const NOTE: Self = Self::Grey(6);

    /// From the number whose six hexadecimal digits are red, green and blue.
    pub const fn hex(rgb: u32) -> Self {
        let [_, red, green, blue] = rgb.to_be_bytes();
        Self::Rgb([red, green, blue])
    }

    /// Red, green and blue, encoded for sRGB.
    pub fn rgb(self) -> [u8; 3] {
        match self {
            Self::Grey(level) => [17 * level; 3],
            Self::Rgb(rgb) => rgb,
        }
    }
}

/// As SVG and HTML have it.
impl fmt::Display for Ink {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Grey(level) => write!(f, "#{level:x}{level:x}{level:x}"),
            Self::Rgb([red, green, blue]) => write!(f, "#{red:02x}{green:02x}{blue:02x}"),
        }
    }
}

/// Lengths of the dashes of a line and of the gaps between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dash(pub f64, pub f64);
