use super::{Real, Register, WIDTH};
use glam::{DMat3, DVec3};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A vector of numbers that a formula is written for.
#[derive(Clone, Copy, Debug)]
pub struct Vector<R> {
    /// First coordinate.
    pub x: R,
    /// Second coordinate.
    pub y: R,
    /// Third coordinate.
    pub z: R,
}

/// Vectors of the lanes of one register.
pub type Vec3Lanes = Vector<Register>;

impl<R: Real> Vector<R> {
    /// From its coordinates.
    #[inline(always)]
    pub fn new(x: R, y: R, z: R) -> Self {
        Self { x, y, z }
    }

    /// The same vector in all lanes.
    #[inline(always)]
    pub fn of(vector: DVec3) -> Self {
        Self { x: R::of(vector.x), y: R::of(vector.y), z: R::of(vector.z) }
    }

    /// Scalar product.
    #[inline(always)]
    pub fn dot(self, other: Self) -> R {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// Square of the length.
    #[inline(always)]
    pub fn length_squared(self) -> R {
        self.dot(self)
    }

    /// Length.
    #[inline(always)]
    pub fn length(self) -> R {
        self.length_squared().sqrt()
    }

    /// The product of a matrix with the vector.
    #[inline(always)]
    pub fn mapped(self, matrix: &DMat3) -> Self {
        let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(Self::of);
        x * self.x + y * self.y + z * self.z
    }

    /// Absolute values of the coordinates.
    #[inline(always)]
    pub fn abs(self) -> Self {
        Self { x: self.x.abs(), y: self.y.abs(), z: self.z.abs() }
    }

    /// The greatest coordinate.
    #[inline(always)]
    pub fn greatest(self) -> R {
        self.x.greater(self.y.greater(self.z))
    }

    /// With length 1.
    #[inline(always)]
    pub fn normalize(self) -> Self {
        self * (R::of(1.0) / self.length())
    }

    /// `yes` where the truth holds, `no` elsewhere.
    #[inline(always)]
    pub fn choose(truth: R::Truth, yes: Self, no: Self) -> Self {
        Self {
            x: R::choose(truth, yes.x, no.x),
            y: R::choose(truth, yes.y, no.y),
            z: R::choose(truth, yes.z, no.z),
        }
    }
}

impl Vec3Lanes {
    /// Zero in each lane.
    pub const ZERO: Self = Self { x: Register::ZERO, y: Register::ZERO, z: Register::ZERO };

    /// The vector of one lane.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> DVec3 {
        let [x, y, z] = [self.x, self.y, self.z].map(|numbers| numbers.as_array()[lane % WIDTH]);
        DVec3::new(x, y, z)
    }

    /// Puts a vector into one lane.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, vector: DVec3) {
        self.x.as_mut_array()[lane % WIDTH] = vector.x;
        self.y.as_mut_array()[lane % WIDTH] = vector.y;
        self.z.as_mut_array()[lane % WIDTH] = vector.z;
    }
}

impl From<DVec3> for Vector<f64> {
    #[inline(always)]
    fn from(vector: DVec3) -> Self {
        Self::of(vector)
    }
}

impl From<Vector<f64>> for DVec3 {
    #[inline(always)]
    fn from(vector: Vector<f64>) -> Self {
        Self::new(vector.x, vector.y, vector.z)
    }
}

impl<R: Real> Add for Vector<R> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }
}

impl<R: Real> Sub for Vector<R> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }
}

impl<R: Real> Mul<R> for Vector<R> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: R) -> Self {
        Self { x: self.x * factor, y: self.y * factor, z: self.z * factor }
    }
}

impl<R: Real> Div<R> for Vector<R> {
    type Output = Self;
    #[inline(always)]
    fn div(self, divisor: R) -> Self {
        Self { x: self.x / divisor, y: self.y / divisor, z: self.z / divisor }
    }
}

impl<R: Real> Neg for Vector<R> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { x: -self.x, y: -self.y, z: -self.z }
    }
}
