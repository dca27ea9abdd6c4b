//! Choosing one of many pieces in proportion to their areas.

/// Distribution of pieces by area: running sums of areas, or of bounds on them.
#[derive(Clone, Debug, Default)]
pub(super) struct AreaDistribution {
    sums: Vec<f64>,
}

impl AreaDistribution {
    pub fn new(areas: impl IntoIterator<Item = f64>) -> Self {
        let mut total = 0.0;
        let sums = areas.into_iter().map(|area| {
            total += area;
            total
        });
        Self { sums: sums.collect() }
    }

    pub fn total(&self) -> f64 {
        self.below(self.sums.len())
    }

    /// Sum of the areas of all pieces before one.
    pub fn below(&self, piece: usize) -> f64 {
        if piece == 0 { 0.0 } else { self.sums[piece - 1] }
    }

    pub fn of(&self, piece: usize) -> f64 {
        self.sums[piece] - self.below(piece)
    }

    /// The piece in which the fraction `u` of the total ends, and how far into it, below 1. There must be
    /// one.
    pub fn choose(&self, u: f64) -> (usize, f64) {
        let target = u * self.total();
        let piece = self.sums.partition_point(|&sum| sum <= target).min(self.sums.len() - 1);
        let fraction = (target - self.below(piece)) / self.of(piece);
        (piece, fraction.clamp(0.0, 1.0 - f64::EPSILON))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_are_chosen_by_their_areas() {
        let areas = AreaDistribution::new([1.0, 0.0, 2.0, 1.0]);
        assert_eq!((areas.total(), areas.below(2), areas.of(2)), (4.0, 1.0, 2.0));
        let chosen = [0.0, 0.125, 0.25, 0.5, 0.75, 0.875].map(|u| areas.choose(u));
        assert_eq!(chosen, [(0, 0.0), (0, 0.5), (2, 0.0), (2, 0.5), (3, 0.0), (3, 0.5)]);
        assert_eq!(areas.choose(1.0), (3, 1.0 - f64::EPSILON));
        assert_eq!(AreaDistribution::default().total(), 0.0);
    }
}
