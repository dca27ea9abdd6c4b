//! Plots: curves with error bars on linear or logarithmic axes, and panels of false-colour images. Each is
//! laid out once as a [`Drawing`], which is written as SVG or as PNG with a font of its own, so that it looks
//! the same everywhere.
//!
//! Nothing here knows what is plotted.

mod axis;
mod chart;
mod drawing;
mod ink;
mod panels;
mod png;

pub use axis::{Axis, Scale};
pub use chart::{Chart, Marker, Point, Series, Strip};
pub use drawing::{Anchor, Bitmap, Drawing, FONTS, escaped};
pub use ink::{Dash, Ink};
pub use panels::{Colours, Panel, Panels};

/// Inks that people with any colour vision tell apart, and that print: Okabe and Ito, "Color Universal
/// Design", 2008, without the yellow that white paper swallows.
pub const INKS: [Ink; 7] = [
    Ink::hex(0x0072b2),
    Ink::hex(0xd55e00),
    Ink::hex(0x009e73),
    Ink::hex(0xcc79a7),
    Ink::hex(0xe69f00),
    Ink::hex(0x56b4e9),
    Ink::hex(0x222222),
];
