/// A density that is constant between ascending edges, sampled by inversion.
#[derive(Clone, Debug)]
pub struct PiecewiseConstant {
    edges: Vec<f64>,
    /// Probability up to each edge: as many values as edges, from 0 to 1.
    cumulative: Vec<f64>,
    density: Vec<f64>,
    /// For each of equal parts of the unit interval, the first bin that reaches into it.
    guide: Vec<u32>,
}

impl PiecewiseConstant {
    /// From the edges and the integral over each bin, up to a common factor. `None` unless the edges ascend, there
    /// is one integral fewer than edges, none is negative or not finite, and their sum is positive and finite.
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
        let density = integrals
            .iter()
            .zip(edges.windows(2))
            .map(|(value, edge)| value / total / (edge[1] - edge[0]))
            .collect();
        let parts = integrals.len().next_power_of_two();
        let guide = (0..parts)
            .map(|part| cumulative[1..].partition_point(|&c| c <= part as f64 / parts as f64) as u32)
            .collect();
        Some(Self { edges, cumulative, density, guide })
    }

    /// The place up to which a share `u` of the probability lies, for u in [0, 1), and the density there.
    pub fn sample(&self, u: f64) -> (f64, f64) {
        let part = ((u * self.guide.len() as f64) as usize).min(self.guide.len() - 1);
        let mut bin = self.guide[part] as usize;
        while self.cumulative[bin + 1] <= u && bin + 2 < self.cumulative.len() {
            bin += 1;
        }
        let [low, high] = [self.cumulative[bin], self.cumulative[bin + 1]];
        let share = if high > low { ((u - low) / (high - low)).clamp(0.0, 1.0) } else { 0.0 };
        (self.edges[bin] + share * (self.edges[bin + 1] - self.edges[bin]), self.density[bin])
    }

    /// The density at `x`; zero outside the edges.
    pub fn density(&self, x: f64) -> f64 {
        let above = self.edges.partition_point(|&edge| edge <= x);
        if above == 0 || above > self.density.len() { 0.0 } else { self.density[above - 1] }
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
