//! Source texts and places in them, for messages that point at what they speak of.

use codespan_reporting::diagnostic::{Diagnostic, Label};
use codespan_reporting::files::{Files, SimpleFiles};
use std::ops::Range;
use std::path::Path;

/// A range of one source text, in bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// Index into [`Sources`].
    pub file: usize,
    /// Bytes of the file, from the first to before the last.
    pub span: Range<usize>,
}

/// Longer lines (bytes) are not shown: a caret far beyond the edge of a terminal helps nobody.
const LONGEST_LINE: usize = 1000;

/// More errors are counted, not shown.
const MOST_SHOWN: usize = 50;

/// The texts that a description was read from.
#[derive(Clone, Debug)]
pub struct Sources(SimpleFiles<String, String>);

impl Default for Sources {
    fn default() -> Self {
        Self(SimpleFiles::new())
    }
}

impl Sources {
    /// Returns the index that a [`Place`] names the file by.
    pub fn add(&mut self, path: &Path, text: String) -> usize {
        self.0.add(path.display().to_string(), text)
    }

    /// The number of the line, from 1, on which a place begins; 0 for a place that does not exist.
    pub fn line(&self, place: &Place) -> usize {
        self.0.line_index(place.file, place.span.start).map_or(0, |index| index + 1)
    }

    /// Length in bytes of the line on which a place begins.
    fn line_length(&self, place: &Place) -> usize {
        let index = self.0.line_index(place.file, place.span.start).unwrap_or(0);
        self.0.line_range(place.file, index).map_or(0, |range| range.len())
    }

    /// The name of the file of a place.
    pub fn name(&self, place: &Place) -> &str {
        self.0.get(place.file).map_or("", |file| file.name().as_str())
    }
}

/// One thing that is wrong with a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneError {
    /// `None` where the file cannot be read at all.
    pub place: Option<Place>,
    /// What is wrong, in one sentence.
    pub problem: String,
    /// What was expected there, shown beside the place.
    pub expected: String,
    /// What would put it right.
    pub remedy: Option<String>,
}

impl SceneError {
    /// An error at a place, with what was expected there.
    pub fn at(place: &Place, problem: impl Into<String>, expected: impl Into<String>) -> Self {
        Self { place: Some(place.clone()), problem: problem.into(), expected: expected.into(), remedy: None }
    }

    /// The same with what to do about it.
    pub fn with_remedy(mut self, remedy: impl Into<String>) -> Self {
        self.remedy = Some(remedy.into());
        self
    }

    fn diagnostic(&self, sources: &Sources) -> Diagnostic<usize> {
        let diagnostic = Diagnostic::error().with_message(&self.problem);
        let diagnostic = match &self.place {
            Some(place) if sources.line_length(place) > LONGEST_LINE => {
                let (line, name) = (sources.line(place), sources.name(place));
                diagnostic.with_notes(vec![format!("{name}:{line}: {}", self.expected)])
            }
            Some(place) => diagnostic.with_labels(vec![
                Label::primary(place.file, place.span.clone()).with_message(&self.expected),
            ]),
            None => diagnostic.with_notes(vec![self.expected.clone()]),
        };
        match &self.remedy {
            Some(remedy) => diagnostic.with_notes(vec![format!("help: {remedy}")]),
            None => diagnostic,
        }
    }
}

/// All that is wrong with a scene, with the texts to show it in. Never empty.
#[derive(Clone, Debug)]
pub struct SceneErrors {
    /// The files that were read.
    pub sources: Sources,
    /// What is wrong in them, in order. At least one.
    pub errors: Vec<SceneError>,
}

impl std::fmt::Display for SceneErrors {
    /// Each error as a compiler shows it: message, file:line:column, the line with the place marked, help.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let config = codespan_reporting::term::Config::default();
        for error in self.errors.iter().take(MOST_SHOWN) {
            let diagnostic = error.diagnostic(&self.sources);
            let text = codespan_reporting::term::emit_into_string(&config, &self.sources.0, &diagnostic)
                .map_err(|_| std::fmt::Error)?;
            f.write_str(&text)?;
        }
        match self.errors.len().saturating_sub(MOST_SHOWN) {
            0 => Ok(()),
            more => writeln!(f, "and {more} more errors"),
        }
    }
}

impl std::error::Error for SceneErrors {}
