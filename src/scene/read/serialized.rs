//! Mitsuba's `serialized`: several meshes in a file, each compressed with zlib (RFC 1950).
//!
//! A mesh begins with a magic number and a version (3 or 4), 16 bits each; all else is compressed: flags, in
//! version 4 a name that ends with a zero, the numbers of vertices and triangles (64 bits), positions,
//! normals, texture coordinates and colours of the vertices as far as the flags tell of them, three indices
//! (32 bits) for each triangle. The file ends with the offsets of the meshes (64 bits each, 32 in version 3)
//! and their number (32 bits). All is little endian.

use super::meshes::{MeshError, MeshFile, MeshOptions, MeshResult, Position};
use crate::shape::MeshData;
use flate2::bufread::ZlibDecoder;
use std::io::Read;

const MAGIC: u16 = 0x041c;

const NORMALS: u32 = 0x1;
const TEXTURE_COORDINATES: u32 = 0x2;
const COLOURS: u32 = 0x8;
/// Without it numbers have single precision, whether or not the flag of that is there.
const DOUBLE: u32 = 0x2000;

/// No mesh is compressed better than this; a file that claims to be is a trap for the memory.
const BEST_COMPRESSION: u64 = 100;
/// So much may always be unpacked, in bytes.
const FREE: u64 = 1 << 20;

/// The mesh number `shape_index`.
pub(super) fn read(bytes: &[u8], shape_index: u32, options: MeshOptions) -> MeshResult {
    let (mut start, version) = (0, header(bytes, 0)?);
    // The first needs no dictionary.
    if shape_index > 0 {
        start = offset(bytes, version, shape_index)?;
        header(bytes, start)?;
    }
    let packed = &bytes[start + 4..];
    let mesh = unpack(packed, version, options).map_err(|error| error.on(Position::Byte(start)))?;
    Ok(MeshFile { mesh, extension: None })
}

/// The version of the mesh at `start`.
fn header(bytes: &[u8], start: usize) -> Result<u16, MeshError> {
    let at = |offset: usize| {
        let pair = bytes.get(start..)?.get(offset..offset + 2)?;
        Some(u16::from_le_bytes([pair[0], pair[1]]))
    };
    match (at(0), at(2)) {
        (Some(MAGIC), Some(version @ (3 | 4))) => Ok(version),
        (Some(MAGIC), Some(version)) => Err(MeshError::new(
            format!("The mesh is of version {version}"),
            "expected version 3 or 4 of Mitsuba's serialized format",
        )),
        _ => Err(MeshError::new(
            "No mesh begins here",
            "expected a file in Mitsuba's serialized format, which begins with the bytes 1c 04",
        )
        .on(Position::Byte(start))),
    }
}

/// Where the mesh begins, by the dictionary at the end of the file.
fn offset(bytes: &[u8], version: u16, index: u32) -> Result<usize, MeshError> {
    let width = if version == 4 { 8 } else { 4 };
    let number = |at: usize, width: usize| {
        let mut digits = [0; 8];
        digits[..width].copy_from_slice(bytes.get(at..)?.get(..width)?);
        usize::try_from(u64::from_le_bytes(digits)).ok()
    };
    let end = bytes.len().saturating_sub(4);
    let count = number(end, 4).unwrap_or(0);
    if index as usize >= count {
        return Err(MeshError::new(
            format!("There is no mesh {index}"),
            format!("expected a shape_index below {count}, the number of meshes in the file"),
        ));
    }
    let entry = count.checked_mul(width).and_then(|size| end.checked_sub(size));
    let found = entry.and_then(|first| number(first + index as usize * width, width));
    found.filter(|&start| start < end).ok_or_else(|| {
        MeshError::new(
            format!("The place of mesh {index} lies outside the file"),
            "expected offsets of the meshes at the end of the file",
        )
    })
}

