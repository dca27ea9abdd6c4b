//! What of a picture is done, as a file: the integer sums of its film and how far they go.
//!
//! A checkpoint is what a render that was interrupted goes on from, and a part that a picture is put together
//! from ([`merge`]). Sums are integers, so what is read is what was written, and parts add up to the bits of
//! the whole.
//!
//! The file begins with `MAGIC`, then come blocks of bytes, each with its length and its CRC-32 before it:
//! the header as JSON; the images beside the picture, one at a time; some rows of the film at a time. An
//! empty block and the check sum of all sums end it.

mod blocks;
pub mod merge;

use super::{Content, write_through};
use crate::film::{BadValues, Extent, Extras, Film, FixedPoint, Region, Row, Storage};
use crate::render::{Auxiliary, Position, Work};
use blocks::{Reader, Writer, packed, unpacked};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{BufReader, Error, Result};
use std::ops::Range;
use std::path::Path;

/// How the names of checkpoints end.
pub const EXTENSION: &str = "checkpoint";

/// What tells the file from others, and its version.
const MAGIC: &[u8; 16] = b"abbe checkpoint\x01";

/// Integers that are packed at once.
const AT_ONCE: usize = 1 << 18;

/// Some samples of the pixels of a rectangle.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RenderPart {
    /// The rectangle.
    pub region: Region,
    /// Their numbers, from the first to before the last.
    pub samples: Range<u64>,
}

/// All that a checkpoint says beside the sums.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// What all parts of a picture have in common, each with its name: parts in which any differs are of
    /// different pictures.
    pub identity: Vec<(String, String)>,
    /// What becomes of the film when the picture is written.
    pub picture: Description,
    /// What the film measures.
    pub film: Measures,
    /// Samples of each pixel in the finished picture.
    pub samples_per_pixel: u64,
    /// All that is in the sums. Empty where pixels differ: where a render was interrupted within a pass.
    pub holds: Vec<RenderPart>,
    /// What a render was asked for and how far it is. `None` of what was put together from parts.
    pub render: Option<(RenderPart, Position)>,
    /// Values that were left out of the sums.
    pub bad: BadValues,
    /// By replicate: how many light subpaths there were.
    pub light_paths: Vec<u64>,
    /// The names of the images beside the picture, each with whether it has errors.
    pub images: Vec<(String, bool)>,
}

/// What becomes of the film when the picture is written.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Description {
    /// What the main channels are.
    pub content: Content,
    /// What the names of the channels of means and of second moments begin with, if there are any.
    pub moments: Option<[String; 2]>,
    /// Name and text, but for those that say how many samples there are.
    pub attributes: Vec<(String, String)>,
}

/// What a film measures, and where.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measures {
    /// The exposed pixels within the whole film.
    pub extent: Extent,
    /// Parts of the samples, whose spread tells the error.
    pub replicates: u32,
    /// Replicates of each net.
    pub per_net: u32,
    /// What is measured beside X, Y and Z.
    pub extras: Extras,
    /// The quantum that sums are counted in.
    pub scale: FixedPoint,
}

impl Measures {
    /// What a film measures.
    pub fn of(film: &Film) -> Self {
        let (extent, replicates, per_net) = (film.extent, film.replicates, film.per_net);
        Self { extent, replicates, per_net, extras: film.extras.clone(), scale: film.scale() }
    }

    /// A film without samples that measures this, in another part of the picture, with the sums of its
    /// spectral bins in a storage.
    ///
    /// # Errors
    /// Where there is no room for them.
    pub fn film(&self, storage: Storage, extent: Extent) -> Result<Film> {
        let mut film = Film::part_at(storage, extent, self.replicates, self.extras.clone(), self.scale)?;
        film.per_net = self.per_net;
        Ok(film)
    }

    fn width(&self) -> usize {
        self.extent.measured.size[0] as usize
    }

    fn sums_per_row(&self) -> usize {
        self.width() * self.replicates as usize * self.extras.channels()
    }

