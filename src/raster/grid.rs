//! Grids of values in space, in Mitsuba's `.vol` format, version 3.

use super::{ImageError, MOST_TEXELS};
use crate::geometry::Vec3;

/// Values at the centres of the cells of a box.
#[derive(Clone, Debug)]
pub struct Grid {
    /// Cells along x, y and z.
    pub size: [usize; 3],
    /// Values a cell has: 1, 3 or 6.
    pub channels: usize,
    /// Finite; the channels of a cell together, then along x, along y, along z.
    pub values: Vec<f32>,
    /// The corners of the box that the file states.
    pub corners: [Vec3; 2],
}

impl Grid {
    /// # Errors
    /// Another format, a size that the content does not have, values that are not finite.
    pub fn decode(bytes: &[u8]) -> Result<Self, ImageError> {
        const HEADER: usize = 48;
        if !bytes.starts_with(b"VOL\x03") || bytes.len() < HEADER {
            return Err(ImageError::new("The file is no grid", "expected a file of format VOL, version 3"));
        }
        let word = |at: usize| [bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]];
        let integer = |at: usize| i32::from_le_bytes(word(at));
        let float = |at: usize| f32::from_le_bytes(word(at));
        if integer(4) != 1 {
            return Err(ImageError::new(
                format!("The grid's values are of type {}", integer(4)),
                "expected type 1, floats of 32 bits",
            ));
        }
        let size = [8, 12, 16].map(|at| usize::try_from(integer(at)).unwrap_or(0));
        let channels = usize::try_from(integer(20)).unwrap_or(0);
        if !matches!(channels, 1 | 3 | 6) {
            return Err(ImageError::new(
                format!("The cells of the grid have {} channels", integer(20)),
                "expected 1, 3 for a colour, or 6 for the matrix of `sggx`",
            ));
        }
        let cells = size.iter().fold(1usize, |cells, &size| cells.saturating_mul(size));
        let expected = cells.saturating_mul(4 * channels);
        if cells == 0 || cells > MOST_TEXELS || bytes.len() - HEADER < expected {
            let [x, y, z] = size;
            return Err(ImageError::new(
                format!("A grid of {x} × {y} × {z} cells does not fit its file of {} bytes", bytes.len()),
                format!("expected from 1 to {MOST_TEXELS} cells, and a value of each"),
            ));
        }
        let values: Vec<f32> = (0..cells * channels).map(|i| float(HEADER + 4 * i)).collect();
        let corners = [24, 36].map(|at| Vec3::from_array([0, 4, 8].map(|i| f64::from(float(at + i)))));
        if !values.iter().all(|value| value.is_finite()) || !corners.iter().all(|corner| corner.is_finite()) {
            return Err(ImageError::new("The grid holds what is no number", "expected finite values"));
        }
        Ok(Self { size, channels, values, corners })
    }
}
