//! Spectra written as text: Mitsuba's `.spd` files and `wavelength:value` lists.
//!
//! Both give plain pairs of columns; [`Spectrum::irregular`](super::Spectrum::irregular) makes the function.
//! Every refusal says where in the text it is.

use std::fmt;

/// The two columns of a spectrum as written: wavelengths (nm, strictly increasing) and values.
#[derive(Clone, Debug, PartialEq)]
pub struct Columns {
    /// Wavelengths, nm, strictly ascending.
    pub nodes: Vec<f64>,
    /// Values at them.
    pub values: Vec<f64>,
}

/// What is wrong at one place of a text.
#[derive(Clone, Debug, PartialEq)]
pub enum TextProblem {
    /// The text at this place is not a finite number.
    NotANumber(String),
    /// A wavelength without a value.
    NoValue,
    /// More than a wavelength and a value.
    Trailing(String),
    /// No `:` between wavelength and value.
    NoColon(String),
    /// A wavelength that is not positive.
    NotPositive(f64),
    /// A wavelength that is not above its predecessor.
    NotIncreasing {
        /// The wavelength before, nm.
        previous_nm: f64,
        /// The wavelength, nm.
        nm: f64,
    },
    /// Fewer than two wavelengths in all.
    TooFew(usize),
    /// Wavelengths that can only be in another unit than nm: the first and the last.
    NotNanometres([f64; 2]),
}

impl fmt::Display for TextProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotANumber(text) => write!(f, "expected a number, found '{text}'"),
            Self::NoValue => write!(f, "expected a value after the wavelength"),
            Self::Trailing(text) => write!(f, "expected only a wavelength and a value, found also '{text}'"),
            Self::NoColon(text) => write!(f, "expected 'wavelength:value', found '{text}'"),
            Self::NotPositive(nm) => write!(f, "expected a positive wavelength in nm, found {nm}"),
            Self::NotIncreasing { previous_nm, nm } => {
                write!(f, "expected a wavelength above {previous_nm} nm, found {nm} nm")
            }
            Self::TooFew(found) => write!(f, "expected at least 2 wavelengths, found {found}"),
            Self::NotNanometres([first, last]) => {
                write!(f, "expected wavelengths in nm, found {first} to {last}")
            }
        }
    }
}

/// What to do about [`TextProblem::NotNanometres`].
pub const TO_NANOMETRES: &str = "write nanometres: multiply micrometres by 1000, metres by 1e9";

/// Refuses a table whose ends show that its wavelengths are in micrometres or metres: no light that is
/// rendered is below 1 nm, and tables of light that begin there reach far beyond 100 nm.
///
/// # Errors
/// [`TextProblem::NotNanometres`].
pub fn demand_nanometres([first, last]: [f64; 2]) -> Result<(), TextProblem> {
    let least = if first < 1.0 { 100.0 } else { 10.0 };
    if last < least { Err(TextProblem::NotNanometres([first, last])) } else { Ok(()) }
}

/// A problem in a file, at a line and a column (both from 1; columns count characters).
#[derive(Clone, Debug, PartialEq)]
pub struct SpdError {
    /// The line, counted from 1.
    pub line: usize,
    /// The column, counted from 1.
    pub column: usize,
    /// What is wrong there.
    pub problem: TextProblem,
}

impl fmt::Display for SpdError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}, column {}: {}", self.line, self.column, self.problem)
    }
}

impl std::error::Error for SpdError {}

/// A problem in a list, at a byte offset from its start.
#[derive(Clone, Debug, PartialEq)]
pub struct ListError {
    /// Where it is, in bytes from the beginning of the list.
    pub offset: usize,
    /// What is wrong there.
    pub problem: TextProblem,
}

impl fmt::Display for ListError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "at byte {}: {}", self.offset, self.problem)
    }
}

impl std::error::Error for ListError {}

