//! What Mitsuba 3's parser accepts although XML does not, and scene files in use have.

use std::borrow::Cow;

/// The text with blanks in the place of what XML would refuse: `--` within comments, and a declaration that
/// does not come first. Everything keeps its place.
pub(super) fn accepted(text: &str) -> Cow<'_, str> {
    let mut blanks = Vec::new();
    let start = text.len() - text.trim_start().len();
    if start > 0
        && text[start..].starts_with("<?xml ")
        && let Some(length) = text[start..].find("?>")
    {
        blanks.push(start..start + length + 2);
    }
    let mut at = 0;
    while let Some(offset) = text[at..].find('<') {
        let begin = at + offset;
        let rest = &text[begin..];
        let end_of = |mark: &str| rest.find(mark).map_or(text.len(), |length| begin + length + mark.len());
        at = if let Some(comment) = rest.strip_prefix("<!--") {
            let Some(length) = comment.find("-->") else { break };
            let inside = begin + 4..begin + 4 + length;
            if comment[..length].contains("--") || comment[..length].ends_with('-') {
                blanks.push(inside.clone());
            }
            inside.end + 3
        } else if rest.starts_with("<![CDATA[") {
            end_of("]]>")
        } else if rest.starts_with("<?") {
            end_of("?>")
        } else {
            begin + 1
        };
    }
    if blanks.is_empty() {
        return Cow::Borrowed(text);
    }
    let mut result = String::with_capacity(text.len());
    let mut kept = 0;
    for blank in blanks {
        result.push_str(&text[kept..blank.start]);
        result.extend(text[blank.clone()].bytes().map(|byte| if byte == b'\n' { '\n' } else { ' ' }));
        kept = blank.end;
    }
    result.push_str(&text[kept..]);
    Cow::Owned(result)
}

#[cfg(test)]
mod tests {
    use super::accepted;

    #[test]
    fn places_stay_as_they_are() {
        let text = " <?xml version=\"1.0\"?><!-- é -- \n b --><a b=\"--\"/><!-- fine --><![CDATA[<!-- -- -->]]><!-- c --->";
        let accepted = accepted(text);
        assert_eq!(accepted.len(), text.len());
        assert_eq!(accepted.find("<a"), text.find("<a"));
        assert_eq!(accepted.find('\n'), text.find('\n'));
        assert!(accepted.contains("\"--\"") && accepted.contains("<!-- fine -->"));
        assert!(accepted.contains("<![CDATA[<!-- -- -->]]>") && accepted.ends_with("<!--    -->"));
        assert!(matches!(super::accepted("<a/>"), std::borrow::Cow::Borrowed(_)));
    }
}