fn unpack(packed: &[u8], version: u16, options: MeshOptions) -> Result<MeshData, MeshError> {
    let mut stream = Stream { decoder: ZlibDecoder::new(packed), double: false };
    let flags = u32::from_le_bytes(stream.array()?);
    stream.double = flags & DOUBLE != 0;
    if version == 4 {
        stream.skip_name()?;
    }
    let counts = [u64::from_le_bytes(stream.array()?), u64::from_le_bytes(stream.array()?)];
    let [vertices, triangles] =
        counts.map(|count| u32::try_from(count).ok().filter(|&count| count < u32::MAX));
    let number = if stream.double { 8 } else { 4 };
    let given = |flag: u32, numbers: u64| if flags & flag == 0 { 0 } else { numbers };
    let numbers = 3 + given(NORMALS, 3) + given(TEXTURE_COORDINATES, 2) + given(COLOURS, 3);
    let most = BEST_COMPRESSION * packed.len() as u64 + FREE;
    let fits = |vertices: u32, triangles: u32| {
        u64::from(vertices) * numbers * number + u64::from(triangles) * 12 <= most
    };
    let (Some(vertices), Some(triangles)) = (vertices, triangles) else {
        return Err(too_many(counts));
    };
    if !fits(vertices, triangles) {
        return Err(too_many(counts));
    }
    let positions = stream.vectors(vertices, "position")?;
    let normals = if flags & NORMALS == 0 { None } else { Some(stream.vectors(vertices, "normal")?) };
    let uvs = match flags & TEXTURE_COORDINATES {
        0 => None,
        _ => Some(stream.vectors(vertices, "texture coordinate")?),
    };
    if flags & COLOURS != 0 {
        // Mitsuba 3 makes no attribute of them.
        let _: Vec<[f32; 3]> = stream.vectors(vertices, "colour")?;
    }
    let indices = stream.indices(vertices, triangles)?;
    let normals = normals.filter(|_| !options.face_normals);
    Ok(MeshData { positions, indices, normals, uvs, ..MeshData::default() })
}

fn too_many([vertices, triangles]: [u64; 2]) -> MeshError {
    MeshError::new(
        format!(
            "The mesh has {vertices} vertices and {triangles} triangles, but the file is too short for them"
        ),
        "expected fewer, or a longer file",
    )
}

/// What comes out of the compression.
struct Stream<'a> {
    decoder: ZlibDecoder<&'a [u8]>,
    double: bool,
}

impl Stream<'_> {
    fn array<const N: usize>(&mut self) -> Result<[u8; N], MeshError> {
        let mut array = [0; N];
        self.decoder.read_exact(&mut array).map_err(|error| damaged(&error))?;
        Ok(array)
    }

    fn skip_name(&mut self) -> Result<(), MeshError> {
        for _ in 0..1 << 16 {
            if self.array()? == [0] {
                return Ok(());
            }
        }
        Err(MeshError::new("The name of the mesh does not end", "expected fewer than 65536 bytes and a zero"))
    }

    fn bytes(&mut self, count: u64) -> Result<Vec<u8>, MeshError> {
        let mut bytes = Vec::new();
        let found =
            (&mut self.decoder).take(count).read_to_end(&mut bytes).map_err(|error| damaged(&error))?;
        if found as u64 == count {
            return Ok(bytes);
        }
        Err(MeshError::new(
            "The mesh ends too early",
            "expected as many vertices and triangles as it promises",
        ))
    }

    fn vectors<const N: usize>(&mut self, count: u32, what: &str) -> Result<Vec<[f32; N]>, MeshError> {
        let width = if self.double { 8 } else { 4 };
        let bytes = self.bytes(u64::from(count) * (N * width) as u64)?;
        let number = |item: &[u8]| {
            let mut digits = [0; 8];
            digits[..width].copy_from_slice(item);
            match self.double {
                true => f64::from_le_bytes(digits) as f32,
                false => f32::from_bits(u64::from_le_bytes(digits) as u32),
            }
        };
        let vector = |item: &[u8]| std::array::from_fn(|i| number(&item[i * width..(i + 1) * width]));
        let vectors: Vec<[f32; N]> = bytes.chunks_exact(N * width).map(vector).collect();
        match vectors.iter().position(|vector| !vector.iter().all(|x| x.is_finite())) {
            None => Ok(vectors),
            Some(vertex) => Err(MeshError::new(
                format!("The {what} of vertex {vertex} is not finite"),
                "expected finite numbers of single precision",
            )),
        }
    }

    fn indices(&mut self, vertices: u32, triangles: u32) -> Result<Vec<[u32; 3]>, MeshError> {
        let bytes = self.bytes(u64::from(triangles) * 12)?;
        let index = |item: &[u8]| u32::from_le_bytes([item[0], item[1], item[2], item[3]]);
        let corners = |item: &[u8]| [index(item), index(&item[4..]), index(&item[8..])];
        let indices: Vec<[u32; 3]> = bytes.chunks_exact(12).map(corners).collect();
        let wrong = |(triangle, corners): (usize, &[u32; 3])| {
            Some((triangle, *corners.iter().find(|&&index| index >= vertices)?))
        };
        match indices.iter().enumerate().find_map(wrong) {
            None => Ok(indices),
            Some((triangle, index)) => Err(MeshError::new(
                format!("Triangle {triangle} refers to vertex {index}, but there are {vertices} vertices"),
                "expected indices from 0 to one less than the number of vertices",
            )),
        }
    }
}

