use super::{Dash, Ink, png};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use std::fmt::Write;
use std::path::Path;

/// The fonts of all plots, regular and semi-bold, of the family Inter.
pub const FONTS: [&[u8]; 2] = [
    include_bytes!("../../data/fonts/Inter-Regular.otf"),
    include_bytes!("../../data/fonts/Inter-SemiBold.otf"),
];

/// A laid-out picture: vector elements in pixels from the upper left corner, and bitmaps above them.
#[derive(Clone, Debug)]
pub struct Drawing {
    /// Width, in pixels.
    pub width: f64,
    /// Height, in pixels.
    pub height: f64,
    title: String,
    pub(super) elements: Vec<Element>,
    pub(super) bitmaps: Vec<(Frame, Bitmap)>,
}

/// What a drawing is made of.
#[derive(Clone, Debug)]
pub(super) enum Element {
    Line {
        points: Vec<[f64; 2]>,
        ink: Ink,
        width: f64,
        dash: Option<Dash>,
    },
    Polygon {
        points: Vec<[f64; 2]>,
        ink: Ink,
    },
    Disk {
        centre: [f64; 2],
        radius: f64,
        ink: Ink,
    },
    Rectangle {
        frame: Frame,
        ink: Ink,
    },
    Text(Text),
    /// What shows within a frame only.
    Clipped {
        frame: Frame,
        elements: Vec<Element>,
    },
}

/// A line of text.
#[derive(Clone, Debug)]
pub(super) struct Text {
    /// On the base line.
    pub at: [f64; 2],
    pub text: String,
    pub size: f64,
    pub anchor: Anchor,
    pub ink: Ink,
    pub style: Style,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Style {
    Plain,
    /// In semi-bold letters.
    Heading,
    /// Read from below.
    Upward,
}

/// The outline of polygons and disks, which sets them off from what they lie on.
pub(super) const OUTLINE: f64 = 0.8;

/// Left, top, width, height.
pub type Frame = [f64; 4];

/// Red, green and blue of each pixel, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Bitmap {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Red, green and blue, encoded for sRGB, by rows from the top.
    pub pixels: Vec<[u8; 3]>,
}

/// Which point of a text is at its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// It begins at the place.
    Start,
    /// Its middle is at the place.
    Middle,
    /// It ends at the place.
    End,
}

impl Drawing {
    /// Everything that follows is drawn above a white ground. The title is what a reader without eyes for it
    /// is told.
    pub fn new(width: f64, height: f64, title: &str) -> Self {
        Self { width, height, title: title.to_owned(), elements: Vec::new(), bitmaps: Vec::new() }
    }

    /// A line through points, not closed.
    pub fn line(&mut self, points: &[[f64; 2]], ink: Ink, width: f64, dash: Option<Dash>) {
        if points.is_empty() {
            return;
        }
        self.elements.push(Element::Line { points: points.to_vec(), ink, width, dash });
    }

    /// A filled polygon, with an outline of the paper's colour that sets it off from what it lies on.
    pub fn polygon(&mut self, points: &[[f64; 2]], ink: Ink) {
        self.elements.push(Element::Polygon { points: points.to_vec(), ink });
    }

    /// Draws a filled disk.
    pub fn disk(&mut self, centre: [f64; 2], radius: f64, ink: Ink) {
        self.elements.push(Element::Disk { centre, radius, ink });
    }

    /// A rectangle without outline, its edges on whole pixels.
    pub fn rectangle(&mut self, frame: Frame, ink: Ink) {
        self.elements.push(Element::Rectangle { frame, ink });
    }

    /// A line of text on the base line through `at`.
    pub fn text(&mut self, at: [f64; 2], text: &str, size: f64, anchor: Anchor, ink: Ink) {
        self.write(at, text, size, anchor, ink, Style::Plain);
    }

    /// Writes a heading that begins at a point.
    pub fn heading(&mut self, at: [f64; 2], text: &str) {
        self.write(at, text, 15.0, Anchor::Start, Ink::TEXT, Style::Heading);
    }

