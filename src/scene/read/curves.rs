//! Curves from files: one control point "x y z radius" a line, curves separated by empty lines.

use super::super::description::ShapeKind;
use super::super::source::SceneError;
use super::query::Query;
use super::tree::Class;
use super::{attributes, files};
use crate::geometry::Vec3;
use crate::shape::{ControlPoint, CurveKind};
use std::path::Path;
use std::sync::Arc;

/// A larger file holds more segments than 32-bit indices can name.
const LARGEST_FILE: u64 = 64 << 30;

/// A `linearcurve`, `bsplinecurve` or `sweptsphere`. `None` where it is wrong, which is reported.
pub(super) fn read(query: &Query<'_>) -> Option<ShapeKind> {
    let object = query.object;
    let solid = object.plugin == "sweptsphere";
    let kind = match object.plugin.as_str() {
        "linearcurve" => CurveKind::Linear,
        "bsplinecurve" => CurveKind::BSpline,
        _ => {
            query.reader.extension(&object.place, "sweptsphere: what a ball passes along curves".to_owned());
            let kinds = [("linear", CurveKind::Linear), ("bspline", CurveKind::BSpline)];
            query.choice("interpolation", &kinds, false).unwrap_or(CurveKind::Linear)
        }
    };
    if !solid {
        if query.has("flip_normals") {
            query
                .reader
                .extension(&query.place("flip_normals"), format!("flip_normals on a {}", object.plugin));
        }
        for class in [Class::Emitter, Class::Sensor] {
            if let Some((entry, _)) = query.object(class) {
                let what = if class == Class::Emitter { "a light" } else { "a sensor" };
                let problem = format!("A {} cannot be {what}, here as in Mitsuba 3", object.plugin);
                let error = SceneError::at(&entry.place, problem, "expected a shape whose area is known");
                query.error(error.with_remedy("a sweptsphere of the same file can"));
            }
        }
    }
    let filename = query.required("filename", query.text("filename"))?;
    let file = query.reader.search.find(filename);
    let place = query.place("filename");
    let read = files::read(&file, LARGEST_FILE, &place)
        .and_then(|bytes| parse(&bytes, kind).map_err(|error| error.at(&file, &place)));
    match read {
        Ok(curves) => Some(ShapeKind::Curves { file, kind, solid, curves: Arc::new(curves) }),
        Err(error) => {
            query.error(error);
            None
        }
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
    fn at(self, file: &Path, place: &super::super::source::Place) -> SceneError {
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
