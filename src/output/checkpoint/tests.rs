use super::*;
use crate::output::Colour;

/// Header of a whole picture that is made at once.
pub(super) fn header(size: [u32; 2], samples_per_pixel: u64) -> Header {
    let film = Film::new(size[0], size[1], 2, Extras::default(), FixedPoint::SHARE);
    let part = RenderPart { region: Region::whole(size), samples: 0..samples_per_pixel };
    Header {
        identity: [("build", "1"), ("seed", "0")].map(|(a, b)| (a.to_owned(), b.to_owned())).to_vec(),
        picture: Description {
            content: Content::Colour(Colour::Rec709),
            moments: None,
            attributes: vec![("abbe.seed".to_owned(), "0".to_owned())],
        },
        film: Measures::of(&film),
        samples_per_pixel,
        holds: vec![part],
        render: None,
        bad: BadValues::default(),
        light_paths: vec![3, 4],
        images: Vec::new(),
    }
}

/// A file that this test alone uses.
fn path(name: &str) -> std::path::PathBuf {
    std::env::temp_dir().join(format!("abbe-{name}-{}.{EXTENSION}", std::process::id()))
}

/// A film with sums of all sizes, and a header that fits it.
fn exposed() -> (Film, Header) {
    let extras = Extras { responses: vec![0.1, 1.0 / 3.0], light_paths: true, ..Extras::default() };
    let mut film = Film::new(300, 200, 2, extras.clone(), FixedPoint::for_reference(3.0));
    for y in 0..200 {
        let number = |i: usize| ((i as i64).wrapping_mul(0x9E37_79B9_7F4A_7C15_u64 as i64)) >> (i % 63);
        let sums: Vec<i64> = (0..300 * film.sums_per_pixel()).map(|i| number(i + y as usize)).collect();
        let light = sums.iter().map(|sum| sum ^ 5).collect();
        let row = Row { sums, light, samples: (0..300).map(|x| x * y).collect() };
        film.add_row([0, y], &row, Region::whole([300, 200]));
    }
    let header = Header { film: Measures::of(&film), ..header([300, 200], 16) };
    (film, header)
}

#[test]
fn what_is_read_is_what_was_written() {
    let (film, mut header) = exposed();
    header.images = vec![("depth.T".to_owned(), true), ("shape_index.I".to_owned(), false)];
    let value = |i: usize| 1.0 / (i as f32 + 0.5);
    let values: Vec<f32> = (0..60_000).map(value).collect();
    let images = [
        Auxiliary { name: "depth.T".to_owned(), values: values.clone(), errors: Some(values.clone()) },
        Auxiliary { name: "shape_index.I".to_owned(), values, errors: None },
    ];
    let path = path("written");
    for threads in [1, 3] {
        write(&path, &header, &film, &images, threads).expect("it can be written");
        let opened = open(&path).expect("it can be read");
        assert_eq!(opened.header, header);
        let mut read = header.film.film(Storage::Memory, film.extent).expect("it is in memory");
        let found = opened.add_to(&mut read, Region::whole([300, 200])).expect("it can be read");
        assert!((0..200).all(|y| read.row(y) == film.row(y)));
        for (found, image) in found.iter().zip(&images) {
            assert!(found.name == image.name && found.values == image.values && found.errors == image.errors);
        }
        assert_eq!(found.len(), 2);
    }
    std::fs::remove_file(path).expect("it is there");
}

/// Any byte that differs, and any end that is missing, is noticed.
#[test]
fn damage_is_noticed() {
    let (film, header) = exposed();
    let path = path("damaged");
    write(&path, &header, &film, &[], 2).expect("it can be written");
    let bytes = std::fs::read(&path).expect("it is there");
    let is_read = |bytes: &[u8]| {
        std::fs::write(&path, bytes).expect("it can be written");
        let mut film = header.film.film(Storage::Memory, film.extent).expect("it is in memory");
        open(&path).and_then(|opened| opened.add_to(&mut film, Region::whole([300, 200]))).is_ok()
    };
    assert!(is_read(&bytes));
    for i in 0..40 {
        let place = (i * 7919 * 104_729) % bytes.len();
        let mut damaged = bytes.clone();
        damaged[place] ^= 1 << (i % 8);
        assert!(!is_read(&damaged), "byte {place}");
        assert!(!is_read(&bytes[..place]), "cut at {place}");
    }
    for place in (0..24).chain(bytes.len() - 12..bytes.len()) {
        let mut damaged = bytes.clone();
        damaged[place] ^= 0x10;
        assert!(!is_read(&damaged), "byte {place}");
    }
    assert!(!is_read(b"no checkpoint"));
    assert!(!is_read(b""));
    std::fs::remove_file(path).expect("it is there");
}

#[test]
fn small_numbers_come_first() {
    assert_eq!([0, -1, 1, -2, 2].map(unsigned), [0, 1, 2, 3, 4]);
    for value in [i64::MIN, i64::MAX, -5, 0, 1 << 40] {
        assert_eq!(signed(unsigned(value)), value);
    }
}
