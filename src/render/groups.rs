//! How the pixels of a film are dealt into groups that share work.

use crate::integrator::{Plan, Sharing};
use crate::sampling::{Member, mix};
use crate::scene::Scene;
use std::ops::Range;

/// Pixels of a group, and what they have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Members {
    /// One pixel, with a time of its own.
    One,
    /// Sixteen pixels that are worked on together, each with sample values of its own. They have the time in
    /// common.
    Strangers,
    /// Sixteen pixels that share sample values, too: a Sobol sequence, wavelengths and times.
    Sixteen,
}

impl Members {
    /// As a plan asks for them.
    pub fn of(scene: &Scene, plan: Plan) -> Self {
        match plan.sharing {
            Sharing::Nothing if scene.features().motion => Self::One,
            Sharing::Nothing => Self::Strangers,
            Sharing::Four | Sharing::Sixteen => Self::Sixteen,
        }
    }

    /// Along one side of the group.
    fn edge(self) -> u32 {
        match self {
            Self::One => 1,
            Self::Strangers | Self::Sixteen => 4,
        }
    }

    /// Distance between the members, pixels.
    fn spacing(self) -> u32 {
        match self {
            Self::One | Self::Strangers => 1,
            Self::Sixteen => SPACING,
        }
    }

    /// By how much the second groups of a block across and down begin after the first, beside what lets them
    /// interleave.
    fn stagger(self) -> u32 {
        match self {
            Self::One | Self::Strangers => 0,
            Self::Sixteen => STAGGER,
        }
    }
}

/// Pixels of a group that share lie two pixels apart, so that the groups of a block interleave: what a group
/// has too much of is spread between the pixels of others. They do not begin at the same places, and each net
/// has its blocks elsewhere: no border of groups stays.
#[derive(Clone, Debug)]
pub struct Groups {
    members: Members,
    /// Where the blocks of each net begin, below the edge of a block.
    shifts: Vec<[u32; 2]>,
}

/// Edge of a block, pixels: that of a group of sixteen with those between its members. Blocks follow one
/// another at this distance.
pub const BLOCK: u32 = 8;

/// By how much groups that share begin after others of their block: so their borders lie in the middles of
/// the others.
const STAGGER: u32 = 4;

/// Distance between the members of a group that share, pixels.
const SPACING: u32 = 2;

/// Pixels that are rendered together: whole groups, for one net.
#[derive(Clone, Debug)]
pub struct Block {
    pub net: u32,
    /// The upper left pixel, from the corner of the whole film. It may lie outside.
    pub corner: [i64; 2],
}

/// A pixel of a group, from the corner of the whole film.
#[derive(Clone, Copy, Debug)]
pub struct Pixel {
    pub place: [i64; 2],
    pub member: Member,
}

impl Groups {
    pub fn new(members: Members, nets: u32, seed: u64) -> Self {
        let shift = |net: u32| match members {
            Members::One | Members::Strangers => [0, 0],
            Members::Sixteen => {
                let random = mix(mix(seed) ^ u64::from(net));
                [random as u32 % BLOCK, (random >> 32) as u32 % BLOCK]
            }
        };
        Self { members, shifts: (0..nets).map(shift).collect() }
    }

    /// How many pixels share sample values.
    pub fn sharers(&self) -> u32 {
        match self.members {
            Members::One | Members::Strangers => 1,
            Members::Sixteen => self.members.edge().pow(2),
        }
    }

    /// Edge of the square in which the pixels of a block lie, from the block's corner on.
    pub fn extent_of_block(&self) -> u32 {
        BLOCK + self.members.stagger()
    }

    /// The blocks of a net in which there are pixels of a rectangle, given by the range of its columns and of
    /// its rows.
    pub fn blocks(&self, net: u32, pixels: [Range<i64>; 2]) -> impl Iterator<Item = Block> + use<> {
        let block = i64::from(BLOCK);
        let shift = self.shifts[net as usize].map(i64::from);
        let [columns, rows] = [0, 1].map(|axis| {
            // Groups of the block before may begin within this one.
            let start = pixels[axis].start - i64::from(self.members.stagger());
            let first = (start - shift[axis]).div_euclid(block) * block + shift[axis];
            (first..pixels[axis].end).step_by(BLOCK as usize)
        });
        rows.flat_map(move |y| columns.clone().map(move |x| Block { net, corner: [x, y] }))
    }

    /// The groups of a block, each with its pixels.
    pub fn of(&self, block: &Block) -> impl Iterator<Item = impl Iterator<Item = Pixel> + use<>> + use<> {
        let (edge, spacing, corner) = (self.members.edge(), self.members.spacing(), block.corner);
        let shares = self.sharers() > 1;
        let step = if spacing == 1 { edge } else { 1 + self.members.stagger() };
        let across = BLOCK / edge;
        (0..across * across).map(move |group| {
            let origin = [group % across, group / across];
            let origin: [i64; 2] = std::array::from_fn(|axis| corner[axis] + i64::from(step * origin[axis]));
            (0..edge * edge).map(move |number| {
                let within = square_of(number);
                let place: [i64; 2] =
                    std::array::from_fn(|axis| origin[axis] + i64::from(spacing * within[axis]));
                let (first, number) = if shares { (origin, number) } else { (place, 0) };
                Pixel { place, member: Member { origin: first.map(|place| place as u32), number } }
            })
        })
    }
}

/// Column and row of a member: four that follow one another are a square of two by two.
fn square_of(number: u32) -> [u32; 2] {
    [(number & 1) | (number >> 1 & 2), (number >> 1 & 1) | (number >> 2 & 2)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn each_pixel_is_in_one_group_of_each_net() {
        for members in [Members::One, Members::Strangers, Members::Sixteen] {
            let groups = Groups::new(members, 2, 5);
            for net in 0..2 {
                let mut seen = HashSet::new();
                for block in groups.blocks(net, [-3..20, 5..17]) {
                    for group in groups.of(&block) {
                        let group: Vec<_> = group.collect();
                        assert_eq!(group.len() as u32, members.edge().pow(2));
                        let sequences: HashSet<_> = group.iter().map(|pixel| pixel.member.origin).collect();
                        assert_eq!(sequences.len() as u32, group.len() as u32 / groups.sharers());
                        for pixel in group {
                            assert!(seen.insert(pixel.place), "{pixel:?} twice");
                        }
                    }
                }
                assert!((-3..20).all(|x| (5..17).all(|y| seen.contains(&[x, y]))));
            }
        }
    }
}
