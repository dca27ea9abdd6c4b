//! Ranges of values over blocks of cells.

/// For blocks of 2, 4, 8 … cells along each axis the least and the greatest of the values in them.
#[derive(Clone, Debug)]
pub(in crate::shape) struct Pyramid<const N: usize> {
    size: [usize; N],
    /// Ranges of single cells, then of ever larger blocks, down to one.
    levels: Vec<Level<N>>,
}

#[derive(Clone, Debug)]
struct Level<const N: usize> {
    size: [usize; N],
    ranges: Vec<[f32; 2]>,
}

/// The index of a place in an array whose first axis runs fastest.
pub(in crate::shape) fn index<const N: usize>(size: [usize; N], at: [usize; N]) -> usize {
    (0..N).rev().fold(0, |index, axis| index * size[axis] + at[axis])
}

/// The place of an index.
pub(in crate::shape) fn place<const N: usize>(size: [usize; N], mut index: usize) -> [usize; N] {
    size.map(|length| {
        let at = index % length;
        index /= length;
        at
    })
}

const NOTHING: [f32; 2] = [f32::INFINITY, f32::NEG_INFINITY];

fn union([a, b]: [f32; 2], [c, d]: [f32; 2]) -> [f32; 2] {
    [a.min(c), b.max(d)]
}

impl<const N: usize> Pyramid<N> {
    /// Over the cells between `points` along each axis, at least two, with a value each.
    pub fn new(points: [usize; N], values: &[f32]) -> Self {
        let size = points.map(|points| points - 1);
        let count = |size: [usize; N]| size.iter().product::<usize>();
        let corners = |at: [usize; N], limit: [usize; N]| {
            (0..1usize << N).map(move |corner| {
                std::array::from_fn(|axis| (at[axis] + (corner >> axis & 1)).min(limit[axis] - 1))
            })
        };
        let of_cell = |i: usize| {
            let values = corners(place(size, i), points).map(|at| values[index(points, at)]);
            values.fold(NOTHING, |range, value| union(range, [value; 2]))
        };
        let mut levels = vec![Level { size, ranges: (0..count(size)).map(of_cell).collect() }];
        while let Some(below) = levels.last()
            && below.ranges.len() > 1
        {
            let size = below.size.map(|length| length.div_ceil(2));
            let of_block = |i: usize| {
                let at = place(size, i).map(|i| 2 * i);
                corners(at, below.size).map(|at| below.ranges[index(below.size, at)]).fold(NOTHING, union)
            };
            let ranges = (0..count(size)).map(of_block).collect();
            levels.push(Level { size, ranges });
        }
        Self { size, levels }
    }

    /// Cells along each axis.
    pub fn size(&self) -> [usize; N] {
        self.size
    }

    pub fn cells(&self) -> usize {
        self.levels[0].ranges.len()
    }

    /// The level that has but one block, the largest.
    pub fn top(&self) -> usize {
        self.levels.len() - 1
    }

    /// The least and the greatest value of a block of 2 to the power of `level` cells along each axis.
    pub fn range(&self, level: usize, block: [usize; N]) -> [f32; 2] {
        let Level { size, ranges } = &self.levels[level];
        ranges[index(*size, block)]
    }

    /// The range of all cells.
    pub fn whole(&self) -> [f32; 2] {
        self.levels[self.top()].ranges[0]
    }
}
