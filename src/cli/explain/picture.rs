//! A path drawn in two projections.

use abbe::integrator::{RecordedStep, Step};
use abbe::plot::{Anchor, Dash, Drawing, INKS, Ink};
use abbe::render::Explained;

const EDGE: f64 = 420.0;
const MARGIN: f64 = 24.0;
const TOP: f64 = 64.0;

/// A stroke from one place to another.
struct Stroke {
    ends: [[f64; 3]; 2],
    /// Whether it is a light sample.
    is_light_sample: bool,
    brings: bool,
}

/// Places of vertices, and strokes between them.
struct Layout {
    /// With the number by which the text tells of it.
    vertices: Vec<(usize, [f64; 3])>,
    strokes: Vec<Stroke>,
}

fn along(from: [f64; 3], direction: [f64; 3], length: f64) -> [f64; 3] {
    std::array::from_fn(|axis| from[axis] + direction[axis] * length)
}

fn is_light(contribution: &[f64]) -> bool {
    contribution.iter().any(|&value| value != 0.0)
}

impl Layout {
    fn new(explained: &Explained) -> Self {
        let mut vertices = Vec::new();
        let mut strokes = Vec::new();
        // Where each vertex of the path that is under way lies: branches go on from one of them.
        let mut known: Vec<[f64; 3]> = Vec::new();
        let reach = extent(&explained.steps, explained.origin);
        for RecordedStep { vertex, step } in &explained.steps {
            let vertex = *vertex as usize;
            let from = vertex.checked_sub(1).and_then(|before| known.get(before)).copied();
            let from = from.unwrap_or(explained.origin);
            match step {
                Step::Surface { place, .. } | Step::Medium { place, .. } => {
                    known.truncate(vertex);
                    known.push(*place);
                    vertices.push((vertex, *place));
                    strokes.push(Stroke { ends: [from, *place], is_light_sample: false, brings: false });
                }
                Step::Escape { direction, .. } => {
                    let end = along(from, *direction, 0.25 * reach);
                    strokes.push(Stroke { ends: [from, end], is_light_sample: false, brings: false });
                }
                Step::LightSample { toward, distance, contribution, .. } => {
                    let from = known.get(vertex).copied().unwrap_or(from);
                    let end = if distance.is_some() { *toward } else { along(from, *toward, 0.25 * reach) };
                    let brings = is_light(contribution);
                    strokes.push(Stroke { ends: [from, end], is_light_sample: true, brings });
                }
                Step::Found { contribution } if is_light(contribution) => {
                    if let Some(last) = strokes.last_mut() {
                        last.brings = true;
                    }
                }
                _ => {}
            }
        }
        Self { vertices, strokes }
    }

    /// Per axis the least and the greatest coordinate.
    fn bounds(&self) -> [[f64; 2]; 3] {
        let ends = self.strokes.iter().flat_map(|stroke| stroke.ends);
        ends.fold([[f64::INFINITY, f64::NEG_INFINITY]; 3], |bounds, place| {
            std::array::from_fn(|axis| [bounds[axis][0].min(place[axis]), bounds[axis][1].max(place[axis])])
        })
    }
}

/// The largest distance along an axis between vertices.
fn extent(steps: &[RecordedStep], origin: [f64; 3]) -> f64 {
    let places = steps.iter().filter_map(|told| match &told.step {
        Step::Surface { place, .. } | Step::Medium { place, .. } => Some(*place),
        _ => None,
    });
    let farthest = places.flat_map(|place| (0..3).map(move |axis| (place[axis] - origin[axis]).abs()));
    let farthest = farthest.fold(0.0, f64::max);
    if farthest > 0.0 { farthest } else { 1.0 }
}

pub fn draw(explained: &Explained) -> Drawing {
    let layout = Layout::new(explained);
    let bounds = layout.bounds();
    let [x, y] = explained.pixel;
    let title = format!("Pixel {x},{y}, sample {}", explained.sample);
    let width = 3.0 * MARGIN + 2.0 * EDGE;
    let mut drawing = Drawing::new(width, TOP + EDGE + 2.0 * MARGIN, &title);
    drawing.heading([MARGIN, 28.0], &title);
    let note = "path: line; light samples: dashed; what brings light: red; the camera: square";
    drawing.text([MARGIN, 46.0], note, 11.5, Anchor::Start, Ink::NOTE);
    // One scale for both, so that lengths compare.
    let size = bounds.map(|[least, most]| most - least).into_iter().fold(0.0, f64::max);
    let scale = (EDGE - 2.0 * MARGIN) / if size > 0.0 { size } else { 1.0 };
    for (panel, [across, up]) in [[0, 1], [0, 2]].into_iter().enumerate() {
        let left = MARGIN + panel as f64 * (EDGE + MARGIN);
        let middle = |axis: usize| 0.5 * (bounds[axis][0] + bounds[axis][1]);
        let project = |place: [f64; 3]| {
            [
                left + 0.5 * EDGE + (place[across] - middle(across)) * scale,
                TOP + 0.5 * EDGE - (place[up] - middle(up)) * scale,
            ]
        };
        drawing.rectangle([left, TOP, EDGE, EDGE], Ink::hex(0xf4f4f4));
        let name = |axis: usize| ["x", "y", "z"][axis];
        let axes = format!("{} to the right, {} up", name(across), name(up));
        drawing.text([left + 0.5 * EDGE, TOP + EDGE + 18.0], &axes, 11.5, Anchor::Middle, Ink::NOTE);
        for Stroke { ends, is_light_sample, brings } in &layout.strokes {
            let ink = if *brings { INKS[1] } else { INKS[0] };
            let dash = is_light_sample.then_some(Dash(4.0, 3.0));
            drawing.line(&ends.map(project), ink, if *is_light_sample { 1.0 } else { 1.8 }, dash);
        }
        let [cx, cy] = project(explained.origin);
        drawing.rectangle([cx - 4.0, cy - 4.0, 8.0, 8.0], INKS[6]);
        for (number, place) in &layout.vertices {
            let at = project(*place);
            drawing.disk(at, 3.5, INKS[6]);
            drawing.text([at[0] + 6.0, at[1] - 5.0], &number.to_string(), 10.0, Anchor::Start, Ink::TEXT);
        }
    }
    drawing
}
