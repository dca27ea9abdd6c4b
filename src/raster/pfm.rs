//! Portable float maps: a header in text, then rows of 32-bit floats from the bottom up (P. Debevec's PFM).

use super::{Image, ImageError, check_size};

pub(super) fn is_pfm(bytes: &[u8]) -> bool {
    matches!(bytes, [b'P', b'F' | b'f', space, ..] if space.is_ascii_whitespace())
}

pub(super) fn decode(bytes: &[u8]) -> Result<Image, ImageError> {
    let channels = if bytes[1] == b'F' { 3 } else { 1 };
    let mut at = 2;
    let mut word = || {
        let rest = &bytes[at..];
        let start = rest.iter().position(|byte| !byte.is_ascii_whitespace())?;
        let length = rest[start..].iter().position(u8::is_ascii_whitespace)?;
        // One blank ends the word, and the header.
        at += start + length + 1;
        std::str::from_utf8(&rest[start..start + length]).ok()
    };
    let header = || {
        ImageError::new(
            "The header of the PFM file is wrong",
            "expected PF or Pf, the width, the height and a scale other than 0",
        )
    };
    let width: usize = word().and_then(|word| word.parse().ok()).ok_or_else(header)?;
    let height: usize = word().and_then(|word| word.parse().ok()).ok_or_else(header)?;
    let scale: f32 = word().and_then(|word| word.parse().ok()).ok_or_else(header)?;
    if !scale.is_finite() || scale == 0.0 {
        return Err(header());
    }
    check_size(width, height, 4 * channels, bytes.len())?;
    let row_bytes = 4 * channels * width;
    let Some(data) = bytes.get(at..).and_then(|rest| rest.get(..row_bytes * height)) else {
        return Err(ImageError::new(
            format!("The file is too short for {width} × {height} texels"),
            format!("expected {} bytes after the header", row_bytes * height),
        ));
    };
    // The sign of the scale tells the byte order; its size is that of a unit.
    let value = |bytes: &[u8]| {
        let bytes = [bytes[0], bytes[1], bytes[2], bytes[3]];
        scale.abs() * if scale < 0.0 { f32::from_le_bytes(bytes) } else { f32::from_be_bytes(bytes) }
    };
    let values = data.chunks_exact(row_bytes).rev().flat_map(|row| row.chunks_exact(4).map(value)).collect();
    Ok(Image::new(width, height, channels, values, false))
}
