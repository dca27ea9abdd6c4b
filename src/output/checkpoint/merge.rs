//! A picture from its parts: runs of its samples, and rectangles of its pixels.
//!
//! Parts are boxes of pixels and samples. What no part holds is missing, what two hold is refused unless one
//! of them holds all of the other: a sample is a pure function of the scene, so that other adds nothing.

use super::{Header, Measures, Opened, RenderPart};
use crate::film::{Extent, Film, Region};
use crate::render::Auxiliary;
use std::fmt;

impl RenderPart {
    fn is_empty(&self) -> bool {
        self.region.pixel_count() == 0 || self.samples.is_empty()
    }

    fn common(&self, other: &Self) -> Self {
        let samples = self.samples.start.max(other.samples.start)..self.samples.end.min(other.samples.end);
        Self { region: self.region.common(other.region), samples }
    }

    /// What of it is not in another: boxes without anything in common.
    fn without(self, other: &Self) -> Vec<Self> {
        let common = self.common(other);
        if common.is_empty() {
            return vec![self];
        }
        let mut rest = Vec::new();
        let mut push = |part: Self| {
            if !part.is_empty() {
                rest.push(part);
            }
        };
        push(Self { samples: self.samples.start..common.samples.start, ..self.clone() });
        push(Self { samples: common.samples.end..self.samples.end, ..self.clone() });
        let samples = common.samples.clone();
        let box_of = |x: [u64; 2], y: [u64; 2]| {
            let offset = [x[0] as u32, y[0] as u32];
            let size = [x, y].map(|[from, to]| to.saturating_sub(from) as u32);
            Self { region: Region { offset, size }, samples: samples.clone() }
        };
        let [left, top] = self.region.offset.map(u64::from);
        let [right, bottom] = self.region.end();
        let [from_x, from_y] = common.region.offset.map(u64::from);
        let [to_x, to_y] = common.region.end();
        push(box_of([left, right], [top, from_y]));
        push(box_of([left, right], [to_y, bottom]));
        push(box_of([left, from_x], [from_y, to_y]));
        push(box_of([to_x, right], [from_y, to_y]));
        rest
    }
}

/// What of some boxes is in none of others.
fn remainder<'a>(
    mut of: Vec<RenderPart>,
    without: impl IntoIterator<Item = &'a RenderPart>,
) -> Vec<RenderPart> {
    for part in without {
        of = of.into_iter().flat_map(|rest| rest.without(part)).collect();
    }
    of
}

/// How files are put together, by their numbers among those given.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// What is added up.
    pub used: Vec<usize>,
    /// Files that hold nothing that the ones used do not hold.
    pub redundant: Vec<usize>,
    /// Files of renders that were interrupted within a pass: they are left out until they are resumed.
    pub unfinished: Vec<usize>,
    /// The film of the picture.
    pub extent: Extent,
    /// All that is in the sums then.
    pub holds: Vec<RenderPart>,
    /// What no file holds.
    pub missing: Vec<RenderPart>,
}

/// Why files make no picture. Files are told by their numbers among those given.
#[derive(Clone, Debug, PartialEq)]
pub enum Refusal {
    /// They are of different pictures: what differs, and how it is in either.
    Different {
        /// Numbers of the two files.
        files: [usize; 2],
        /// What differs.
        what: String,
        /// What either has.
        values: [String; 2],
    },
    /// Both hold this, and each has something that the other has not.
    Overlap {
        /// Numbers of the two files.
        files: [usize; 2],
        /// What both have.
        part: RenderPart,
    },
    /// Both hold the same samples, with other sums.
    Contradiction {
        /// Numbers of the two files.
        files: [usize; 2],
    },
}

impl fmt::Display for RenderPart {
    /// As options of `abbe render`.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Region { offset: [x, y], size: [width, height] } = self.region;
        write!(f, "--samples {}..{} --crop {x},{y},{width},{height}", self.samples.start, self.samples.end)
    }
}

/// Plans how checkpoints, each with the digest of its sums, are put together. The order in which they are
/// given changes nothing.
///
/// # Errors
/// Where they are not of one picture, or overlap.
pub fn plan(files: &[(&Header, u32)]) -> Result<Plan, Refusal> {
    let header = |file: usize| files[file].0;
    for other in 1..files.len() {
        if let Some([what, first, second]) = header(0).mismatch(&header(other).identity) {
            return Err(Refusal::Different { files: [0, other], what, values: [first, second] });
        }
    }
    let (unfinished, mut rest): (Vec<usize>, Vec<usize>) =
        (0..files.len()).partition(|&file| header(file).holds.is_empty());
    let size = |file: usize| -> u128 {
        let parts = header(file).holds.iter();
        parts.map(|p| u128::from(p.region.pixel_count()) * u128::from(p.samples.end - p.samples.start)).sum()
    };
    // What holds much may hold all of what holds less.
    rest.sort_by_key(|&file| (std::cmp::Reverse(size(file)), file));
    let (mut used, mut redundant) = (Vec::<usize>::new(), Vec::new());
    for file in rest {
        let own = &header(file).holds;
        let meets = |other: &&usize| {
            own.iter().any(|part| header(**other).holds.iter().any(|held| !part.common(held).is_empty()))
        };
        let met: Vec<usize> = used.iter().filter(meets).copied().collect();
        let Some(&first) = met.first() else {
            used.push(file);
            continue;
        };
        let held = met.iter().flat_map(|&other| &header(other).holds);
        if !remainder(own.clone(), held).is_empty() {
            let others = &header(first).holds;
            let shared = own.iter().flat_map(|part| others.iter().map(|held| part.common(held)));
            let part = shared.into_iter().find(|part| !part.is_empty()).unwrap_or_else(|| own[0].clone());
            return Err(Refusal::Overlap { files: [first.min(file), first.max(file)], part });
        }
        let is_same = header(first).holds == *own && header(first).film == header(file).film;
        if is_same && files[first].1 != files[file].1 {
            return Err(Refusal::Contradiction { files: [first.min(file), first.max(file)] });
        }
        redundant.push(file);
    }
    used.sort_unstable();
    redundant.sort_unstable();
    let extent = extent_of(files.iter().map(|(header, _)| &header.film));
    let goal = RenderPart { region: extent.shown, samples: 0..header(0).samples_per_pixel };
    let holds: Vec<RenderPart> = used.iter().flat_map(|&file| header(file).holds.clone()).collect();
    let missing = joined(remainder(vec![goal], &holds));
    let holds = joined(holds);
    Ok(Plan { used, redundant, unfinished, extent, holds, missing })
}

