//! Curves from files: one control point "x y z radius" a line, curves separated by empty lines.

use crate::geometry::Vec3;
use crate::scene::info::hash_of_curves;
use crate::scene::plugins::fields::Choices;
use crate::scene::plugins::{Field, Parameter, Simple, Takes, choice};
use crate::scene::read::{Class, Query, attributes, files};
use crate::scene::source::{Place, SceneError};
use crate::scene::write::{Node, Value, Writer};
use crate::shape::{ControlPoint, CurveKind};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A larger file holds more segments than 32-bit indices can name.
const LARGEST_FILE: u64 = 64 << 30;

const INTERPOLATION: Simple<Choices<CurveKind>> = choice(
    "interpolation",
    CurveKind::Linear,
    &[("linear", CurveKind::Linear), ("bspline", CurveKind::BSpline)],
    "the curve that the points make",
);

/// A file of fibres of a kind.
pub struct CurveFile(pub CurveKind);

impl Field for CurveFile {
    type Value = (PathBuf, Arc<Vec<Vec<ControlPoint>>>);

    fn parameters(&self) -> Vec<Parameter> {
        let doc = "file with a control point \"x y z radius\" on each line, curves apart by empty lines";
        vec![Parameter { is_required: true, doc, ..Parameter::new("filename", Takes::File) }]
    }

    fn read(&self, query: &Query<'_>) -> Option<Self::Value> {
        refuse_lights(query);
        load(query, self.0)
    }

    fn write(&self, node: Node, (file, curves): &Self::Value, _: &mut Writer) -> Node {
        let points = curves.iter().map(Vec::len).sum::<usize>();
        let summary = format!("{} curves, {points} control points", curves.len());
        node.with("filename", Value::File { path: file.clone(), content: hash_of_curves(curves), summary })
    }
}

/// A file of curves of the kind that stands beside it.
pub struct AnyCurves;

impl Field for AnyCurves {
    type Value = (CurveKind, PathBuf, Arc<Vec<Vec<ControlPoint>>>);

    fn parameters(&self) -> Vec<Parameter> {
        [INTERPOLATION.parameters(), CurveFile(CurveKind::Linear).parameters()].concat()
    }

    fn read(&self, query: &Query<'_>) -> Option<Self::Value> {
        let kind = INTERPOLATION.read(query)?;
        load(query, kind).map(|(file, curves)| (kind, file, curves))
    }

    fn write(&self, node: Node, (kind, file, curves): &Self::Value, writer: &mut Writer) -> Node {
        let node = INTERPOLATION.write(node, kind, writer);
        CurveFile(*kind).write(node, &(file.clone(), curves.clone()), writer)
    }
}

/// The curves of the file that is named; `None` where it is wrong, which is reported.
fn load(query: &Query<'_>, kind: CurveKind) -> Option<(PathBuf, Arc<Vec<Vec<ControlPoint>>>)> {
    let file = query.file("filename")?;
    let place = query.place("filename");
    let read = files::read(&file, LARGEST_FILE, &place)
        .and_then(|bytes| parse(&bytes, kind).map_err(|error| error.at(&file, &place)));
    let curves = read.map_err(|error| query.error(error)).ok()?;
    Some((file, Arc::new(curves)))
}

/// Refuses lights on fibres, whose area is not known.
fn refuse_lights(query: &Query<'_>) {
    if query.has("flip_normals") {
        query
            .reader
            .extension(&query.place("flip_normals"), format!("flip_normals on a {}", query.object.plugin));
    }
    if let Some((entry, _)) = query.object(Class::Emitter) {
        let problem = format!("A {} cannot be a light, here as in Mitsuba 3", query.object.plugin);
        let error = SceneError::at(&entry.place, problem, "expected a shape whose area is known");
        query.error(error.with_remedy("a sweptsphere of the same file can"));
    }
}

/// What is wrong with a file of curves.
#[derive(Debug)]
struct CurveError {
    problem: String,
    expected: String,
    line: usize,
}

