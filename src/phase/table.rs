/// A density over the cosine of the angle, linear between equally spaced values from −1 to 1.
#[derive(Clone, Debug)]
pub struct PhaseTable {
    /// Densities per unit of the cosine, of integral 1.
    values: Vec<f64>,
    /// The probability up to each of them.
    cumulative: Vec<f64>,
}

impl PhaseTable {
    /// From values up to a common factor. `None` unless there are two at least, none negative or not finite,
    /// and not all zero.
    pub fn new(values: &[f64]) -> Option<Self> {
        let valid = values.iter().all(|&value| value >= 0.0 && value.is_finite());
        if values.len() < 2 || !valid {
            return None;
        }
        let greatest = values.iter().copied().fold(0.0, f64::max);
        let relative: Vec<f64> = values.iter().map(|value| value / greatest).collect();
        let step = 2.0 / (values.len() - 1) as f64;
        let areas = relative.windows(2).map(|pair| 0.5 * step * (pair[0] + pair[1]));
        let total: f64 = areas.clone().sum();
        if !(total > 0.0 && total.is_finite()) {
            return None;
        }
        let mut sum = 0.0;
        let mut cumulative = vec![0.0];
        cumulative.extend(areas.map(|area| {
            sum += area;
            sum / total
        }));
        Some(Self { values: relative.iter().map(|value| value / total).collect(), cumulative })
    }

    /// Per unit of the cosine.
    pub fn density(&self, cos: f64) -> f64 {
        let place = (0.5 * (cos + 1.0)).clamp(0.0, 1.0) * (self.values.len() - 1) as f64;
        let index = (place as usize).min(self.values.len() - 2);
        let fraction = place - index as f64;
        self.values[index] * (1.0 - fraction) + self.values[index + 1] * fraction
    }

    /// The cosine up to which a fraction `u` of the probability lies.
    pub fn sample(&self, u: f64) -> f64 {
        let above = self.cumulative.partition_point(|&cumulative| cumulative <= u);
        let index = above.clamp(1, self.values.len() - 1) - 1;
        let step = 2.0 / (self.values.len() - 1) as f64;
        let x = within([self.values[index], self.values[index + 1]], (u - self.cumulative[index]) / step);
        (index as f64 + x) * step - 1.0
    }
}

/// The place from 0 to 1 up to which a density that is linear between two values has an integral.
fn within([a, b]: [f64; 2], area: f64) -> f64 {
    // a x + (b − a) x² / 2 = area, by the form of the root that is exact where a and b are equal.
    let area = area.max(0.0);
    let root = (a * a + 2.0 * (b - a) * area).max(0.0).sqrt();
    if a + root > 0.0 { (2.0 * area / (a + root)).min(1.0) } else { 0.0 }
}

/// A density over the cosine, linear between values at cosines that are kept elsewhere.
#[derive(Clone, Debug)]
pub(super) struct Piecewise {
    values: Vec<f64>,
    cumulative: Vec<f64>,
}

impl Piecewise {
    /// From values up to a common factor at ascending cosines. `None` where they are no density.
    pub(super) fn new(cosines: &[f64], mut values: Vec<f64>) -> Option<Self> {
        if values.len() != cosines.len() || values.iter().any(|value| !(*value >= 0.0 && value.is_finite())) {
            return None;
        }
        let mut cumulative = vec![0.0];
        let mut sum = 0.0;
        for (pair, ends) in values.windows(2).zip(cosines.windows(2)) {
            sum += 0.5 * (pair[0] + pair[1]) * (ends[1] - ends[0]);
            cumulative.push(sum);
        }
        if !(sum > 0.0 && sum.is_finite()) {
            return None;
        }
        values.iter_mut().chain(&mut cumulative).for_each(|value| *value /= sum);
        Some(Self { values, cumulative })
    }

    /// The density at a fraction of the way from one cosine to the next.
    pub(super) fn between(&self, index: usize, fraction: f64) -> f64 {
        self.values[index] * (1.0 - fraction) + self.values[index + 1] * fraction
    }

    /// The cosine up to which a fraction `u` of the probability lies.
    pub(super) fn sample(&self, cosines: &[f64], u: f64) -> f64 {
        let above = self.cumulative.partition_point(|&cumulative| cumulative <= u);
        let index = above.clamp(1, self.values.len() - 1) - 1;
        let [low, high] = [cosines[index], cosines[index + 1]];
        let area = (u - self.cumulative[index]) / (high - low);
        low + within([self.values[index], self.values[index + 1]], area) * (high - low)
    }
}
