//! Binary rows that are all of one length: each has its place, so that they can be read by several threads.

use super::{Cursor, Element, Format, Property, Scalar};
use rayon::prelude::*;

/// Fewer rows are not worth a thread.
const LEAST: usize = 1 << 12;

/// All rows of an element.
pub(super) struct Rows<'a> {
    bytes: &'a [u8],
    length: usize,
    big: bool,
}

/// Where a property's number is in a row.
#[derive(Clone, Copy)]
pub(super) struct Column {
    offset: usize,
    scalar: Scalar,
}

impl<'a> Rows<'a> {
    /// So many rows of that length from where `cursor` is; `None` where the file is text, or ends before.
    fn new(cursor: &Cursor<'a>, format: Format, length: usize, count: usize) -> Option<Self> {
        let end = cursor.at.checked_add(length.checked_mul(count)?)?;
        let bytes = cursor.bytes.get(cursor.at..end)?;
        (format != Format::Ascii && length > 0).then_some(Self { bytes, length, big: format == Format::Big })
    }

    /// The rows of an element without lists, and the places of all its properties.
    pub fn of_numbers(cursor: &Cursor<'a>, format: Format, element: &Element) -> Option<(Self, Vec<Column>)> {
        let mut length = 0;
        let mut columns = Vec::with_capacity(element.properties.len());
        for Property { list, scalar, .. } in &element.properties {
            if list.is_some() {
                return None;
            }
            columns.push(Column { offset: length, scalar: *scalar });
            length += scalar.size();
        }
        Some((Self::new(cursor, format, length, element.count)?, columns))
    }

    /// The rows of an element that is but one list of three numbers in each, and the places of these.
    pub fn of_triples(cursor: &Cursor<'a>, format: Format, element: &Element) -> Option<(Self, [Column; 3])> {
        let [Property { list: Some(count), scalar, .. }] = &element.properties[..] else { return None };
        let length = count.size() + 3 * scalar.size();
        let rows = Self::new(cursor, format, length, element.count)?;
        let columns =
            std::array::from_fn(|i| Column { offset: count.size() + i * scalar.size(), scalar: *scalar });
        rows.all([Column { offset: 0, scalar: *count }], |count| count == 3.0).then_some((rows, columns))
    }

    /// How many bytes they are.
    pub fn size(&self) -> usize {
        self.bytes.len()
    }

    /// Whether something is true of all numbers of some columns.
    pub fn all<const N: usize>(&self, columns: [Column; N], is: impl Fn(f64) -> bool + Sync) -> bool {
        let rows = self.bytes.par_chunks_exact(self.length).with_min_len(LEAST);
        rows.all(|row| columns.iter().all(|column| is(column.of(row, self.big))))
    }

    /// Something of some columns of each row, in order.
    pub fn map<const N: usize, T: Send>(
        &self,
        columns: [Column; N],
        value: impl Fn([f64; N]) -> T + Sync,
    ) -> Vec<T> {
        let rows = self.bytes.par_chunks_exact(self.length).with_min_len(LEAST);
        rows.map(|row| value(columns.map(|column| column.of(row, self.big)))).collect()
    }
}

impl Column {
    #[inline]
    fn of(self, row: &[u8], big: bool) -> f64 {
        self.scalar.value(&row[self.offset..], big)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{MeshOptions, read};
    use crate::shape::MeshData;

    /// A strip of triangles, with normals and texture coordinates, in a file in which `more` is behind each
    /// face.
    fn strip(big: bool, triangles: u32, more: Option<u8>) -> Vec<u8> {
        let order = if big { "big" } else { "little" };
        let flag = if more.is_some() { "property uchar flag\n" } else { "" };
        let mut bytes = format!(
            "ply\nformat binary_{order}_endian 1.0\nelement vertex {}\nproperty float x\nproperty double y\nproperty float z\n\
             property short s_5\nproperty float u\nproperty float v\nproperty float nx\nproperty float ny\nproperty float nz\n\
             element face {triangles}\nproperty list uchar uint vertex_indices\n{flag}end_header\n",
            triangles + 2
        )
        .into_bytes();
        let mut put = |little: &[u8]| match big {
            true => bytes.extend(little.iter().rev()),
            false => bytes.extend(little),
        };
        for vertex in 0..triangles + 2 {
            let x = vertex as f32;
            put(&x.to_le_bytes());
            put(&(0.1 * f64::from(x)).to_le_bytes());
            put(&(-x).to_le_bytes());
            put(&7_i16.to_le_bytes());
            for value in [0.25, 0.125 * x, x + 1.0, x + 2.0, x + 3.0] {
                put(&value.to_le_bytes());
            }
        }
        for triangle in 0..triangles {
            put(&[3]);
            for index in triangle..triangle + 3 {
                put(&index.to_le_bytes());
            }
            more.into_iter().for_each(|flag| put(&[flag]));
        }
        bytes
    }

    const OPTIONS: MeshOptions = MeshOptions { face_normals: false, flip_tex_coords: true };

    fn mesh(bytes: &[u8]) -> MeshData {
        read(bytes, OPTIONS).unwrap().mesh
    }

    #[test]
    fn rows_read_at_once_are_those_read_one_by_one() {
        for (big, count) in [(false, 1), (true, 7), (false, 20_000)] {
            let (at_once, one_by_one) = (mesh(&strip(big, count, None)), mesh(&strip(big, count, Some(1))));
            assert_eq!(at_once.positions.len(), count as usize + 2);
            assert_eq!(at_once.positions[2], [2.0, 0.2, -2.0]);
            assert_eq!(at_once.normals.as_ref().unwrap()[1], [2.0, 3.0, 4.0]);
            assert_eq!(at_once.uvs.unwrap()[1], [0.25, 0.875]);
            assert_eq!(at_once.normals, one_by_one.normals);
            let expected: Vec<_> = (0..count).map(|first| [first, first + 1, first + 2]).collect();
            assert_eq!(at_once.indices, expected);
            assert_eq!(one_by_one.indices, expected);
        }
    }

    /// What is wrong in one row of many is said as if they were read one by one.
    #[test]
    fn what_is_wrong_is_said_with_its_place() {
        let count = 10_000;
        let whole = strip(false, count, None);
        let faces = whole.len() - 13 * count as usize;
        let vertex = faces - 38 * (count as usize + 2);
        let with = |at: usize, value: &[u8]| {
            let mut bytes = whole.clone();
            bytes[at..at + value.len()].copy_from_slice(value);
            format!("{:?}", read(&bytes, OPTIONS).unwrap_err())
        };
        let message = with(vertex + 38 * 5000, &f32::NAN.to_le_bytes());
        assert!(
            message.contains("Vertex 5000") && message.contains(&format!("Byte({})", vertex + 38 * 5000))
        );
        let message = with(faces + 13 * 7000, &[2]);
        assert!(message.contains("2 corners") && message.contains(&format!("Byte({})", faces + 13 * 7000)));
        let message = with(faces + 13 * 7000 + 5, &u32::MAX.to_le_bytes());
        assert!(message.contains("vertex 4294967295"), "{message}");
        let message = with(faces + 13 * 7000 + 5, &20_000_u32.to_le_bytes());
        assert!(message.contains("vertex 20000") && message.contains("triangle 7000"), "{message}");
        assert!(read(&whole[..whole.len() - 1], OPTIONS).is_err());
    }
}
