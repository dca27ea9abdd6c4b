use super::Vec3;

/// An axis-aligned box. Empty when any `min` exceeds its `max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The least coordinates.
    pub min: Vec3,
    /// The greatest coordinates.
    pub max: Vec3,
}

impl Bounds {
    /// The box of no point; its union with another is that other.
    pub const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// The smallest box around points.
    pub fn of(points: impl IntoIterator<Item = Vec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |bounds, point| bounds.including(point))
    }

    /// The smallest box around it and a point.
    pub fn including(self, point: Vec3) -> Self {
        Self { min: self.min.min(point), max: self.max.max(point) }
    }

    /// The largest coordinate of its points, whatever its sign.
    pub fn reach(self) -> f64 {
        if self.is_empty() { 0.0 } else { self.min.abs().max(self.max.abs()).max_element() }
    }

    /// The smallest box around both.
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// What two boxes share.
    pub fn common(self, other: Self) -> Self {
        let common = Self { min: self.min.max(other.min), max: self.max.min(other.max) };
        if common.is_empty() { Self::EMPTY } else { common }
    }

    /// The smallest box around several.
    pub fn of_all(boxes: impl IntoIterator<Item = Self>) -> Self {
        boxes.into_iter().fold(Self::EMPTY, Self::union)
    }

    /// Whether two boxes share a point.
    pub fn overlaps(self, other: Self) -> bool {
        self.min.cmple(other.max).all() && other.min.cmple(self.max).all()
    }

    /// Whether another box lies wholly in this one.
    pub fn contains(self, other: Self) -> bool {
        self.min.cmple(other.min).all() && other.max.cmple(self.max).all()
    }

    /// The widest gap between two boxes along an axis; below zero by how far they reach into one another.
    pub fn gap(self, other: Self) -> f64 {
        (self.min - other.max).max(other.min - self.max).max_element()
    }

    /// Whether it holds no point.
    pub fn is_empty(self) -> bool {
        self.min.cmpgt(self.max).any()
    }

    /// All eight; none of an empty box.
    pub fn corners(self) -> impl Iterator<Item = Vec3> {
        let Self { min, max } = self;
        let count = if self.is_empty() { 0 } else { 8 };
        (0..count).map(move |corner| {
            let on_axis = |axis: usize| if corner >> axis & 1 == 0 { min[axis] } else { max[axis] };
            Vec3::new(on_axis(0), on_axis(1), on_axis(2))
        })
    }

    /// The most that direction · x is over its points x.
    pub fn support(self, direction: Vec3) -> f64 {
        let half = 0.5 * (self.max - self.min);
        direction.dot(self.centre()) + direction.abs().dot(half)
    }

    /// Half of its surface's area; 0 where it is empty.
    pub fn half_area(self) -> f64 {
        let size = (self.max - self.min).max(Vec3::ZERO);
        size.x * size.y + size.y * size.z + size.z * size.x
    }

    /// The point in the middle.
    pub fn centre(self) -> Vec3 {
        0.5 * (self.min + self.max)
    }

    /// Length of the diagonal; 0 for an empty box.
    pub fn diameter(self) -> f64 {
        if self.is_empty() { 0.0 } else { (self.max - self.min).length() }
    }
}
