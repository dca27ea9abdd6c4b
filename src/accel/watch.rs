//! What a query of a tree takes, for whoever wants to know.

use std::cell::Cell;
use std::ops::AddAssign;

/// Is told of the steps of a query. It goes by value, so that the one that ignores them takes no argument.
pub(super) trait Watch: Copy {
    /// A node: how many boxes it has, and how many of them the ray enters.
    fn node(self, boxes: impl FnOnce() -> usize, entered: u32);

    /// A packet of four triangles.
    fn packet(self);

    /// A surface that is no triangle, or a group of them.
    fn surface(self);

    /// A leaf, and whether anything in it was hit.
    fn leaf(self, hit: bool);
}

/// Ignores all of it.
#[derive(Clone, Copy)]
pub(super) struct Unwatched;

impl Watch for Unwatched {
    #[inline(always)]
    fn node(self, _: impl FnOnce() -> usize, _: u32) {}

    #[inline(always)]
    fn packet(self) {}

    #[inline(always)]
    fn surface(self) {}

    #[inline(always)]
    fn leaf(self, _: bool) {}
}

/// What queries have taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tests {
    /// Nodes that were visited.
    pub nodes: u64,
    /// Boxes that the ray was tested against, eight at once.
    pub boxes: u64,
    /// Those that the ray enters. Some lie behind a hit that is found sooner, and are left out.
    pub entered: u64,
    /// Packets of four triangles.
    pub packets: u64,
    /// Surfaces that are no triangles, and groups of them.
    pub surfaces: u64,
    /// Leaves that were visited.
    pub leaves: u64,
    /// Boxes that were visited with nothing hit in them: leaves in which nothing was hit (or nothing nearer
    /// than what was known), and nodes of which the ray enters no box.
    pub empty: u64,
}

impl AddAssign for Tests {
    fn add_assign(&mut self, other: Self) {
        self.nodes += other.nodes;
        self.boxes += other.boxes;
        self.entered += other.entered;
        self.packets += other.packets;
        self.surfaces += other.surfaces;
        self.leaves += other.leaves;
        self.empty += other.empty;
    }
}

/// Adds what a step takes.
fn count(tests: &Cell<Tests>, step: Tests) {
    let mut sum = tests.get();
    sum += step;
    tests.set(sum);
}

impl Watch for &Cell<Tests> {
    fn node(self, boxes: impl FnOnce() -> usize, entered: u32) {
        count(
            self,
            Tests {
                nodes: 1,
                boxes: boxes() as u64,
                entered: u64::from(entered),
                empty: u64::from(entered == 0),
                ..Tests::default()
            },
        );
    }

    fn packet(self) {
        count(self, Tests { packets: 1, ..Tests::default() });
    }

    fn surface(self) {
        count(self, Tests { surfaces: 1, ..Tests::default() });
    }

    fn leaf(self, hit: bool) {
        count(self, Tests { leaves: 1, empty: u64::from(!hit), ..Tests::default() });
    }
}
