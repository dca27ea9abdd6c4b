//! Rays of several lanes that go through the tree together: each node is visited once for all rays that enter
//! it.
//!
//! The test of a box is that of one ray, so the answers are those of [`Accel::occluded`]. A ray alone waits
//! for most of its time, for memory and for what the last boxes say; here the next ray is tested meanwhile.

use super::node::{Child, NodeRay};
use super::packet::PacketRay;
use super::watch::Unwatched;
use super::{Accel, ROOM};
use crate::geometry::Ray;
use crate::lanes::{LANES, Mask, lanes_of, mask_of};
use crate::shape::RaySpace;
use smallvec::SmallVec;

/// What the tree needs of a ray.
struct Going {
    lane: usize,
    ray: Ray,
    node_ray: NodeRay,
    packet_ray: PacketRay,
    t_last: f64,
}

impl Accel {
    /// The lanes asked for whose ray is [`Accel::occluded`].
    pub fn occluded_together(&self, all: &[Ray; LANES], time: f64, asked: Mask) -> Mask {
        if self.stack_size == 0 {
            return 0;
        }
        let mut rays: SmallVec<[Going; LANES]> = SmallVec::new();
        for lane in lanes_of(asked) {
            let ray = all[lane];
            let Some(node_ray) = NodeRay::new(&self.space, &ray) else { continue };
            let packet_ray = PacketRay::new(&RaySpace::new(&ray));
            rays.push(Going { lane, ray, node_ray, packet_ray, t_last: ray.t_max.next_down() });
        }
        // By their places among the rays.
        let mut open: Mask = (1 << rays.len()) - 1;
        let mut waiting: SmallVec<[(Child, Mask); ROOM]> = SmallVec::new();
        waiting.push((Child::of_node(0), open));
        while let Some((child, entering)) = waiting.pop() {
            let entering = entering & open;
            let Some(index) = child.node() else {
                for place in lanes_of(entering) {
                    let blocked = self.leaf_occludes(child, &rays[place], time);
                    open &= !(Mask::from(blocked) << place);
                }
                if open == 0 {
                    break;
                }
                continue;
            };
            let node = &self.nodes[index];
            let (mut entered, mut any) = ([0u64; LANES / 8], 0);
            for place in lanes_of(entering) {
                let (mask, _) = node.entered(&rays[place].node_ray);
                entered[place / 8] |= u64::from(mask) << (place % 8 * 8);
                any |= mask;
            }
            let by_child = entered.map(transposed);
            for slot in lanes_of(any) {
                let of_slot = |entered: u64| (entered >> (8 * slot)) as u8;
                let mask = Mask::from(u16::from_le_bytes(by_child.map(of_slot)));
                let child = node.child(slot);
                self.prefetch(child);
                waiting.push((child, mask));
            }
        }
        let open = mask_of(lanes_of(open).map(|place| rays[place].lane));
        mask_of(rays.iter().map(|ray| ray.lane)) & !open
    }

    fn leaf_occludes(&self, leaf: Child, going: &Going, time: f64) -> bool {
        let Going { ray, packet_ray, t_last, .. } = going;
        match leaf.is_other() {
            false => self.packets[leaf.items()].iter().any(|packet| packet.occludes(packet_ray, *t_last)),
            true => {
                self.others[leaf.items()].iter().any(|other| self.other_occludes(other, ray, time, Unwatched))
            }
        }
    }
}

/// Bit j of byte i becomes bit i of byte j (H. S. Warren, *Hacker's Delight*, 2nd edition 2012, sec. 7-3).
fn transposed(mut bits: u64) -> u64 {
    for (distance, mask) in
        [(7, 0x00AA_00AA_00AA_00AA), (14, 0x0000_CCCC_0000_CCCC), (28, 0x0000_0000_F0F0_F0F0)]
    {
        let moved = (bits ^ (bits >> distance)) & mask;
        bits ^= moved ^ (moved << distance);
    }
    bits
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_change_places() {
        for (i, j) in (0..8).flat_map(|i| (0..8).map(move |j| (i, j))) {
            assert_eq!(transposed(1 << (8 * i + j)), 1 << (8 * j + i));
        }
    }
}
