//! Which crossings along a line cannot be told apart.

use crate::shape::Crossing;
use smallvec::SmallVec;

/// A crossing of one of a solid's leaves.
#[derive(Clone, Copy, Debug)]
pub(super) struct Event {
    /// Number of the leaf in the order of the tree.
    pub leaf: usize,
    /// What it adds to the winding number: 1 where the leaf is entered, -1 where it is left.
    pub turn: i32,
    pub crossing: Crossing,
}

pub(super) type Events = SmallVec<[Event; 16]>;

impl Event {
    /// Interval of t in which the crossing certainly is.
    fn range(&self) -> [f64; 2] {
        let Crossing { hit, error, .. } = self.crossing;
        [hit.t - error, hit.t + error]
    }
}

/// Takes out of the events from `first` on, which are those of one leaf in order, pairs of which it isn't
/// certain that they are there: entering and leaving again, or the reverse, while the line all but touches.
/// Their bounds, which may be as large as the leaf, would draw in what has nothing to do with them.
pub(super) fn without_touches(events: &mut Events, first: usize) {
    let mut kept = first;
    for next in first..events.len() {
        let event = events[next];
        let touches = kept > first && {
            let last = &events[kept - 1];
            let apart = event.crossing.hit.t - last.crossing.hit.t;
            last.turn + event.turn == 0 && apart <= 2.0 * last.crossing.error.min(event.crossing.error)
        };
        if touches {
            kept -= 1;
        } else {
            events[kept] = event;
            kept += 1;
        }
    }
    events.truncate(kept);
}

/// How many of the events, which are in order, are at the place of the first: those that may all be at one
/// and the same place. That they have to share one keeps chains from growing by what is near but not there.
pub(super) fn first(events: &[Event]) -> usize {
    let Some((start, rest)) = events.split_first() else { return 0 };
    let [mut low, mut high] = start.range();
    let shared = rest.iter().take_while(|event| {
        let [from, to] = event.range();
        (low, high) = (low.max(from), high.min(to));
        low <= high
    });
    1 + shared.count()
}
