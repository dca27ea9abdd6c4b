//! The lists that a study takes on the command line.

use super::super::sampling_options;
use abbe::integrator::Estimator;
use abbe::render::WavelengthCount;
use abbe::sampling::SamplerKind;

/// Several values of one option.
#[derive(Clone)]
pub struct List<T>(pub Vec<T>);

/// Without those that come again.
pub fn distinct<T: PartialEq>(values: Vec<T>) -> List<T> {
    let mut kept: Vec<T> = Vec::new();
    for value in values {
        if !kept.contains(&value) {
            kept.push(value);
        }
    }
    List(kept)
}

pub fn parse_samplers(text: &str) -> Result<List<SamplerKind>, String> {
    if text == "all" {
        return Ok(List(SamplerKind::NAMES.map(|(_, kind)| kind).to_vec()));
    }
    let kinds: Option<Vec<SamplerKind>> =
        text.split(',').map(|name| SamplerKind::named(name.trim())).collect();
    kinds.map(distinct).ok_or_else(|| {
        format!(
            "expected all, or some of {}, with commas",
            SamplerKind::NAMES.map(|(name, _)| name).join(", ")
        )
    })
}

pub fn parse_spp(text: &str) -> Result<List<u32>, String> {
    let expected =
        || "expected a list such as 1,4,16, or 1..256 for powers of two, each 1 to 65536".to_owned();
    let number = |text: &str| {
        let number: Option<u32> = text.trim().parse().ok();
        number.filter(|number| (1..=65_536).contains(number)).ok_or_else(expected)
    };
    let mut samples = match text.split_once("..") {
        Some((first, last)) => {
            let (first, last) = (number(first)?, number(last)?);
            (0..=16).map(|power| 1 << power).filter(|samples| (first..=last).contains(samples)).collect()
        }
        None => text.split(',').map(number).collect::<Result<Vec<u32>, String>>()?,
    };
    if samples.is_empty() {
        return Err(expected());
    }
    samples.sort_unstable();
    Ok(distinct(samples))
}

pub fn parse_wavelengths(text: &str) -> Result<List<WavelengthCount>, String> {
    parse_each(text, sampling_options::parse_wavelengths)
}

pub fn parse_estimators(text: &str) -> Result<List<Estimator>, String> {
    parse_each(text, sampling_options::parse_estimator)
}

/// Values with commas between them.
fn parse_each<T: PartialEq>(text: &str, parse: fn(&str) -> Result<T, String>) -> Result<List<T>, String> {
    text.split(',').map(|value| parse(value.trim())).collect::<Result<_, _>>().map(distinct)
}

pub fn parse_target(text: &str) -> Result<f64, String> {
    let target: Option<f64> = text.parse().ok();
    target
        .filter(|target| *target > 0.0 && target.is_finite())
        .ok_or_else(|| "expected a relative error above 0, for example 0.01".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_samples_are_lists_or_powers_of_two() {
        let parsed = |text| parse_spp(text).map(|list| list.0).ok();
        assert_eq!(parsed("1..16"), Some(vec![1, 2, 4, 8, 16]));
        assert_eq!(parsed("3..70"), Some(vec![4, 8, 16, 32, 64]));
        assert_eq!(parsed("9, 4,4,100"), Some(vec![4, 9, 100]));
        for wrong in ["0", "", "5..7", "1..", "x", "1,,2", "70000"] {
            assert_eq!(parsed(wrong), None, "{wrong}");
        }
    }
}
