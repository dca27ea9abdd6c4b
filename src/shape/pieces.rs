//! Shapes of which each piece is a surface by itself for the acceleration structure.

use super::{Crossings, Curves, Hit, Patches, Shape};
use crate::geometry::{Bounds, Ray};

/// Such a shape. Hits carry the piece as their triangle.
#[derive(Clone, Debug)]
pub enum Pieces {
    /// Segments.
    Curves(Curves),
    /// Bézier patches.
    Patches(Patches),
}

impl Pieces {
    /// `None` of all others.
    pub fn of(shape: &Shape) -> Option<Self> {
        match shape {
            Shape::Curves(curves) => Some(Self::Curves(curves.clone())),
            Shape::Patches(patches) => Some(Self::Patches(patches.clone())),
            _ => None,
        }
    }

    /// Number of pieces.
    pub fn count(&self) -> usize {
        match self {
            Self::Curves(curves) => curves.segment_count(),
            Self::Patches(patches) => patches.count(),
        }
    }

    /// A box around a piece.
    pub fn bounds(&self, piece: u32) -> Bounds {
        match self {
            Self::Curves(curves) => curves.segment_bounds(piece),
            Self::Patches(patches) => patches.patch_bounds(piece),
        }
    }

    /// The nearest hit of a piece with 0 ≤ t < `ray.t_max`.
    pub fn intersect(&self, piece: u32, ray: &Ray) -> Option<Hit> {
        match self {
            Self::Curves(curves) => curves.intersect_segment(piece, ray),
            Self::Patches(patches) => patches.intersect_patch(piece, ray),
        }
    }

    /// All crossings of a piece along the whole line, in ascending order.
    pub fn crossings(&self, piece: u32, ray: &Ray) -> Crossings {
        match self {
            Self::Curves(curves) => curves.segment_crossings(piece, ray),
            Self::Patches(patches) => patches.patch_crossings(piece, ray),
        }
    }
}
