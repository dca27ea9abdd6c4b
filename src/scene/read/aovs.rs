//! The list of images that an `aov` integrator writes beside the picture.

use super::super::description::{Aov, AovKind};
use super::super::source::SceneError;
use super::hints;
use super::query::Query;
use std::collections::BTreeSet;

/// What `aovs` lists: pairs `name:type`, apart by commas or blanks.
pub(in crate::scene) fn read(query: &Query<'_>) -> Vec<Aov> {
    let place = query.place("aovs");
    let Some(list) = query.text("aovs") else {
        if !query.has("aovs") {
            let error = SceneError::at(&place, "The \"aov\" lists no images", "expected a string \"aovs\"");
            query.error(error.with_remedy("write <string name=\"aovs\" value=\"nn:sh_normal, dd:depth\"/>"));
        }
        return Vec::new();
    };
    let mut aovs = Vec::new();
    for word in list.split([',', ' ', '\t', '\n', '\r']).filter(|word| !word.is_empty()) {
        let pair = word.split_once(':').filter(|(name, _)| !name.is_empty());
        let Some((name, kind)) = pair else {
            let error = SceneError::at(&place, format!("\"{word}\" has no name"), "expected name:type");
            query.error(error.with_remedy(format!("write for instance {word}:{word}")));
            continue;
        };
        match AovKind::named(kind) {
            Some(kind) => aovs.push(Aov { name: name.to_owned(), kind }),
            None => query.error(unknown(kind).at(query)),
        }
    }
    aovs
}

/// Refuses names that channels of the picture have, and names given twice.
pub(in crate::scene) fn check(query: &Query<'_>, aovs: &[Aov]) {
    let place = query.place("aovs");
    let mut taken = BTreeSet::new();
    for aov in aovs {
        if aov.name == "error" || aov.name.starts_with("error.") {
            let problem = format!("An image cannot have the name \"{}\"", aov.name);
            query.error(SceneError::at(&place, problem, "channels error.* hold standard errors"));
        }
        if let Some(channel) = aov.channels().find(|channel| !taken.insert(channel.clone())) {
            let problem = format!("Two images have the channel \"{channel}\"");
            let error = SceneError::at(&place, problem, "expected a name of its own for each image");
            query.error(error.with_remedy("the name stands before the colon"));
        }
    }
}

/// What to say of a word that is no type.
struct Unknown {
    problem: String,
    expected: String,
    remedy: Option<String>,
}

impl Unknown {
    fn at(self, query: &Query<'_>) -> SceneError {
        let error = SceneError::at(&query.place("aovs"), self.problem, self.expected);
        match self.remedy {
            Some(remedy) => error.with_remedy(remedy),
            None => error,
        }
    }
}

fn unknown(kind: &str) -> Unknown {
    let known = AovKind::NAMES.map(|(name, _)| name);
    Unknown {
        problem: match kind {
            "duv_dx" | "duv_dy" => format!("The image \"{kind}\" is not supported"),
            _ => format!("There is no image \"{kind}\""),
        },
        expected: format!("expected {}", hints::either(&known)),
        remedy: match kind {
            "normal" => Some("say which: sh_normal or geo_normal".to_owned()),
            _ => hints::nearest(kind, &known).map(|near| format!("did you mean \"{near}\"?")),
        },
    }
}

impl Aov {
    /// An image as the command line asks for it: `type`, or `name:type`.
    ///
    /// # Errors
    /// What is wrong with it, and what to write.
    pub fn of_word(word: &str) -> Result<Self, String> {
        let (name, kind) = word.split_once(':').unwrap_or((word, word));
        let Some(found) = AovKind::named(kind) else {
            let Unknown { problem, expected, remedy } = unknown(kind);
            let remedy = remedy.map_or(String::new(), |remedy| format!("; {remedy}"));
            return Err(format!("{problem}: {expected}{remedy}"));
        };
        if name.is_empty() || name == "error" || name.starts_with("error.") {
            return Err(format!("an image cannot have the name \"{name}\": expected name:type"));
        }
        Ok(Self { name: name.to_owned(), kind: found })
    }
}
