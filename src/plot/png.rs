//! From SVG to pixels. The only file that names resvg.

use super::drawing::{Bitmap, Drawing, FONTS};
use resvg::tiny_skia::{FilterQuality, Pixmap, PixmapPaint, PremultipliedColorU8, Transform};
use resvg::usvg;
use std::sync::{Arc, OnceLock};

fn fonts() -> Arc<usvg::fontdb::Database> {
    static KNOWN: OnceLock<Arc<usvg::fontdb::Database>> = OnceLock::new();
    let load = || {
        let mut database = usvg::fontdb::Database::new();
        for font in FONTS {
            database.load_font_data(font.to_vec());
        }
        Arc::new(database)
    };
    KNOWN.get_or_init(load).clone()
}

/// The drawing whose SVG without bitmaps is given, as a PNG file.
pub(super) fn draw(svg: &str, drawing: &Drawing, scale: f64) -> Result<Vec<u8>, String> {
    let options = usvg::Options { fontdb: fonts(), font_family: "Inter".to_owned(), ..Default::default() };
    let tree = usvg::Tree::from_str(svg, &options).map_err(|error| error.to_string())?;
    let size = |edge: f64| (edge * scale).round().max(1.0) as u32;
    let mut pixmap = Pixmap::new(size(drawing.width), size(drawing.height))
        .ok_or_else(|| "the picture is too large".to_owned())?;
    let scaled = Transform::from_scale(scale as f32, scale as f32);
    resvg::render(&tree, scaled, &mut pixmap.as_mut());
    let paint = PixmapPaint { quality: FilterQuality::Nearest, ..Default::default() };
    for ([x, y, width, height], bitmap) in &drawing.bitmaps {
        let Some(source) = pixels(bitmap) else { continue };
        let stretch = [width / f64::from(bitmap.width), height / f64::from(bitmap.height)];
        let place =
            scaled.pre_translate(*x as f32, *y as f32).pre_scale(stretch[0] as f32, stretch[1] as f32);
        pixmap.draw_pixmap(0, 0, source.as_ref(), &paint, place, None);
    }
    pixmap.encode_png().map_err(|error| error.to_string())
}

/// `None` for a bitmap without pixels.
fn pixels(bitmap: &Bitmap) -> Option<Pixmap> {
    let mut pixmap = Pixmap::new(bitmap.width, bitmap.height)?;
    for (to, &[r, g, b]) in pixmap.pixels_mut().iter_mut().zip(&bitmap.pixels) {
        *to = PremultipliedColorU8::from_rgba(r, g, b, 255)?;
    }
    Some(pixmap)
}

/// A bitmap as a PNG file; empty for one without pixels.
pub(super) fn encode(bitmap: &Bitmap) -> Vec<u8> {
    pixels(bitmap).and_then(|pixmap| pixmap.encode_png().ok()).unwrap_or_default()
}
