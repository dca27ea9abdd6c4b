//! JSON as RFC 8259 has it, with the place of each value.

use super::super::super::source::{Place, SceneError};
use super::super::attributes::GREATEST;
use std::ops::Range;

/// Arrays and objects deeper than this are refused: recursion must not exhaust the stack.
const DEEPEST: usize = 256;

#[derive(Debug)]
pub(super) struct Node {
    pub span: Range<usize>,
    pub kind: Kind,
}

#[derive(Debug)]
pub(super) enum Kind {
    Null,
    Boolean(bool),
    /// A number without decimals and exponent, if it fits.
    Integer(i64),
    Float(f64),
    Text(String),
    Array(Vec<Node>),
    Object(Vec<Member>),
}

#[derive(Debug)]
pub(super) struct Member {
    pub key: String,
    pub key_span: Range<usize>,
    pub value: Node,
}

impl Member {
    /// Key and value.
    pub fn span(&self) -> Range<usize> {
        self.key_span.start..self.value.span.end
    }
}

impl Node {
    /// What a message calls it.
    pub fn word(&self) -> &'static str {
        match self.kind {
            Kind::Null => "null",
            Kind::Boolean(_) => "a boolean",
            Kind::Integer(_) | Kind::Float(_) => "a number",
            Kind::Text(_) => "a string",
            Kind::Array(_) => "an array",
            Kind::Object(_) => "an object",
        }
    }

    pub fn number(&self) -> Option<f64> {
        match self.kind {
            Kind::Integer(value) => Some(value as f64),
            Kind::Float(value) => Some(value),
            _ => None,
        }
    }

    /// The numbers of an array of numbers.
    pub fn numbers(&self) -> Option<Vec<f64>> {
        let Kind::Array(items) = &self.kind else { return None };
        items.iter().map(Self::number).collect()
    }
}

/// Reads the text of `file`; what is wrong with it first.
pub(super) fn parse(text: &str, file: usize) -> Result<Node, SceneError> {
    let mut parser = Parser { text, at: 0, file };
    let node = parser.value(0)?;
    parser.blanks();
    match parser.peek() {
        None => Ok(node),
        Some(_) => Err(parser.wrong("There is something after the end", "expected nothing after the last }")),
    }
}

struct Parser<'a> {
    text: &'a str,
    at: usize,
    file: usize,
}

