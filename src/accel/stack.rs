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

    /// Pushes below those items from `bottom` on that are entered sooner. These have to be sorted, the
    /// soonest on top.
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
    #[allow(unsafe_code, reason = "to fill the room first would take longer than many a query")]
    fn get(&self, index: usize) -> Waiting {
        debug_assert!(index < self.len);
        // SAFETY: `push` and `insert` initialise all items before `len`, and only these are asked for.
        unsafe { self.room[index].assume_init() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Siblings come out as they are entered, after them what waited before.
    #[test]
    fn the_soonest_sibling_is_on_top() {
        let mut room = [Stack::UNUSED; 8];
        let mut stack = Stack::new(&mut room);
        let item = |entry: f32, index: usize| Waiting::new(entry, Child::of_node(index));
        stack.push(item(0.5, 9));
        let bottom = stack.len();
        for (index, entry) in [3.0, 1e-30, f32::INFINITY, 0.0, 2.0].into_iter().enumerate() {
            stack.insert(bottom, item(entry, index));
        }
        let popped: Vec<_> =
            std::iter::from_fn(|| stack.pop()).map(|item| (item.entry(), item.child())).collect();
        let expected = [(0.0, 3), (1e-30, 1), (2.0, 4), (3.0, 0), (f32::INFINITY, 2), (0.5, 9)];
        assert_eq!(popped, expected.map(|(entry, index)| (entry, Child::of_node(index))));
    }
}