impl CurveError {
    fn at(self, file: &Path, place: &Place) -> SceneError {
        let problem = format!("{} ({}:{})", self.problem, file.display(), self.line);
        SceneError::at(place, problem, "this file of curves is wrong").with_remedy(self.expected)
    }
}

fn parse(bytes: &[u8], kind: CurveKind) -> Result<Vec<Vec<ControlPoint>>, CurveError> {
    let mut curves: Vec<Vec<ControlPoint>> = Vec::new();
    let mut curve: Vec<ControlPoint> = Vec::new();
    let finished = |curve: &mut Vec<ControlPoint>, line: usize| {
        let (found, least) = (curve.len(), kind.order());
        if found > 0 && found < least {
            let points = if found == 1 { "point" } else { "points" };
            let problem = format!("The curve that ends here has {found} control {points}");
            let expected = format!("expected {least} or more between empty lines");
            return Err(CurveError { problem, expected, line });
        }
        Ok(std::mem::take(curve))
    };
    let mut last = 0;
    for (line, text) in (1..).zip(bytes.split(|&byte| byte == b'\n')) {
        let text = String::from_utf8_lossy(text);
        if text.trim().is_empty() {
            let done = finished(&mut curve, line.max(2) - 1)?;
            curves.extend((!done.is_empty()).then_some(done));
            continue;
        }
        last = line;
        // What follows the fourth number Mitsuba 3 ignores, too.
        let numbers: Vec<Option<f64>> = text.split_whitespace().take(4).map(attributes::number).collect();
        let &[Some(x), Some(y), Some(z), Some(radius)] = &numbers[..] else {
            let shown: String = text.trim().chars().take(60).collect();
            let expected = "expected four finite numbers, \"x y z radius\", separated by blanks".to_owned();
            let problem = format!("\"{shown}\" is not a control point");
            return Err(CurveError { problem, expected, line });
        };
        if radius < 0.0 {
            let problem = format!("The radius is {radius}");
            return Err(CurveError { problem, expected: "expected a radius of at least 0".to_owned(), line });
        }
        curve.push(ControlPoint { position: Vec3::new(x, y, z), radius });
    }
    let done = finished(&mut curve, last)?;
    curves.extend((!done.is_empty()).then_some(done));
    if curves.is_empty() {
        let expected = format!("expected {} lines \"x y z radius\" or more", kind.order());
        let problem = "There are no control points".to_owned();
        return Err(CurveError { problem, expected, line: 1 });
    }
    Ok(curves)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As Mitsuba 3.9.1 reads them: any number of empty lines, ends of lines of any system, further numbers
    /// ignored.
    #[test]
    fn curves_are_read_as_mitsuba_reads_them() {
        let text = b"\n 0 0 0 1\r\n1 0 0 1 7\r\n\r\n \r\n2 0 0 1\t\n3 1e-1 0 0.5";
        let curves = parse(text, CurveKind::Linear).unwrap();
        assert_eq!(curves.iter().map(Vec::len).collect::<Vec<_>>(), [2, 2]);
        assert_eq!(curves[1][1], ControlPoint { position: Vec3::new(3.0, 0.1, 0.0), radius: 0.5 });
    }

    #[test]
    fn what_is_no_curve_is_refused_with_its_line() {
        let line = |text: &str, kind| parse(text.as_bytes(), kind).unwrap_err().line;
        assert_eq!(line("0 0 0 1\n0 0 1 1\n\n1 0 0 1\n", CurveKind::Linear), 4);
        assert_eq!(line("0 0 0 1\n0 0 1 1\n0 1 0 1\n", CurveKind::BSpline), 3);
        assert_eq!(line("0 0 0 1\n0 0 1\n", CurveKind::Linear), 2);
        assert_eq!(line("0 0 0 1\n# no comment\n", CurveKind::Linear), 2);
        assert_eq!(line("0 0 0 1\n0 0 1 nan\n", CurveKind::Linear), 2);
        assert_eq!(line("0 0 0 1\n0 0 1 -1\n", CurveKind::Linear), 2);
        assert_eq!(line("0,0,0,1\n0,0,1,1\n", CurveKind::Linear), 1);
        assert_eq!(line("\n\n", CurveKind::Linear), 1);
    }
}