/// Reads an `.spd` file: lines of `wavelength value`, separated by blanks; empty lines and lines that start
/// with `#` are skipped, and so is what follows a `#` within a line.
///
/// # Errors
/// The first place that is not so, or where wavelengths do not increase.
pub fn parse_spd(text: &str) -> Result<Columns, SpdError> {
    let mut columns = Columns { nodes: Vec::new(), values: Vec::new() };
    let (mut lines, mut begins) = (0, [1, 1]);
    for (number, line) in text.lines().enumerate() {
        lines = number + 1;
        let body = line.split('#').next().unwrap_or_default();
        let place = |word: &str| body[..offset_within(body, word)].chars().count() + 1;
        let refuse = |column, problem| SpdError { line: number + 1, column, problem };
        let mut words = body.split_whitespace();
        let Some(first) = words.next() else { continue };
        let nm = number_of(first).map_err(|problem| refuse(place(first), problem))?;
        let Some(second) = words.next() else {
            return Err(refuse(place(first) + first.chars().count(), TextProblem::NoValue));
        };
        let value = number_of(second).map_err(|problem| refuse(place(second), problem))?;
        if let Some(third) = words.next() {
            return Err(refuse(place(third), TextProblem::Trailing(third.to_owned())));
        }
        columns.push(nm, value).map_err(|problem| refuse(place(first), problem))?;
        if columns.nodes.len() == 1 {
            begins = [number + 1, place(first)];
        }
    }
    match columns.problem() {
        Some(problem @ TextProblem::TooFew(_)) => Err(SpdError { line: lines.max(1), column: 1, problem }),
        Some(problem) => Err(SpdError { line: begins[0], column: begins[1], problem }),
        None => Ok(columns),
    }
}

/// Reads a list `wavelength:value, wavelength:value, ...` as Mitsuba's `<spectrum value="...">` writes it;
/// commas, blanks or both separate the pairs.
///
/// # Errors
/// The first place that is not so, or where wavelengths do not increase.
pub fn parse_list(text: &str) -> Result<Columns, ListError> {
    let mut columns = Columns { nodes: Vec::new(), values: Vec::new() };
    let separates = |c: char| c == ',' || c.is_whitespace();
    for pair in text.split(separates).filter(|pair| !pair.is_empty()) {
        let refuse = |part: &str, problem| ListError { offset: offset_within(text, part), problem };
        let Some((first, second)) = pair.split_once(':') else {
            return Err(refuse(pair, TextProblem::NoColon(pair.to_owned())));
        };
        let nm = number_of(first).map_err(|problem| refuse(first, problem))?;
        if second.is_empty() {
            return Err(refuse(second, TextProblem::NoValue));
        }
        let value = number_of(second).map_err(|problem| refuse(second, problem))?;
        columns.push(nm, value).map_err(|problem| refuse(first, problem))?;
    }
    match columns.problem() {
        Some(problem) => Err(ListError { offset: text.len(), problem }),
        None => Ok(columns),
    }
}

impl Columns {
    /// What is wrong with them as a whole.
    fn problem(&self) -> Option<TextProblem> {
        match self.nodes.as_slice() {
            few @ ([] | [_]) => Some(TextProblem::TooFew(few.len())),
            &[first, .., last] => demand_nanometres([first, last]).err(),
        }
    }

    fn push(&mut self, nm: f64, value: f64) -> Result<(), TextProblem> {
        if nm <= 0.0 {
            return Err(TextProblem::NotPositive(nm));
        }
        if let Some(&previous_nm) = self.nodes.last().filter(|&&previous| previous >= nm) {
            return Err(TextProblem::NotIncreasing { previous_nm, nm });
        }
        self.nodes.push(nm);
        self.values.push(value);
        Ok(())
    }
}

/// A number of at most what single precision holds: sums and products of larger ones would overflow.
fn number_of(word: &str) -> Result<f64, TextProblem> {
    match word.parse::<f64>() {
        Ok(number) if number.abs() <= f64::from(f32::MAX) => Ok(number),
        _ => Err(TextProblem::NotANumber(word.to_owned())),
    }
}

