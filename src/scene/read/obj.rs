//! Wavefront OBJ: positions, texture coordinates, normals and polygons.
//!
//! Polygons become fans from their first corner. Names, groups, smoothing groups and materials mean nothing
//! here, as in Mitsuba 3: a shape has one BSDF. Points and lines have no surface and are passed over.

use super::meshes::{MeshError, MeshFile, MeshOptions, MeshResult, Position};
use crate::shape::MeshData;
use std::collections::HashMap;

/// No index: the corner has no texture coordinates, or no normal.
const NONE: u32 = u32::MAX;

/// So many vertices with one position are looked through one by one.
const FEW: usize = 32;

/// One corner of a face: indices of position, texture coordinates and normal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Corner {
    position: u32,
    uv: u32,
    normal: u32,
}

/// A vertex made so far, and the previous one with the same position.
#[derive(Clone, Copy, Debug)]
struct Vertex {
    corner: Corner,
    previous: u32,
}

#[derive(Debug, Default)]
struct File {
    positions: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    normals: Vec<[f32; 3]>,
    vertices: Vec<Vertex>,
    /// For each position, the vertex made last with it.
    latest: Vec<u32>,
    /// The vertices with positions that more than [`FEW`] of them share, such as the tip of a cone.
    crowded: HashMap<Corner, u32>,
    indices: Vec<[u32; 3]>,
    with_normal: bool,
    without_normal: bool,
    negative: bool,
}

pub(super) fn read(bytes: &[u8], options: MeshOptions) -> MeshResult {
    let mut file = File::default();
    let mut corners = Vec::new();
    for (number, line) in bytes.split(|&byte| byte == b'\n').enumerate() {
        file.line(line, &mut corners).map_err(|error| error.on(Position::Line(number + 1)))?;
    }
    Ok(file.finish(options))
}

impl File {
    fn line(&mut self, line: &[u8], corners: &mut Vec<u32>) -> Result<(), MeshError> {
        let line = line.split(|&byte| byte == b'#').next().unwrap_or(&[]);
        let mut words = line.split(|byte| byte.is_ascii_whitespace()).filter(|word| !word.is_empty());
        match words.next() {
            None => Ok(()),
            Some(b"v") => {
                self.positions.push(floats(&mut words, "expected 3 coordinates after v")?);
                self.latest.push(NONE);
                Ok(())
            }
            Some(b"vt") => {
                // A one-dimensional coordinate has no v.
                let u = float(words.next(), "expected 2 texture coordinates after vt")?;
                let v = words.next().map_or(Ok(0.0), |word| float(Some(word), "expected a number"))?;
                self.uvs.push([u, v]);
                Ok(())
            }
            Some(b"vn") => {
                self.normals.push(floats(&mut words, "expected 3 components after vn")?);
                Ok(())
            }
            Some(b"f") => {
                corners.clear();
                for word in words {
                    let corner = self.corner(word)?;
                    corners.push(self.vertex(corner)?);
                }
                if corners.len() < 3 {
                    let problem = format!("A face with {} corners", corners.len());
                    return Err(MeshError::new(problem, "expected at least 3 corners after f"));
                }
                let fan = corners[1..].windows(2).map(|pair| [corners[0], pair[0], pair[1]]);
                self.indices.extend(fan);
                Ok(())
            }
            Some(
                b"o" | b"g" | b"s" | b"usemtl" | b"mtllib" | b"p" | b"l" | b"vp" | b"mg" | b"usemap"
                | b"maplib" | b"bevel" | b"c_interp" | b"d_interp" | b"lod" | b"shadow_obj" | b"trace_obj",
            ) => Ok(()),
            Some(other) => Err(MeshError::new(
                format!("\"{}\" is not known in an OBJ file", String::from_utf8_lossy(other)),
                "expected v, vt, vn, f, o, g, s, usemtl, mtllib, p or l at the beginning of a line",
            )),
        }
    }

