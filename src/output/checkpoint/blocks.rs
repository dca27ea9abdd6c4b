//! Blocks of bytes in a file, each checked; and how integers are packed into one.

use flate2::Crc;
use flate2::bufread::DeflateDecoder;
use flate2::write::DeflateEncoder;
use std::fs::File;
use std::io::{Error, ErrorKind, Read, Result, Seek, SeekFrom, Write};
use std::path::Path;

/// Bytes of an integer.
const BYTES: usize = 8;

/// Largest block that is read. A damaged length asks for anything.
const LARGEST: u64 = 1 << 32;

pub(super) fn damaged() -> Error {
    Error::new(ErrorKind::InvalidData, "the checkpoint is damaged")
}

fn no_checkpoint() -> Error {
    Error::new(ErrorKind::InvalidData, "it is no checkpoint of this version of abbe")
}

fn check_sum(bytes: &[u8]) -> u32 {
    let mut crc = Crc::new();
    crc.update(bytes);
    crc.sum()
}

/// Integers byte by byte, the lowest byte of all of them first, compressed: the higher ones are nearly all
/// the same.
pub(super) fn packed(numbers: &[u64]) -> Vec<u8> {
    let mut encoder = DeflateEncoder::new(Vec::new(), flate2::Compression::fast());
    for byte in 0..BYTES {
        let plane: Vec<u8> = numbers.iter().map(|number| (number >> (8 * byte)) as u8).collect();
        // A vector takes whatever is written.
        let _ = encoder.write_all(&plane);
    }
    encoder.finish().unwrap_or_default()
}

/// The inverse of [`packed`], for `count` integers.
pub(super) fn unpacked(bytes: &[u8], count: usize) -> Result<Vec<u64>> {
    let mut decoder = DeflateDecoder::new(bytes);
    let (mut numbers, mut plane) = (vec![0; count], vec![0; count]);
    for byte in 0..BYTES {
        decoder.read_exact(&mut plane).map_err(|_| damaged())?;
        for (number, &bits) in numbers.iter_mut().zip(&plane) {
            *number |= u64::from(bits) << (8 * byte);
        }
    }
    match decoder.read(&mut [0]) {
        Ok(0) => Ok(numbers),
        _ => Err(damaged()),
    }
}

pub(super) struct Writer<'a> {
    to: &'a mut dyn Write,
    /// Check sum of the check sums of the blocks of the film.
    sums: Crc,
}

impl<'a> Writer<'a> {
    pub fn new(to: &'a mut dyn Write, magic: &[u8]) -> Result<Self> {
        to.write_all(magic)?;
        Ok(Self { to, sums: Crc::new() })
    }

    pub fn block(&mut self, bytes: &[u8]) -> Result<()> {
        let sum = check_sum(bytes).to_le_bytes();
        self.sums.update(&sum);
        self.to.write_all(&(bytes.len() as u64).to_le_bytes())?;
        self.to.write_all(&sum)?;
        self.to.write_all(bytes)
    }

    /// What comes now are the sums.
    pub fn begin_sums(&mut self) {
        self.sums.reset();
    }

    pub fn end(self) -> Result<()> {
        self.to.write_all(&0u64.to_le_bytes())?;
        self.to.write_all(&self.sums.sum().to_le_bytes())
    }
}

pub(super) struct Reader<R> {
    from: R,
    sums: Crc,
}

impl<R: Read> Reader<R> {
    pub fn new(mut from: R, magic: &[u8]) -> Result<Self> {
        let mut found = vec![0; magic.len()];
        match from.read_exact(&mut found) {
            Ok(()) if found == magic => Ok(Self { from, sums: Crc::new() }),
            Err(error) if error.kind() != ErrorKind::UnexpectedEof => Err(error),
            _ => Err(no_checkpoint()),
        }
    }

    fn number<const N: usize>(&mut self) -> Result<[u8; N]> {
        let mut bytes = [0; N];
        self.from.read_exact(&mut bytes).map_err(|_| damaged())?;
        Ok(bytes)
    }

    pub fn block(&mut self) -> Result<Vec<u8>> {
        let length = u64::from_le_bytes(self.number()?);
        let sum: [u8; 4] = self.number()?;
        self.sums.update(&sum);
        let mut bytes = Vec::new();
        if length < LARGEST {
            self.from.by_ref().take(length).read_to_end(&mut bytes)?;
        }
        let is_whole = bytes.len() as u64 == length && check_sum(&bytes).to_le_bytes() == sum;
        if is_whole { Ok(bytes) } else { Err(damaged()) }
    }

    /// See [`Writer::begin_sums`].
    pub fn begin_sums(&mut self) {
        self.sums.reset();
    }

    pub fn end(mut self) -> Result<()> {
        let (length, sum) = (u64::from_le_bytes(self.number()?), u32::from_le_bytes(self.number()?));
        if length == 0 && sum == self.sums.sum() { Ok(()) } else { Err(damaged()) }
    }
}

/// The check sum at the end of a file.
pub(super) fn digest(path: &Path) -> Result<u32> {
    let mut file = File::open(path)?;
    let mut bytes = [0; 4];
    file.seek(SeekFrom::End(-4)).and_then(|_| file.read_exact(&mut bytes)).map_err(|_| no_checkpoint())?;
    Ok(u32::from_le_bytes(bytes))
}
