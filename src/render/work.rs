//! What of a picture is done, and what is still to do.

use super::{Schedule, Settings};
use crate::film::{Film, FixedPoint, Storage};
use crate::scene::Scene;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Most samples of each replicate that a tile takes at once: bounds how long an interruption has to wait.
const LONGEST_PASS: u32 = 256;

/// A picture in the making: the sums of its film, and which samples are in them.
///
/// The samples of a pixel are numbered over the whole picture: with R replicates, sample n is the one of
/// index n / R of replicate n mod R. So any run of them has its share in each replicate, and runs that follow
/// one another make up the picture.
#[derive(Debug)]
pub struct Work {
    film: Film,
    schedule: Schedule,
    samples: Range<u64>,
    /// Where the pass under way begins: all samples of lower indices are in the film.
    index: u32,
    /// Which pieces of that pass are in the film, by their number.
    done: Vec<bool>,
}

/// How far a work is, apart from its film.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Position {
    /// All samples of lower indices are done.
    pub index: u32,
    /// The pieces of the pass under way that are done as well, as runs of their numbers.
    pub pieces: Vec<Range<u32>>,
}

impl Work {
    /// Nothing done yet of some samples of each pixel, or of all that the settings ask for.
    pub fn new(scene: &Scene, settings: &Settings, samples: Option<Range<u64>>) -> Self {
        Self::new_at(Storage::Memory, scene, settings, samples).expect("what is kept in memory needs no file")
    }

    /// The same with the sums of spectral bins in a storage.
    ///
    /// # Errors
    /// Where there is no room for them.
    pub fn new_at(
        storage: Storage,
        scene: &Scene,
        settings: &Settings,
        samples: Option<Range<u64>>,
    ) -> std::io::Result<Self> {
        let schedule = settings.schedule();
        let scale = FixedPoint::for_reference(scene.reference_radiance);
        let extras = settings.extras(scene);
        let mut film = Film::part_at(storage, scene.film.extent, schedule.replicates, extras, scale)?;
        film.per_net = schedule.per_net;
        let samples = samples.unwrap_or(0..schedule.samples());
        let index = (samples.start / u64::from(schedule.replicates)) as u32;
        Ok(Self { film, schedule, samples, index, done: Vec::new() })
    }

    /// The same with what a film is given that is exposed up to a position.
    ///
    /// # Errors
    /// Those of what gives it.
    pub fn exposed<E>(
        mut self,
        position: &Position,
        expose: impl FnOnce(&mut Film) -> Result<(), E>,
    ) -> Result<Self, E> {
        expose(&mut self.film)?;
        let mut done = Vec::new();
        for run in &position.pieces {
            done.resize(done.len().max(run.end as usize), false);
            done[run.start as usize..run.end as usize].fill(true);
        }
        Ok(Self { index: position.index, done, ..self })
    }

    /// What has been measured so far.
    pub fn film(&self) -> &Film {
        &self.film
    }

    /// What has been measured, at the end.
    pub fn into_film(self) -> Film {
        self.film
    }

    /// The samples of each pixel that are asked for.
    pub fn samples(&self) -> Range<u64> {
        self.samples.clone()
    }

    /// The samples of each pixel that are in the film. `None` while pixels differ.
    pub fn finished(&self) -> Option<Range<u64>> {
        let reached = u64::from(self.index) * u64::from(self.schedule.replicates);
        let end = reached.clamp(self.samples.start, self.samples.end);
        (!self.done.contains(&true)).then_some(self.samples.start..end)
    }

    /// The samples of each replicate that are in the film, in a picture whose samples are not allocated: a
    /// pixel may have half as many of them, or four times as many. `None` while a pass is under way.
    pub fn samples_per_replicate(&self) -> Option<u64> {
        let finished = self.finished()?;
        Some((finished.end - finished.start) / u64::from(self.schedule.replicates))
    }

    /// Whether all samples are taken.
    pub fn is_finished(&self) -> bool {
        self.finished() == Some(self.samples())
    }

    /// How far it is.
    pub fn position(&self) -> Position {
        let mut pieces: Vec<Range<u32>> = Vec::new();
        for (piece, _) in (0..).zip(&self.done).filter(|&(_, &done)| done) {
            match pieces.last_mut() {
                Some(run) if run.end == piece => run.end += 1,
                _ => pieces.push(piece..piece + 1),
            }
        }
        Position { index: self.index, pieces }
    }

    /// The next pass over the picture: which indices, and which of its pieces are done already.
    ///
    /// Passes double what is there at first, and then add a quarter of a power of two: what a Sobol sequence
    /// has after any of them is well spread, there is a picture with error bars after the first, and a render
    /// that ends at an error ends soon after it is reached.
    pub(super) fn pass(&self) -> Option<Pass> {
        let replicates = u64::from(self.schedule.replicates);
        let first = (self.samples.start / replicates) as u32;
        let end = self.samples.end.div_ceil(replicates) as u32;
        let step = pass_after(self.index - first).min(end.saturating_sub(self.index));
        let indices = self.index..self.index + step;
        (step > 0).then(|| Pass {
            indices,
            samples: self.samples.clone(),
            replicates: self.schedule.replicates,
            done: self.done.clone(),
        })
    }

