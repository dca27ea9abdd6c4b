//! Progress of a render: reports, and the wish to stop.

use super::{Chosen, Work};
use std::sync::atomic::AtomicBool;

/// Receives the progress of a render, and may stop it.
pub trait Progress: Sync {
    /// Called when the pilots are done, if there are any, and the picture begins: how it is rendered.
    fn pilots_done(&self, _: &Chosen) {}

    /// Called after each piece of work with the number of its samples.
    fn advanced(&self, samples: u64);

    /// Called when every pixel has its share of the samples again.
    fn pass_done(&self, work: &Work);

    /// Asked after each piece of work: whether [`Self::keep`] is to be called.
    fn wants_to_keep(&self) -> bool {
        false
    }

    /// Called with all that is done so far. Nothing is added to it meanwhile.
    fn keep(&self, _: &Work) {}

    /// Once true, the tiles under way are finished and no others begun.
    fn stop(&self) -> &AtomicBool;
}

/// Ignores all reports and never stops.
pub struct NoProgress(AtomicBool);

impl NoProgress {
    /// Shows nothing and never stops a render.
    pub const fn new() -> Self {
        Self(AtomicBool::new(false))
    }
}

impl Default for NoProgress {
    fn default() -> Self {
        Self::new()
    }
}

impl Progress for NoProgress {
    fn advanced(&self, _: u64) {}

    fn pass_done(&self, _: &Work) {}

    fn stop(&self) -> &AtomicBool {
        &self.0
    }
}
