//! A picture of which as much is read as is asked for.

use super::reading::{checked, damaged, decoded};
use exr::block::reader::{ChunksReader, Reader};
use exr::block::{BlockIndex, UncompressedBlock};
use exr::meta::MetaData;
use exr::meta::attribute::{ChannelDescription, SampleType};
use exr::prelude::*;
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use std::collections::VecDeque;
use std::fs::File;
use std::io::{BufReader, Seek};
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Channels that are kept once they were read: so many bytes, and this many channels at least.
const KEPT: usize = 32 << 20;
const FEWEST_KEPT: usize = 10;

/// An EXR file that stays open, of whose first part with flat channels single channels and pixels are read. A
/// spectral picture has hundreds of channels, and rarely are more than a few of them looked at.
#[derive(Debug)]
pub struct Stored {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// In the order of [`Channels`](super::Channels).
    names: Vec<String>,
    kinds: Vec<SampleType>,
    /// Which part of the file it is.
    layer: usize,
    file: Mutex<File>,
    kept: Mutex<Kept>,
}

#[derive(Debug, Default)]
struct Kept {
    /// By index; the one that was asked for last is at the end.
    channels: VecDeque<(usize, Arc<[f32]>)>,
    /// The blocks around the last pixel.
    blocks: Vec<UncompressedBlock>,
}

impl Stored {
    /// # Errors
    /// What makes the file unreadable, and that it ends too early. Damage to its pixels is found when they
    /// are asked for.
    pub fn open(path: &Path) -> std::io::Result<Self> {
        let mut file = File::open(path)?;
        let length = file.metadata()?.len();
        let meta = reader(&mut file)?.into_meta_data();
        checked(&meta, length)?;
        let Some((layer, header)) = meta.headers.iter().enumerate().find(|(_, header)| !header.deep) else {
            return Err(std::io::Error::other("the file has no flat channels"));
        };
        let list: &[ChannelDescription] = &header.channels.list;
        if let Some(channel) = list.iter().find(|channel| channel.sampling != Vec2(1, 1)) {
            let name = decoded(&channel.name);
            let problem = format!("channel {name} does not have a value for each pixel");
            return Err(std::io::Error::other(problem));
        }
        let stored = Self {
            width: header.layer_size.0,
            height: header.layer_size.1,
            names: list.iter().map(|channel| decoded(&channel.name)).collect(),
            kinds: list.iter().map(|channel| channel.sample_type).collect(),
            layer,
            file: Mutex::new(file),
            kept: Mutex::default(),
        };
        stored.refuse_cut_off()?;
        Ok(stored)
    }

    /// Finds a file that was cut off by its first and its last block, which are not decoded.
    fn refuse_cut_off(&self) -> std::io::Result<()> {
        let is_at_end = |block: &BlockIndex| {
            let (from, size) = (block.pixel_position, block.pixel_size);
            from == Vec2(0, 0) || (from.0 + size.0, from.1 + size.1) == (self.width, self.height)
        };
        let is_wanted =
            |block: &BlockIndex| block.layer == self.layer && block.level == Vec2(0, 0) && is_at_end(block);
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        let mut chunks =
            reader(&mut file)?.filter_chunks(false, |_, _, block| is_wanted(&block)).map_err(damaged)?;
        chunks.try_for_each(|chunk| chunk.map(|_| ())).map_err(damaged)
    }

    /// The names of its channels, in their order.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The values of a channel, row by row from the top; `None` where there is none of this name. One way
    /// through the file also reads what may be asked for next: the channels of `likely`, and neighbours in
    /// the order of the file, as long as they fill no more than half of what is kept.
    ///
    /// # Errors
    /// Where the file cannot be read, or is damaged.
    pub fn channel(&self, name: &str, likely: &[&str]) -> std::io::Result<Option<Arc<[f32]>>> {
        let index = |name: &str| self.names.iter().position(|known| known == name);
        let Some(wanted) = index(name) else { return Ok(None) };
        if let Some(known) = self.kept().find(wanted) {
            return Ok(Some(known));
        }
        let most = (KEPT / (self.width * self.height * size_of::<f32>()).max(1)).max(FEWEST_KEPT);
        let mut together: Vec<usize> = (0..self.names.len()).collect();
        if together.len() > most {
            let likely: Vec<usize> = likely.iter().filter_map(|name| index(name)).collect();
            together.sort_by_key(|&other| (!likely.contains(&other), other.abs_diff(wanted)));
            together.truncate(likely.len().max(most / 2).min(most));
        }
        let mut kept = self.kept();
        together.retain(|&other| other != wanted && kept.find(other).is_none());
        together.push(wanted);
        // Room is made first: both at once would be more than is kept.
        let beyond = (kept.channels.len() + together.len()).saturating_sub(most);
        kept.channels.drain(..beyond);
        drop(kept);
        let found = self.read(&together)?;
        let asked = found.last().cloned();
        self.kept().channels.extend(together.into_iter().zip(found));
        Ok(asked)
    }

