/// A density that is constant between ascending edges, sampled by inversion.
#[derive(Clone, Debug)]
pub struct PiecewiseConstant {
    /// And one of no width at the end.
    bins: Vec<Bin>,
    /// For each of equal parts of the unit interval, the first bin that reaches into it.
    guide: Vec<u32>,
}

/// All that sampling asks of a bin, in half a cache line.
#[derive(Clone, Copy, Debug)]
struct Bin {
    /// The probability up to it.
    cumulative: f64,
    edge: f64,
    /// Its width over its probability; 0 where it has none.
    spread: f64,
    density: f64,
}

impl PiecewiseConstant {
    /// From the edges and the integral over each bin, up to a common factor. `None` unless the edges ascend,
    /// there is one integral fewer than edges, none is negative or not finite, and their sum is positive and
    /// finite.
    pub fn new(edges: Vec<f64>, integrals: &[f64]) -> Option<Self> {
        let ascending = edges.windows(2).all(|pair| pair[0] < pair[1]);
        let valid = integrals.iter().all(|&value| value >= 0.0 && value.is_finite());
        let total: f64 = integrals.iter().sum();
        let positive = total > 0.0 && total.is_finite();
        if !(edges.len() == integrals.len() + 1 && ascending && valid && positive) {
            return None;
        }
        let mut sum = 0.0;
        let mut cumulative = vec![0.0];
        cumulative.extend(integrals.iter().map(|value| {
            sum += value;
            sum / total
        }));
        // Whatever the rounding, the last bin with any probability ends the unit interval.
        let last = integrals.iter().rposition(|&value| value > 0.0).unwrap_or(0);
        cumulative[last + 1..].fill(1.0);
        let parts = integrals.len().next_power_of_two();
        let guide = (0..parts)
            .map(|part| cumulative[1..].partition_point(|&c| c <= part as f64 / parts as f64) as u32)
            .collect();
        let bin = |i: usize| {
            let (width, probability) = (edges[i + 1] - edges[i], cumulative[i + 1] - cumulative[i]);
            let spread = if probability > 0.0 { width / probability } else { 0.0 };
            let density = integrals[i] / total / width;
            Bin { cumulative: cumulative[i], edge: edges[i], spread, density }
        };
        let end = Bin { cumulative: 1.0, edge: edges[integrals.len()], spread: 0.0, density: 0.0 };
        Some(Self { bins: (0..integrals.len()).map(bin).chain([end]).collect(), guide })
    }

    /// The place up to which a fraction `u` of the probability lies, for u in [0, 1), and the density there.
    #[inline]
    pub fn sample(&self, u: f64) -> (f64, f64) {
        let part = ((u * self.guide.len() as f64) as i32 as usize).min(self.guide.len() - 1);
        let first = self.guide[part] as usize;
        let mut bins = self.bins[first..].windows(2).skip_while(|pair| pair[1].cumulative <= u);
        let [bin, next] = match bins.next() {
            Some(&[bin, next]) => [bin, next],
            _ => [self.bins[self.bins.len() - 2], self.bins[self.bins.len() - 1]],
        };
        let place = bin.edge + (u - bin.cumulative).max(0.0) * bin.spread;
        (place.min(next.edge), bin.density)
    }

    /// The density at `x`; zero outside the edges.
    pub fn density(&self, x: f64) -> f64 {
        // The last bin ends the table and has no density.
        let above = self.bins.partition_point(|bin| bin.edge <= x);
        if above == 0 { 0.0 } else { self.bins[above - 1].density }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inversion_follows_the_density_and_skips_empty_bins() {
        let table = PiecewiseConstant::new(vec![0.0, 1.0, 1.5, 4.0, 5.0], &[1.0, 0.0, 3.0, 0.0]).unwrap();
        let n = 100_000;
        let mut below_one = 0;
        for i in 0..n {
            let (x, density) = table.sample((i as f64 + 0.5) / n as f64);
            assert!((0.0..1.0).contains(&x) || (1.5..=4.0).contains(&x), "{x}");
            assert!((density - table.density(x.min(3.999))).abs() < 1e-15);
            below_one += usize::from(x < 1.0);
        }
        assert_eq!(below_one, n / 4);
        assert_eq!(table.density(-0.1), 0.0);
        assert_eq!(table.density(5.0), 0.0);
        assert_eq!(table.density(2.0), 0.75 / 2.5);
    }

    #[test]
    fn what_is_no_density_is_refused() {
        assert!(PiecewiseConstant::new(vec![0.0, 1.0], &[0.0]).is_none());
        assert!(PiecewiseConstant::new(vec![0.0, 1.0], &[-1.0]).is_none());
        assert!(PiecewiseConstant::new(vec![1.0, 0.0], &[1.0]).is_none());
        assert!(PiecewiseConstant::new(vec![0.0, 1.0], &[f64::NAN]).is_none());
    }
}
