use super::axis::{Axis, Settled};
use super::drawing::{Anchor, Drawing};
use super::{Dash, Ink};

/// Curves and points over two axes.
#[derive(Clone, Debug)]
pub struct Chart {
    /// Title above the frame.
    pub title: String,
    /// The axis along the lower edge.
    pub x: Axis,
    /// The axis along the left edge.
    pub y: Axis,
    /// What is drawn, the first at the bottom.
    pub series: Vec<Series>,
    /// A band of colours under the frame that says what the x axis looks like.
    pub band: Vec<Strip>,
}

/// Points of one kind, joined by a line where that is asked for.
#[derive(Clone, Debug)]
pub struct Series {
    /// Not in the legend if empty.
    pub name: String,
    /// Colour of line and markers.
    pub ink: Ink,
    /// The points, in the order in which the line joins them.
    pub points: Vec<Point>,
    /// The line where it does not join the points but is fitted to them; empty otherwise.
    pub fitted: Vec<Point>,
    /// What is drawn at each point; `None` for nothing.
    pub marker: Option<Marker>,
    /// Width of the line; 0 for none.
    pub line: f64,
    /// How a line is broken; `None` for a continuous one.
    pub dash: Option<Dash>,
}

/// A point with its error bar, which is left out where it has no length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Place along the x axis.
    pub x: f64,
    /// Place along the y axis.
    pub y: f64,
    /// Lower end of the error bar.
    pub low: f64,
    /// Upper end of the error bar.
    pub high: f64,
}

impl Point {
    /// A point without error bar.
    pub fn new(x: f64, y: f64) -> Self {
        Self { x, y, low: y, high: y }
    }
}

/// Shapes that are told apart without colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marker {
    /// A filled circle.
    Disk,
    /// A square.
    Square,
    /// A triangle with a corner at the top.
    Triangle,
    /// A square on its corner.
    Diamond,
    /// A triangle with a corner at the bottom.
    Wedge,
    /// A plus sign.
    Plus,
    /// A star.
    Star,
}

impl Marker {
    /// All of them.
    pub const ALL: [Self; 7] =
        [Self::Disk, Self::Square, Self::Triangle, Self::Diamond, Self::Wedge, Self::Plus, Self::Star];

    fn draw(self, drawing: &mut Drawing, [x, y]: [f64; 2], ink: Ink) {
        const R: f64 = 4.4;
        // Corners at these angles, in degrees clockwise from the right, and distances.
        let corners = |angles: &[(f64, f64)]| -> Vec<[f64; 2]> {
            angles
                .iter()
                .map(|&(degrees, r)| [x + r * degrees.to_radians().cos(), y + r * degrees.to_radians().sin()])
                .collect()
        };
        let regular = |first: f64, count: u32| {
            (0..count)
                .map(|i| (first + f64::from(i) * 360.0 / f64::from(count), 1.25 * R))
                .collect::<Vec<_>>()
        };
        match self {
            Self::Disk => drawing.disk([x, y], R, ink),
            Self::Square => drawing.polygon(&corners(&regular(45.0, 4)), ink),
            Self::Triangle => drawing.polygon(&corners(&regular(-90.0, 3)), ink),
            Self::Diamond => drawing.polygon(&corners(&regular(0.0, 4)), ink),
            Self::Wedge => drawing.polygon(&corners(&regular(90.0, 3)), ink),
            Self::Plus => {
                let arm = 18.0;
                let plus: Vec<(f64, f64)> = (0..4)
                    .flat_map(|i| {
                        let middle = 90.0 * f64::from(i);
                        [(middle - arm, 1.3 * R), (middle + arm, 1.3 * R), (middle + 45.0, 0.57 * R)]
                    })
                    .collect();
                drawing.polygon(&corners(&plus), ink);
            }
            Self::Star => {
                let star: Vec<(f64, f64)> = (0..10)
                    .map(|i| (-90.0 + 36.0 * f64::from(i), if i % 2 == 0 { 1.4 * R } else { 0.6 * R }))
                    .collect();
                drawing.polygon(&corners(&star), ink);
            }
        }
    }
}

/// A piece of the band under the frame.
#[derive(Clone, Debug)]
pub struct Strip {
    /// Where it begins on the x axis.
    pub from: f64,
    /// Where it ends on the x axis.
    pub to: f64,
    /// Its colour.
    pub colour: Ink,
}

