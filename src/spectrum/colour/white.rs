//! White of a picture that does not say it.

/// Share of the pixels, the brightest, that do not raise the mean further: lamps and glints.
const LAMPS: f64 = 0.01;

/// Luminance of the reference's mean over that of white: a photographer's grey card.
const GREY: f64 = 0.18;

/// The luminance of white that makes the mean of a picture a middle grey; 1 for a black one. Lamps and glints
/// do not raise the mean.
pub fn assumed_white(mut luminance: Vec<f64>) -> f64 {
    luminance.sort_by(f64::total_cmp);
    let Some(last) = luminance.len().checked_sub(1) else { return 1.0 };
    let lamp = luminance[last - (LAMPS * last as f64) as usize];
    let mean = luminance.iter().map(|&value| value.min(lamp)).sum::<f64>() / luminance.len() as f64;
    if mean > 0.0 { mean / GREY } else { 1.0 }
}
