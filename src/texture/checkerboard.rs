//! Two textures in turn, on squares of half a unit.

use super::{Lines, Texture, TexturePoint};
use crate::geometry::UvTransform;
use crate::spectrum::Sampled;

/// Two textures in turn over u and v.
#[derive(Clone, Debug)]
pub struct Checkerboard {
    /// The first is at the origin.
    pub colours: [Texture; 2],
    /// From the shape's uv to the texture's.
    pub to_uv: UvTransform,
}

impl Checkerboard {
    /// Which of the two is at a place.
    fn square(&self, at: &TexturePoint) -> usize {
        let [u, v] = self.to_uv.apply(at.uv).map(|x| x - x.floor() > 0.5);
        usize::from(u != v)
    }

    /// The colours within have the coordinates of the surface, not those of the board.
    pub fn sample<const C: usize>(&self, at: &TexturePoint, nm: &[f64; C]) -> Sampled<C> {
        self.colours[self.square(at)].sample(at, nm)
    }

    /// Lines between which the board has one colour.
    pub fn lines(&self) -> Lines {
        Lines { to_uv: self.to_uv, per_unit: [2; 2], offset: 0.0, bilinear: false }
    }

    /// In Mitsuba 3 the squares change places where a number is asked for instead of a spectrum.
    pub fn value(&self, at: &TexturePoint) -> f64 {
        self.colours[1 - self.square(at)].value(at)
    }
}
