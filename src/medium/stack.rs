//! The bodies that a ray has entered and not left, and the medium of the innermost.

use crate::spectrum::Spectrum;
use smallvec::SmallVec;

/// What a closed surface encloses.
#[derive(Clone, Debug)]
pub struct Body {
    /// Refractive index inside, for what refracts.
    pub index: Option<Spectrum>,
    /// What the surface parts the index from.
    pub refraction: Refraction,
    /// The medium on the surface's back.
    pub interior: Filling,
    /// The medium on the surface's front.
    pub exterior: Filling,
    /// Where bodies overlap, the one of the highest priority counts alone, and of equal ones the one entered
    /// last.
    pub priority: i32,
    /// Whether its surface is closed and faces outward, so that lines enter and leave it by turns.
    pub closed: bool,
    /// The same number for bodies of the same index; 0 for air and for none.
    pub index_class: u32,
}

/// What a body's surface parts its index from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refraction {
    /// There is no index.
    None,
    /// From that of whatever is around it, so that it covers all that lies beneath it in the order of
    /// precedence.
    Surroundings,
    /// From another one that the file states. The surface is that wherever it lies, as in Mitsuba 3, and
    /// neither hides others nor takes account of them.
    Stated,
}

/// A body where an instance of it stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Entered {
    /// Number of the body.
    pub body: u32,
    /// Number of the instance that it belongs to.
    pub instance: u32,
}

/// The medium that a surface's file states for one of its sides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filling {
    /// None is stated: the medium of the other side goes on here.
    Unspecified,
    /// Nothing that absorbs or scatters.
    Vacuum,
    /// The medium of this index.
    Medium(u32),
}

/// The bodies that a path is inside of, in the order of their priorities, of equal ones in the order in which
/// they were entered: the last one counts (Schmidt and Budge, "Simple nested dielectrics in ray traced
/// images", JGT 7(2), 2002).
///
/// Leaving removes the body that is left, wherever it stands, so bodies that overlap instead of nesting are
/// left correctly too. A surface that is no closed body may be entered here and left elsewhere, by way of one
/// that is made of the same: that is how the panes of a block and the inner wall of a hollow ball go
/// together.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct MediumStack {
    /// Hardly a scene has more within one another than there is room for in place.
    bodies: SmallVec<[Entered; 4]>,
    /// The medium outside all bodies.
    beyond: Option<u32>,
}

impl Clone for MediumStack {
    fn clone(&self) -> Self {
        // The stacks of most paths that split are empty.
        if self.bodies.is_empty() {
            return Self::outside(self.beyond);
        }
        Self { bodies: SmallVec::from_slice(&self.bodies), beyond: self.beyond }
    }

    /// Without asking for memory again.
    fn clone_from(&mut self, source: &Self) {
        self.bodies.clear();
        self.bodies.extend_from_slice(&source.bodies);
        self.beyond = source.beyond;
    }
}

impl MediumStack {
    /// Outside all bodies, in a medium or in none.
    pub fn outside(beyond: Option<u32>) -> Self {
        Self { beyond, ..Self::default() }
    }

