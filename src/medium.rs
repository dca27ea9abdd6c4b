//! What a ray travels through: the dielectrics that it has entered and not left.

/// The bodies that a path is inside of, innermost last.
///
/// Leaving removes the body that is left, wherever it stands, so bodies that overlap instead of nesting are left
/// correctly too. A surface that is no closed body is entered and never left; past the stack's depth the
/// outermost body is forgotten.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MediumStack {
    bodies: [u32; Self::DEPTH],
    depth: u8,
}

impl MediumStack {
    pub const DEPTH: usize = 8;

    /// The body that surrounds the ray; `None` outside all.
    pub fn innermost(&self) -> Option<u32> {
        self.inside().last().copied()
    }

    /// What surrounds the ray apart from `body`: on the other side of its surface.
    pub fn around(&self, body: u32) -> Option<u32> {
        let skip = self.inside().iter().rposition(|&entered| entered == body);
        let mut rest = self.inside().iter().enumerate().rev().filter(|&(i, _)| Some(i) != skip);
        rest.next().map(|(_, &entered)| entered)
    }

    pub fn enter(&mut self, body: u32) {
        if usize::from(self.depth) == Self::DEPTH {
            self.bodies.rotate_left(1);
            self.depth -= 1;
        }
        self.bodies[usize::from(self.depth)] = body;
        self.depth += 1;
    }

    pub fn leave(&mut self, body: u32) {
        if let Some(position) = self.inside().iter().rposition(|&entered| entered == body) {
            self.bodies[position..usize::from(self.depth)].rotate_left(1);
            self.depth -= 1;
        }
    }

    fn inside(&self) -> &[u32] {
        &self.bodies[..usize::from(self.depth)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn water_in_glass_in_air() {
        let (glass, water) = (4, 7);
        let mut stack = MediumStack::default();
        assert_eq!(stack.innermost(), None);
        stack.enter(glass);
        stack.enter(water);
        assert_eq!(stack.innermost(), Some(water));
        assert_eq!(stack.around(water), Some(glass));
        stack.leave(water);
        assert_eq!((stack.innermost(), stack.around(glass)), (Some(glass), None));
        stack.leave(glass);
        stack.leave(glass);
        assert_eq!(stack, MediumStack { bodies: stack.bodies, depth: 0 });
    }

    #[test]
    fn overlapping_bodies_are_left_in_any_order() {
        let mut stack = MediumStack::default();
        [1, 2, 3].into_iter().for_each(|body| stack.enter(body));
        stack.leave(1);
        assert_eq!(stack.innermost(), Some(3));
        stack.leave(3);
        assert_eq!(stack.innermost(), Some(2));
    }

    #[test]
    fn a_surface_that_is_never_left_does_not_fill_the_stack() {
        let mut stack = MediumStack::default();
        (0..100).for_each(|body| stack.enter(body));
        assert_eq!(stack.innermost(), Some(99));
    }
}
