//! PLY: ascii and binary of both byte orders; positions, normals, texture coordinates, further attributes,
//! polygons.
//!
//! What an attribute of Mitsuba 3 is becomes one here; whatever else the file holds is passed over. Numbers
//! of elements are checked against the length of the file before anything is allocated for them.

mod attributes;
mod header;
mod rows;

use super::meshes::{MeshError, MeshFile, MeshOptions, MeshResult, Position};
use crate::shape::MeshData;
use attributes::Columns;
use header::header;
use rows::Rows;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Format {
    Ascii,
    Little,
    Big,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn named(name: &[u8]) -> Option<Self> {
        Some(match name {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// The value at the beginning of `bytes`, which are long enough.
    #[inline]
    fn value(self, bytes: &[u8], big: bool) -> f64 {
        fn array<const N: usize>(bytes: &[u8], big: bool) -> [u8; N] {
            let mut array = [0; N];
            array.copy_from_slice(&bytes[..N]);
            if big {
                array.reverse();
            }
            array
        }
        match self {
            Self::I8 => f64::from(i8::from_le_bytes(array(bytes, big))),
            Self::U8 => f64::from(bytes[0]),
            Self::I16 => f64::from(i16::from_le_bytes(array(bytes, big))),
            Self::U16 => f64::from(u16::from_le_bytes(array(bytes, big))),
            Self::I32 => f64::from(i32::from_le_bytes(array(bytes, big))),
            Self::U32 => f64::from(u32::from_le_bytes(array(bytes, big))),
            Self::F32 => f64::from(f32::from_le_bytes(array(bytes, big))),
            Self::F64 => f64::from_le_bytes(array(bytes, big)),
        }
    }
}

#[derive(Clone, Debug)]
struct Property {
    name: Vec<u8>,
    /// The type of the length, for a list.
    list: Option<Scalar>,
    scalar: Scalar,
}

#[derive(Clone, Debug)]
struct Element {
    name: Vec<u8>,
    count: usize,
    properties: Vec<Property>,
}

impl Element {
    /// The fewest bytes that a row takes.
    fn least_bytes(&self, format: Format) -> usize {
        let sizes = self.properties.iter().map(|property| match format {
            // A digit and a separator.
            Format::Ascii => 2,
            _ => property.list.unwrap_or(property.scalar).size(),
        });
        sizes.sum::<usize>().max(1)
    }

    fn find(&self, names: &[&[u8]]) -> Option<usize> {
        self.properties
            .iter()
            .position(|property| property.list.is_none() && names.contains(&property.name.as_slice()))
    }

    fn find_all<const N: usize>(&self, names: [&[&[u8]]; N]) -> Option<[usize; N]> {
        let mut found = [0; N];
        for (slot, names) in found.iter_mut().zip(names) {
            *slot = self.find(names)?;
        }
        Some(found)
    }

    /// Mitsuba 3 makes garbage of coordinates that are integers of more than a byte: fractions of the largest
    /// number.
    fn refuse_whole_numbers(&self, columns: &[usize]) -> Result<(), MeshError> {
        let allowed = |scalar| matches!(scalar, Scalar::F32 | Scalar::F64 | Scalar::U8);
        match columns.iter().map(|&at| &self.properties[at]).find(|property| !allowed(property.scalar)) {
            None => Ok(()),
            Some(property) => Err(MeshError::new(
                format!(
                    "\"{}\" has an integer type, which Mitsuba 3 would take for shares of the largest integer",
                    String::from_utf8_lossy(&property.name)
                ),
                "expected the type float",
            )),
        }
    }
}

pub(super) fn read(bytes: &[u8], options: MeshOptions) -> MeshResult {
    let (format, elements, mut cursor) = header(bytes)?;
    let mut mesh = MeshData::default();
    let mut polygons = false;
    for element in &elements {
        let rows_left = (cursor.bytes.len() - cursor.at + 1) / element.least_bytes(format);
        if element.count > rows_left {
            return Err(MeshError::new(
                format!(
                    "The file says that it has {} of \"{}\", but it is too short for them",
                    element.count,
                    String::from_utf8_lossy(&element.name)
                ),
                format!("expected at most {rows_left} in a file of {} bytes", bytes.len()),
            ));
        }
        match element.name.as_slice() {
            b"vertex" => vertices(element, format, &mut cursor, options, &mut mesh)?,
            b"face" => polygons = faces(element, format, &mut cursor, &mut mesh)?,
            b"tristrips" if element.count > 0 => {
                return Err(MeshError::new(
                    "Triangle strips are not supported",
                    "expected an element \"face\" with a list \"vertex_indices\"",
                ));
            }
            _ => {
                let mut row = vec![0.0; element.properties.len()];
                for _ in 0..element.count {
                    cursor.row(element, format, &mut row, None, &mut Vec::new())?;
                }
            }
        }
    }
    let vertices = mesh.positions.len();
    // Faces may stand before the vertices, so this can only be judged in the end.
    if let Some(triangle) =
        mesh.indices.iter().position(|triangle| triangle.iter().any(|&i| i as usize >= vertices))
    {
        let index = mesh.indices[triangle].into_iter().max().unwrap_or(0);
        return Err(MeshError::new(
            format!(
                "A face refers to vertex {index}, but the file has {vertices} vertices (triangle {triangle})"
            ),
            "expected indices from 0 to one less than the number of vertices",
        ));
    }
    let extension =
        polygons.then_some("faces of more than three corners in a PLY file; Mitsuba 3 reads triangles");
    Ok(MeshFile { mesh, extension })
}

/// A place in the data, with what is needed to say where it is.
struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    /// The current line, in an ascii file.
    line: usize,
}

impl<'a> Cursor<'a> {
    /// The next line without its end; `None` at the end of the file.
    fn next_line(&mut self) -> Option<&'a [u8]> {
        let rest = self.bytes.get(self.at..).filter(|rest| !rest.is_empty())?;
        let length = rest.iter().position(|&byte| byte == b'\n').unwrap_or(rest.len());
        self.at += (length + 1).min(rest.len());
        self.line += 1;
        let line = &rest[..length];
        Some(line.strip_suffix(b"\r").unwrap_or(line))
    }

    fn ends(&self, format: Format) -> MeshError {
        let error = MeshError::new("The file ends too early", "expected more data, as the header says");
        error.on(match format {
            Format::Ascii => Position::Line(self.line),
            _ => Position::Byte(self.bytes.len()),
        })
    }

    /// Where a row is that began at the byte `start` and has just been read.
    fn position(&self, format: Format, start: usize) -> Position {
        if format == Format::Ascii { Position::Line(self.line) } else { Position::Byte(start) }
    }

    fn take(&mut self, count: usize, format: Format) -> Result<&'a [u8], MeshError> {
        let taken = self.at.checked_add(count).and_then(|end| self.bytes.get(self.at..end));
        let taken = taken.ok_or_else(|| self.ends(format))?;
        self.at += count;
        Ok(taken)
    }

    /// One row: its single values into `values`, and the list at `wanted` into `list`.
    fn row(
        &mut self,
        element: &Element,
        format: Format,
        values: &mut [f64],
        wanted: Option<usize>,
        list: &mut Vec<f64>,
    ) -> Result<(), MeshError> {
        if format == Format::Ascii {
            return self.ascii_row(element, values, wanted, list);
        }
        let big = format == Format::Big;
        for (index, property) in element.properties.iter().enumerate() {
            let size = property.scalar.size();
            let Some(count) = property.list else {
                values[index] = property.scalar.value(self.take(size, format)?, big);
                continue;
            };
            let start = self.at;
            let count = length(count.value(self.take(count.size(), format)?, big))
                .map_err(|error| error.on(Position::Byte(start)))?;
            let data = self.take(count.saturating_mul(size), format)?;
            if wanted == Some(index) {
                list.clear();
                list.extend(data.chunks_exact(size).map(|item| property.scalar.value(item, big)));
            }
        }
        Ok(())
    }

    fn ascii_row(
        &mut self,
        element: &Element,
        values: &mut [f64],
        wanted: Option<usize>,
        list: &mut Vec<f64>,
    ) -> Result<(), MeshError> {
        let line = loop {
            let line = self.next_line().ok_or_else(|| self.ends(Format::Ascii))?;
            if !line.trim_ascii().is_empty() {
                break line;
            }
        };
        let position = Position::Line(self.line);
        let mut words = line.split(|byte| byte.is_ascii_whitespace()).filter(|word| !word.is_empty());
        let mut next = || number(words.next()).map_err(|error| error.on(position));
        for (index, property) in element.properties.iter().enumerate() {
            if property.list.is_none() {
                values[index] = next()?;
                continue;
            }
            let count = length(next()?).map_err(|error| error.on(position))?;
            let is_wanted = wanted == Some(index);
            if is_wanted {
                list.clear();
            }
            for _ in 0..count {
                let item = next()?;
                if is_wanted {
                    list.push(item);
                }
            }
        }
        Ok(())
    }
}

