/// When light is let in: the distribution of the rays' times.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shutter {
    /// When it opens, in the scene's unit of time.
    pub open: f64,
    /// Not before `open`.
    pub close: f64,
    /// How it opens and closes.
    pub kind: ShutterKind,
}

/// How much light is let in over the time that the shutter is open.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShutterKind {
    /// The same at all times.
    Box,
    /// Most at the middle of the time, falling linearly to none at its ends.
    Triangle,
    /// Flashes, the first when the shutter opens, the last when it closes, and equal times between them. A
    /// single one is at the middle.
    Strobe {
        /// Number of flashes, at least 1.
        flashes: u32,
    },
}

impl Shutter {
    /// Lets light in at time 0 only.
    pub const INSTANT: Self = Self { open: 0.0, close: 0.0, kind: ShutterKind::Box };

    /// Times from its opening to its closing.
    pub fn during(&self) -> [f64; 2] {
        [self.open, self.close]
    }

    /// The time of a ray, for a sample value in [0, 1). Strata of the value are strata of time.
    pub fn time(&self, u: f64) -> f64 {
        let fraction = match self.kind {
            ShutterKind::Box => u,
            ShutterKind::Triangle if u < 0.5 => (0.5 * u).sqrt(),
            ShutterKind::Triangle => 1.0 - (0.5 * (1.0 - u)).sqrt(),
            ShutterKind::Strobe { flashes: 0 | 1 } => 0.5,
            ShutterKind::Strobe { flashes } => {
                let last = f64::from(flashes - 1);
                (u * f64::from(flashes)).floor().min(last) / last
            }
        };
        // Never beyond the end by rounding.
        (self.open + fraction * (self.close - self.open)).min(self.close)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn times(kind: ShutterKind, n: u32) -> Vec<f64> {
        let shutter = Shutter { open: 2.0, close: 4.0, kind };
        (0..n).map(|i| shutter.time((f64::from(i) + 0.5) / f64::from(n))).collect()
    }

    #[test]
    fn times_follow_what_is_let_in() {
        assert_eq!(times(ShutterKind::Box, 4), [2.25, 2.75, 3.25, 3.75]);
        assert_eq!(times(ShutterKind::Strobe { flashes: 1 }, 2), [3.0, 3.0]);
        assert_eq!(times(ShutterKind::Strobe { flashes: 3 }, 6), [2.0, 2.0, 3.0, 3.0, 4.0, 4.0]);
        // Over a triangle from 2 to 4 the fraction of times up to t is (t − 2)²/2 in its first half.
        let n = 1000;
        for (i, time) in times(ShutterKind::Triangle, n).into_iter().enumerate() {
            let below =
                if time < 3.0 { 0.5 * (time - 2.0).powi(2) } else { 1.0 - 0.5 * (4.0 - time).powi(2) };
            assert!((below - (i as f64 + 0.5) / f64::from(n)).abs() < 1e-12);
        }
    }
}