    /// A text that is read from below, centred on `at`.
    pub fn upward(&mut self, at: [f64; 2], text: &str, size: f64) {
        self.write(at, text, size, Anchor::Middle, Ink::TEXT, Style::Upward);
    }

    fn write(&mut self, at: [f64; 2], text: &str, size: f64, anchor: Anchor, ink: Ink, style: Style) {
        self.elements.push(Element::Text(Text { at, text: text.to_owned(), size, anchor, ink, style }));
    }

    /// What is drawn by `draw` shows within the frame only. Its coordinates are those of the whole drawing.
    pub fn clipped(&mut self, frame: Frame, draw: impl FnOnce(&mut Self)) {
        let before = std::mem::take(&mut self.elements);
        draw(self);
        let elements = std::mem::replace(&mut self.elements, before);
        self.elements.push(Element::Clipped { frame, elements });
    }

    /// A bitmap whose pixels stay sharp squares.
    pub fn bitmap(&mut self, frame: Frame, bitmap: Bitmap) {
        self.bitmaps.push((frame, bitmap));
    }

    /// A whole SVG file, which may also stand inside a page.
    pub fn svg(&self) -> String {
        let mut out = self.opening();
        for ([x, y, width, height], bitmap) in &self.bitmaps {
            let _ = writeln!(
                out,
                "<image x=\"{x:.2}\" y=\"{y:.2}\" width=\"{width:.2}\" height=\"{height:.2}\" preserveAspectRatio=\"none\" \
                 style=\"image-rendering: pixelated\" href=\"data:image/png;base64,{}\"/>",
                BASE64_STANDARD.encode(png::encode(bitmap))
            );
        }
        out + "</svg>\n"
    }

    /// The SVG without its bitmaps and its end.
    fn opening(&self) -> String {
        let Self { width, height, title, elements, .. } = self;
        let ink = Ink::TEXT;
        let mut out = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" width=\"{width:.0}\" height=\"{height:.0}\" \
             role=\"img\" font-family=\"Inter, Helvetica, Arial, sans-serif\" font-size=\"13\" fill=\"{ink}\">\n\
             <title>{}</title>\n\
             <rect width=\"{width:.0}\" height=\"{height:.0}\" fill=\"white\"/>\n",
            escaped(title)
        );
        // Writing to a string cannot fail.
        let _ = elements.iter().try_for_each(|element| element.write(&mut out));
        out
    }

    /// A whole PNG file with `scale` pixels for each of the drawing's.
    pub fn png(&self, scale: f64) -> Result<Vec<u8>, String> {
        png::draw(self, scale)
    }

    /// The bytes for a file of this name, by its ending.
    pub fn file(&self, path: &Path) -> Result<Vec<u8>, String> {
        let ends_in = |ending| path.extension().is_some_and(|extension| extension == ending);
        if ends_in("svg") {
            Ok(self.svg().into_bytes())
        } else if ends_in("png") {
            self.png(2.0)
        } else {
            Err(format!("expected a plot file that ends in .svg or .png, found {}", path.display()))
        }
    }
}

