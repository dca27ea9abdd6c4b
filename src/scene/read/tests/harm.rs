//! Files that mean harm: nothing panics, nothing takes long, nothing is allocated for a promise.

use super::super::meshes::MeshOptions;
use super::super::{obj, ply, serialized};
use super::read;
use crate::scene::{CompileOptions, ReadOptions, read_str};
use std::path::Path;
use std::time::{Duration, Instant};

const OPTIONS: [MeshOptions; 2] = [
    MeshOptions { face_normals: false, flip_tex_coords: true },
    MeshOptions { face_normals: true, flip_tex_coords: false },
];

const SCENE: &str = include_str!("everything.xml");

const OBJ: &str = "# all\nv 0 0 0\nv 1 0 0 1\nv 0 1 0\nv 1 1 0\nvt 0 1\nvn 0 0 1\no x\nf 1/1/1 2/1/1 4/1/1 3/1/1\nf -4/1/1 -3/1/1 -2/1/1\n";

const ASCII: &str = "ply\nformat ascii 1.0\ncomment c\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\nelement face 1\nproperty list uchar int vertex_indices\nproperty float quality\nend_header\n0 0 0 7\n1 0 0 7\n0 1 0 7\n3 0 1 2 0.5\n";

/// A square.
const SERIALIZED: &[u8] = include_bytes!("../../../../tests/scenes/broken/one.serialized");

/// Steele, Lea and Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014.
fn splitmix(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (*state ^ (*state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// A few bytes changed, left out, put in or doubled.
fn mutated(bytes: &[u8], state: &mut u64) -> Vec<u8> {
    const TOKENS: [&[u8]; 12] = [
        b"\"",
        b"<",
        b"/>",
        b"$",
        b"-1",
        b"1e308",
        b"nan",
        b"4294967295",
        b"999999999999",
        b":",
        b"\0",
        b"\xff",
    ];
    let mut bytes = bytes.to_vec();
    for _ in 0..=splitmix(state) % 4 {
        let at = (splitmix(state) as usize) % (bytes.len() + 1);
        let until = (at + (splitmix(state) as usize) % 9).min(bytes.len());
        match splitmix(state) % 5 {
            0 if at < bytes.len() => bytes[at] = splitmix(state) as u8,
            1 => drop(bytes.drain(at..until)),
            2 => {
                let copy = bytes[at..until].to_vec();
                bytes.splice(at..at, copy);
            }
            3 => {
                let token = TOKENS[(splitmix(state) as usize) % TOKENS.len()];
                bytes.splice(at..until, token.iter().copied());
            }
            _ => bytes.truncate(at.max(1)),
        }
    }
    bytes
}

fn within(limit: Duration, what: &str, run: impl FnOnce()) {
    let start = Instant::now();
    run();
    assert!(start.elapsed() < limit, "{what} took {:?}", start.elapsed());
}

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

#[test]
fn mutated_files_do_not_panic() {
    assert!(read(SCENE).is_ok(), "{}", read(SCENE).unwrap_err());
    let mut state = 20_261_121;
    within(Duration::from_secs(60), "all of it", || {
        for _ in 0..4000 {
            let bytes = mutated(SCENE.as_bytes(), &mut state);
            let text = String::from_utf8_lossy(&bytes);
            within(Duration::from_secs(5), &text, || drop(read(&text)));
        }
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
                        // Whatever is accepted can be traced.
                        crate::shape::Mesh::new(file.mesh).unwrap_or_else(|error| panic!("{error}"));
                    }
                }
            }
        }
    });
}

#[test]
fn deep_and_wide_scenes_end_quickly() {
    let deep = |element: &str, count: usize| {
        let open = format!("<{element} type=\"twosided\">").repeat(count);
        let close = format!("</{element}>").repeat(count);
        format!("<scene version=\"3.0.0\"><sensor type=\"perspective\"/>{open}{close}</scene>")
    };
    within(Duration::from_secs(5), "a deep scene", || {
        assert!(read(&deep("bsdf", 20_000)).unwrap_err().contains("nested more than"));
    });
    for (backwards, last) in [(false, 20_000), (true, 0)] {
        let link = |i| if backwards { (i + 1, i) } else { (i, i + 1) };
        let chain: String = (0..20_000)
            .map(link)
            .map(|(id, next)| format!("<bsdf type=\"twosided\" id=\"{id}\"><ref id=\"{next}\"/></bsdf>"))
            .collect();
        let chain = format!(
            "<scene version=\"3.0.0\"><sensor type=\"perspective\"/>{chain}<bsdf type=\"diffuse\" id=\"{last}\"/></scene>"
        );
        within(Duration::from_secs(20), "a chain of references", || {
            let options = ReadOptions::default();
            let errors = read_str(chain, Path::new("chain.xml"), &options).unwrap_err();
            let deep = errors.errors.iter().filter(|error| error.problem.contains("nested more than"));
            assert!(deep.count() > 0);
            assert!(errors.to_string().contains("more errors"));
        });
    }
    // Each object holds the one before twice.
    let twice = |count: usize| -> String {
        let link = |i| {
            let below = i - 1;
            format!(
                "<bsdf type=\"blendbsdf\" id=\"{i}\"><float name=\"weight\" value=\"0.5\"/><ref id=\"{below}\" name=\"a\"/><ref id=\"{below}\" name=\"b\"/></bsdf>"
            )
        };
        let links: String = (1..=count).map(link).collect();
        format!(
            "<bsdf type=\"diffuse\" id=\"0\"/>{links}<shape type=\"sphere\"><ref id=\"{count}\"/></shape>"
        )
    };
    within(Duration::from_secs(5), "objects within objects twice", || {
        let scene = super::scene(&twice(8));
        assert!(crate::scene::outline(&scene).contains("as above"));
        let compiled = crate::scene::compile(&scene, &CompileOptions::default()).unwrap();
        let text = crate::scene::json(&scene, &compiled.features(), None);
        assert_eq!(super::read(&text).unwrap().hash(), scene.hash());
        assert!(super::errors(&twice(60)).contains("more than 4096 objects"));
    });
    let doubling: String =
        (0..64).map(|i| format!("<default name=\"a{}\" value=\"$a{i}$a{i}\"/>", i + 1)).collect();
    let doubling = format!(
        "<scene version=\"3.0.0\"><sensor type=\"perspective\"/><default name=\"a0\" value=\"xxxx\"/>{doubling}</scene>"
    );
    within(Duration::from_secs(5), "doubling parameters", || drop(read(&doubling)));
}

#[test]
fn tables_stay_small_whatever_their_range() {
    let bounds = r#"<float name="wavelength_min" value="400"/><float name="wavelength_max" value="1e12"/>"#;
    let scene = super::scene(&format!(
        r#"<emitter type="constant"><spectrum name="radiance" type="blackbody"><float name="temperature" value="3000"/>{bounds}</spectrum></emitter>"#
    ));
    within(Duration::from_secs(5), "a black body of any range", || {
        assert!(crate::scene::compile(&scene, &CompileOptions::default()).is_ok());
    });
}