    /// Those of samples and light subpaths included.
    fn numbers_per_row(&self) -> usize {
        self.sums_per_row() * if self.extras.light_paths { 2 } else { 1 } + self.width()
    }

    /// Rows that are packed together.
    fn runs_of_rows(&self) -> impl Iterator<Item = Range<u32>> + use<> {
        let height = self.extent.measured.size[1];
        let step = (AT_ONCE / self.numbers_per_row().max(1)).clamp(1, height.max(1) as usize) as u32;
        (0..height).step_by(step as usize).map(move |first| first..(first + step).min(height))
    }
}

impl Header {
    /// What is to be kept of a work. `identity` and `picture` say what it is a part of.
    pub fn of(
        work: &Work,
        identity: &[(String, String)],
        picture: &Description,
        samples_per_pixel: u64,
        images: &[Auxiliary],
    ) -> Self {
        let (film, samples) = (work.film(), work.samples());
        let part = |samples| RenderPart { region: film.extent.shown, samples };
        let holds = work.finished().filter(|samples| !samples.is_empty()).map(part);
        Self {
            identity: identity.to_vec(),
            picture: picture.clone(),
            film: Measures::of(film),
            samples_per_pixel,
            holds: holds.into_iter().collect(),
            render: Some((part(samples), work.position())),
            bad: film.bad,
            light_paths: film.light_counts().to_vec(),
            images: images.iter().map(|image| (image.name.clone(), image.errors.is_some())).collect(),
        }
    }

    /// The first thing in which another file is of another picture: its name, and how it is here and there.
    pub fn mismatch(&self, identity: &[(String, String)]) -> Option<[String; 3]> {
        let of = |name: &str, all: &[(String, String)]| {
            let found = all.iter().find(|(known, _)| known == name);
            found.map_or_else(|| "not stated".to_owned(), |(_, value)| value.clone())
        };
        let names = self.identity.iter().chain(identity).map(|(name, _)| name);
        let mut told = names.map(|name| [name.clone(), of(name, &self.identity), of(name, identity)]);
        told.find(|[_, own, other]| own != other)
    }
}

/// Writes a checkpoint on so many threads. What was there before stays until all of it is on the disk.
pub fn write(path: &Path, header: &Header, film: &Film, images: &[Auxiliary], threads: usize) -> Result<()> {
    write_through(path, |file| {
        let mut writer = Writer::new(file, MAGIC)?;
        writer.block(&serde_json::to_vec(header).map_err(Error::other)?)?;
        for image in images {
            let values = image.values.iter().chain(image.errors.iter().flatten());
            writer.block(&packed(&values.map(|value| u64::from(value.to_bits())).collect::<Vec<_>>()))?;
        }
        writer.begin_sums();
        let rows: Vec<Range<u32>> = header.film.runs_of_rows().collect();
        for batch in rows.chunks(threads.max(1)) {
            // Threads of its own: those of the render wait for the film.
            let blocks: Vec<Vec<u8>> = std::thread::scope(|scope| {
                let pack = |rows: &Range<u32>| {
                    let rows = rows.clone();
                    scope.spawn(move || packed(&numbers(film, rows)))
                };
                let under_way: Vec<_> = batch.iter().map(pack).collect();
                under_way.into_iter().filter_map(|thread| thread.join().ok()).collect()
            });
            if blocks.len() < batch.len() {
                return Err(Error::other("a thread that compresses it has ended"));
            }
            blocks.iter().try_for_each(|block| writer.block(block))?;
        }
        writer.end()
    })
}

/// Signed integers in an order in which small ones come first: 0, −1, 1, −2 …
fn unsigned(value: i64) -> u64 {
    ((value << 1) ^ (value >> 63)) as u64
}

fn signed(value: u64) -> i64 {
    (value >> 1) as i64 ^ -((value & 1) as i64)
}

/// The sums of some rows.
fn numbers(film: &Film, rows: Range<u32>) -> Vec<u64> {
    let mut numbers = Vec::new();
    for y in rows {
        let row = film.row(y);
        numbers.extend(row.sums.iter().chain(&row.light).map(|&sum| unsigned(sum)));
        numbers.extend(row.samples.iter().map(|&samples| u64::from(samples)));
    }
    numbers
}

