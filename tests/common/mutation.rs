//! Files with random mistakes, which nothing is to take long over.

use std::time::{Duration, Instant};

/// Steele, Lea and Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014.
fn splitmix(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (*state ^ (*state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// A few bytes changed, left out, put in or doubled.
pub fn mutated(bytes: &[u8], state: &mut u64) -> Vec<u8> {
    const TOKENS: [&[u8]; 12] = [
        b"\"",
        b"<",
        b"/>",
        b"$",
        b"-1",
        b"1e308",
        b"nan",
        b"4294967295",
        b"999999999999",
        b":",
        b"\0",
        b"\xff",
    ];
    let mut bytes = bytes.to_vec();
    for _ in 0..=splitmix(state) % 4 {
        let at = (splitmix(state) as usize) % (bytes.len() + 1);
        let until = (at + (splitmix(state) as usize) % 9).min(bytes.len());
        match splitmix(state) % 5 {
            0 if at < bytes.len() => bytes[at] = splitmix(state) as u8,
            1 => drop(bytes.drain(at..until)),
            2 => {
                let copy = bytes[at..until].to_vec();
                bytes.splice(at..at, copy);
            }
            3 => {
                let token = TOKENS[(splitmix(state) as usize) % TOKENS.len()];
                bytes.splice(at..until, token.iter().copied());
            }
            _ => bytes.truncate(at.max(1)),
        }
    }
    bytes
}

pub fn within(limit: Duration, what: &str, run: impl FnOnce()) {
    let start = Instant::now();
    run();
    assert!(start.elapsed() < limit, "{what} took {:?}", start.elapsed());
}
