//! One change to what is text, at random.

/// Steele, Lea and Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014.
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub fn below(&mut self, limit: usize) -> usize {
        (self.next() % limit.max(1) as u64) as usize
    }
}

/// Where a stretch of bytes that `belongs` begins and ends, around a random place.
fn stretch(bytes: &[u8], random: &mut Random, belongs: impl Fn(u8) -> bool) -> Option<(usize, usize)> {
    let from = random.below(bytes.len());
    let start = from + bytes[from..].iter().position(|&byte| belongs(byte))?;
    let length = bytes[start..].iter().position(|&byte| !belongs(byte)).unwrap_or(bytes.len() - start);
    Some((start, start + length))
}

fn line(bytes: &[u8], random: &mut Random) -> (usize, usize) {
    stretch(bytes, random, |byte| byte != b'\n').unwrap_or((0, 0))
}

/// One change.
pub fn change(bytes: &mut Vec<u8>, other: &[u8], random: &mut Random) {
    const NUMBERS: [&str; 16] = [
        "0",
        "-1",
        "1",
        "1e308",
        "-1e308",
        "1e-308",
        "nan",
        "inf",
        "4294967295",
        "4294967296",
        "99999999999",
        "-2147483649",
        "0.5",
        "1e9",
        "65536",
        "1e-12",
    ];
    const TOKENS: [&str; 20] = [
        "\"",
        "<",
        "/>",
        "$",
        ":",
        "\0",
        "{",
        "}",
        "[",
        "]",
        ",",
        "<!--",
        "-->",
        "type=\"null\"",
        "<ref id=\"a\"/>",
        "\r",
        "é",
        "&amp;",
        "\\u0000",
        "<include filename=\"scene.xml\"/>",
    ];
    let digit = |byte: u8| byte.is_ascii_digit() || byte == b'.';
    let at = random.below(bytes.len() + 1);
    let until = (at + random.below(9)).min(bytes.len());
    match random.below(12) {
        0 if at < bytes.len() => bytes[at] = random.next() as u8,
        1 => drop(bytes.drain(at..until)),
        2 => {
            let token = TOKENS[random.below(TOKENS.len())].bytes();
            drop(bytes.splice(at..until, token));
        }
        3 => {
            let (from, to) = line(bytes, random);
            drop(bytes.drain(from..to));
        }
        4 => {
            let (from, to) = line(bytes, random);
            let copy = bytes[from..to].to_vec();
            drop(bytes.splice(at..at, copy));
        }
        5 => {
            let (from, to) = line(other, random);
            drop(bytes.splice(at..at, other[from..to].iter().copied()));
        }
        6 => {
            // A line of another file in the place of one of this.
            let (from, to) = line(bytes, random);
            let (start, end) = line(other, random);
            drop(bytes.splice(from..to, other[start..end].iter().copied()));
        }
        7 => {
            let word = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'_';
            if let (Some((from, to)), Some((start, end))) =
                (stretch(bytes, random, word), stretch(other, random, word))
            {
                drop(bytes.splice(from..to, other[start..end].iter().copied()));
            }
        }
        8 if random.below(4) == 0 => bytes.truncate(at),
        _ => {
            if let Some((from, to)) = stretch(bytes, random, digit) {
                let ordinary = format!("{}", random.below(4000) as f64 / 1000.0);
                let number =
                    if random.below(2) == 0 { &ordinary } else { NUMBERS[random.below(NUMBERS.len())] };
                drop(bytes.splice(from..to, number.bytes()));
            }
        }
    }
}
