//! The film: integer sums per pixel, reconstruction filters, error bars.

/// A reconstruction filter over the image plane, in pixels, with Mitsuba 3's names and defaults.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FilterKind {
    Box,
    Tent { radius: f64 },
    Gaussian { stddev: f64 },
    Mitchell { b: f64, c: f64 },
    CatmullRom,
    Lanczos { lobes: u32 },
}