fn number(word: Option<&[u8]>) -> Result<f64, MeshError> {
    let Some(word) = word else {
        return Err(MeshError::new(
            "The line is too short",
            "expected a number for each property of the element",
        ));
    };
    std::str::from_utf8(word).ok().and_then(|text| text.parse().ok()).ok_or_else(|| {
        MeshError::new(format!("\"{}\" is not a number", String::from_utf8_lossy(word)), "expected a number")
    })
}

fn length(number: f64) -> Result<usize, MeshError> {
    if number >= 0.0 && number.fract() == 0.0 && number <= f64::from(u32::MAX) {
        return Ok(number as usize);
    }
    Err(MeshError::new(format!("A list has {number} items"), "expected a whole number of at least 0"))
}

fn vertices(
    element: &Element,
    format: Format,
    cursor: &mut Cursor<'_>,
    options: MeshOptions,
    mesh: &mut MeshData,
) -> Result<(), MeshError> {
    if !mesh.positions.is_empty() {
        return Err(MeshError::new("The file has two elements \"vertex\"", "expected one"));
    }
    let Some(position) = element.find_all([&[b"x"], &[b"y"], &[b"z"]]) else {
        return Err(MeshError::new("The vertices have no position", "expected properties x, y and z"));
    };
    let normal = element.find_all([&[b"nx"], &[b"ny"], &[b"nz"]]);
    let uv = element
        .find_all([&[b"u"], &[b"v"]])
        .or_else(|| element.find_all([&[b"texture_u"], &[b"texture_v"]]))
        .or_else(|| element.find_all([&[b"s"], &[b"t"]]));
    let taken: Vec<usize> =
        position.into_iter().chain(normal.into_iter().flatten()).chain(uv.into_iter().flatten()).collect();
    element.refuse_whole_numbers(&taken)?;
    let mut attributes = Columns::of(element, &taken, false)?;
    let normal = normal.filter(|_| !options.face_normals);
    let place_v = |v: f64| if options.flip_tex_coords { 1.0 - v as f32 } else { v as f32 };
    // What is not finite is left to the loop below, which says where it is.
    if let Some((rows, columns)) = Rows::of_numbers(cursor, format, element).filter(|_| attributes.is_empty())
        && taken.iter().all(|&at| rows.all([columns[at]], |x| (x as f32).is_finite()))
    {
        let vector = |vector: [f64; 3]| vector.map(|x| x as f32);
        mesh.positions = rows.map(position.map(|i| columns[i]), vector);
        mesh.normals = normal.map(|at| rows.map(at.map(|i| columns[i]), vector));
        mesh.uvs = uv.map(|at| rows.map(at.map(|i| columns[i]), |[u, v]| [u as f32, place_v(v)]));
        cursor.at += rows.size();
        return Ok(());
    }
    let mut row = vec![0.0; element.properties.len()];
    let mut positions = Vec::with_capacity(element.count);
    let mut normals = Vec::with_capacity(if normal.is_some() { element.count } else { 0 });
    let mut uvs = Vec::with_capacity(if uv.is_some() { element.count } else { 0 });
    for _ in 0..element.count {
        let start = cursor.at;
        cursor.row(element, format, &mut row, None, &mut Vec::new())?;
        let mut finite = taken.iter().all(|&i| (row[i] as f32).is_finite());
        for columns in &mut attributes {
            finite &= columns.push(&row);
        }
        if !finite {
            let problem = format!("Vertex {} has a number that is not finite", positions.len());
            let expected = "expected finite numbers of single precision";
            return Err(MeshError::new(problem, expected).on(cursor.position(format, start)));
        }
        let vector = |at: [usize; 3]| at.map(|i| row[i] as f32);
        positions.push(vector(position));
        if let Some(normal) = normal {
            normals.push(vector(normal));
        }
        if let Some(uv) = uv {
            let [u, v] = uv.map(|i| row[i]);
            uvs.push([u as f32, place_v(v)]);
        }
    }
    mesh.positions = positions;
    mesh.normals = normal.map(|_| normals);
    mesh.uvs = uv.map(|_| uvs);
    mesh.attributes.extend(attributes.into_iter().map(|columns| columns.attribute));
    Ok(())
}