impl Element {
    /// Writes it as SVG.
    fn write(&self, out: &mut String) -> std::fmt::Result {
        let path = |points: &[[f64; 2]]| {
            let points: Vec<String> = points.iter().map(|[x, y]| format!("{x:.2} {y:.2}")).collect();
            points.join("L")
        };
        match self {
            Self::Line { points, ink, width, dash } => {
                let dash = dash
                    .map_or(String::new(), |Dash(dash, gap)| format!(" stroke-dasharray=\"{dash} {gap}\""));
                writeln!(
                    out,
                    "<path d=\"M{}\" fill=\"none\" stroke=\"{ink}\" stroke-width=\"{width}\" stroke-linejoin=\"round\"{dash}/>",
                    path(points)
                )
            }
            Self::Polygon { points, ink } => writeln!(
                out,
                "<path d=\"M{}Z\" fill=\"{ink}\" stroke=\"white\" stroke-width=\"{OUTLINE}\"/>",
                path(points)
            ),
            Self::Disk { centre: [x, y], radius, ink } => writeln!(
                out,
                "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{radius}\" fill=\"{ink}\" stroke=\"white\" stroke-width=\"{OUTLINE}\"/>"
            ),
            Self::Rectangle { frame: [x, y, width, height], ink } => writeln!(
                out,
                "<rect x=\"{x:.2}\" y=\"{y:.2}\" width=\"{width:.2}\" height=\"{height:.2}\" fill=\"{ink}\" shape-rendering=\"crispEdges\"/>"
            ),
            Self::Text(text) => text.write(out),
            Self::Clipped { frame: [x, y, width, height], elements } => {
                writeln!(
                    out,
                    "<svg x=\"{x:.2}\" y=\"{y:.2}\" width=\"{width:.2}\" height=\"{height:.2}\" viewBox=\"{x:.2} {y:.2} {width:.2} {height:.2}\" overflow=\"hidden\">"
                )?;
                elements.iter().try_for_each(|element| element.write(out))?;
                writeln!(out, "</svg>")
            }
        }
    }
}

impl Text {
    fn write(&self, out: &mut String) -> std::fmt::Result {
        let Self { at: [x, y], text, size, anchor, ink, style } = self;
        let text = escaped(text);
        match style {
            Style::Plain => writeln!(
                out,
                "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"{size}\"{} fill=\"{ink}\">{text}</text>",
                anchor.attribute()
            ),
            Style::Heading => writeln!(
                out,
                "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"{size}\" font-weight=\"600\">{text}</text>"
            ),
            Style::Upward => writeln!(
                out,
                "<text transform=\"translate({x:.1} {y:.1}) rotate(-90)\" font-size=\"{size}\"{}>{text}</text>",
                anchor.attribute()
            ),
        }
    }
}

impl Anchor {
    fn attribute(self) -> &'static str {
        match self {
            Self::Start => "",
            Self::Middle => " text-anchor=\"middle\"",
            Self::End => " text-anchor=\"end\"",
        }
    }
}

/// A text as it stands between tags or quotes of XML and HTML.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_cannot_break_the_picture() {
        let mut drawing = Drawing::new(40.0, 20.0, "a<b & \"c\"");
        drawing.text([1.0, 10.0], "</svg>", 10.0, Anchor::Start, Ink::Grey(0));
        let svg = drawing.svg();
        assert!(roxmltree::Document::parse(&svg).is_ok(), "{svg}");
        assert!(drawing.png(1.0).is_ok());
    }

    /// The same drawing as PNG: text, lines and bitmaps leave ink where they stand.
    #[test]
    fn a_png_shows_lines_text_and_bitmaps() {
        let mut drawing = Drawing::new(100.0, 60.0, "test");
        drawing.line(&[[0.0, 5.0], [100.0, 5.0]], Ink::hex(0xff0000), 4.0, None);
        drawing.text([5.0, 40.0], "10⁻³ − Σλ", 12.0, Anchor::Start, Ink::Grey(0));
        drawing.bitmap(
            [80.0, 40.0, 20.0, 20.0],
            Bitmap { width: 2, height: 1, pixels: vec![[0, 0, 255], [0, 255, 0]] },
        );
        let bytes = drawing.png(2.0).expect("it can be drawn");
        let image = image::load_from_memory(&bytes).expect("a PNG").to_rgb8();
        assert_eq!((image.width(), image.height()), (200, 120));
        assert_eq!(image.get_pixel(100, 10).0, [255, 0, 0]);
        assert_eq!(image.get_pixel(165, 100).0, [0, 0, 255]);
        assert_eq!(image.get_pixel(195, 100).0, [0, 255, 0]);
        let dark = (0..150).flat_map(|x| (56..90).map(move |y| (x, y)));
        assert!(dark.filter(|&(x, y)| image.get_pixel(x, y).0[1] < 100).count() > 60, "no letters");
    }
}
