//! What a ray travels through: the bodies that it has entered and not left, and the absorbing medium of the innermost.

use crate::spectrum::Spectrum;

/// What a closed surface encloses.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Refractive index inside, for what refracts.
    pub index: Option<Spectrum>,
    pub interior: Filling,
    pub exterior: Filling,
}

/// What a surface says of the space on one side of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filling {
    /// Nothing: whatever is on the other side goes on here.
    Unsaid,
    /// Nothing that absorbs.
    Vacuum,
    /// The absorption of this index.
    Medium(u32),
}

/// The bodies that a path is inside of, innermost last.
///
/// Leaving removes the body that is left, wherever it stands, so bodies that overlap instead of nesting are left
/// correctly too. A surface that is no closed body is entered and never left; past the stack's depth the
/// outermost body is forgotten.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MediumStack {
    bodies: [u32; Self::DEPTH],
    depth: u8,
    /// What absorbs outside all bodies.
    beyond: Option<u32>,
}

impl MediumStack {
    pub const DEPTH: usize = 8;

    /// Outside all bodies, in a medium or in none.
    pub fn outside(beyond: Option<u32>) -> Self {
        Self { beyond, ..Self::default() }
    }

    /// The index of what surrounds `body`: on the other side of its surface.
    pub fn index_around<'a>(&self, body: u32, bodies: &'a [Body]) -> Option<&'a Spectrum> {
        let skip = self.inside().iter().rposition(|&entered| entered == body);
        let rest = self.inside().iter().enumerate().rev().filter(|&(i, _)| Some(i) != skip);
        rest.into_iter().find_map(|(_, &entered)| bodies[entered as usize].index.as_ref())
    }

    /// The medium that the ray is in: that of the innermost body which says what is in it.
    pub fn medium(&self, bodies: &[Body]) -> Option<u32> {
        let said = self.inside().iter().rev().find_map(|&body| match bodies[body as usize].interior {
            Filling::Unsaid => None,
            Filling::Vacuum => Some(None),
            Filling::Medium(medium) => Some(Some(medium)),
        });
        said.unwrap_or(self.beyond)
    }

    pub fn enter(&mut self, body: u32) {
        if usize::from(self.depth) == Self::DEPTH {
            self.bodies.rotate_left(1);
            self.depth -= 1;
        }
        self.bodies[usize::from(self.depth)] = body;
        self.depth += 1;
    }

    /// Leaves a body for what its surface says is outside, or else for what surrounds it. A body that was never entered
    /// is one that the path began in.
    pub fn leave(&mut self, body: u32, bodies: &[Body]) {
        let Body { interior, exterior, .. } = &bodies[body as usize];
        if let Some(position) = self.inside().iter().rposition(|&entered| entered == body) {
            self.remove(position);
        } else if *interior != Filling::Unsaid {
            self.beyond = None;
        }
        let Filling::Medium(outside) = *exterior else { return };
        if self.medium(bodies) != Some(outside) {
            // The file contradicts what was entered: the surface at hand is believed.
            while let Some(position) =
                self.inside().iter().position(|&entered| bodies[entered as usize].interior != Filling::Unsaid)
            {
                self.remove(position);
            }
            self.beyond = Some(outside);
        }
    }

    fn remove(&mut self, position: usize) {
        self.bodies[position..usize::from(self.depth)].rotate_left(1);
        self.depth -= 1;
    }

    fn inside(&self) -> &[u32] {
        &self.bodies[..usize::from(self.depth)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn body(index: f64, interior: Filling) -> Body {
        Body { index: Some(Spectrum::Constant(index)), interior, exterior: Filling::Unsaid }
    }

    fn index_around(stack: &MediumStack, id: u32, bodies: &[Body]) -> Option<f64> {
        stack.index_around(id, bodies).map(|index| index.at(550.0))
    }

    #[test]
    fn water_in_glass_in_air() {
        let bodies = [body(1.5, Filling::Medium(0)), body(1.33, Filling::Medium(1))];
        let (glass, water) = (0, 1);
        let mut stack = MediumStack::default();
        assert_eq!(stack.medium(&bodies), None);
        stack.enter(glass);
        stack.enter(water);
        assert_eq!(stack.medium(&bodies), Some(1));
        assert_eq!(index_around(&stack, water, &bodies), Some(1.5));
        stack.leave(water, &bodies);
        assert_eq!(stack.medium(&bodies), Some(0));
        assert_eq!(index_around(&stack, glass, &bodies), None);
        stack.leave(glass, &bodies);
        stack.leave(glass, &bodies);
        assert_eq!(stack, MediumStack { bodies: stack.bodies, ..MediumStack::default() });
    }

    #[test]
    fn overlapping_bodies_are_left_in_any_order() {
        let bodies: Vec<Body> = (0..4).map(|i| body(1.0, Filling::Medium(i))).collect();
        let mut stack = MediumStack::default();
        [1, 2, 3].into_iter().for_each(|body| stack.enter(body));
        stack.leave(1, &bodies);
        assert_eq!(stack.medium(&bodies), Some(3));
        stack.leave(3, &bodies);
        assert_eq!(stack.medium(&bodies), Some(2));
    }

    #[test]
    fn a_surface_that_is_never_left_does_not_fill_the_stack() {
        let bodies: Vec<Body> = (0..100).map(|i| body(1.0, Filling::Medium(i))).collect();
        let mut stack = MediumStack::default();
        (0..100).for_each(|body| stack.enter(body));
        assert_eq!(stack.medium(&bodies), Some(99));
    }

    #[test]
    fn glass_that_says_nothing_is_filled_with_the_fog_around_it() {
        let bodies = [body(1.5, Filling::Unsaid), body(1.5, Filling::Vacuum)];
        let mut stack = MediumStack::outside(Some(7));
        stack.enter(0);
        assert_eq!(stack.medium(&bodies), Some(7));
        stack.enter(1);
        assert_eq!(stack.medium(&bodies), None);
        stack.leave(1, &bodies);
        stack.leave(0, &bodies);
        assert_eq!(stack.medium(&bodies), Some(7));
    }

    #[test]
    fn a_path_that_begins_within_a_body_leaves_it_for_what_is_outside() {
        let mut bodies = [body(1.0, Filling::Medium(3))];
        let mut stack = MediumStack::outside(Some(3));
        stack.leave(0, &bodies);
        assert_eq!(stack.medium(&bodies), None);
        bodies[0].exterior = Filling::Medium(4);
        stack.leave(0, &bodies);
        assert_eq!(stack.medium(&bodies), Some(4));
    }
}