fn damaged(error: &std::io::Error) -> MeshError {
    MeshError::new(
        format!("The compressed data is damaged: {error}"),
        "expected zlib data as Mitsuba writes it",
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::Compression;
    use flate2::write::ZlibEncoder;
    use std::io::Write;

    const SINGLE: u32 = 0x1000;
    const SMOOTH: MeshOptions = MeshOptions { face_normals: false, flip_tex_coords: false };

    /// A folded square, as written for Mitsuba 3.9.1, which read the same numbers from it.
    fn packed(version: u16, flags: u32, counts: [u64; 2]) -> Vec<u8> {
        let mut data = flags.to_le_bytes().to_vec();
        if version == 4 {
            data.extend("a näme\0".bytes());
        }
        data.extend(counts.into_iter().flat_map(u64::to_le_bytes));
        let positions = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.5];
        let normals = [0.0, 0.0, 2.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
        let uvs = [0.0, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875];
        let given = |flag: u32, values: &[f64]| if flags & flag == 0 { Vec::new() } else { values.to_vec() };
        let all = [
            positions.to_vec(),
            given(NORMALS, &normals),
            given(TEXTURE_COORDINATES, &uvs),
            given(COLOURS, &[0.5; 12]),
        ];
        for value in all.concat() {
            if flags & DOUBLE == 0 {
                data.extend((value as f32).to_le_bytes());
            } else {
                data.extend(value.to_le_bytes());
            }
        }
        data.extend([0u32, 1, 2, 0, 2, 3].into_iter().flat_map(u32::to_le_bytes));
        let mut bytes = [MAGIC.to_le_bytes(), version.to_le_bytes()].concat();
        let mut encoder = ZlibEncoder::new(&mut bytes, Compression::default());
        encoder.write_all(&data).unwrap();
        encoder.finish().unwrap();
        bytes
    }

    fn file(version: u16, meshes: &[Vec<u8>]) -> Vec<u8> {
        let starts = meshes.iter().scan(0u64, |end, mesh| {
            *end += mesh.len() as u64;
            Some(*end - mesh.len() as u64)
        });
        let width = if version == 4 { 8 } else { 4 };
        let dictionary = starts.flat_map(|start| start.to_le_bytes().into_iter().take(width));
        let dictionary: Vec<u8> = dictionary.collect();
        [meshes.concat(), dictionary, (meshes.len() as u32).to_le_bytes().to_vec()].concat()
    }

    #[test]
    fn both_versions_and_precisions_are_read() {
        for version in [3, 4] {
            for precision in [0, SINGLE, DOUBLE, SINGLE | DOUBLE] {
                let all = precision | NORMALS | TEXTURE_COORDINATES | COLOURS;
                let file = file(version, &[packed(version, precision, [4, 2]), packed(version, all, [4, 2])]);
                let plain = read(&file, 0, SMOOTH).unwrap().mesh;
                assert!(plain.normals.is_none() && plain.uvs.is_none());
                let mesh = read(&file, 1, SMOOTH).unwrap().mesh;
                for mesh in [&plain, &mesh] {
                    let expected = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.5]];
                    assert_eq!(mesh.positions, expected);
                    assert_eq!(mesh.indices, [[0, 1, 2], [0, 2, 3]]);
                }
                assert_eq!(mesh.normals.as_ref().unwrap()[1], [0.0, 1.0, 1.0]);
                assert_eq!(mesh.uvs.as_ref().unwrap()[3], [0.75, 0.875]);
                assert!(mesh.attributes.is_empty());
                let flat = MeshOptions { face_normals: true, ..SMOOTH };
                assert!(read(&file, 1, flat).unwrap().mesh.normals.is_none());
                assert!(read(&file, 2, SMOOTH).is_err());
            }
        }
    }

    #[test]
    fn what_is_cut_or_lies_is_refused() {
        let whole = packed(4, SINGLE | NORMALS, [4, 2]);
        assert!(read(&whole, 0, SMOOTH).is_ok());
        // The last bytes are a checksum of what was read already.
        for length in 0..whole.len() - 5 {
            assert!(read(&whole[..length], 0, SMOOTH).is_err(), "{length} of {}", whole.len());
        }
        for counts in [[5, 2], [4, 3], [1 << 60, 2], [4, u64::MAX], [1 << 31, 2], [3, 2], [0, 0]] {
            assert_eq!(read(&packed(4, SINGLE, counts), 0, SMOOTH).is_err(), counts != [0, 0], "{counts:?}");
        }
        assert!(read(&packed(5, SINGLE, [4, 2]), 0, SMOOTH).is_err());
    }
}
