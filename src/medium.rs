//! What a ray travels through: the bodies that it has entered and not left, and the absorbing medium of the innermost.

use crate::spectrum::Spectrum;

/// What a closed surface encloses.
#[derive(Clone, Debug)]
pub struct Body {
    /// Refractive index inside, for what refracts.
    pub index: Option<Spectrum>,
    pub interior: Filling,
    pub exterior: Filling,
    /// Where bodies overlap, the one of the highest priority counts alone, and of equal ones the one entered last.
    pub priority: i32,
    /// Whether its surface is closed and faces outward, so that lines enter and leave it by turns.
    pub closed: bool,
    /// The same number for bodies of the same index; 0 for air and for none.
    pub index_class: u32,
}

/// A body where an instance of it stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Entered {
    pub body: u32,
    pub instance: u32,
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

/// The bodies that a path is inside of, in the order of their priorities, of equal ones in the order in which they were
/// entered: the last one counts (Schmidt and Budge, "Simple nested dielectrics in ray traced images", JGT 7(2), 2002).
///
/// Leaving removes the body that is left, wherever it stands, so bodies that overlap instead of nesting are left
/// correctly too. A surface that is no closed body is entered and never left; past the stack's depth the
/// outermost body is forgotten.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MediumStack {
    bodies: [Entered; Self::DEPTH],
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
    pub fn index_around<'a>(&self, body: Entered, bodies: &'a [Body]) -> Option<&'a Spectrum> {
        let skip = self.inside().iter().rposition(|&entered| entered == body);
        let rest = self.inside().iter().enumerate().rev().filter(|&(i, _)| Some(i) != skip);
        rest.into_iter().find_map(|(_, entered)| bodies[entered.body as usize].index.as_ref())
    }

    /// The body whose index counts.
    pub fn refracting(&self, bodies: &[Body]) -> Option<Entered> {
        self.inside().iter().rev().copied().find(|entered| bodies[entered.body as usize].index.is_some())
    }

    /// The body that counts.
    pub fn first(&self) -> Option<Entered> {
        self.inside().last().copied()
    }

    pub fn contains(&self, body: Entered) -> bool {
        self.inside().contains(&body)
    }

    /// The medium that the ray is in: that of the first body in precedence which says what is in it.
    pub fn medium(&self, bodies: &[Body]) -> Option<u32> {
        let said =
            self.inside().iter().rev().find_map(|entered| match bodies[entered.body as usize].interior {
                Filling::Unsaid => None,
                Filling::Vacuum => Some(None),
                Filling::Medium(medium) => Some(Some(medium)),
            });
        said.unwrap_or(self.beyond)
    }

    pub fn enter(&mut self, body: Entered, bodies: &[Body]) {
        if usize::from(self.depth) == Self::DEPTH {
            self.remove(0);
        }
        let priority = |entered: Entered| bodies[entered.body as usize].priority;
        let above =
            self.inside().iter().rev().take_while(|&&entered| priority(entered) > priority(body)).count();
        let last = usize::from(self.depth);
        self.bodies[last] = body;
        self.bodies[last - above..=last].rotate_right(1);
        self.depth += 1;
    }

    /// Leaves a body for what its surface says is outside, or else for what surrounds it. A body that was never entered
    /// is one that the path began in.
    pub fn leave(&mut self, body: Entered, bodies: &[Body]) {
        let Body { interior, exterior, .. } = &bodies[body.body as usize];
        if let Some(position) = self.inside().iter().rposition(|&entered| entered == body) {
            self.remove(position);
        } else if *interior != Filling::Unsaid {
            self.beyond = None;
        }
        let Filling::Medium(outside) = *exterior else { return };
        if self.medium(bodies) != Some(outside) {
            // The file contradicts what was entered: the surface at hand is believed.
            while let Some(position) = self
                .inside()
                .iter()
                .position(|entered| bodies[entered.body as usize].interior != Filling::Unsaid)
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

    fn inside(&self) -> &[Entered] {
        &self.bodies[..usize::from(self.depth)]
    }
}

/// What a path is in, and what is behind the surface that it met last.
#[derive(Clone, Copy, Debug, Default)]
pub struct Media {
    pub here: MediumStack,
    /// Only where surfaces are met together or hidden: see [`crate::scene::Needs::meetings`].
    pub beyond: MediumStack,
}

impl Media {
    pub fn of(here: MediumStack) -> Self {
        Self { here, beyond: here }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn body(index: f64, interior: Filling) -> Body {
        Body {
            index: Some(Spectrum::Constant(index)),
            interior,
            exterior: Filling::Unsaid,
            priority: 0,
            closed: true,
            index_class: 1,
        }
    }

    fn at(body: u32) -> Entered {
        Entered { body, instance: 0 }
    }

    fn index_around(stack: &MediumStack, id: u32, bodies: &[Body]) -> Option<f64> {
        stack.index_around(at(id), bodies).map(|index| index.at(550.0))
    }

    #[test]
    fn water_in_glass_in_air() {
        let bodies = [body(1.5, Filling::Medium(0)), body(1.33, Filling::Medium(1))];
        let (glass, water) = (0, 1);
        let mut stack = MediumStack::default();
        assert_eq!(stack.medium(&bodies), None);
        stack.enter(at(glass), &bodies);
        stack.enter(at(water), &bodies);
        assert_eq!(stack.medium(&bodies), Some(1));
        assert_eq!(index_around(&stack, water, &bodies), Some(1.5));
        stack.leave(at(water), &bodies);
        assert_eq!(stack.medium(&bodies), Some(0));
        assert_eq!(index_around(&stack, glass, &bodies), None);
        stack.leave(at(glass), &bodies);
        stack.leave(at(glass), &bodies);
        assert_eq!(stack, MediumStack { bodies: stack.bodies, ..MediumStack::default() });
    }

    #[test]
    fn overlapping_bodies_are_left_in_any_order() {
        let bodies: Vec<Body> = (0..4).map(|i| body(1.0, Filling::Medium(i))).collect();
        let mut stack = MediumStack::default();
        [1, 2, 3].into_iter().for_each(|body| stack.enter(at(body), &bodies));
        stack.leave(at(1), &bodies);
        assert_eq!(stack.medium(&bodies), Some(3));
        stack.leave(at(3), &bodies);
        assert_eq!(stack.medium(&bodies), Some(2));
    }

    #[test]
    fn a_surface_that_is_never_left_does_not_fill_the_stack() {
        let bodies: Vec<Body> = (0..100).map(|i| body(1.0, Filling::Medium(i))).collect();
        let mut stack = MediumStack::default();
        (0..100).for_each(|body| stack.enter(at(body), &bodies));
        assert_eq!(stack.medium(&bodies), Some(99));
    }

    #[test]
    fn glass_that_says_nothing_is_filled_with_the_fog_around_it() {
        let bodies = [body(1.5, Filling::Unsaid), body(1.5, Filling::Vacuum)];
        let mut stack = MediumStack::outside(Some(7));
        stack.enter(at(0), &bodies);
        assert_eq!(stack.medium(&bodies), Some(7));
        stack.enter(at(1), &bodies);
        assert_eq!(stack.medium(&bodies), None);
        stack.leave(at(1), &bodies);
        stack.leave(at(0), &bodies);
        assert_eq!(stack.medium(&bodies), Some(7));
    }

    #[test]
    fn a_path_that_begins_within_a_body_leaves_it_for_what_is_outside() {
        let mut bodies = [body(1.0, Filling::Medium(3))];
        let mut stack = MediumStack::outside(Some(3));
        stack.leave(at(0), &bodies);
        assert_eq!(stack.medium(&bodies), None);
        bodies[0].exterior = Filling::Medium(4);
        stack.leave(at(0), &bodies);
        assert_eq!(stack.medium(&bodies), Some(4));
    }

    #[test]
    fn the_highest_priority_counts_and_of_equal_ones_the_last() {
        let mut bodies: Vec<Body> = (0..3).map(|i| body(1.0 + f64::from(i), Filling::Medium(i))).collect();
        (bodies[0].priority, bodies[1].priority, bodies[2].priority) = (5, 1, 1);
        let mut stack = MediumStack::default();
        stack.enter(at(0), &bodies);
        stack.enter(at(1), &bodies);
        assert_eq!((stack.first(), stack.medium(&bodies)), (Some(at(0)), Some(0)));
        stack.enter(at(2), &bodies);
        stack.leave(at(0), &bodies);
        assert_eq!((stack.first(), stack.medium(&bodies)), (Some(at(2)), Some(2)));
        stack.enter(at(0), &bodies);
        stack.leave(at(2), &bodies);
        assert_eq!(stack.refracting(&bodies), Some(at(0)));
        assert!(stack.contains(at(1)) && !stack.contains(at(2)));
        stack.leave(at(0), &bodies);
        assert_eq!(stack.first(), Some(at(1)));
    }

    /// Instances of one body are bodies of their own.
    #[test]
    fn instances_are_told_apart() {
        let bodies = [body(1.5, Filling::Medium(0))];
        let mut stack = MediumStack::default();
        stack.enter(Entered { body: 0, instance: 3 }, &bodies);
        stack.leave(Entered { body: 0, instance: 4 }, &bodies);
        assert!(stack.contains(Entered { body: 0, instance: 3 }));
    }
}