    /// `position`, `position/uv`, `position//normal` or `position/uv/normal`.
    fn corner(&mut self, word: &[u8]) -> Result<Corner, MeshError> {
        self.negative |= word.contains(&b'-');
        let mut parts = word.split(|&byte| byte == b'/');
        let position = index(parts.next().unwrap_or(&[]), self.positions.len(), "position")?;
        let optional = |part: Option<&[u8]>, count: usize, what: &str| match part {
            None | Some([]) => Ok(NONE),
            Some(part) => index(part, count, what),
        };
        let uv = optional(parts.next(), self.uvs.len(), "texture coordinate")?;
        let normal = optional(parts.next(), self.normals.len(), "normal")?;
        if parts.next().is_some() {
            let problem = format!("\"{}\" is not a corner of a face", String::from_utf8_lossy(word));
            return Err(MeshError::new(problem, "expected position/uv/normal"));
        }
        self.with_normal |= normal != NONE;
        self.without_normal |= normal == NONE;
        if self.with_normal && self.without_normal {
            return Err(MeshError::new(
                "Some corners have a normal and others have none",
                "expected normals at all corners or at none",
            ));
        }
        Ok(Corner { position, uv, normal })
    }

    /// The vertex with exactly these attributes, made where there is none yet.
    fn vertex(&mut self, corner: Corner) -> Result<u32, MeshError> {
        let (mut candidate, mut passed) = (self.latest[corner.position as usize], 0);
        while candidate != NONE && passed < FEW {
            let vertex = self.vertices[candidate as usize];
            if vertex.corner == corner {
                return Ok(candidate);
            }
            (candidate, passed) = (vertex.previous, passed + 1);
        }
        let was_crowded = candidate != NONE;
        if let Some(&known) = self.crowded.get(&corner).filter(|_| was_crowded) {
            return Ok(known);
        }
        let made = u32::try_from(self.vertices.len()).ok().filter(|&made| made != NONE);
        let made =
            made.ok_or_else(|| MeshError::new("The mesh has too many vertices", "expected fewer than 2^32"))?;
        let latest = &mut self.latest[corner.position as usize];
        self.vertices.push(Vertex { corner, previous: *latest });
        *latest = made;
        if passed == FEW {
            let previous = |&index: &u32| Some(self.vertices[index as usize].previous);
            let all = std::iter::successors(Some(made), previous).take_while(|&index| index != NONE);
            let new = all.take(if was_crowded { 1 } else { FEW + 1 });
            self.crowded.extend(new.map(|index| (self.vertices[index as usize].corner, index)));
        }
        Ok(made)
    }

    fn finish(self, options: MeshOptions) -> MeshFile {
        let with_uv = self.vertices.iter().any(|vertex| vertex.corner.uv != NONE);
        let uv = |index: u32| match self.uvs.get(index as usize) {
            Some(&[u, v]) if options.flip_tex_coords => [u, 1.0 - v],
            Some(&uv) => uv,
            None => [0.0; 2],
        };
        let corners = || self.vertices.iter().map(|vertex| vertex.corner);
        let with_normals = self.with_normal && !options.face_normals;
        let mesh = MeshData {
            positions: corners().map(|corner| self.positions[corner.position as usize]).collect(),
            normals: with_normals
                .then(|| corners().map(|corner| self.normals[corner.normal as usize]).collect()),
            uvs: with_uv.then(|| corners().map(|corner| uv(corner.uv)).collect()),
            indices: self.indices,
            ..MeshData::default()
        };
        let extension =
            self.negative.then_some("negative indices, which count backwards; Mitsuba 3 refuses them");
        MeshFile { mesh, extension }
    }
}

/// An index from 1, or from −1 backwards from the latest.
fn index(word: &[u8], count: usize, what: &str) -> Result<u32, MeshError> {
    let text = String::from_utf8_lossy(word);
    let number: Option<i64> = text.parse().ok();
    let found = match number {
        Some(number) if number > 0 => usize::try_from(number - 1).ok(),
        Some(number) if number < 0 => {
            usize::try_from(number.unsigned_abs()).ok().and_then(|back| count.checked_sub(back))
        }
        _ => None,
    };
    let found = found.filter(|&found| found < count).and_then(|found| u32::try_from(found).ok());
    found.filter(|&found| found != NONE).ok_or_else(|| match number {
        Some(_) => MeshError::new(
            format!("A face refers to {what} {text}, but there are {count} so far"),
            format!("expected an index from 1 to {count}, or a negative one that counts backwards"),
        ),
        None => MeshError::new(format!("\"{text}\" is not an index"), "expected whole numbers after f"),
    })
}

