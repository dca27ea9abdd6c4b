/// How numbers become places along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Equal differences are equally long.
    Linear,
    /// Only numbers above 0 have a place.
    Log,
}

/// One axis of a chart.
#[derive(Clone, Debug)]
pub struct Axis {
    /// What it is, with its unit.
    pub title: String,
    /// How numbers become places.
    pub scale: Scale,
    /// What it shows at least; the data widens it where it is `None`.
    pub range: Option<[f64; 2]>,
    /// Places of its numbers; round ones are found where there are none.
    pub ticks: Vec<f64>,
}

impl Axis {
    /// An axis with its title, unit included.
    pub fn new(title: &str, scale: Scale) -> Self {
        Self { title: title.to_owned(), scale, range: None, ticks: Vec::new() }
    }
}

/// An axis with its range settled: between numbers and the unit interval.
#[derive(Clone, Debug)]
pub(super) struct Settled {
    scale: Scale,
    from: f64,
    to: f64,
    /// Numbers with their labels.
    pub ticks: Vec<(f64, String)>,
}

impl Settled {
    /// An axis for these numbers, of which those without a place are left out.
    pub fn new(axis: &Axis, numbers: impl Iterator<Item = f64>) -> Self {
        let placed = |value: &f64| value.is_finite() && (axis.scale == Scale::Linear || *value > 0.0);
        let (mut from, mut to) = numbers
            .filter(placed)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
        if let Some([low, high]) = axis.range {
            (from, to) = (low, high);
        }
        if from > to {
            (from, to) = (1.0, 10.0);
        }
        match axis.scale {
            Scale::Linear => {
                if from == to {
                    to = from + 1.0;
                }
                let ticks = if axis.ticks.is_empty() { linear_ticks(from, to) } else { axis.ticks.clone() };
                if axis.range.is_none() {
                    from = from.min(ticks[0]);
                    to = to.max(ticks[ticks.len() - 1]);
                }
                let step = if ticks.len() > 1 { ticks[1] - ticks[0] } else { 1.0 };
                let inside = |tick: &f64| *tick >= from - 1e-9 * step && *tick <= to + 1e-9 * step;
                let ticks = ticks.into_iter().filter(inside).map(|tick| (tick, number(tick, step))).collect();
                Self { scale: axis.scale, from, to, ticks }
            }
            Scale::Log => {
                if axis.range.is_none() {
                    // Room for what stands at the ends.
                    let room = (0.04 * (to / from).ln()).max(0.05).exp();
                    (from, to) = (from / room, to * room);
                }
                let ticks = if axis.ticks.is_empty() {
                    log_ticks(from, to)
                } else {
                    axis.ticks.iter().map(|&tick| (tick, plain(tick))).collect()
                };
                let ticks = ticks.into_iter().filter(|(tick, _)| *tick >= from && *tick <= to).collect();
                Self { scale: axis.scale, from, to, ticks }
            }
        }
    }

    /// 0 at the lower end, 1 at the upper; `None` where there is no place.
    pub fn place(&self, value: f64) -> Option<f64> {
        let place = match self.scale {
            Scale::Linear => (value - self.from) / (self.to - self.from),
            Scale::Log if value > 0.0 => (value / self.from).ln() / (self.to / self.from).ln(),
            Scale::Log => return None,
        };
        place.is_finite().then_some(place)
    }

    /// Places of the small lines between the numbers.
    pub fn minor(&self) -> Vec<f64> {
        if self.scale == Scale::Linear || (self.to / self.from).log10() > 9.0 {
            return Vec::new();
        }
        let decades = self.from.log10().floor() as i32..=self.to.log10().floor() as i32;
        let all = decades.flat_map(|decade| (1..10).map(move |digit| f64::from(digit) * 10f64.powi(decade)));
        all.filter_map(|value| self.place(value)).filter(|place| (0.0..=1.0).contains(place)).collect()
    }
}

/// About seven round numbers from at or below `from` to at or above `to`.
fn linear_ticks(from: f64, to: f64) -> Vec<f64> {
    let rough = (to - from) / 6.0;
    let power = 10f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 2.5, 5.0, 10.0]
        .into_iter()
        .map(|factor| factor * power)
        .find(|&step| step >= rough * (1.0 - 1e-9))
        .unwrap_or(10.0 * power);
    let (first, last) = ((from / step + 1e-9).floor(), (to / step - 1e-9).ceil());
    (0..=(last - first).max(1.0) as usize).map(|i| (first + i as f64) * step).collect()
}

