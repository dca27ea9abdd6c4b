use super::Ink;
use super::axis::{Axis, Scale, Settled};
use super::drawing::{Anchor, Bitmap, Drawing};

/// Images in false colours, side by side, all on one scale.
#[derive(Clone, Debug)]
pub struct Panels {
    /// Title above all.
    pub title: String,
    /// The panels, by rows.
    pub panels: Vec<Panel>,
    /// What the numbers are, with their unit.
    pub quantity: String,
    /// The numbers at the ends of the colours.
    pub range: [f64; 2],
    /// How values become places in the colour bar.
    pub scale: Scale,
    /// Colours of the values.
    pub colours: Colours,
}

/// One image.
#[derive(Clone, Debug)]
pub struct Panel {
    /// Title above the panel.
    pub title: String,
    /// A second line.
    pub note: String,
    /// Columns of its values.
    pub width: usize,
    /// Row by row from the top; a number that has no place on the scale shows grey.
    pub values: Vec<f64>,
}

/// How values become colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Colours {
    /// Dark to bright (viridis).
    Sequential,
    /// Blue, white, red around a middle that is nothing.
    Diverging,
}

impl Colours {
    fn at(self, place: f64) -> [u8; 3] {
        let place = place.clamp(0.0, 1.0);
        let colour = match self {
            Self::Sequential => colorous::VIRIDIS.eval_continuous(place),
            // The scheme has red at its lower end.
            Self::Diverging => colorous::RED_BLUE.eval_continuous(1.0 - place),
        };
        [colour.r, colour.g, colour.b]
    }
}

const GREY: [u8; 3] = [128; 3];
const WIDTH: f64 = 800.0;
const MARGIN: f64 = 16.0;
const BAR: f64 = 84.0;
const TOP: f64 = 44.0;
/// Above each panel, for its two lines of text.
const HEAD: f64 = 42.0;
const GAP: f64 = 14.0;

impl Panels {
    /// Draws them side by side.
    pub fn draw(&self) -> Drawing {
        let columns = self.panels.len().clamp(1, 3);
        let inner = WIDTH - 2.0 * MARGIN - BAR;
        let width = (inner - GAP * (columns - 1) as f64) / columns as f64;
        let height_of = |panel: &Panel| {
            let rows = panel.values.len().div_ceil(panel.width.max(1));
            width * rows as f64 / panel.width.max(1) as f64
        };
        let height = self.panels.iter().map(height_of).fold(0.0, f64::max).clamp(40.0, 2.0 * WIDTH);
        let rows = self.panels.len().div_ceil(columns).max(1);
        let total = TOP + rows as f64 * (HEAD + height + GAP);
        let mut drawing = Drawing::new(WIDTH, total.max(240.0).round(), &self.title);
        drawing.heading([MARGIN, 28.0], &self.title);
        let axis = Axis { range: Some(self.range), ..Axis::new(&self.quantity, self.scale) };
        let scale = Settled::new(&axis, std::iter::empty());
        for (i, panel) in self.panels.iter().enumerate() {
            let left = MARGIN + (i % columns) as f64 * (width + GAP);
            let top = TOP + (i / columns) as f64 * (HEAD + height + GAP) + HEAD;
            drawing.text([left, top - 23.0], &panel.title, 13.0, Anchor::Start, Ink::TEXT);
            drawing.text([left, top - 7.0], &panel.note, 11.5, Anchor::Start, Ink::NOTE);
            if let Some(bitmap) = self.bitmap(panel, &scale) {
                drawing.bitmap([left, top, width, height_of(panel).min(height)], bitmap);
            }
        }
        self.draw_bar(&mut drawing, &scale);
        drawing
    }

    fn bitmap(&self, panel: &Panel, scale: &Settled) -> Option<Bitmap> {
        let rows = panel.values.len().checked_div(panel.width)?;
        let colour = |&value: &f64| match scale.place(value) {
            Some(place) => self.colours.at(place),
            // Nothing at all is darker than everything on a logarithmic scale.
            None if value == 0.0 => self.colours.at(0.0),
            None => GREY,
        };
        let pixels = panel.values.iter().take(rows * panel.width).map(colour).collect();
        (rows > 0).then_some(Bitmap { width: panel.width as u32, height: rows as u32, pixels })
    }

    /// What number each colour stands for.
    fn draw_bar(&self, drawing: &mut Drawing, scale: &Settled) {
        const STEPS: u32 = 256;
        let (left, top, width) = (WIDTH - MARGIN - BAR + 18.0, TOP + HEAD, 14.0);
        let height = (drawing.height - top - GAP).min(300.0);
        let pixels = (0..STEPS).map(|i| self.colours.at(1.0 - f64::from(i) / f64::from(STEPS - 1))).collect();
        drawing.bitmap([left, top, width, height], Bitmap { width: 1, height: STEPS, pixels });
        for (tick, label) in &scale.ticks {
            let Some(place) = scale.place(*tick) else { continue };
            let at = top + (1.0 - place) * height;
            drawing.line(&[[left + width, at], [left + width + 4.0, at]], Ink::TEXT, 1.0, None);
            drawing.text([left + width + 7.0, at + 4.0], label, 11.5, Anchor::Start, Ink::TEXT);
        }
        drawing.text([WIDTH - MARGIN, top - 12.0], &self.quantity, 11.5, Anchor::End, Ink::TEXT);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_become_the_colours_of_the_bar() {
        let panel = Panel {
            title: "a".to_owned(),
            note: String::new(),
            width: 2,
            values: vec![-1.0, 0.0, 1.0, f64::NAN],
        };
        let panels = Panels {
            title: "t".to_owned(),
            panels: vec![panel],
            quantity: "error".to_owned(),
            range: [-1.0, 1.0],
            scale: Scale::Linear,
            colours: Colours::Diverging,
        };
        let drawn = panels.draw();
        let image = drawn.bitmaps[0].1.clone();
        assert_eq!((image.width, image.height), (2, 2));
        let [low, middle, high, missing] = [0, 1, 2, 3].map(|i: usize| image.pixels[i]);
        assert!(low[2] > low[0] && high[0] > high[2], "{low:?} {high:?}");
        assert!(middle.iter().all(|&value| value > 230) && missing == GREY, "{middle:?}");
        assert!(drawn.svg().contains("data:image/png;base64,") && drawn.png(1.0).is_ok());
    }
}
