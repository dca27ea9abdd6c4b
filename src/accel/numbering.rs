//! One number for the instance that a ray met, however many stand around it.

use super::Instance;
use crate::shape::NO_INSTANCE;

/// Numbers for the instances of a tree and for those within them: first an instance, then all that its group
/// shows, then the next instance. So a hit carries one number and no list, and a thousand million instances
/// take no memory but that of the groups.
#[derive(Clone, Debug, Default)]
pub(super) struct Numbering {
    /// The number of each of the tree's own instances. Empty where no group shows others: then it is the
    /// index.
    firsts: Vec<u32>,
    /// How many numbers there are.
    pub count: u64,
}

impl Numbering {
    /// Numbers beyond those of `u32` mean nothing: whoever builds trees asks for their count before.
    pub fn new(instances: &[Instance]) -> Self {
        let counts = || instances.iter().map(|instance| 1 + instance.group().instance_count());
        let mut count = 0_u64;
        let mut first = |own: u64| {
            let first = count as u32;
            count = count.saturating_add(own);
            first
        };
        let nested = counts().any(|count| count > 1);
        let firsts: Vec<u32> = counts().map(&mut first).collect();
        Self { firsts: if nested { firsts } else { Vec::new() }, count }
    }

    /// The number for what is met by the instance of an index, and within it by that of a number.
    pub fn joined(&self, index: u32, inner: u32) -> u32 {
        match self.firsts.get(index as usize) {
            None => index,
            Some(first) if inner == NO_INSTANCE => *first,
            Some(first) => first + 1 + inner,
        }
    }

    /// The index and the number within: the inverse of [`Self::joined`].
    #[inline]
    pub fn split(&self, number: u32) -> (u32, u32) {
        if self.firsts.is_empty() {
            return (number, NO_INSTANCE);
        }
        let index = self.firsts.partition_point(|&first| first <= number) - 1;
        let inner = (number - self.firsts[index]).checked_sub(1).unwrap_or(NO_INSTANCE);
        (index as u32, inner)
    }

    pub fn memory(&self) -> usize {
        size_of_val(&self.firsts[..])
    }
}
