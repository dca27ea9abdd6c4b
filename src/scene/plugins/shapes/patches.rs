//! Bézier patches, written in the scene or in a file as the teapot is handed on: the number of patches, then
//! for each its degrees, "3 3", and sixteen control points "x y z".

use super::profiles;
use crate::geometry::Vec3;
use crate::scene::info::hash_of_patches;
use crate::scene::plugins::{Field, Parameter, Takes};
use crate::scene::read::{Query, attributes, files};
use crate::scene::source::{Place, SceneError};
use crate::scene::write::{Node, Value, Writer};
use crate::shape::ControlNet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A larger file holds more patches than 32-bit indices can name.
const LARGEST_FILE: u64 = 1 << 40;

/// Control points of a patch.
const POINTS: usize = 16;

/// Patches from a file or from a list.
pub struct PatchSource;

impl Field for PatchSource {
    type Value = (Option<PathBuf>, Arc<Vec<ControlNet>>);

    fn parameters(&self) -> Vec<Parameter> {
        let file = Parameter::new("filename", Takes::File);
        let points = Parameter::new("points", Takes::Points(3));
        vec![
            Parameter { doc: "file in the form of the Utah teapot's", ..file },
            Parameter {
                doc: "instead of `filename`, sixteen points \"x y z, …\" for each patch, along u first",
                ..points
            },
        ]
    }

    fn read(&self, query: &Query<'_>) -> Option<Self::Value> {
        let (file, patches) = match (query.text("filename"), query.text("points")) {
            (Some(name), None) => {
                let file = query.reader.search.find(name);
                let patches = from_file(query, &file)?;
                (Some(file), patches)
            }
            (None, Some(text)) => (None, from_list(query, text)?),
            (name, _) => {
                let problem = match name {
                    Some(_) => "The bezierpatch has its control points from a file and from \"points\"",
                    None => "The bezierpatch has no control points",
                };
                let expected = "expected one of \"filename\" (a file) and \"points\" (a list)";
                query.error(SceneError::at(&query.object.place, problem, expected));
                return None;
            }
        };
        Some((file, Arc::new(patches)))
    }

    fn write(&self, node: Node, (file, patches): &Self::Value, _: &mut Writer) -> Node {
        let Some(file) = file else {
            let all: Vec<[f64; 3]> = patches.iter().flatten().map(|point| point.to_array()).collect();
            return node.text("points", profiles::text_of(&all));
        };
        let summary = format!("{} patches", patches.len());
        node.with("filename", Value::File { path: file.clone(), content: hash_of_patches(patches), summary })
    }
}

/// "x y z, …", sixteen for each patch.
fn from_list(query: &Query<'_>, text: &str) -> Option<Vec<ControlNet>> {
    let points = profiles::points::<3>(query, "points", text)?;
    if points.is_empty() || !points.len().is_multiple_of(POINTS) {
        let problem = format!("{} control points make no bicubic patch", points.len());
        let error =
            SceneError::at(&query.place("points"), problem, "expected 16 points, or a multiple of it");
        query.error(error.with_remedy("four rows of four, along u first"));
        return None;
    }
    let point = |k: usize| Vec3::from_array(points[k]);
    Some((0..points.len() / POINTS).map(|patch| std::array::from_fn(|k| point(POINTS * patch + k))).collect())
}

fn from_file(query: &Query<'_>, file: &Path) -> Option<Vec<ControlNet>> {
    let place = query.place("filename");
    let read = files::read(file, LARGEST_FILE, &place)
        .and_then(|bytes| parse(&bytes).map_err(|error| error.at(file, &place)));
    read.map_err(|error| query.error(error)).ok()
}

/// What is wrong with a file of patches.
#[derive(Debug)]
struct PatchError {
    problem: String,
    expected: &'static str,
    line: usize,
}

impl PatchError {
    fn at(self, file: &Path, place: &Place) -> SceneError {
        let problem = format!("{} ({}:{})", self.problem, file.display(), self.line);
        SceneError::at(place, problem, "this file of patches is wrong").with_remedy(self.expected)
    }
}

/// The words of a file with their lines.
struct Words<'a, I: Iterator<Item = (usize, &'a str)>> {
    words: I,
    line: usize,
}

impl<'a, I: Iterator<Item = (usize, &'a str)>> Words<'a, I> {
    fn next(&mut self, expected: &'static str) -> Result<&'a str, PatchError> {
        let Some((line, word)) = self.words.next() else {
            return Err(self.error("The file ends".to_owned(), expected));
        };
        self.line = line;
        Ok(word)
    }

    fn error(&self, problem: String, expected: &'static str) -> PatchError {
        PatchError { problem, expected, line: self.line }
    }

    fn number(&mut self, expected: &'static str) -> Result<f64, PatchError> {
        let word = self.next(expected)?;
        attributes::number(word).ok_or_else(|| self.error(shown(word), expected))
    }
}

fn shown(word: &str) -> String {
    format!("\"{}\" is not what is here", word.chars().take(60).collect::<String>())
}

fn parse(bytes: &[u8]) -> Result<Vec<ControlNet>, PatchError> {
    const COUNT: &str = "expected the number of patches first, 1 or more";
    const DEGREES: &str = "expected \"3 3\", the degrees, before the points of each patch";
    const POINT: &str = "expected sixteen points \"x y z\" for each patch";
    let text = String::from_utf8_lossy(bytes);
    let words = (1..)
        .zip(text.lines())
        .flat_map(|(line, text)| text.split_whitespace().map(move |word| (line, word)));
    let mut words = Words { words, line: 1 };
    let word = words.next(COUNT)?;
    let count = match word.parse::<usize>() {
        Ok(count) if count > 0 => count,
        _ => return Err(words.error(shown(word), COUNT)),
    };
    let mut patches = Vec::new();
    for _ in 0..count {
        for _ in 0..2 {
            let word = words.next(DEGREES)?;
            if word != "3" {
                return Err(words.error(shown(word), DEGREES));
            }
        }
        let mut patch = [Vec3::ZERO; POINTS];
        for point in &mut patch {
            *point = Vec3::new(words.number(POINT)?, words.number(POINT)?, words.number(POINT)?);
        }
        patches.push(patch);
    }
    if let Ok(word) = words.next("") {
        return Err(words.error(shown(word), "expected the file to end after as many patches as it says"));
    }
    Ok(patches)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(count: usize, patches: usize) -> String {
        let point = |k: usize| format!("{k} {}e-1 -0.5\n", 2 * k);
        let patch = format!("3 3\n{}", (0..16).map(point).collect::<String>());
        format!("{count}\r\n{}", patch.repeat(patches))
    }

    #[test]
    fn patches_are_read() {
        let patches = parse(file(2, 2).as_bytes()).unwrap();
        assert_eq!(patches.len(), 2);
        assert_eq!(patches[1][15], Vec3::new(15.0, 3.0, -0.5));
    }

    #[test]
    fn what_is_no_file_of_patches_is_refused_with_its_line() {
        let line = |text: String| parse(text.as_bytes()).unwrap_err().line;
        assert_eq!(line(String::new()), 1);
        assert_eq!(line("no\n".to_owned()), 1);
        assert_eq!(line(file(0, 0)), 1);
        assert_eq!(line(file(2, 1)), 18);
        assert_eq!(line(file(1, 2)), 19);
        assert_eq!(line("1\n\n2 3\n".to_owned()), 3);
        assert_eq!(line(file(1, 1).replace("15 30e-1 -0.5", "15 nan -0.5")), 18);
    }
}
