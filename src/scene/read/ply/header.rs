//! The header of a PLY file: its format, and which elements and properties follow.

use super::super::meshes::{MeshError, Position};
use super::{Cursor, Element, Format, Property, Scalar};

/// A header names at most this many properties of an element: more are no mesh, and take long to compare.
const MOST_PROPERTIES: usize = 1000;

pub(super) fn header(bytes: &[u8]) -> Result<(Format, Vec<Element>, Cursor<'_>), MeshError> {
    let mut cursor = Cursor { bytes, at: 0, line: 0 };
    if cursor.next_line().map(<[u8]>::trim_ascii) != Some(b"ply") {
        return Err(MeshError::new("This is not a PLY file", "expected \"ply\" on its first line"));
    }
    let mut format = None;
    let mut elements: Vec<Element> = Vec::new();
    loop {
        let Some(line) = cursor.next_line() else {
            return Err(MeshError::new("The header does not end", "expected a line \"end_header\""));
        };
        let position = Position::Line(cursor.line);
        let wrong = |expected: &str| {
            let text = String::from_utf8_lossy(&line[..line.len().min(80)]);
            MeshError::new(format!("The header is wrong: \"{text}\""), expected).on(position)
        };
        let words: Vec<&[u8]> =
            line.split(|byte| byte.is_ascii_whitespace()).filter(|word| !word.is_empty()).collect();
        match words[..] {
            [] | [b"comment" | b"obj_info", ..] => {}
            [b"format", name, ..] => {
                format = Some(match name {
                    b"ascii" => Format::Ascii,
                    b"binary_little_endian" => Format::Little,
                    b"binary_big_endian" => Format::Big,
                    _ => return Err(wrong("expected ascii, binary_little_endian or binary_big_endian")),
                });
            }
            [b"element", name, count] => {
                let count = std::str::from_utf8(count).ok().and_then(|text| text.parse().ok());
                let count = count.ok_or_else(|| wrong("expected a number of elements"))?;
                elements.push(Element { name: name.to_vec(), count, properties: Vec::new() });
            }
            [b"property", b"list", count, scalar, name] => {
                let element = last(&mut elements).ok_or_else(|| wrong(BEFORE))?;
                let types = Scalar::named(count).zip(Scalar::named(scalar));
                let (count, scalar) = types.ok_or_else(|| wrong("expected types such as uchar and int"))?;
                element.properties.push(Property { name: name.to_vec(), list: Some(count), scalar });
            }
            [b"property", scalar, name] => {
                let element = last(&mut elements).ok_or_else(|| wrong(BEFORE))?;
                let scalar = Scalar::named(scalar).ok_or_else(|| wrong("expected a type such as float"))?;
                element.properties.push(Property { name: name.to_vec(), list: None, scalar });
            }
            [b"end_header"] => break,
            _ => return Err(wrong("expected format, element, property, comment or end_header")),
        }
    }
    for element in &elements {
        let name = |at: usize| &element.properties[at].name;
        if let Some(twice) = (1..element.properties.len()).find(|&at| (0..at).any(|i| name(i) == name(at))) {
            let problem = format!("There are two properties \"{}\"", String::from_utf8_lossy(name(twice)));
            return Err(MeshError::new(problem, "expected names that differ within an element"));
        }
    }
    let format = format
        .ok_or_else(|| MeshError::new("The header names no format", "expected a line \"format ...\""))?;
    Ok((format, elements, cursor))
}

const BEFORE: &str = "expected an element with at most 1000 properties before a property";

/// The element that a property belongs to, if it has room for one.
fn last(elements: &mut [Element]) -> Option<&mut Element> {
    elements.last_mut().filter(|element| element.properties.len() < MOST_PROPERTIES)
}
