//! How much of their noise the pixels of each tile have in common.
//!
//! A tile has 8 × 8 pixels from the upper left corner of the file, fewer at the right and lower border. The
//! variance of its mean is so many times what the errors of its pixels in the file would make of it if pixels
//! were independent. One printable character stands for it, row by row: k eighths of an octave above 1 for
//! the k-th character after `A`, below 1 for those before.

use crate::film::{NOISE_TILE, PictureNoise, Region};
use crate::output::error_bars;

/// What the errors of a file add up to in each tile.
pub(super) struct TileNoise {
    size: [u32; 2],
    /// By quantity and tile: the sum of the squares of the errors of its pixels.
    independent: Vec<Vec<f64>>,
    /// Rows that are in it.
    rows: u32,
}

impl TileNoise {
    /// For a picture with this width and height, and so many quantities.
    pub fn new(size: [u32; 2], quantities: usize) -> Self {
        let tiles = across(size).iter().map(|&tiles| tiles as usize).product();
        Self { size, independent: vec![vec![0.0; tiles]; quantities], rows: 0 }
    }

    /// Adds the next row: the errors of some quantities, by their numbers.
    pub fn add<'a>(&mut self, errors: impl Iterator<Item = (usize, &'a [f32])>) {
        let first = (self.rows / NOISE_TILE * across(self.size)[0]) as usize;
        for (number, errors) in errors {
            for (sum, errors) in
                self.independent[number][first..].iter_mut().zip(errors.chunks(NOISE_TILE as usize))
            {
                *sum += errors.iter().map(|&error| f64::from(error).powi(2)).sum::<f64>();
            }
        }
        self.rows += 1;
    }

    /// What the file says of a quantity.
    pub fn told(&self, number: usize, noise: &PictureNoise) -> String {
        let tiles = across(self.size);
        let times = |variances: &[f64]| -> Vec<f64> {
            variances.iter().zip(&self.independent[number]).map(|(found, sum)| found / sum).collect()
        };
        let of_nets = (!noise.tiles_of_nets.is_empty()).then(|| times(&noise.tiles_of_nets));
        let runs = times(&noise.tiles);
        error_bars::calibrated(tiles, Region::whole(tiles), None, &runs, of_nets.as_deref())
            .into_iter()
            .map(letter)
            .collect()
    }
}

/// Tiles across and down.
fn across(size: [u32; 2]) -> [u32; 2] {
    size.map(|size| size.div_ceil(NOISE_TILE))
}

const ONE: f64 = b'A' as f64;

fn letter(times: f64) -> char {
    let steps = if times.is_nan() { 0.0 } else { (8.0 * times.log2()).round() };
    char::from((ONE + steps).clamp(f64::from(b'!'), f64::from(b'~')) as u8)
}

/// What the characters of a channel say, tile by tile.
pub(super) fn read(letters: &str) -> Vec<f64> {
    letters.bytes().map(|letter| ((f64::from(letter) - ONE) / 8.0).exp2()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_stand_for_eighths_of_octaves() {
        assert_eq!(
            [1.0, 2.0, 64.0, 0.5, 0.0, f64::INFINITY, f64::NAN].map(letter),
            ['A', 'I', 'q', '9', '!', '~', 'A']
        );
        assert_eq!(read("AIq9"), [1.0, 2.0, 64.0, 0.5]);
    }

    #[test]
    fn tiles_are_told_by_what_their_pixels_errors_add_up_to() {
        let mut noise = TileNoise::new([9, 9], 1);
        for _ in 0..9 {
            noise.add(std::iter::once((0, [2.0; 9].as_slice())));
        }
        // Tiles of 64, 8, 8 and 1 pixels: too few to moderate one another.
        let tiles = vec![64.0 * 4.0, 2.0 * 8.0 * 4.0, 4.0 * 8.0 * 4.0, 4.0];
        let mean = crate::film::Measured { mean: 0.0, error: 1.0 };
        let (tiles_of_nets, squares) = (Vec::new(), Default::default());
        let found = PictureNoise { mean, of_tiles: None, tiles, tiles_of_nets, squares };
        assert_eq!(read(&noise.told(0, &found)), [1.0, 2.0, 4.0, 1.0]);
    }
}