const WIDTH: f64 = 800.0;
const HEIGHT: f64 = 480.0;
const LEFT: f64 = 84.0;
const TOP: f64 = 48.0;
const BOTTOM: f64 = 418.0;
const BAND: f64 = 14.0;

/// About the width of a letter of the legend.
const LETTER: f64 = 6.9;
/// Width of what stands before a name in the legend, and height of a row.
const KEY: f64 = 40.0;
const ROW: f64 = 22.0;

impl Chart {
    /// Draws it.
    pub fn draw(&self) -> Drawing {
        let points = || self.series.iter().flat_map(|series| &series.points);
        let x = Settled::new(&self.x, points().map(|point| point.x));
        let y = Settled::new(&self.y, points().flat_map(|point| [point.y, point.low, point.high]));
        let named: Vec<&Series> = self.series.iter().filter(|series| !series.name.is_empty()).collect();
        let longest = named.iter().map(|series| series.name.chars().count()).max();
        let right =
            WIDTH - longest.map_or(24.0, |letters| (26.0 + KEY + LETTER * letters as f64).min(0.5 * WIDTH));
        let across = |value| x.place(value).map(|place| LEFT + place * (right - LEFT));
        let up = |value| y.place(value).map(|place| BOTTOM - place * (BOTTOM - TOP));

        let rows_end = TOP + 12.0 + ROW * named.len() as f64;
        let mut drawing = Drawing::new(WIDTH, HEIGHT.max(rows_end), &self.title);
        drawing.heading([LEFT, 28.0], &self.title);
        let band = if self.band.is_empty() { 0.0 } else { BAND };
        self.draw_axes(&mut drawing, (&x, &y), right, band);
        for strip in &self.band {
            if let (Some(from), Some(to)) = (across(strip.from), across(strip.to)) {
                drawing.rectangle([from, BOTTOM, to - from + 0.3, BAND], strip.colour);
            }
        }
        let room = 7.0; // for markers on the edge
        let frame = [LEFT - room, TOP - room, right - LEFT + 2.0 * room, BOTTOM - TOP + 2.0 * room];
        drawing.clipped(frame, |drawing| {
            for series in &self.series {
                series.draw(drawing, &across, &up, [TOP, BOTTOM]);
            }
        });
        drawing.line(&[[LEFT, TOP], [LEFT, BOTTOM], [right, BOTTOM]], Ink::TEXT, 1.0, None);
        for (i, series) in named.into_iter().enumerate() {
            let (at, left) = (TOP + 12.0 + ROW * i as f64, right + 12.0);
            if series.line > 0.0 {
                drawing.line(&[[left, at], [left + KEY, at]], series.ink, series.line, series.dash);
            }
            if let Some(marker) = series.marker {
                marker.draw(&mut drawing, [left + 0.5 * KEY, at], series.ink);
            }
            drawing.text([left + KEY + 7.0, at + 4.5], &series.name, 13.0, Anchor::Start, Ink::TEXT);
        }
        drawing
    }

    fn draw_axes(&self, drawing: &mut Drawing, (x, y): (&Settled, &Settled), right: f64, band: f64) {
        for place in y.minor() {
            let at = BOTTOM - place * (BOTTOM - TOP);
            drawing.line(&[[LEFT, at], [right, at]], Ink::hex(0xf0f0f0), 1.0, None);
        }
        for place in x.minor() {
            let at = LEFT + place * (right - LEFT);
            drawing.line(&[[at, TOP], [at, BOTTOM]], Ink::hex(0xf5f5f5), 1.0, None);
        }
        for (tick, label) in &y.ticks {
            let Some(place) = y.place(*tick) else { continue };
            let at = BOTTOM - place * (BOTTOM - TOP);
            drawing.line(&[[LEFT, at], [right, at]], Ink::hex(0xd8d8d8), 1.0, None);
            drawing.text([LEFT - 8.0, at + 4.5], label, 13.0, Anchor::End, Ink::TEXT);
        }
        for (tick, label) in &x.ticks {
            let Some(place) = x.place(*tick) else { continue };
            let at = LEFT + place * (right - LEFT);
            if band == 0.0 {
                drawing.line(&[[at, TOP], [at, BOTTOM]], Ink::hex(0xe8e8e8), 1.0, None);
            }
            drawing.line(&[[at, BOTTOM], [at, BOTTOM + band + 5.0]], Ink::TEXT, 1.0, None);
            drawing.text([at, BOTTOM + band + 19.0], label, 13.0, Anchor::Middle, Ink::TEXT);
        }
        drawing.text(
            [0.5 * (LEFT + right), BOTTOM + band + 44.0],
            &self.x.title,
            13.0,
            Anchor::Middle,
            Ink::TEXT,
        );
        drawing.upward([20.0, 0.5 * (TOP + BOTTOM)], &self.y.title, 13.0);
    }
}

