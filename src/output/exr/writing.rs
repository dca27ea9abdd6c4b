//! Writing the file, some rows at a time.

use super::bands::Bands;
use super::tile_noise::TileNoise;
use super::{ENCODING, attributes, sort_attributes, utf8};
use crate::film::{Extent, NoiseSums};
use crate::output::{Content, Picture, folder_of, write_through};
use exr::block::chunk::Chunk;
use exr::block::{BlockIndex, UncompressedBlock};
use exr::error::Error;
use exr::meta::Headers;
use exr::meta::attribute::{ChannelDescription, SampleType};
use exr::meta::header::Header;
use exr::prelude::{IntegerBounds, SmallVec, Text, Vec2};
use rayon::prelude::*;
use std::collections::VecDeque;
use std::io::{BufReader, BufWriter, Cursor, Result, Seek, Write};
use std::path::Path;

/// Most blocks of rows that are compressed at once.
const AT_ONCE: usize = 16;

/// Writes the whole file or, where that fails, none of it: it is made beside its place and moved there.
///
/// Equal pictures give equal bytes. Rows are developed, compressed and put aside as they come, so that no
/// more than some of them are in memory; the header, which states what all of them have in common, comes
/// last, and before them in the file.
pub fn write(path: &Path, picture: &Picture) -> Result<()> {
    let bands = Bands::new(picture);
    let mut header = header(picture, &bands);
    let mut aside = BufWriter::new(tempfile::tempfile_in(folder_of(path))?);
    let mut lengths = Vec::new();
    let mut noise = NoiseSums::new(picture.film, bands.quantities.iter().map(|(_, quantity)| *quantity));
    let shown = picture.film.extent.shown;
    let first = shown.offset[1] - picture.film.extent.measured.offset[1];
    let mut tiles = TileNoise::new(shown.size, bands.quantities.len());
    let mut blocks = Blocks { header: &header, rows: VecDeque::new(), next: 0 };
    for rows in bands.rows() {
        if picture.has_errors() {
            noise.add_up_to(picture.film, rows.end - first);
        }
        let is_last = rows.end - first == shown.size[1];
        for row in bands.develop(rows) {
            tiles.add(bands.errors(&row));
            blocks.rows.push_back(row);
        }
        for chunk in blocks.compressed(is_last)? {
            let mut bytes = Vec::new();
            chunk.write(&mut bytes, 1).map_err(failed)?;
            lengths.push(bytes.len() as u64);
            aside.write_all(&bytes)?;
        }
    }
    header.own_attributes.other = attributes(picture, &bands.quantities, &noise.told(), &tiles);
    let mut aside = aside.into_inner()?;
    aside.rewind()?;
    write_through(path, |file| {
        let head = written(header)?;
        file.write_all(&head)?;
        let mut place = (head.len() + lengths.len() * size_of::<u64>()) as u64;
        for length in lengths {
            file.write_all(&place.to_le_bytes())?;
            place += length;
        }
        std::io::copy(&mut BufReader::new(aside), file)?;
        Ok(())
    })
}

fn failed(error: Error) -> std::io::Error {
    match error {
        Error::Io(error) => error,
        error => std::io::Error::other(error),
    }
}

/// All of it but the attributes that are text.
fn header(picture: &Picture, bands: &Bands) -> Header {
    let Extent { whole, shown, .. } = picture.film.extent;
    let named = |name: &str| ChannelDescription::new(utf8(name), SampleType::F32, true);
    let channels: SmallVec<[ChannelDescription; 5]> = bands.names().map(named).collect();
    let [width, height] = shown.size.map(|size| size as usize);
    let mut header = Header::new(Text::default(), (width, height), channels).with_encoding(
        ENCODING.compression,
        exr::meta::BlockDescription::ScanLines,
        ENCODING.line_order,
    );
    header.own_attributes.layer_name = None;
    header.own_attributes.layer_position = Vec2(shown.offset[0] as i32, shown.offset[1] as i32);
    header.shared_attributes.display_window =
        IntegerBounds::new((0, 0), (whole[0] as usize, whole[1] as usize));
    if let Content::Colour(colour) = &picture.content {
        header.shared_attributes.chromaticities = Some(colour.chromaticities());
    }
    header
}

/// The beginning of the file, as far as the places of its blocks.
fn written(header: Header) -> Result<Vec<u8>> {
    let headers: Headers = SmallVec::from_iter([header]);
    let mut bytes = Cursor::new(Vec::new());
    // The crate writes what comes before the blocks, and is not given any.
    match exr::block::write(&mut bytes, headers, false, |_, _| Err(Error::Aborted)) {
        Ok(()) | Err(Error::Aborted) => {}
        Err(error) => return Err(failed(error)),
    }
    let mut bytes = bytes.into_inner();
    // Behind the header it leaves room for the places of the blocks.
    let end = sort_attributes(&mut bytes).ok_or_else(|| std::io::Error::other("the header has no end"))?;
    bytes.truncate(end);
    Ok(bytes)
}

/// Rows that wait until there are enough for blocks.
struct Blocks<'a> {
    header: &'a Header,
    rows: VecDeque<Vec<f32>>,
    /// The first of them, from the top of the file.
    next: usize,
}

impl Blocks<'_> {
    /// The blocks that there are rows for. Once they are the last, all of them.
    fn compressed(&mut self, is_last: bool) -> Result<Vec<Chunk>> {
        let height = ENCODING.compression.scan_lines_per_block();
        let wanted = height * rayon::current_num_threads().clamp(1, AT_ONCE);
        if !is_last && self.rows.len() < wanted {
            return Ok(Vec::new());
        }
        let whole = if is_last { self.rows.len() } else { self.rows.len() / height * height };
        let rows: Vec<Vec<f32>> = self.rows.drain(..whole).collect();
        let first = self.next;
        self.next += whole;
        let block = |(number, rows): (usize, &[Vec<f32>])| {
            let index = BlockIndex {
                layer: 0,
                pixel_position: Vec2(0, first + number * height),
                pixel_size: Vec2(self.header.layer_size.x(), rows.len()),
                level: Vec2(0, 0),
            };
            let mut data = Vec::with_capacity(rows.iter().map(|row| size_of_val(row.as_slice())).sum());
            rows.iter().flatten().for_each(|value| data.extend_from_slice(&value.to_ne_bytes()));
            let headers = std::slice::from_ref(self.header);
            UncompressedBlock { index, data }.compress_to_chunk(headers).map_err(failed)
        };
        rows.par_chunks(height).enumerate().map(block).collect()
    }
}