    /// All channels of a pixel, in their order. It lies within the picture.
    ///
    /// # Errors
    /// Where the file cannot be read, or is damaged.
    pub fn pixel(&self, [x, y]: [usize; 2]) -> std::io::Result<Vec<f32>> {
        let holds = |block: &BlockIndex| {
            let (from, size) = (block.pixel_position, block.pixel_size);
            (from.0..from.0 + size.0).contains(&x) && (from.1..from.1 + size.1).contains(&y)
        };
        let known = self.kept().blocks.iter().any(|block| holds(&block.index));
        if !known {
            let mut blocks = Vec::new();
            self.for_blocks(holds, |_, block| blocks.push(block))?;
            self.kept().blocks = blocks;
        }
        let kept = self.kept();
        let block = kept.blocks.iter().find(|block| holds(&block.index));
        let block = block.ok_or_else(|| std::io::Error::other("the file has no block with this pixel"))?;
        let (from, size) = (block.index.pixel_position, block.index.pixel_size);
        // In a block all channels of a row lie one behind the other.
        let lengths = self.kinds.iter().map(SampleType::bytes_per_sample);
        let row = lengths.clone().sum::<usize>() * size.0 * (y - from.1);
        let mut start = row;
        let mut values = Vec::with_capacity(self.kinds.len());
        for (kind, bytes) in self.kinds.iter().zip(lengths) {
            let place = start + bytes * (x - from.0);
            let sample = block.data.get(place..place + bytes);
            values.push(number(*kind, sample.ok_or_else(|| std::io::Error::other("a block is too short"))?));
            start += bytes * size.0;
        }
        Ok(values)
    }

    /// These channels, in this order.
    fn read(&self, wanted: &[usize]) -> std::io::Result<Vec<Arc<[f32]>>> {
        let mut channels = vec![vec![0.0; self.width * self.height]; wanted.len()];
        let mut places = vec![None; self.names.len()];
        wanted.iter().enumerate().for_each(|(place, &channel)| places[channel] = Some(place));
        self.for_blocks(
            |_| true,
            |meta, block| {
                for line in block.lines(&meta.headers[self.layer].channels) {
                    let Some(place) = places[line.location.channel] else { continue };
                    let kind = self.kinds[line.location.channel];
                    let Vec2(x, y) = line.location.position;
                    let start = y * self.width + x;
                    let row = &mut channels[place][start..start + line.location.sample_count];
                    let samples = line.value.chunks_exact(kind.bytes_per_sample());
                    row.iter_mut().zip(samples).for_each(|(value, sample)| *value = number(kind, sample));
                }
            },
        )?;
        Ok(channels.into_iter().map(Arc::from).collect())
    }

    /// The decoded blocks of full resolution that are wanted, in any order.
    fn for_blocks(
        &self,
        wanted: impl Fn(&BlockIndex) -> bool,
        mut take: impl FnMut(&MetaData, UncompressedBlock),
    ) -> std::io::Result<()> {
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        let is_wanted =
            |block: &BlockIndex| block.layer == self.layer && block.level == Vec2(0, 0) && wanted(block);
        let mut chunks =
            reader(&mut file)?.filter_chunks(false, |_, _, block| is_wanted(&block)).map_err(damaged)?;
        // As many at once as there are threads, and by these: threads that come and go, as the crate's own
        // do, leave memory behind.
        loop {
            let some = chunks.by_ref().take(rayon::current_num_threads()).collect::<Result<Vec<_>>>();
            let some = some.map_err(damaged)?;
            if some.is_empty() {
                return Ok(());
            }
            let meta = chunks.meta_data();
            let decode = |chunk| UncompressedBlock::decompress_chunk(chunk, meta, false);
            let blocks = some.into_par_iter().map(decode).collect::<Result<Vec<_>>>().map_err(damaged)?;
            blocks.into_iter().for_each(|block| take(meta, block));
        }
    }

    fn kept(&self) -> MutexGuard<'_, Kept> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Kept {
    /// A channel that is known, which then is the one that was asked for last.
    fn find(&mut self, wanted: usize) -> Option<Arc<[f32]>> {
        let place = self.channels.iter().position(|(index, _)| *index == wanted)?;
        let found = self.channels.remove(place)?;
        let values = found.1.clone();
        self.channels.push_back(found);
        Some(values)
    }
}

/// Reads from the beginning of a file.
fn reader(file: &mut File) -> std::io::Result<Reader<BufReader<&mut File>>> {
    file.rewind()?;
    exr::block::read(BufReader::new(file), false).map_err(damaged)
}

/// The value of a sample as blocks hold it: in the order of bytes of this machine.
fn number(kind: SampleType, bytes: &[u8]) -> f32 {
    match (kind, bytes) {
        (SampleType::F16, &[a, b]) => f16::from_ne_bytes([a, b]).to_f32(),
        (SampleType::F32, &[a, b, c, d]) => f32::from_ne_bytes([a, b, c, d]),
        (SampleType::U32, &[a, b, c, d]) => u32::from_ne_bytes([a, b, c, d]) as f32,
        _ => f32::NAN,
    }
}