impl Series {
    fn draw<'a>(
        &'a self,
        drawing: &mut Drawing,
        across: &dyn Fn(f64) -> Option<f64>,
        up: &dyn Fn(f64) -> Option<f64>,
        [top, bottom]: [f64; 2],
    ) {
        let placed = |points: &'a [Point]| {
            points.iter().filter_map(|point| Some((point, [across(point.x)?, up(point.y)?])))
        };
        let joined = if self.fitted.is_empty() { &self.points } else { &self.fitted };
        let path: Vec<[f64; 2]> = placed(joined).map(|(_, at)| at).collect();
        let placed: Vec<(&Point, [f64; 2])> = placed(&self.points).collect();
        for (point, [x, _]) in placed.iter().filter(|(point, _)| point.low < point.high) {
            // A bar that goes below what a logarithmic axis shows goes to its end.
            let low = up(point.low).unwrap_or(bottom).min(bottom);
            let high = up(point.high).unwrap_or(top).max(top);
            drawing.line(&[[*x, low], [*x, high]], self.ink, 1.2, None);
            for end in [low, high] {
                drawing.line(&[[x - 3.0, end], [x + 3.0, end]], self.ink, 1.2, None);
            }
        }
        if self.line > 0.0 {
            drawing.line(&path, self.ink, self.line, self.dash);
        }
        if let Some(marker) = self.marker {
            for (_, at) in &placed {
                marker.draw(drawing, *at, self.ink);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Scale;
    use super::*;

    fn chart(points: Vec<Point>) -> Chart {
        let series = Series {
            name: "a".to_owned(),
            ink: Ink::hex(0xff0000),
            points,
            fitted: Vec::new(),
            marker: Some(Marker::Disk),
            line: 1.5,
            dash: None,
        };
        Chart {
            title: "t".to_owned(),
            x: Axis { range: Some([1.0, 100.0]), ..Axis::new("x", Scale::Log) },
            y: Axis { range: Some([1e-3, 1e-1]), ..Axis::new("y", Scale::Log) },
            series: vec![series],
            band: Vec::new(),
        }
    }

    /// A point in the middle of both logarithmic axes has its disk in the middle of the frame.
    #[test]
    fn points_are_where_the_axes_say() {
        let drawn = chart(vec![Point { x: 10.0, y: 1e-2, low: 5e-3, high: 2e-2 }]).draw();
        let right = WIDTH - 26.0 - KEY - LETTER;
        let image =
            image::load_from_memory(&drawn.png(1.0).expect("it can be drawn")).expect("a PNG").to_rgb8();
        let (x, y) = ((0.5 * (LEFT + right)) as u32, (0.5 * (TOP + BOTTOM)) as u32);
        assert_eq!(image.get_pixel(x, y).0, [255, 0, 0]);
        // The bar reaches up and down by log 2 / log 100 of the frame and no further.
        let bar = (2f64.ln() / 100f64.ln() * (BOTTOM - TOP)) as u32;
        let red = |dy: i64| {
            let pixel = image.get_pixel(x, (i64::from(y) + dy) as u32).0;
            pixel[0] > 200 && pixel[1] < 220 && pixel[1] < pixel[0] - 30
        };
        let bar = i64::from(bar);
        assert!(red(bar - 3) && red(3 - bar) && !red(bar + 5) && !red(-5 - bar));
    }

    #[test]
    fn what_has_no_place_is_left_out() {
        let values = [f64::NAN, f64::INFINITY, 0.0, -1.0];
        let svg = chart(values.map(|y| Point::new(10.0, y)).to_vec()).draw().svg();
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        let marked = chart(vec![Point::new(10.0, 0.01)]).draw().svg();
        assert_eq!(svg.matches("<circle").count() + 1, marked.matches("<circle").count());
    }
}