/// Runs of samples of the same pixels that follow one another as one.
fn joined(mut parts: Vec<RenderPart>) -> Vec<RenderPart> {
    parts.sort_by_key(|part| (part.samples.start, part.region));
    let mut joined: Vec<RenderPart> = Vec::new();
    for part in parts {
        match joined.iter_mut().find(|p| p.region == part.region && p.samples.end == part.samples.start) {
            Some(before) => before.samples.end = part.samples.end,
            None => joined.push(part),
        }
    }
    joined
}

/// The film of parts that are of the same pixels is theirs; else it is that of the whole picture.
fn extent_of<'a>(mut films: impl Iterator<Item = &'a Measures>) -> Extent {
    let first = films.next().map_or(Extent::whole([0, 0]), |film| film.extent);
    match films.all(|film| film.extent == first) {
        true => first,
        false => Extent { measured: first.window, shown: first.window, ..first },
    }
}

impl Plan {
    /// Adds up the files that are used, given by their numbers, on a film without samples: that film, and the
    /// images beside the picture where there are some for all of it.
    ///
    /// # Errors
    /// Where a file cannot be read: its number comes with why.
    pub fn add_up(
        &self,
        mut film: Film,
        mut open: impl FnMut(usize) -> std::io::Result<Opened>,
    ) -> Result<(Film, Vec<Auxiliary>), (usize, std::io::Error)> {
        let mut images = Images { extent: self.extent, all: Vec::new(), covered: Vec::new() };
        // Light subpaths are those of the whole picture: what is counted for one pixel is counted for all.
        let pixel = self.holds.first().map(|part| Region { size: [1, 1], ..part.region });
        for &file in &self.used {
            let opened = open(file).map_err(|error| (file, error))?;
            let header = opened.header.clone();
            let own = header.film.extent;
            // Around what is shown there is what other parts hold.
            let region = if own == self.extent { own.measured } else { own.shown };
            let found = opened.add_to(&mut film, region).map_err(|error| (file, error))?;
            images.add(own.measured, region, found);
            if header.holds.iter().any(|part| pixel.is_some_and(|pixel| part.region.holds(pixel))) {
                for (replicate, &paths) in (0..film.replicates).zip(&header.light_paths) {
                    film.count_light(replicate, paths);
                }
            }
        }
        Ok((film, images.whole()))
    }

    /// Whether the pixels that have samples have the same ones, so that the light subpaths of one are those
    /// of all.
    pub fn is_even(&self, samples_per_pixel: u64) -> bool {
        let whole =
            |part: &RenderPart| part.region == self.extent.shown || part.samples == (0..samples_per_pixel);
        self.missing.iter().all(whole)
    }
}

/// Images beside the picture, put together.
struct Images {
    extent: Extent,
    all: Vec<Auxiliary>,
    covered: Vec<RenderPart>,
}

impl Images {
    /// Those of a part, of the pixels of `measured`, as far as they are in `region`.
    fn add(&mut self, measured: Region, region: Region, images: Vec<Auxiliary>) {
        if images.is_empty() {
            return;
        }
        let pixels = self.extent.measured.pixel_count() as usize;
        if self.all.is_empty() {
            let empty = |image: &Auxiliary| Auxiliary {
                name: image.name.clone(),
                values: vec![0.0; pixels],
                errors: image.errors.as_ref().map(|_| vec![0.0; pixels]),
            };
            self.all = images.iter().map(empty).collect();
        }
        let index = |region: Region, [x, y]: [u32; 2]| y as usize * region.size[0] as usize + x as usize;
        for pixel in region.pixels() {
            let (Some(from), Some(to)) = (measured.within(pixel), self.extent.measured.within(pixel)) else {
                continue;
            };
            let (from, to) = (index(measured, from), index(self.extent.measured, to));
            for (own, image) in self.all.iter_mut().zip(&images) {
                own.values[to] = image.values[from];
                if let (Some(own), Some(errors)) = (&mut own.errors, &image.errors) {
                    own[to] = errors[from];
                }
            }
        }
        self.covered.push(RenderPart { region, samples: 0..1 });
    }

    /// All of them where they are there for every pixel, else none.
    fn whole(self) -> Vec<Auxiliary> {
        let goal = RenderPart { region: self.extent.measured, samples: 0..1 };
        if remainder(vec![goal], &self.covered).is_empty() { self.all } else { Vec::new() }
    }
}

#[cfg(test)]
mod tests;