    /// The index of what surrounds `body`, on the other side of its surface: that of what lies beneath it.
    pub fn index_around<'a>(&self, body: Entered, leaving: bool, bodies: &'a [Body]) -> Option<&'a Spectrum> {
        let end = if leaving { self.standing_for(body, bodies) } else { self.position(body) };
        let beneath = &self.bodies[..end.unwrap_or(self.bodies.len())];
        refracting(beneath, bodies).and_then(|entered| bodies[entered.body as usize].index.as_ref())
    }

    /// Whether the path is inside of a body.
    pub fn contains(&self, body: Entered) -> bool {
        self.bodies.contains(&body)
    }

    /// What leaves the stack where `body` is left.
    pub fn left_with(&self, body: Entered, bodies: &[Body]) -> Option<Entered> {
        self.standing_for(body, bodies).map(|position| self.bodies[position])
    }

    /// What counts more than `body`, which is here or will be left.
    pub fn above(&self, body: Entered, bodies: &[Body]) -> &[Entered] {
        let position = self.standing_for(body, bodies);
        position.map_or(&[], |position| &self.bodies[position + 1..])
    }

    /// What counts most here and there, where nothing differs, and on either side what lies beneath that.
    pub fn parted<'a>(&'a self, other: &'a Self) -> (&'a [Entered], [&'a [Entered]; 2]) {
        let pairs = self.bodies.iter().rev().zip(other.bodies.iter().rev());
        let same = pairs.take_while(|(a, b)| a == b).count();
        let (own, above) = self.bodies.split_at(self.bodies.len() - same);
        (above, [own, &other.bodies[..other.bodies.len() - same]])
    }

    /// The medium that the ray is in: that of the first body in precedence which says what is in it.
    pub fn medium(&self, bodies: &[Body]) -> Option<u32> {
        let said =
            self.bodies.iter().rev().find_map(|entered| match bodies[entered.body as usize].interior {
                Filling::Unspecified => None,
                Filling::Vacuum => Some(None),
                Filling::Medium(medium) => Some(Some(medium)),
            });
        said.unwrap_or(self.beyond)
    }

    /// Adds a body, below those of higher priority.
    pub fn enter(&mut self, body: Entered, bodies: &[Body]) {
        let Body { priority, closed, .. } = bodies[body.body as usize];
        // What is entered once more has been left where it has no surface.
        if let Some(position) = self.position(body).filter(|_| !closed) {
            self.bodies.remove(position);
        }
        let above = |entered: &&Entered| bodies[entered.body as usize].priority > priority;
        let above = self.bodies.iter().rev().take_while(above).count();
        self.bodies.insert(self.bodies.len() - above, body);
    }

    /// Leaves a body for what its surface says is outside, or else for what surrounds it. A body that was
    /// never entered is one that the path began in.
    pub fn leave(&mut self, body: Entered, bodies: &[Body]) {
        let says = |entered: &Entered| bodies[entered.body as usize].interior != Filling::Unspecified;
        if let Some(position) = self.standing_for(body, bodies) {
            self.bodies.remove(position);
            if bodies[body.body as usize].closed {
                self.leave_sheets(position, bodies);
            }
            if self.bodies[position..].iter().any(says) {
                return;
            }
        } else if says(&body) {
            self.beyond = None;
        }
        let Filling::Medium(outside) = bodies[body.body as usize].exterior else { return };
        if self.medium(bodies) != Some(outside) {
            // The file contradicts what was entered: the surface at hand is believed.
            self.bodies.retain(|entered| !says(entered));
            self.beyond = Some(outside);
        }
    }

    /// Forgets the open surfaces, from a position on, that state the media on both of their sides. Such a
    /// sheet parts media within the body that it stands in, and encloses nothing that goes on beyond it.
    fn leave_sheets(&mut self, position: usize, bodies: &[Body]) {
        let mut place = 0;
        self.bodies.retain(|entered| {
            let &Body { closed, refraction, interior, exterior, .. } = &bodies[entered.body as usize];
            let states_both = interior != Filling::Unspecified && exterior != Filling::Unspecified;
            place += 1;
            place <= position || closed || refraction != Refraction::None || !states_both
        });
    }

    fn position(&self, body: Entered) -> Option<usize> {
        self.bodies.iter().rposition(|&entered| entered == body)
    }

    /// Where a body is that is being left. One that was never entered, or that another surface has led into,
    /// is the last one made of the same, if one of the two is open.
    fn standing_for(&self, body: Entered, bodies: &[Body]) -> Option<usize> {
        let same = |entered: &Entered| {
            let [own, other] = [body, *entered].map(|entered| &bodies[entered.body as usize]);
            !(own.closed && other.closed)
                && (own.refraction, own.index_class, own.interior)
                    == (other.refraction, other.index_class, other.interior)
        };
        self.position(body).or_else(|| self.bodies.iter().rposition(same))
    }
}

/// The body whose index counts, among bodies in the order of their precedence.
pub fn refracting(stack: &[Entered], bodies: &[Body]) -> Option<Entered> {
    stack.iter().rev().copied().find(|entered| bodies[entered.body as usize].index.is_some())
}

/// What a path is in, and what is behind the surface that it met last.
#[derive(Clone, Debug, Default)]
pub struct Media {
    /// The bodies around the path.
    pub here: MediumStack,
    /// Only where surfaces are met together or hidden: see [`crate::scene::Features::interface_events`].
    pub beyond: MediumStack,
}

impl Media {
    /// A path that begins within these bodies.
    pub fn of(here: MediumStack) -> Self {
        Self { here, beyond: MediumStack::default() }
    }

