//! What waits during a traversal.

use super::node::Child;
use std::mem::MaybeUninit;

/// A subtree that waits to be visited, and where the ray enters it. Greater ones are entered later.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Waiting(u64);

impl Waiting {
    /// `entry` is not negative: then the order of the bits is that of the numbers.
    #[inline(always)]
    pub fn new(entry: f32, child: Child) -> Self {
        Self(u64::from(entry.to_bits()) << 32 | u64::from(child.to_bits()))
    }

    pub fn entry(self) -> f32 {
        f32::from_bits((self.0 >> 32) as u32)
    }

    pub fn child(self) -> Child {
        Child::from_bits(self.0 as u32)
    }
}

/// A stack over borrowed room. That is not initialised: to fill it would take longer than many a query.
pub(super) struct Stack<'a> {
    /// Those before `len` are initialised.
    room: &'a mut [MaybeUninit<Waiting>],
    len: usize,
}

impl<'a> Stack<'a> {
    /// An item of room.
    pub const UNUSED: MaybeUninit<Waiting> = MaybeUninit::uninit();

    pub fn new(room: &'a mut [MaybeUninit<Waiting>]) -> Self {
        Self { room, len: 0 }
    }

    pub fn len(&self) -> usize {
        self.len
    }

    #[inline(always)]
    pub fn push(&mut self, item: Waiting) {
        self.room[self.len].write(item);
        self.len += 1;
    }

    /// Pushes below those items from `bottom` on that are entered sooner. These have to be sorted, the soonest on top.
    #[inline(always)]
    pub fn insert(&mut self, bottom: usize, item: Waiting) {
        let mut place = self.len;
        while place > bottom && self.get(place - 1) < item {
            self.room[place] = self.room[place - 1];
            place -= 1;
        }
        self.room[place].write(item);
        self.len += 1;
    }

    #[inline(always)]
    pub fn pop(&mut self) -> Option<Waiting> {
        let top = self.len.checked_sub(1)?;
        let item = self.get(top);
        self.len = top;
        Some(item)
    }

    #[inline(always)]
    fn get(&self, index: usize) -> Waiting {
        debug_assert!(index < self.len);
        // SAFETY: `push` and `insert` initialise all items before `len`, and only these are asked for.
        unsafe { self.room[index].assume_init() }
    }
}