impl<'a> Parser<'a> {
    fn rest(&self) -> &'a str {
        &self.text[self.at..]
    }

    fn peek(&self) -> Option<char> {
        self.rest().chars().next()
    }

    fn blanks(&mut self) {
        let rest = self.rest();
        self.at += rest.len() - rest.trim_start_matches([' ', '\t', '\r', '\n']).len();
    }

    fn place(&self, span: Range<usize>) -> Place {
        Place { file: self.file, span }
    }

    /// An error at the next character.
    fn wrong(&self, problem: &str, expected: &str) -> SceneError {
        let length = self.peek().map_or(0, char::len_utf8);
        // At the end of the file there is nothing to point at but the last character.
        if length == 0 {
            let end = self.text.trim_end().len();
            let start = self.text[..end].char_indices().next_back().map_or(0, |(at, _)| at);
            return SceneError::at(&self.place(start..end), "The file ends too early", expected);
        }
        SceneError::at(&self.place(self.at..self.at + length), problem, expected)
    }

    fn take(&mut self, c: char) -> bool {
        let found = self.peek() == Some(c);
        if found {
            self.at += c.len_utf8();
        }
        found
    }

    fn value(&mut self, depth: usize) -> Result<Node, SceneError> {
        self.blanks();
        let start = self.at;
        if depth > DEEPEST {
            let problem = format!("Values are nested more than {DEEPEST} deep");
            return Err(SceneError::at(&self.place(start..start + 1), problem, "expected a flatter scene"));
        }
        let kind = match self.peek() {
            Some('{') => self.object(depth)?,
            Some('[') => self.array(depth)?,
            Some('"') => Kind::Text(self.string()?),
            Some('-' | '0'..='9') => self.number()?,
            _ => self.word()?,
        };
        Ok(Node { span: start..self.at, kind })
    }

    fn word(&mut self) -> Result<Kind, SceneError> {
        let length = self.rest().find(|c: char| !c.is_ascii_alphanumeric()).unwrap_or(self.rest().len());
        let kind = match &self.rest()[..length] {
            "true" => Kind::Boolean(true),
            "false" => Kind::Boolean(false),
            "null" => Kind::Null,
            "" => return Err(self.wrong("The file is not well-formed JSON", "expected a value here")),
            word => {
                let place = self.place(self.at..self.at + length);
                let error = SceneError::at(
                    &place,
                    format!("\"{word}\" is no value of JSON"),
                    "expected a string, a number, true, false, [ or {",
                );
                return Err(match word {
                    "True" | "False" => error.with_remedy(format!("write {}", word.to_lowercase())),
                    "NaN" | "Infinity" => error.with_remedy("only finite numbers have a meaning in a scene"),
                    _ => error.with_remedy("a string stands between double quotes"),
                });
            }
        };
        self.at += length;
        Ok(kind)
    }

    fn number(&mut self) -> Result<Kind, SceneError> {
        let start = self.at;
        let numeric = |c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '.' | 'e' | 'E');
        let rest = self.rest();
        let text = &rest[..rest.find(|c| !numeric(c)).unwrap_or(rest.len())];
        self.at += text.len();
        let digits = text.strip_prefix('-').unwrap_or(text);
        let integral = digits.bytes().all(|c| c.is_ascii_digit());
        let leading_zero =
            digits.len() > 1 && digits.starts_with('0') && digits.as_bytes()[1].is_ascii_digit();
        let bare_point = digits.starts_with('.') || digits.ends_with('.') || digits.contains(".e");
        if integral
            && !leading_zero
            && let Ok(value) = text.parse()
        {
            return Ok(Kind::Integer(value));
        }
        match text.parse::<f64>() {
            Ok(value) if value.abs() <= GREATEST && !leading_zero && !bare_point => Ok(Kind::Float(value)),
            _ => Err(SceneError::at(
                &self.place(start..self.at),
                format!("\"{text}\" is not a number"),
                "expected a number such as 3, 0.5 or 2e-3, at most 3.4e38",
            )),
        }
    }

    fn array(&mut self, depth: usize) -> Result<Kind, SceneError> {
        self.take('[');
        let mut items = Vec::new();
        self.blanks();
        if self.take(']') {
            return Ok(Kind::Array(items));
        }
        loop {
            items.push(self.value(depth + 1)?);
            self.blanks();
            if self.take(']') {
                return Ok(Kind::Array(items));
            }
            if !self.take(',') {
                return Err(self.wrong("The array does not go on here", "expected , or ]"));
            }
        }
    }

    fn object(&mut self, depth: usize) -> Result<Kind, SceneError> {
        self.take('{');
        let mut members = Vec::new();
        self.blanks();
        if self.take('}') {
            return Ok(Kind::Object(members));
        }
        loop {
            self.blanks();
            let start = self.at;
            if self.peek() != Some('"') {
                let error = self.wrong("The object does not go on here", "expected a name in double quotes");
                let trailing = matches!(self.peek(), Some('}'));
                return Err(if trailing { error.with_remedy("remove the comma before it") } else { error });
            }
            let key = self.string()?;
            let key_span = start..self.at;
            self.blanks();
            if !self.take(':') {
                return Err(self.wrong("The name has no value", "expected : after the name"));
            }
            let value = self.value(depth + 1)?;
            members.push(Member { key, key_span, value });
            self.blanks();
            if self.take('}') {
                return Ok(Kind::Object(members));
            }
            if !self.take(',') {
                return Err(self.wrong("The object does not go on here", "expected , or }"));
            }
        }
    }

    fn string(&mut self) -> Result<String, SceneError> {
        let start = self.at;
        self.take('"');
        let mut text = String::new();
        loop {
            let at = self.at;
            let Some(c) = self.peek() else {
                return Err(SceneError::at(
                    &self.place(start..start + 1),
                    "The string does not end",
                    "expected a closing \" after this one",
                ));
            };
            self.at += c.len_utf8();
            match c {
                '"' => return Ok(text),
                '\\' => text.push(self.escape(at)?),
                '\0'..'\x20' => {
                    return Err(SceneError::at(
                        &self.place(at..self.at),
                        "A string holds a line break or another control character",
                        "expected it to be written as \\n, \\t or \\u00xx",
                    ));
                }
                c => text.push(c),
            }
        }
    }

    /// What stands after a backslash at `start`.
    fn escape(&mut self, start: usize) -> Result<char, SceneError> {
        let next = self.peek();
        self.at += next.map_or(0, char::len_utf8);
        let c = match next {
            Some(c @ ('"' | '\\' | '/')) => Some(c),
            Some('b') => Some('\u{8}'),
            Some('f') => Some('\u{c}'),
            Some('n') => Some('\n'),
            Some('r') => Some('\r'),
            Some('t') => Some('\t'),
            Some('u') => self.unicode(),
            _ => None,
        };
        c.ok_or_else(|| {
            SceneError::at(
                &self.place(start..self.at),
                "A backslash stands before something that it does not fit",
                "expected \\\", \\\\, \\/, \\b, \\f, \\n, \\r, \\t or \\u and 4 digits",
            )
            .with_remedy("a backslash itself is written \\\\; paths may have / on every system")
        })
    }

    /// Four hexadecimal digits, or two times four for a character beyond the first 65536.
    fn unicode(&mut self) -> Option<char> {
        let first = self.hexadecimal()?;
        if !(0xd800..0xdc00).contains(&first) {
            return char::from_u32(first);
        }
        if !(self.take('\\') && self.take('u')) {
            return None;
        }
        char::decode_utf16([first as u16, self.hexadecimal()? as u16]).next()?.ok()
    }

    fn hexadecimal(&mut self) -> Option<u32> {
        let digits = self.rest().get(..4).filter(|digits| digits.bytes().all(|c| c.is_ascii_hexdigit()))?;
        self.at += 4;
        u32::from_str_radix(digits, 16).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_read_with_their_places() {
        let text = r#" {"a": [1, -2.5e-3, 1e2], "é\u00e9\ud83d\ude00\n": {"b": null, "c": true}} "#;
        let node = parse(text, 0).unwrap();
        let Kind::Object(members) = &node.kind else { panic!("{node:?}") };
        assert_eq!(&text[members[0].span()], "\"a\": [1, -2.5e-3, 1e2]");
        assert_eq!(members[0].value.numbers().unwrap(), [1.0, -0.0025, 100.0]);
        assert_eq!(members[1].key, "éé😀\n");
        assert_eq!(&text[members[1].value.span.clone()], "{\"b\": null, \"c\": true}");
    }

    #[test]
    fn numbers_keep_every_bit() {
        for number in [0.1 + 0.2, -0.0, f64::MIN_POSITIVE, f64::from(f32::MAX), 1e16, 5e-324] {
            let node = parse(&format!("{number:?}"), 0).unwrap();
            assert_eq!(node.number().unwrap().to_bits(), number.to_bits());
        }
    }

    #[test]
    fn what_is_not_json_is_refused() {
        for text in [
            "",
            "{",
            "[1,]",
            "{\"a\":1,}",
            "{a:1}",
            "01",
            "1.",
            ".5",
            "+1",
            "1e",
            "NaN",
            "nul",
            "\"a",
            "\"\\x\"",
            "\"\\ud800\"",
            "\"\\udc00\"",
            "[1 2]",
            "{} {}",
            "\"\n\"",
            "1e999",
            "'a'",
            "-",
        ] {
            assert!(parse(text, 0).is_err(), "{text}");
        }
        assert!(parse(&"[".repeat(100_000), 0).is_err());
    }
}