    /// The index that a surface which was met has on its outer side.
    pub fn index_outside<'a>(&self, from_front: bool, bodies: &'a [Body]) -> Option<&'a Spectrum> {
        let (_, [here, beyond]) = self.here.parted(&self.beyond);
        refracting(if from_front { here } else { beyond }, bodies)
            .and_then(|entered| bodies[entered.body as usize].index.as_ref())
    }

    /// Through the surface that was met last.
    pub fn cross(&mut self) {
        std::mem::swap(&mut self.here, &mut self.beyond);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn body(index: f64, interior: Filling) -> Body {
        Body {
            index: Some(Spectrum::Constant(index)),
            refraction: Refraction::Surroundings,
            interior,
            exterior: Filling::Unspecified,
            priority: 0,
            closed: true,
            index_class: 1,
        }
    }

    fn at(body: u32) -> Entered {
        Entered { body, instance: 0 }
    }

    fn index_around(stack: &MediumStack, id: u32, bodies: &[Body]) -> Option<f64> {
        stack.index_around(at(id), true, bodies).map(|index| index.at(550.0))
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
        assert_eq!(stack, MediumStack::default());
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
        let bodies = [body(1.5, Filling::Unspecified), body(1.5, Filling::Vacuum)];
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
        assert_eq!((stack.bodies.last().copied(), stack.medium(&bodies)), (Some(at(0)), Some(0)));
        stack.enter(at(2), &bodies);
        stack.leave(at(0), &bodies);
        assert_eq!((stack.bodies.last().copied(), stack.medium(&bodies)), (Some(at(2)), Some(2)));
        stack.enter(at(0), &bodies);
        stack.leave(at(2), &bodies);
        assert_eq!(refracting(&stack.bodies, &bodies), Some(at(0)));
        assert!(stack.contains(at(1)) && !stack.contains(at(2)));
        stack.leave(at(0), &bodies);
        assert_eq!(stack.bodies.last().copied(), Some(at(1)));
    }

    /// However many; in a body that is never left and entered again a path is but once.
    #[test]
    fn no_body_is_forgotten() {
        let mut bodies: Vec<Body> = (0..100).map(|i| body(1.0 + f64::from(i), Filling::Medium(i))).collect();
        let mut stack = MediumStack::default();
        (0..100).for_each(|id| stack.enter(at(id), &bodies));
        for id in (0..100).rev() {
            assert_eq!(stack.medium(&bodies), Some(id));
            stack.leave(at(id), &bodies);
        }
        assert_eq!(stack, MediumStack::default());
        bodies[0].closed = false;
        (0..100).for_each(|_| stack.enter(at(0), &bodies));
        stack.leave(at(0), &bodies);
        assert_eq!(stack, MediumStack::default());
    }

    /// What a closed body absorbs outside says nothing of what it is left beneath.
    #[test]
    fn leaving_beneath_another_body_leaves_its_medium() {
        let mut bodies: Vec<Body> = (0..2).map(|i| body(1.5, Filling::Medium(i))).collect();
        bodies[0].exterior = Filling::Medium(7);
        let mut stack = MediumStack::outside(Some(7));
        stack.enter(at(0), &bodies);
        stack.enter(at(1), &bodies);
        stack.leave(at(0), &bodies);
        assert!(stack.contains(at(1)));
        stack.leave(at(1), &bodies);
        assert_eq!(stack.medium(&bodies), Some(7));
    }

    /// A sheet that names the fog on both of its sides, in a body of fog. The fog ends with the body,
    /// whichever way the sheet is passed.
    #[test]
    fn a_sheet_within_a_body_is_left_with_the_body() {
        for below in [0, 1] {
            let sheet = Body {
                index: None,
                refraction: Refraction::None,
                exterior: Filling::Medium(0),
                closed: false,
                index_class: 0,
                ..body(1.0, Filling::Medium(below))
            };
            let fog = Body { exterior: Filling::Unspecified, closed: true, ..sheet.clone() };
            let bodies = [Body { interior: Filling::Medium(0), ..fog }, sheet];
            let mut stack = MediumStack::default();
            stack.enter(at(0), &bodies);
            stack.enter(at(1), &bodies);
            assert_eq!(stack.medium(&bodies), Some(below));
            stack.leave(at(0), &bodies);
            assert_eq!(stack.medium(&bodies), None);
            stack.enter(at(0), &bodies);
            stack.leave(at(1), &bodies);
            assert_eq!(stack.medium(&bodies), Some(0));
            stack.leave(at(0), &bodies);
            assert_eq!(stack.medium(&bodies), None);
        }
    }

    /// The panes of a block, and the inner wall of a hollow body, which faces what is hollow.
    #[test]
    fn open_surfaces_of_the_same_glass_lead_in_and_out() {
        let mut bodies = vec![body(1.5, Filling::Medium(0)); 2];
        bodies[1].closed = false;
        let mut stack = MediumStack::default();
        stack.enter(at(0), &bodies);
        assert_eq!(index_around(&stack, 1, &bodies), None);
        stack.leave(at(1), &bodies);
        assert_eq!(stack, MediumStack::default());
        stack.enter(at(1), &bodies);
        stack.leave(at(0), &bodies);
        assert_eq!(stack, MediumStack::default());
        // Closed bodies are taken for one another never.
        bodies[1].closed = true;
        stack.enter(at(1), &bodies);
        stack.leave(at(0), &bodies);
        assert!(stack.contains(at(1)));
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
