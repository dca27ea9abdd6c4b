//! Mesh files of every kind, and such that mean harm.

use super::super::{obj, ply, serialized};
use super::MeshOptions;
use crate::mutation::{mutated, within};
use crate::shape::Mesh;
use std::time::Duration;

const OPTIONS: [MeshOptions; 2] = [
    MeshOptions { face_normals: false, flip_tex_coords: true },
    MeshOptions { face_normals: true, flip_tex_coords: false },
];

const OBJ: &str = "# all\nv 0 0 0\nv 1 0 0 1\nv 0 1 0\nv 1 1 0\nvt 0 1\nvn 0 0 1\no x\nf 1/1/1 2/1/1 4/1/1 3/1/1\nf -4/1/1 -3/1/1 -2/1/1\n";

const ASCII: &str = "ply\nformat ascii 1.0\ncomment c\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\nelement face 1\nproperty list uchar int vertex_indices\nproperty float quality\nend_header\n0 0 0 7\n1 0 0 7\n0 1 0 7\n3 0 1 2 0.5\n";

/// A square.
const SERIALIZED: &[u8] = include_bytes!("../../../../tests/scenes/broken/one.serialized");

fn binary_ply(big: bool) -> Vec<u8> {
    let order = if big { "big" } else { "little" };
    let mut bytes = format!(
        "ply\nformat binary_{order}_endian 1.0\nelement vertex 4\nproperty double x\nproperty float y\nproperty float z\n\
         property uchar red\nproperty list uchar short history\nproperty float nx\nproperty float ny\nproperty float nz\n\
         property float u\nproperty float v\nelement extra 1\nproperty list int double more\nelement face 2\n\
         property uchar flag\nproperty list uchar uint vertex_index\nend_header\n"
    )
    .into_bytes();
    let mut put = |little: &[u8]| {
        let mut little = little.to_vec();
        if big {
            little.reverse();
        }
        bytes.extend(little);
    };
    for (x, y) in [(0.0_f64, 0.0_f32), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
        put(&x.to_le_bytes());
        put(&y.to_le_bytes());
        put(&0.5_f32.to_le_bytes());
        put(&[9]);
        put(&[2]);
        put(&7_i16.to_le_bytes());
        put(&8_i16.to_le_bytes());
        for component in [0.0_f32, 0.0, 1.0, 0.25, y] {
            put(&component.to_le_bytes());
        }
    }
    put(&1_i32.to_le_bytes());
    put(&3.0_f64.to_le_bytes());
    for polygon in [&[0_u32, 1, 2, 3][..], &[0, 2, 3]] {
        put(&[1]);
        put(&[polygon.len() as u8]);
        for index in polygon {
            put(&index.to_le_bytes());
        }
    }
    bytes
}

#[test]
fn ply_is_read_in_every_format() {
    for big in [false, true] {
        let mesh = ply::read(&binary_ply(big), OPTIONS[0]).unwrap().mesh;
        assert_eq!(mesh.positions, [[0.0, 0.0, 0.5], [1.0, 0.0, 0.5], [1.0, 1.0, 0.5], [0.0, 1.0, 0.5]]);
        assert_eq!(mesh.indices, [[0, 1, 2], [0, 2, 3], [0, 2, 3]]);
        assert_eq!(mesh.normals.unwrap(), [[0.0, 0.0, 1.0]; 4]);
        assert_eq!(mesh.uvs.unwrap(), [[0.25, 1.0], [0.25, 1.0], [0.25, 0.0], [0.25, 0.0]]);
        let flat = ply::read(&binary_ply(big), OPTIONS[1]).unwrap().mesh;
        assert!(flat.normals.is_none());
        assert_eq!(flat.uvs.unwrap()[2], [0.25, 1.0]);
    }
    for text in [ASCII.to_owned(), ASCII.replace('\n', "\r\n")] {
        let mesh = ply::read(text.as_bytes(), OPTIONS[0]).unwrap().mesh;
        assert_eq!(mesh.positions, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        assert_eq!(mesh.indices, [[0, 1, 2]]);
    }
}

#[test]
fn a_truncated_ply_is_refused_wherever_it_ends() {
    for bytes in [binary_ply(false), binary_ply(true), ASCII.as_bytes().to_vec()] {
        for length in 0..bytes.len() - 4 {
            assert!(ply::read(&bytes[..length], OPTIONS[0]).is_err(), "{length} of {} bytes", bytes.len());
        }
    }
}

#[test]
fn counts_are_not_trusted() {
    let header = |vertices: &str, faces: &str| {
        format!(
            "ply\nformat binary_little_endian 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\nelement face {faces}\nproperty list uint int vertex_indices\nend_header\n"
        )
    };
    for (vertices, faces) in [("18446744073709551615", "1"), ("4000000000", "1"), ("0", "4000000000")] {
        assert!(ply::read(header(vertices, faces).as_bytes(), OPTIONS[0]).is_err());
    }
    let mut long_list = header("0", "1").into_bytes();
    long_list.extend(u32::MAX.to_le_bytes());
    assert!(ply::read(&long_list, OPTIONS[0]).is_err());
}

/// Whatever is accepted can be traced.
#[test]
fn mutated_files_do_not_panic() {
    let mut state = 20_261_121;
    within(Duration::from_secs(60), "all of it", || {
        for _ in 0..20_000 {
            for original in
                [OBJ.as_bytes(), ASCII.as_bytes(), &binary_ply(false), &binary_ply(true), SERIALIZED]
            {
                let bytes = mutated(original, &mut state);
                for options in OPTIONS {
                    let meshes = [
                        obj::read(&bytes, options),
                        ply::read(&bytes, options),
                        serialized::read(&bytes, 0, options),
                    ];
                    for file in meshes.into_iter().flatten().filter(|file| !file.mesh.indices.is_empty()) {
                        Mesh::new(file.mesh).unwrap_or_else(|error| panic!("{error}"));
                    }
                }
            }
        }
    });
}