/// Powers of ten, at most eight; multiples of them as well where there are few, and equal steps where even of
/// these fewer than three lie between the ends.
fn log_ticks(from: f64, to: f64) -> Vec<(f64, String)> {
    let decades = (to / from).log10();
    let (first, last) = (from.log10().floor() as i32, to.log10().ceil() as i32);
    let every = ((decades / 8.0).ceil() as i32).max(1);
    let digits: &[f64] = match decades {
        d if d >= 2.2 => &[1.0],
        d if d >= 1.0 => &[1.0, 2.0, 5.0],
        _ => &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0],
    };
    let powers = (first..=last).filter(|power| power.rem_euclid(every) == 0);
    let ticks: Vec<(f64, String)> = powers
        .flat_map(|power| digits.iter().map(move |&digit| (digit, power)))
        .map(|(digit, power)| (digit * 10f64.powi(power), power_of_ten(digit, power)))
        .collect();
    if ticks.iter().filter(|(tick, _)| (from..=to).contains(tick)).count() >= 3 {
        return ticks;
    }
    let equal = linear_ticks(from, to);
    let step = equal[1] - equal[0];
    equal.into_iter().map(|tick| (tick, number(tick, step))).collect()
}

/// `10⁻³`, `2·10⁻³`; plain numbers from 0.01 to 1000.
fn power_of_ten(digit: f64, power: i32) -> String {
    if (-2..=3).contains(&power) {
        return plain(digit * 10f64.powi(power));
    }
    let superscript: String = power.to_string().chars().map(superscript).collect();
    if digit == 1.0 { format!("10{superscript}") } else { format!("{digit}·10{superscript}") }
}

fn superscript(c: char) -> char {
    match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => digit.to_digit(10).and_then(|digit| char::from_u32('⁰' as u32 + digit)).unwrap_or(digit),
    }
}

/// As few digits as tell it, with the minus sign of print.
fn plain(value: f64) -> String {
    let text = format!("{:.4}", value);
    text.trim_end_matches('0').trim_end_matches('.').replace('-', "−")
}

/// With as many decimals as tell it from the next one, a step away.
fn number(value: f64, step: f64) -> String {
    if value != 0.0 && !(1e-4..1e6).contains(&value.abs()) {
        return format!("{value:.2e}").replace('-', "−");
    }
    let whole = |d: &i32| {
        let fraction = (step * 10f64.powi(*d)).fract();
        fraction.min(1.0 - fraction) < 1e-6
    };
    let decimals = (0..9).find(whole).unwrap_or(9);
    // No number of a plot is −0.
    format!("{:.*}", decimals as usize, value + 0.0).replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_enclose() {
        assert_eq!(linear_ticks(0.0, 1.0), [0.0, 0.2, 0.4, 0.6000000000000001, 0.8, 1.0]);
        let wide = linear_ticks(3.7, 118.0);
        assert!(wide[0] <= 3.7 && *wide.last().unwrap() >= 118.0 && wide.len() < 10, "{wide:?}");
        assert_eq!(number(0.6000000000000001, 0.2), "0.6");
        assert_eq!(number(1.525, 0.0025), "1.5250");
        assert_eq!(number(2e7, 5e6), "2.00e7");
    }

    #[test]
    fn a_logarithmic_axis_has_powers_of_ten() {
        let axis = Settled::new(&Axis::new("", Scale::Log), [3e-5, 0.0, 4e-1, f64::NAN].into_iter());
        let labels: Vec<&str> = axis.ticks.iter().map(|(_, label)| label.as_str()).collect();
        assert_eq!(labels, ["10⁻⁴", "10⁻³", "0.01", "0.1"]);
        assert_eq!(axis.place(0.0), None);
        let [low, high] = [1e-4, 1e-3].map(|value| axis.place(value).unwrap());
        let decade = axis.place(1e-2).unwrap() - high;
        assert!((high - low - decade).abs() < 1e-12 && low > 0.0);
        assert_eq!(power_of_ten(2.0, -12), "2·10⁻¹²");
    }

    /// However short the axis, three numbers tell its scale, in all decades.
    #[test]
    fn a_short_logarithmic_axis_has_numbers() {
        for i in 0..1000 {
            let from = 1e-5 * 1.03f64.powi(i);
            for span in [1.05, 1.3, 2.0, 5.0, 9.0, 30.0, 200.0] {
                let axis = Settled::new(&Axis::new("", Scale::Log), [from, span * from].into_iter());
                assert!((3..=14).contains(&axis.ticks.len()), "{from} {span} {:?}", axis.ticks);
            }
        }
    }

    #[test]
    fn an_axis_without_data_stands() {
        for scale in [Scale::Linear, Scale::Log] {
            let axis = Settled::new(&Axis::new("", scale), std::iter::empty());
            assert!(axis.ticks.len() >= 2 && axis.place(2.0).is_some());
        }
    }
}