fn floats<'a, const N: usize>(
    words: &mut impl Iterator<Item = &'a [u8]>,
    expected: &str,
) -> Result<[f32; N], MeshError> {
    let mut numbers = [0.0; N];
    for number in &mut numbers {
        *number = float(words.next(), expected)?;
    }
    Ok(numbers)
}

fn float(word: Option<&[u8]>, expected: &str) -> Result<f32, MeshError> {
    let Some(word) = word else { return Err(MeshError::new("A number is missing", expected)) };
    let number = std::str::from_utf8(word).ok().and_then(|text| text.parse::<f32>().ok());
    number.filter(|number| number.is_finite()).ok_or_else(|| {
        MeshError::new(format!("\"{}\" is not a finite number", String::from_utf8_lossy(word)), expected)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLAIN: MeshOptions = MeshOptions { face_normals: false, flip_tex_coords: false };

    fn error(text: &str) -> String {
        format!("{:?}", read(text.as_bytes(), PLAIN).unwrap_err())
    }

    /// A vertex is made once, also where hundreds have one position: a cone's tip with texture coordinates.
    #[test]
    fn corners_that_are_the_same_are_one_vertex() {
        let sides = 4 * FEW;
        let mut text = "v 0 0 1\n".to_owned();
        for side in 0..sides {
            text += &format!("v {side} 1 0\nvt {side} 0\n");
        }
        // Each side twice: the second time nothing is new.
        for side in (0..sides).chain(0..sides) {
            let next = (side + 1) % sides;
            text += &format!("f 1/{} {}/{} {}/{}\n", side + 1, side + 2, side + 1, next + 2, next + 1);
        }
        let mesh = read(text.as_bytes(), PLAIN).unwrap().mesh;
        assert_eq!((mesh.positions.len(), mesh.indices.len()), (2 * sides, 2 * sides));
        assert_eq!(mesh.indices[..sides], mesh.indices[sides..]);
    }

    #[test]
    fn polygons_become_fans_and_indices_may_be_negative() {
        let text = "# a fan\nmtllib m.mtl\no x\ng y\ns 1\nv 0 0 0\nv 1 0 0 1\r\nv 1 1 0\nv 0 1 0\nusemtl m\nf 1 2 3 4\nf -4 -3 -2 # again\nl 1 2\n";
        let mesh = read(text.as_bytes(), PLAIN).unwrap().mesh;
        assert_eq!(mesh.positions, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]);
        assert_eq!(mesh.indices, [[0, 1, 2], [0, 2, 3], [0, 1, 2]]);
        assert!(mesh.normals.is_none() && mesh.uvs.is_none());
    }

    #[test]
    fn a_vertex_is_made_for_each_combination() {
        let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0.25\nvt 1 0.5\nvn 0 0 2\nf 1/1/1 2/1/1 3/1/1\nf 1/2/1 2/1/1 3/1/1\n";
        let mesh = read(text.as_bytes(), PLAIN).unwrap().mesh;
        assert_eq!(mesh.indices, [[0, 1, 2], [3, 1, 2]]);
        assert_eq!(mesh.uvs.unwrap(), [[0.0, 0.25], [0.0, 0.25], [0.0, 0.25], [1.0, 0.5]]);
        assert_eq!(mesh.normals.unwrap(), [[0.0, 0.0, 2.0]; 4]);
        let flipped = MeshOptions { face_normals: true, flip_tex_coords: true };
        let mesh = read(text.as_bytes(), flipped).unwrap().mesh;
        assert_eq!(mesh.uvs.unwrap()[3], [1.0, 0.5]);
        assert!(mesh.normals.is_none());
    }

    #[test]
    fn errors_name_the_line() {
        assert!(error("v 0 0 0\nv 1 0 0\nf 1 2 3\n").contains("Line(3)"));
        assert!(error("v 0 0 x\n").contains("\\\"x\\\" is not a finite number"));
        assert!(error("v 0 0\n").contains("expected 3 coordinates"));
        assert!(error("v 0 0 0\nf 1 1\n").contains("2 corners"));
        assert!(error("v 0 0 0\nf 0 1 1\n").contains("position 0"));
        assert!(error("v 0 0 0\nf 1 1 -2\n").contains("position -2"));
        assert!(error("v 0 0 0\nvn 0 0 1\nf 1//1 1 1//1\n").contains("others have none"));
        assert!(error("curv 1 2\n").contains("not known"));
        assert!(error("v 0 0 nan\n").contains("finite"));
    }
}