/// The inverse of [`numbers`].
fn rows_of(measures: &Measures, numbers: &[u64]) -> Vec<Row> {
    let row = |numbers: &[u64]| {
        let (sums, samples) = numbers.split_at(numbers.len() - measures.width());
        let (own, light) = sums.split_at(measures.sums_per_row());
        let signed = |numbers: &[u64]| numbers.iter().map(|&number| signed(number)).collect();
        Row {
            sums: signed(own),
            light: signed(light),
            samples: samples.iter().map(|&samples| samples as u32).collect(),
        }
    };
    numbers.chunks_exact(measures.numbers_per_row()).map(row).collect()
}

/// A checkpoint whose header is read.
pub struct Opened {
    /// What it says of itself.
    pub header: Header,
    reader: Reader<BufReader<File>>,
    /// Check sum of all blocks: equal for equal sums of the same part.
    pub digest: u32,
}

/// Opens a checkpoint.
///
/// # Errors
/// Where it cannot be read, is no checkpoint, or is damaged as far as it is read.
pub fn open(path: &Path) -> Result<Opened> {
    let digest = blocks::digest(path)?;
    let mut reader = Reader::new(BufReader::new(File::open(path)?), MAGIC)?;
    let header = serde_json::from_slice(&reader.block()?).map_err(|_| blocks::damaged())?;
    Ok(Opened { header, reader, digest })
}

impl Opened {
    /// Adds the sums to a film that measures the same, as far as they are of pixels of a region. The images
    /// beside the picture.
    pub fn add_to(mut self, film: &mut Film, region: Region) -> Result<Vec<Auxiliary>> {
        let measures = &self.header.film;
        let Region { offset: [left, top], .. } = measures.extent.measured;
        let pixels = measures.extent.measured.pixel_count() as usize;
        let mut images = Vec::new();
        for (name, has_errors) in &self.header.images {
            let count = if *has_errors { 2 * pixels } else { pixels };
            let numbers = unpacked(&self.reader.block()?, count)?;
            let mut values: Vec<f32> = numbers.iter().map(|&bits| f32::from_bits(bits as u32)).collect();
            let errors = has_errors.then(|| values.split_off(pixels));
            images.push(Auxiliary { name: name.clone(), values, errors });
        }
        self.reader.begin_sums();
        let runs: Vec<Range<u32>> = measures.runs_of_rows().collect();
        for batch in runs.chunks(rayon::current_num_threads().max(1)) {
            let read = batch.iter().map(|rows| Ok((rows.clone(), self.reader.block()?)));
            let blocks: Vec<(Range<u32>, Vec<u8>)> = read.collect::<Result<_>>()?;
            let unpack = |(rows, block): &(Range<u32>, Vec<u8>)| {
                let numbers = unpacked(block, measures.numbers_per_row() * rows.len())?;
                Ok((rows.clone(), rows_of(measures, &numbers)))
            };
            let rows: Vec<(Range<u32>, Vec<Row>)> = blocks.par_iter().map(unpack).collect::<Result<_>>()?;
            for (numbers, rows) in &rows {
                for (y, row) in numbers.clone().zip(rows) {
                    film.add_row([left, top + y], row, region);
                }
            }
        }
        self.reader.end()?;
        film.bad.add(self.header.bad);
        Ok(images)
    }

    /// The work that goes on from here. `begun` is the same with nothing done, which is where what was put
    /// together from parts is.
    ///
    /// # Errors
    /// Where it cannot be read or is damaged.
    pub fn resumed(self, begun: Work) -> Result<Work> {
        let header = self.header.clone();
        let Some((_, position)) = &header.render else { return Ok(begun) };
        begun.exposed(position, |film| {
            self.add_to(film, header.film.extent.measured)?;
            for (replicate, &paths) in (0..film.replicates).zip(&header.light_paths) {
                film.count_light(replicate, paths);
            }
            Ok(())
        })
    }
}

#[cfg(test)]
mod tests;
