//! Textures that are computed: a pattern that selects between other textures, or mixes them.

use super::noise::Field;
use super::{Pattern, Texture, TexturePoint};
use crate::geometry::{UvTransform, Vec3};
use crate::sampling::quadrature::even_place;
use crate::spectrum::{Sampled, Spectrum};
use crate::units::WavelengthRange;
use glam::DAffine3;

/// A pattern and the textures that its values stand for.
#[derive(Clone, Debug)]
pub struct Procedural {
    /// The formula.
    pub pattern: Pattern,
    /// The coordinates that it is computed in.
    pub ground: Ground,
    /// At least two, for values of the pattern from the least to the greatest.
    pub colours: Vec<Texture>,
    /// The values of the pattern that are the first and the last colour. The second is above the first.
    pub range: [f64; 2],
    /// Whether colours are mixed where the value is between those of two; else each has an equal part of the
    /// values.
    pub mixed: bool,
}

/// What the coordinates of a pattern are made from, in units of its period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ground {
    /// The surface's own; the pattern is cut at z = 0.
    Uv(UvTransform),
    /// The place in space, from [`TexturePoint::at_rest`].
    Solid(DAffine3),
}

impl Ground {
    fn place(&self, at: &TexturePoint) -> Vec3 {
        match self {
            Self::Uv(to_pattern) => {
                let [u, v] = to_pattern.apply(at.uv);
                Vec3::new(u, v, 0.0)
            }
            Self::Solid(to_pattern) => to_pattern.transform_point3(at.at_rest.position),
        }
    }

    /// The derivatives by u and v of a function of the place.
    fn by_uv(&self, slope: Vec3, at: &TexturePoint) -> [f64; 2] {
        match self {
            Self::Uv(to_pattern) => to_pattern.pull_back([slope.x, slope.y]),
            Self::Solid(to_pattern) => {
                at.at_rest.tangents.map(|tangent| slope.dot(to_pattern.transform_vector3(tangent)))
            }
        }
    }
}

impl Procedural {
    /// The value within [`Self::range`], from 0 to 1.
    fn field(&self, place: Vec3) -> Field {
        let Field { value, slope } = self.pattern.at(place, self.mixed);
        let [low, high] = self.range;
        let value = (value - low) / (high - low);
        if (0.0..=1.0).contains(&value) {
            Field { value, slope: slope / (high - low) }
        } else {
            Field { value: value.clamp(0.0, 1.0), slope: Vec3::ZERO }
        }
    }

    /// The colour that a value stands for, and the fraction of the next one.
    fn colour(&self, value: f64) -> (usize, f64) {
        let count = self.colours.len();
        if !self.mixed {
            return (((value * count as f64) as usize).min(count - 1), 0.0);
        }
        let scaled = value * (count - 1) as f64;
        let index = (scaled as usize).min(count - 2);
        (index, scaled - index as f64)
    }

    fn blend<T: std::ops::Add<Output = T> + std::ops::Mul<f64, Output = T>>(
        &self,
        at: &TexturePoint,
        of: impl Fn(&Texture) -> T,
    ) -> T {
        let (index, fraction) = self.colour(self.field(self.ground.place(at)).value);
        let first = of(&self.colours[index]);
        if fraction == 0.0 {
            first
        } else {
            first * (1.0 - fraction) + of(&self.colours[index + 1]) * fraction
        }
    }

    /// The values at the wavelengths of a path.
    pub fn sample<const C: usize>(&self, at: &TexturePoint, nm: &[f64; C]) -> Sampled<C> {
        self.blend(at, |colour| colour.sample(at, nm))
    }

    /// The value of a pattern without wavelength.
    pub fn value(&self, at: &TexturePoint) -> f64 {
        self.blend(at, |colour| colour.value(at))
    }

    /// Gradient of [`Self::value`]. Zero where colours are not mixed, though there are steps between them.
    pub fn gradient(&self, at: &TexturePoint) -> [f64; 2] {
        let field = self.field(self.ground.place(at));
        let (index, fraction) = self.colour(field.value);
        let first = &self.colours[index];
        let [a, b] = first.gradient(at);
        if !self.mixed {
            return [a, b];
        }
        let second = &self.colours[index + 1];
        let rise = (second.value(at) - first.value(at)) * (self.colours.len() - 1) as f64;
        let [along_u, along_v] = self.ground.by_uv(field.slope, at);
        let [c, d] = second.gradient(at);
        [
            a * (1.0 - fraction) + c * fraction + rise * along_u,
            b * (1.0 - fraction) + d * fraction + rise * along_v,
        ]
    }

    /// About the mean over space: of places spread evenly over a cube of many periods. No colour is left out.
    pub fn mean_spectrum(&self, range: WavelengthRange) -> Spectrum {
        const PLACES: u32 = 1024;
        let mut fractions = vec![1e-3; self.colours.len()];
        for i in 0..PLACES {
            let place = Vec3::from_array(even_place(i)) * 64.0;
            let (index, fraction) = self.colour(self.field(place).value);
            fractions[index] += (1.0 - fraction) / f64::from(PLACES);
            if fraction > 0.0 {
                fractions[index + 1] += fraction / f64::from(PLACES);
            }
        }
        let means: Vec<Spectrum> = self.colours.iter().map(|colour| colour.mean_spectrum(range)).collect();
        super::tabulated(range, &means.iter().collect::<Vec<_>>(), |nm| {
            means.iter().zip(&fractions).map(|(mean, fraction)| mean.at(nm) * fraction).sum()
        })
    }
}
