//! Files whose content is compressed or has checksums: changes are made inside, so that more than the first
//! check sees them.

use super::Kind;
use super::change::Random;
use flate2::Compression;
use flate2::bufread::ZlibDecoder;
use flate2::write::ZlibEncoder;
use std::io::{Read, Write};

/// The content of a file, and what stands around it.
pub struct Packed {
    pub content: Vec<u8>,
    kind: Kind,
    head: Vec<u8>,
    tail: Vec<u8>,
}

/// `None` for files that are as they are.
pub fn open(kind: Kind, bytes: &[u8]) -> Option<Packed> {
    match kind {
        // Four bytes, a compressed mesh, and the places of all.
        Kind::Mesh("serialized") => {
            let mut content = Vec::new();
            ZlibDecoder::new(bytes.get(4..)?).read_to_end(&mut content).ok()?;
            let tail = [0u64.to_le_bytes().as_slice(), &1u32.to_le_bytes()].concat();
            Some(Packed { content, kind, head: bytes[..4].to_vec(), tail })
        }
        // The header of an image, between its name and its checksum.
        Kind::Image("png") => Some(Packed {
            content: bytes.get(12..29)?.to_vec(),
            kind,
            head: bytes[..12].to_vec(),
            tail: bytes.get(33..)?.to_vec(),
        }),
        _ => None,
    }
}

impl Packed {
    /// The file with another content.
    pub fn close(self, content: &[u8]) -> Vec<u8> {
        let packed = match self.kind {
            Kind::Image(_) => [content, &checksum(content).to_be_bytes()].concat(),
            _ => {
                let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
                encoder.write_all(content).and_then(|()| encoder.finish()).expect("memory can be written to")
            }
        };
        [self.head, packed, self.tail].concat()
    }
}

/// The CRC of PNG (its specification, annex D).
fn checksum(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |mut crc, &byte| {
        crc ^= u32::from(byte);
        for _ in 0..8 {
            crc = if crc & 1 == 1 { 0xedb8_8320 ^ (crc >> 1) } else { crc >> 1 };
        }
        crc
    })
}

/// One change to what is no text, mostly near the beginning, where the headers are.
pub fn change(bytes: &mut Vec<u8>, random: &mut Random) {
    const NUMBERS: [u32; 8] = [0, 1, 0xffff_ffff, 0x7fff_ffff, 0x8000_0000, 0xffff, 0x7f80_0000, 0x7fc0_0000];
    let within = if random.below(2) == 0 { bytes.len().min(64) } else { bytes.len() };
    let at = random.below(within);
    match random.below(8) {
        0 => bytes[at] = random.next() as u8,
        1 => bytes[at] ^= 1 << random.below(8),
        2 => {
            // Numbers of 32 bits, in either order.
            let number = NUMBERS[random.below(NUMBERS.len())];
            let digits = if random.below(2) == 0 { number.to_le_bytes() } else { number.to_be_bytes() };
            for (byte, digit) in bytes[at..].iter_mut().zip(digits) {
                *byte = digit;
            }
        }
        3 => bytes.truncate(at),
        4 => {
            let until = (at + random.below(16)).min(bytes.len());
            drop(bytes.drain(at..until));
        }
        5 => {
            let until = (at + random.below(64)).min(bytes.len());
            let copy = bytes[at..until].to_vec();
            drop(bytes.splice(at..at, copy));
        }
        6 => bytes[at] = bytes[at].wrapping_add(1),
        _ => bytes[at] = if random.below(2) == 0 { 0 } else { 0xff },
    }
}