/// Whether some face has more than three corners.
fn faces(
    element: &Element,
    format: Format,
    cursor: &mut Cursor<'_>,
    mesh: &mut MeshData,
) -> Result<bool, MeshError> {
    if !mesh.indices.is_empty() {
        return Err(MeshError::new("The file has two elements \"face\"", "expected one"));
    }
    let named = |property: &Property| {
        property.list.is_some() && matches!(property.name.as_slice(), b"vertex_index" | b"vertex_indices")
    };
    let Some(corners) = element.properties.iter().position(named) else {
        return Err(MeshError::new("The faces have no corners", "expected a list property vertex_indices"));
    };
    let is_index = |index: f64| index >= 0.0 && index < f64::from(u32::MAX);
    // What is wrong is left to the loop below, which says where it is.
    if let Some((rows, columns)) = Rows::of_triples(cursor, format, element)
        && rows.all(columns, is_index)
    {
        mesh.indices = rows.map(columns, |triangle| triangle.map(|index| index as u32));
        cursor.at += rows.size();
        return Ok(false);
    }
    let mut attributes = Columns::of(element, &[], true)?;
    let mut row = vec![0.0; element.properties.len()];
    let mut polygon = Vec::new();
    let mut polygons = false;
    mesh.indices.reserve(element.count);
    for _ in 0..element.count {
        let start = cursor.at;
        cursor.row(element, format, &mut row, Some(corners), &mut polygon)?;
        let wrong = |problem: String, expected: &str, cursor: &Cursor<'_>| {
            Err(MeshError::new(problem, expected).on(cursor.position(format, start)))
        };
        if polygon.len() < 3 {
            let problem = format!("A face with {} corners", polygon.len());
            return wrong(problem, "expected at least 3 corners", cursor);
        }
        if let Some(bad) = polygon.iter().find(|&&index| !is_index(index)) {
            return wrong(format!("A face refers to vertex {bad}"), "expected indices from 0", cursor);
        }
        if polygon.len() > 3 && !attributes.is_empty() {
            let problem = format!("A face with {} corners has attributes", polygon.len());
            return wrong(problem, "expected triangles where faces have attributes", cursor);
        }
        polygons |= polygon.len() > 3;
        let first = polygon[0] as u32;
        mesh.indices.extend(polygon[1..].windows(2).map(|pair| [first, pair[0] as u32, pair[1] as u32]));
        for columns in &mut attributes {
            if !columns.push(&row) {
                let problem =
                    format!("A face has a value of \"{}\" that is not finite", columns.attribute.name);
                return wrong(problem, "expected finite numbers of single precision", cursor);
            }
        }
    }
    mesh.attributes.extend(attributes.into_iter().map(|columns| columns.attribute));
    Ok(polygons)
}
