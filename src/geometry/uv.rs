//! Maps of surface coordinates.

/// An affine map of surface coordinates: the upper two rows of `to_uv`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UvTransform(pub [[f64; 3]; 2]);

impl UvTransform {
    /// The transform that changes nothing.
    pub const IDENTITY: Self = Self([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);

    /// Takes surface coordinates to those of the texture.
    pub fn apply(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        self.0.map(|[a, b, c]| a * u + b * v + c)
    }

    /// The derivatives by the coordinates that go in of a function with derivatives by those that come out.
    pub fn pull_back(&self, [by_u, by_v]: [f64; 2]) -> [f64; 2] {
        let [[a, b, _], [c, d, _]] = self.0;
        [a * by_u + c * by_v, b * by_u + d * by_v]
    }
}