    /// Whatever a piece of the pass under way brought.
    pub(super) fn add(&mut self, piece: usize, add: impl FnOnce(&mut Film)) {
        add(&mut self.film);
        self.done.resize(self.done.len().max(piece + 1), false);
        self.done[piece] = true;
    }

    pub(super) fn pieces_done(&self) -> usize {
        self.done.iter().filter(|&&done| done).count()
    }

    /// All pieces of the pass under way are done.
    pub(super) fn end_pass(&mut self) {
        if let Some(pass) = self.pass() {
            self.index = pass.indices.end;
            self.done.clear();
        }
    }
}

/// How many samples of each replicate the pass takes that comes after so many.
fn pass_after(samples: u32) -> u32 {
    match samples {
        0..4 => samples.max(1),
        _ => ((1_u32 << samples.ilog2()) / 4).clamp(2, LONGEST_PASS),
    }
}

/// The samples of a pass over the picture.
#[derive(Clone, Debug)]
pub(super) struct Pass {
    indices: Range<u32>,
    samples: Range<u64>,
    replicates: u32,
    done: Vec<bool>,
}

impl Pass {
    /// The indices of a replicate.
    pub fn indices(&self, replicate: u32) -> Range<u32> {
        let bound = |sample: u64| {
            let index = sample.saturating_sub(u64::from(replicate)).div_ceil(u64::from(self.replicates));
            (index as u32).clamp(self.indices.start, self.indices.end)
        };
        bound(self.samples.start)..bound(self.samples.end)
    }

    pub fn is_done(&self, piece: usize) -> bool {
        self.done.get(piece).copied().unwrap_or(false)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Extras;

    fn work(schedule: Schedule, samples: Range<u64>) -> Work {
        let film = Film::new(1, 1, schedule.replicates, Extras::default(), FixedPoint::SHARE);
        let index = (samples.start / u64::from(schedule.replicates)) as u32;
        Work { film, schedule, samples, index, done: Vec::new() }
    }

    /// The samples of each pass, replicate by replicate.
    fn passes(mut work: Work) -> Vec<Vec<Range<u32>>> {
        let replicates = work.schedule.replicates;
        std::iter::from_fn(|| {
            let pass = work.pass()?;
            work.end_pass();
            Some((0..replicates).map(|replicate| pass.indices(replicate)).collect())
        })
        .collect()
    }

    #[test]
    fn passes_grow_and_cover_every_index_once() {
        let ends = |samples: u32| {
            let all = passes(work(Schedule::independent(1, samples), 0..u64::from(samples)));
            all.iter().map(|pass| pass[0].end).collect::<Vec<_>>()
        };
        assert_eq!(ends(1), [1]);
        assert_eq!(ends(11), [1, 2, 4, 6, 8, 10, 11]);
        assert_eq!(ends(100), [1, 2, 4, 6, 8, 10, 12, 14, 16, 20, 24, 28, 32, 40, 48, 56, 64, 80, 96, 100]);
        assert_eq!(ends(2500)[32..], [1024, 1280, 1536, 1792, 2048, 2304, 2500]);
        assert!(ends(0).is_empty());
    }

    /// Whatever the cuts, each sample of each replicate is in one of the runs.
    #[test]
    fn runs_of_samples_make_up_the_picture() {
        let schedule = Schedule::independent(6, 7);
        for cuts in [vec![0, 42], vec![0, 1, 2, 3, 42], vec![0, 5, 6, 13, 29, 41, 42], vec![0, 18, 42]] {
            let mut seen = vec![0; 42];
            for run in cuts.windows(2) {
                let taken = passes(work(schedule, run[0]..run[1]));
                let mut count = 0;
                for (replicate, indices) in taken.iter().flat_map(|pass| (0..).zip(pass)) {
                    for index in indices.clone() {
                        seen[index as usize * 6 + replicate] += 1;
                        count += 1;
                    }
                }
                assert_eq!(count, run[1] - run[0], "{run:?}");
            }
            assert!(seen.iter().all(|&times| times == 1), "{cuts:?}: {seen:?}");
        }
    }

    #[test]
    fn a_position_tells_what_is_done() {
        let mut half = work(Schedule::independent(4, 8), 4..32);
        assert_eq!(half.finished(), Some(4..4));
        half.end_pass();
        assert_eq!(half.finished(), Some(4..8));
        for piece in [5, 1, 2] {
            half.add(piece, |_| {});
        }
        let position = half.position();
        assert_eq!(position, Position { index: 2, pieces: vec![1..3, 5..6] });
        assert_eq!((half.finished(), half.is_finished()), (None, false));
        let again = work(half.schedule, 4..32).exposed(&position, |_| Ok::<(), ()>(()));
        let mut again = again.expect("nothing fails");
        assert_eq!(again.position(), position);
        let pass = again.pass().expect("there is more to do");
        assert_eq!(
            (pass.indices(0), pass.is_done(2), pass.is_done(3), pass.is_done(9)),
            (2..3, true, false, false)
        );
        while again.pass().is_some() {
            again.end_pass();
        }
        assert!(again.is_finished());
    }
}
