//! Suffixes of the paths of several samples of a group, followed together: as paths end, those that go on are
//! moved into fewer bundles.

use super::super::path::Contested;
use super::{Bundle, Scratch, Source};
use crate::lanes::{ALL, LANES, Mask, WIDTH, get, lanes_of, set};
use crate::light::Receiver;
use crate::spectrum::{Sampled, SampledLanes};

/// What suffixes have found.
pub(in crate::integrator) struct Found<const C: usize> {
    /// By the number of the sample.
    pub arriving: Vec<SampledLanes<C>>,
    /// See [`Bundle::contested`].
    pub contested: Vec<(usize, usize, Contested<C>)>,
}

/// Follows paths to their ends. All bundles that have any have come as far as one another.
pub(in crate::integrator) fn follow<const C: usize>(
    mut bundles: Vec<Bundle<C>>,
    scratch: &mut Scratch<C>,
    samples: usize,
) -> Found<C> {
    let mut found = Found { arriving: vec![SampledLanes::ZERO; samples], contested: Vec::new() };
    loop {
        // Before paths move: a bundle without any has not come as far as the others.
        bundles.retain_mut(|bundle| {
            if bundle.alive == 0 {
                found.take(bundle, ALL);
            }
            bundle.alive != 0
        });
        if bundles.is_empty() {
            return found;
        }
        if bundles.windows(2).all(|two| two[0].may_merge(&two[1])) {
            gather(&mut bundles, &mut found);
        }
        bundles.iter_mut().for_each(|bundle| bundle.step(scratch));
    }
}

impl<const C: usize> Found<C> {
    /// Keeps what has come to some lanes of a bundle, and what its paths have found besides.
    fn take(&mut self, bundle: &mut Bundle<C>, lanes: Mask) {
        for lane in lanes_of(lanes & ALL) {
            let (number, of_turn, light) = bundle.found(lane);
            if !light.is_zero() {
                self.arriving[number].set(of_turn, &light);
            }
            bundle.arriving.set(lane, &Sampled::ZERO);
        }
        self.contested.append(&mut bundle.contested);
    }
}

/// Moves paths out of the last bundles as long as the others have room for all of theirs, and within the
/// last one that is left to its first lanes.
fn gather<const C: usize>(bundles: &mut Vec<Bundle<C>>, found: &mut Found<C>) {
    let alive = |bundles: &[Bundle<C>]| bundles.iter().map(|bundle| bundle.alive.count_ones()).sum::<u32>();
    while bundles.len() > 1 && alive(bundles) as usize <= LANES * (bundles.len() - 1) {
        let Some((last, others)) = bundles.split_last_mut() else { return };
        let leaving = last.alive;
        found.take(last, !leaving);
        let mut paths = lanes_of(leaving);
        for bundle in others {
            let free = !bundle.alive & ALL;
            for (lane, from) in lanes_of(free).zip(&mut paths) {
                found.take(bundle, 1 << lane);
                bundle.take(lane, last, from);
            }
        }
        found.contested.append(&mut last.contested);
        bundles.truncate(bundles.len() - 1);
    }
}

impl<const C: usize> Bundle<'_, C> {
    /// Whether paths of another bundle that has come as far may go on in this one.
    fn may_merge(&self, other: &Self) -> bool {
        self.depth == other.depth && (self.time == other.time || !self.scene.features().motion)
    }

    /// What came to a lane, by the number of its turn and its lane there.
    fn found(&self, lane: usize) -> (usize, usize, Sampled<C>) {
        let Source { number, lane: of_turn, .. } = self.sources[lane];
        (number, of_turn, self.arriving.get(lane))
    }

    /// Takes the path of a lane of another bundle, which has come as far, into a lane whose own has ended.
    fn take(&mut self, lane: usize, other: &mut Self, from: usize) {
        self.sources[lane] = other.sources[from];
        self.rays.set(lane, &other.rays.get(from));
        set(&mut self.rays.leaves, lane, get(&other.rays.leaves, from));
        let Receiver { point, facing } = other.from().get(from);
        self.from_point[lane / WIDTH].set(lane, &point);
        self.from_facing[lane / WIDTH].set(lane, facing);
        for (own, other) in [
            (&mut self.throughput, &other.throughput),
            (&mut self.ratio, &other.ratio),
            (&mut self.arriving, &other.arriving),
        ] {
            own.set(lane, &other.get(from));
        }
        for (own, other) in [
            (&mut self.density, &other.density),
            (&mut self.prior_over_density, &other.prior_over_density),
            (&mut self.prior_throughput, &other.prior_throughput),
        ] {
            set(own, lane, get(other, from));
        }
        self.lamp_light.take(lane, &other.lamp_light, from);
        if let (Some(own), Some(other)) = (self.media.get_mut(lane), other.media.get(from)) {
            own.clone_from(other);
        }
        if let (Some(own), Some(other)) = (self.firsts.get_mut(lane), other.firsts.get(from)) {
            own.clone_from(other);
        }
        self.alive |= 1 << lane;
        other.alive &= !(1 << from);
        self.competing = self.competing & !(1 << lane) | (other.competing >> from & 1) << lane;
    }
}
