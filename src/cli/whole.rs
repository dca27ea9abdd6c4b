use std::ops::RangeInclusive;

/// Reads a whole number within a range.
pub fn whole<T: TryFrom<u64>>(
    range: RangeInclusive<u64>,
) -> impl Fn(&str) -> Result<T, String> + Clone + Send + Sync {
    move |text| {
        let number = text.parse().ok().filter(|number| range.contains(number));
        number
            .and_then(|number| T::try_from(number).ok())
            .ok_or_else(|| format!("expected a whole number from {} to {}", range.start(), range.end()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_out_of_its_range_is_told_the_range() {
        assert_eq!(whole::<u32>(1..=64)("64"), Ok(64));
        for wrong in ["0", "65", "-1", "99999999999999999999999", "1.5", "x", ""] {
            let told = Err("expected a whole number from 1 to 64".to_owned());
            assert_eq!(whole::<u32>(1..=64)(wrong), told, "{wrong}");
        }
        assert_eq!(whole::<u64>(0..=u64::MAX)("18446744073709551615"), Ok(u64::MAX));
    }
}