/// Where `part`, a slice of `whole`, begins in it (bytes).
fn offset_within(whole: &str, part: &str) -> usize {
    part.as_ptr() as usize - whole.as_ptr() as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    #[test]
    fn an_spd_file_is_read() {
        let text = "# a comment\n\n400 0.5\n  500.5\t1e-3  # remark\r\n600 -2\n";
        let columns = parse_spd(text).unwrap();
        assert_eq!(columns.nodes, [400.0, 500.5, 600.0]);
        assert_eq!(columns.values, [0.5, 1e-3, -2.0]);
    }

    #[test]
    fn an_spd_error_says_line_and_column() {
        let error = |text: &str| parse_spd(text).unwrap_err();
        let at = |line, column, problem| SpdError { line, column, problem };
        let word = |word: &str| word.to_owned();
        assert_eq!(error("400 1\n500, 2"), at(2, 1, TextProblem::NotANumber(word("500,"))));
        assert_eq!(error("400 1\n 500 é"), at(2, 6, TextProblem::NotANumber(word("é"))));
        assert_eq!(error("400 1\n500 nan"), at(2, 5, TextProblem::NotANumber(word("nan"))));
        assert_eq!(error("400 1\n\n500"), at(3, 4, TextProblem::NoValue));
        assert_eq!(error("400 1 7"), at(1, 7, TextProblem::Trailing(word("7"))));
        assert_eq!(error("-400 1"), at(1, 1, TextProblem::NotPositive(-400.0)));
        let falling = TextProblem::NotIncreasing { previous_nm: 400.0, nm: 400.0 };
        assert_eq!(error("400 1\n400 2"), at(2, 1, falling));
        assert_eq!(error("# nothing\n"), at(1, 1, TextProblem::TooFew(0)));
        assert_eq!(error("400 1").to_string(), "line 1, column 1: expected at least 2 wavelengths, found 1");
    }

    #[test]
    fn micrometres_and_metres_are_told_from_nanometres() {
        let spd = |text: &str| parse_spd(text).map(|columns| columns.nodes.len());
        let at = |line, column, ends| SpdError { line, column, problem: TextProblem::NotNanometres(ends) };
        assert_eq!(spd("# BK7\n 0.3 1.55\n2.5 1.47\n"), Err(at(2, 2, [0.3, 2.5])));
        assert_eq!(spd("1 1\n5 2"), Err(at(1, 1, [1.0, 5.0])));
        assert_eq!(spd("0.3 1\n24.9 2"), Err(at(1, 1, [0.3, 24.9])));
        assert_eq!(spd("4e-7 1\n7e-7 1"), Err(at(1, 1, [4e-7, 7e-7])));
        // The spectrum of the sun, from X-rays on; extreme ultraviolet.
        assert_eq!(spd("0.5 0\n400 1\n2400 1"), Ok(3));
        assert_eq!(spd("5 1\n13.5 2"), Ok(2));
        assert_eq!(
            parse_list("0.4:0.5, 0.7:0.9"),
            Err(ListError { offset: 16, problem: TextProblem::NotNanometres([0.4, 0.7]) })
        );
    }

    #[test]
    fn a_list_is_read() {
        for text in ["400:1, 500.5:2e-1,600:3", " 400:1 500.5:0.2\n600:3,", "400:1,500.5:.2,600:3"] {
            let columns = parse_list(text).unwrap();
            assert_eq!(columns.nodes, [400.0, 500.5, 600.0], "{text}");
            assert_eq!(columns.values, [1.0, 0.2, 3.0], "{text}");
        }
    }

    #[test]
    fn a_list_error_says_the_byte() {
        let error = |text: &str| parse_list(text).unwrap_err();
        let at = |offset, problem| ListError { offset, problem };
        assert_eq!(error("400:1, 500"), at(7, TextProblem::NoColon("500".to_owned())));
        assert_eq!(error("400:1, 500:x"), at(11, TextProblem::NotANumber("x".to_owned())));
        assert_eq!(error("400:1, 500:2:3"), at(11, TextProblem::NotANumber("2:3".to_owned())));
        assert_eq!(error("400:1, 500:, 600:1"), at(11, TextProblem::NoValue));
        assert_eq!(
            error("400:1, 4e2:2"),
            at(7, TextProblem::NotIncreasing { previous_nm: 400.0, nm: 400.0 })
        );
        assert_eq!(error("400:1"), at(5, TextProblem::TooFew(1)));
    }

    /// Whatever is read, nothing panics, and what is accepted makes a spectrum.
    #[test]
    fn no_text_breaks_the_readers() {
        let letters: Vec<char> = "0123456789abcdef .,:#é\n-".chars().collect();
        let mut random = Pcg64Mcg::seed_from_u64(1);
        for _ in 0..1000 {
            let length = random.random_range(0..=60);
            let text: String = (0..length).map(|_| letters[random.random_range(0..letters.len())]).collect();
            for columns in [parse_spd(&text).ok(), parse_list(&text).ok()].into_iter().flatten() {
                let outside = crate::spectrum::Extrapolation::Zero;
                let read = crate::spectrum::Spectrum::irregular(&columns.nodes, &columns.values, outside);
                assert!(read.is_ok(), "{text}");
            }
        }
    }
}
