//! What sampled surfaces share: following a line through a box of cells of unit size, and the sign of a
//! function along it.
//!
//! A line goes from cell to cell through whole blocks of them where the function cannot change its sign (a
//! pyramid of ranges tells). Where a line passes from a cell to the next the sign is decided once and for
//! both: so between any two places the number of crossings is odd if and only if the signs there differ, and
//! no surface is lost or met twice at the border of two cells.

mod pyramid;

pub(super) use pyramid::{Pyramid, index, place};

/// A line in the coordinates of the cells: the cell i fills the space from i to i + 1 along each axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line<const N: usize> {
    pub origin: [f64; N],
    pub direction: [f64; N],
}

/// A part of a line.
#[derive(Clone, Copy, Debug)]
pub(super) enum GridSegment<const N: usize> {
    /// An interval in which the function keeps one sign.
    Free { sign: f64, ends: [f64; 2] },
    /// In one cell. `through` is the axis across which the line leaves it; none where the walk ends.
    Cell { cell: [usize; N], ends: [f64; 2], through: Option<usize> },
}

impl<const N: usize> Line<N> {
    /// The part of it within limits and the cells; `None` where there is none.
    pub fn within(&self, size: [usize; N], [mut low, mut high]: [f64; 2]) -> Option<[f64; 2]> {
        for (axis, cells) in size.into_iter().enumerate() {
            let (origin, direction, end) = (self.origin[axis], self.direction[axis], cells as f64);
            if direction == 0.0 {
                if !(0.0..=end).contains(&origin) {
                    return None;
                }
                continue;
            }
            let (a, b) = (-origin / direction, (end - origin) / direction);
            low = low.max(a.min(b));
            high = high.min(a.max(b));
        }
        // Also where something is no number.
        (low < high).then_some([low, high])
    }

    /// The cell at t; the nearest one where rounding leads outside.
    pub fn cell(&self, size: [usize; N], t: f64) -> [usize; N] {
        std::array::from_fn(|axis| {
            let at = self.origin[axis] + self.direction[axis] * t;
            (at.max(0.0) as usize).min(size[axis] - 1)
        })
    }

    /// Where it enters a cell in which it is at t, and across which axis; none where that is before `first`.
    fn entry(&self, cell: [usize; N], at: f64, first: f64) -> (f64, Option<usize>) {
        let (mut entry, mut across) = (first, None);
        for (axis, cell) in cell.into_iter().enumerate() {
            let direction = self.direction[axis];
            if direction != 0.0 {
                let plane = cell + usize::from(direction < 0.0);
                let t = (plane as f64 - self.origin[axis]) / direction;
                // A line along a side may by rounding seem to enter later.
                if t >= entry && t <= at {
                    (entry, across) = (t, Some(axis));
                }
            }
        }
        (entry, across)
    }

    /// The place in a cell, from 0 to 1 along each axis, where the line crosses one of its sides across an
    /// axis: there the coordinate is exactly 0 or 1. `leaves` tells by which of the two sides.
    pub fn place(&self, cell: [usize; N], t: f64, across: Option<usize>, leaves: bool) -> [f64; N] {
        std::array::from_fn(|axis| {
            if across == Some(axis) {
                return if (self.direction[axis] > 0.0) == leaves { 1.0 } else { 0.0 };
            }
            (self.origin[axis] + self.direction[axis] * t - cell[axis] as f64).clamp(0.0, 1.0)
        })
    }

    /// Walks along a part of the line that is `within` the cells, from the cell at `start` on, until `visit`
    /// says false. `begin` is told in which cell, where and across which axis the walk begins, which may be
    /// before `start`; where it says that the sign there isn't known the walk begins at the first cell of
    /// all.
    ///
    /// `sign` of a range of values and a part of the line is the function's where that is known.
    pub fn walk(
        &self,
        pyramid: &Pyramid<N>,
        [first, last]: [f64; 2],
        start: f64,
        mut begin: impl FnMut([usize; N], f64, Option<usize>) -> bool,
        sign: impl Fn([f32; 2], [f64; 2]) -> Option<f64>,
        mut visit: impl FnMut(GridSegment<N>) -> bool,
    ) {
        let size = pyramid.size();
        let top = pyramid.top();
        let start = start.max(first);
        let mut cell = self.cell(size, start);
        let (mut t, across) = self.entry(cell, start, first);
        if !begin(cell, t, across) && t > first {
            cell = self.cell(size, first);
            let (entry, across) = self.entry(cell, first, first);
            t = entry;
            begin(cell, t, across);
        }
        let mut level = top;
        loop {
            let block = cell.map(|i| i >> level);
            let (mut exit, mut through) = (last, None);
            for axis in 0..N {
                let direction = self.direction[axis];
                if direction != 0.0 {
                    let side = block[axis] + usize::from(direction > 0.0);
                    let plane = (side << level).min(size[axis]);
                    let at = (plane as f64 - self.origin[axis]) / direction;
                    if at < exit {
                        (exit, through) = (at, Some((axis, plane)));
                    }
                }
            }
            let ends = [t, exit.max(t)];
            let goes_on = match sign(pyramid.range(level, block), ends) {
                Some(sign) => visit(GridSegment::Free { sign, ends }),
                None if level > 0 => {
                    level -= 1;
                    continue;
                }
                None => visit(GridSegment::Cell { cell, ends, through: through.map(|(axis, _)| axis) }),
            };
            let Some((axis, plane)) = through.filter(|_| goes_on) else { return };
            let next = if self.direction[axis] > 0.0 { Some(plane) } else { plane.checked_sub(1) };
            let Some(next) = next.filter(|&next| next < size[axis]) else { return };
            t = ends[1];
            if level > 0 {
                // It leaves the block within the block's own sides, and rounding never leads back.
                let here = self.cell(size, t);
                for other in 0..N {
                    let first = block[other] << level;
                    let end = (first + (1 << level) - 1).min(size[other] - 1);
                    cell[other] = match self.direction[other] {
                        0.0 => cell[other],
                        up if up > 0.0 => here[other].clamp(cell[other], end),
                        _ => here[other].clamp(first, cell[other]),
                    };
                }
            }
            cell[axis] = next;
            if level < top && next >> (level + 1) != block[axis] >> 1 {
                level += 1;
            }
        }
    }
}

/// The sign of a continuous function along a line, value by value. Where it is exactly zero the function
/// touches zero or passes through: the next value tells.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Signs {
    /// 0 before there is one.
    sign: f64,
    last: f64,
    zero: Option<f64>,
}

/// A change of sign between two places; the same one twice where the function is zero.
#[derive(Clone, Copy, Debug)]
pub(super) struct Change {
    pub between: [f64; 2],
    /// The sign before.
    pub from: f64,
}

impl Signs {
    /// The next value, at t.
    pub fn next(&mut self, t: f64, value: f64) -> Option<Change> {
        if value.is_nan() {
            return None;
        }
        if value == 0.0 {
            self.zero.get_or_insert(t);
            return None;
        }
        let (from, between) = (self.sign, self.zero.map_or([self.last, t], |zero| [zero; 2]));
        *self = Self { sign: value.signum(), last: t, zero: None };
        (from * self.sign < 0.0).then_some(Change { between, from })
    }

    /// The last sign holds up to t.
    pub fn hold(&mut self, t: f64) {
        self.last = t;
    }

    pub fn sign(&self) -> f64 {
        self.sign
    }
}
