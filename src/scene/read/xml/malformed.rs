use super::super::super::source::{Place, SceneError};

/// What to say of a text that is no XML.
pub(super) fn malformed(error: &roxmltree::Error, text: &str, file: usize) -> SceneError {
    let position = error.pos();
    let lines_before = position.row.saturating_sub(1) as usize;
    let line_start: usize = text.split_inclusive('\n').take(lines_before).map(str::len).sum();
    let line = text[line_start..].split('\n').next().unwrap_or("");
    let column = line.char_indices().nth(position.col.saturating_sub(1) as usize);
    let start = line_start + column.map_or(line.trim_end().len(), |(offset, _)| offset);
    let end = text[start..].chars().next().map_or(start, |c| start + c.len_utf8());
    let place = Place { file, span: start..end };
    match error {
        _ if !text.trim_start().starts_with('<') => {
            let start = text.len() - text.trim_start().len();
            let first = text[start..].chars().next();
            let place = Place { file, span: start..start + first.map_or(0, char::len_utf8) };
            let problem = if first.is_some() { "The file is not a scene" } else { "The file is empty" };
            SceneError::at(&place, problem, "expected <scene version=\"3.0.0\">, or { of a scene in JSON")
                .with_remedy("a scene is a file of Mitsuba 3's XML, or JSON as abbe info --json writes it")
        }
        roxmltree::Error::DtdDetected => {
            let start = text.find("<!DOCTYPE").unwrap_or(0);
            let place = Place { file, span: start..(start + 9).min(text.len()) };
            SceneError::at(&place, "The file has a document type definition", "expected none")
                .with_remedy("remove <!DOCTYPE ...>: scenes do not need it")
        }
        roxmltree::Error::UnexpectedEndOfStream | roxmltree::Error::UnclosedRootNode => {
            let end = text.trim_end().len();
            let start = text[..end].char_indices().next_back().map_or(0, |(offset, _)| offset);
            SceneError::at(
                &Place { file, span: start..end },
                "The file ends too early",
                "expected the end tag of an open element after this",
            )
            .with_remedy("close every element, and the file with </scene>")
        }
        roxmltree::Error::NoRootNode => {
            SceneError::at(&place, "The file has no element", "expected <scene version=\"3.0.0\">")
        }
        roxmltree::Error::UnexpectedCloseTag(expected, found, _) => SceneError::at(
            &place,
            format!("</{found}> closes an element that is not open"),
            format!("expected </{expected}> first"),
        )
        .with_remedy(format!(
            "close <{expected}> before this place; an element without content ends with />"
        )),
        other => {
            // The crate ends its messages with the position, which is shown anyway.
            let text = other.to_string();
            let text = text.rsplit_once(" at ").map_or(text.as_str(), |(what, _)| what);
            SceneError::at(&place, "The file is not well-formed XML", text)
        }
    }
}
