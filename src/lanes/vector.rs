use super::WIDTH;
use crate::geometry::Vec3;
use std::ops::{Add, Mul, Neg, Sub};
use wide::f64x4;

/// Vectors of the lanes of one register.
#[derive(Clone, Copy, Debug)]
pub struct Vec3Lanes {
    pub x: f64x4,
    pub y: f64x4,
    pub z: f64x4,
}

impl Vec3Lanes {
    pub const ZERO: Self = Self { x: f64x4::ZERO, y: f64x4::ZERO, z: f64x4::ZERO };

    #[inline(always)]
    pub fn splat(vector: Vec3) -> Self {
        Self { x: f64x4::splat(vector.x), y: f64x4::splat(vector.y), z: f64x4::splat(vector.z) }
    }

    #[inline(always)]
    pub fn get(&self, lane: usize) -> Vec3 {
        let [x, y, z] = [self.x, self.y, self.z].map(|numbers| numbers.as_array()[lane % WIDTH]);
        Vec3::new(x, y, z)
    }

    #[inline(always)]
    pub fn set(&mut self, lane: usize, vector: Vec3) {
        self.x.as_mut_array()[lane % WIDTH] = vector.x;
        self.y.as_mut_array()[lane % WIDTH] = vector.y;
        self.z.as_mut_array()[lane % WIDTH] = vector.z;
    }

    #[inline(always)]
    pub fn dot(self, other: Self) -> f64x4 {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    #[inline(always)]
    pub fn length_squared(self) -> f64x4 {
        self.dot(self)
    }

    #[inline(always)]
    pub fn length(self) -> f64x4 {
        self.length_squared().sqrt()
    }
}

impl Add for Vec3Lanes {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }
}

impl Sub for Vec3Lanes {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }
}

impl Mul<f64x4> for Vec3Lanes {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f64x4) -> Self {
        Self { x: self.x * factor, y: self.y * factor, z: self.z * factor }
    }
}

impl Neg for Vec3Lanes {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { x: -self.x, y: -self.y, z: -self.z }
    }
}
