//! From a drawing to pixels. The only file that names tiny-skia and ttf-parser.

use super::drawing::{Anchor, Bitmap, Drawing, Element, FONTS, Frame, OUTLINE, Style, Text};
use super::{Dash, Ink};
use std::sync::OnceLock;
use tiny_skia::{
    Color, FillRule, FilterQuality, LineJoin, Mask, Paint, Path, PathBuilder, Pixmap, PixmapPaint,
    PremultipliedColorU8, Rect, Stroke, StrokeDash, Transform,
};
use ttf_parser::{Face, GlyphId, OutlineBuilder};

/// The drawing as a PNG file, with `scale` pixels for each of its own.
pub(super) fn draw(drawing: &Drawing, scale: f64) -> Result<Vec<u8>, String> {
    let size = |edge: f64| (edge * scale).round().max(1.0) as u32;
    let mut pixmap = Pixmap::new(size(drawing.width), size(drawing.height))
        .ok_or_else(|| "the picture is too large".to_owned())?;
    pixmap.fill(Color::WHITE);
    let scaled = Transform::from_scale(scale as f32, scale as f32);
    let mut canvas = Canvas { pixmap, scaled };
    canvas.elements(&drawing.elements, None);
    let Canvas { mut pixmap, .. } = canvas;
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

struct Canvas {
    pixmap: Pixmap,
    /// From the drawing's pixels to those of the picture.
    scaled: Transform,
}

impl Canvas {
    fn elements(&mut self, elements: &[Element], mask: Option<&Mask>) {
        for element in elements {
            match element {
                Element::Line { points, ink, width, dash } => {
                    let stroke = Stroke {
                        width: *width as f32,
                        line_join: LineJoin::Round,
                        dash: dash
                            .and_then(|Dash(dash, gap)| StrokeDash::new(vec![dash as f32, gap as f32], 0.0)),
                        ..Stroke::default()
                    };
                    self.stroke(path(points, false), *ink, &stroke, mask);
                }
                Element::Polygon { points, ink } => self.outlined(path(points, true), *ink, mask),
                Element::Disk { centre: [x, y], radius, ink } => {
                    let circle = PathBuilder::from_circle(*x as f32, *y as f32, *radius as f32);
                    self.outlined(circle, *ink, mask);
                }
                Element::Rectangle { frame, ink } => {
                    let paint = Paint { anti_alias: false, ..paint(*ink) };
                    self.fill(rectangle(*frame), &paint, self.scaled, mask);
                }
                Element::Text(text) => self.text(text, mask),
                Element::Clipped { frame, elements } => {
                    let Some(clip) = self.clip(*frame, mask) else { continue };
                    self.elements(elements, Some(&clip));
                }
            }
        }
    }

    /// What shows within a frame, and within the mask around it.
    fn clip(&self, frame: Frame, around: Option<&Mask>) -> Option<Mask> {
        let path = rectangle(frame)?;
        if let Some(around) = around {
            let mut mask = around.clone();
            mask.intersect_path(&path, FillRule::Winding, true, self.scaled);
            return Some(mask);
        }
        let mut mask = Mask::new(self.pixmap.width(), self.pixmap.height())?;
        mask.fill_path(&path, FillRule::Winding, true, self.scaled);
        Some(mask)
    }

    fn fill(&mut self, path: Option<Path>, paint: &Paint<'_>, place: Transform, mask: Option<&Mask>) {
        if let Some(path) = path {
            self.pixmap.fill_path(&path, paint, FillRule::Winding, place, mask);
        }
    }

    fn stroke(&mut self, path: Option<Path>, ink: Ink, stroke: &Stroke, mask: Option<&Mask>) {
        if let Some(path) = path {
            self.pixmap.stroke_path(&path, &paint(ink), stroke, self.scaled, mask);
        }
    }

    fn outlined(&mut self, path: Option<Path>, ink: Ink, mask: Option<&Mask>) {
        self.fill(path.clone(), &paint(ink), self.scaled, mask);
        let stroke = Stroke { width: OUTLINE as f32, ..Stroke::default() };
        self.stroke(path, Ink::Grey(15), &stroke, mask);
    }

    /// Letters stand side by side by their widths, without the pairs that a font sets closer.
    fn text(&mut self, text: &Text, mask: Option<&Mask>) {
        let [plain, heading] = faces();
        let face = if text.style == Style::Heading { heading } else { plain };
        let size = text.size as f32 / f32::from(face.units_per_em());
        let glyphs: Vec<GlyphId> =
            text.text.chars().map(|letter| face.glyph_index(letter).unwrap_or_default()).collect();
        let advance = |glyph: &GlyphId| f32::from(face.glyph_hor_advance(*glyph).unwrap_or_default());
        let width: f32 = glyphs.iter().map(advance).sum();
        let mut along = match text.anchor {
            Anchor::Start => 0.0,
            Anchor::Middle => -0.5 * width,
            Anchor::End => -width,
        };
        let at = self.scaled.pre_translate(text.at[0] as f32, text.at[1] as f32);
        let turned = if text.style == Style::Upward { at.pre_rotate(-90.0) } else { at };
        // The y axis of a font points up.
        let place = turned.pre_scale(size, -size);
        for glyph in &glyphs {
            let mut outline = Outline(PathBuilder::new());
            // A space has none.
            let _ = face.outline_glyph(*glyph, &mut outline);
            self.fill(outline.0.finish(), &paint(text.ink), place.pre_translate(along, 0.0), mask);
            along += advance(glyph);
        }
    }
}

/// The regular and the semi-bold face.
fn faces() -> &'static [Face<'static>; 2] {
    static FACES: OnceLock<[Face<'static>; 2]> = OnceLock::new();
    FACES.get_or_init(|| FONTS.map(|font| Face::parse(font, 0).expect("a font that comes with the program")))
}

struct Outline(PathBuilder);

impl OutlineBuilder for Outline {
    fn move_to(&mut self, x: f32, y: f32) {
        self.0.move_to(x, y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.0.line_to(x, y);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        self.0.quad_to(x1, y1, x, y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        self.0.cubic_to(x1, y1, x2, y2, x, y);
    }

    fn close(&mut self) {
        self.0.close();
    }
}

fn path(points: &[[f64; 2]], is_closed: bool) -> Option<Path> {
    let mut builder = PathBuilder::new();
    for (i, &[x, y]) in points.iter().enumerate() {
        let (x, y) = (x as f32, y as f32);
        if i == 0 { builder.move_to(x, y) } else { builder.line_to(x, y) }
    }
    if is_closed {
        builder.close();
    }
    builder.finish()
}

fn rectangle([x, y, width, height]: Frame) -> Option<Path> {
    let [x, y, width, height] = [x, y, width, height].map(|edge| edge as f32);
    Rect::from_xywh(x, y, width, height).map(PathBuilder::from_rect)
}

fn paint(ink: Ink) -> Paint<'static> {
    let mut paint = Paint::default();
    let [red, green, blue] = ink.rgb();
    paint.set_color_rgba8(red, green, blue, 255);
    paint
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
