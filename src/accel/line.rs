//! All crossings along a range of a ray, where the nearest alone does not tell enough.

use super::node::{Child, NodeRay};
use super::packet::PacketRay;
use super::{Accel, Other};
use crate::geometry::Ray;
use crate::shape::{Crossings, Hit, RaySpace};
use smallvec::SmallVec;
use std::ops::ControlFlow;

impl Accel {
    /// Reports every crossing with `from` ≤ t ≤ `to` and t ≥ 0, in no order, where the shape knows it with
    /// the bound on the error of t. A crossing may be reported twice, and one of a mesh at an edge is one of
    /// both triangles.
    pub fn crossings(
        &self,
        ray: &Ray,
        time: f64,
        [from, to]: [f64; 2],
        report: &mut dyn FnMut(Hit, Option<f64>),
    ) {
        let from = from.max(0.0);
        // The tree is asked for the range alone; what it lets through is tested with the very ray.
        let range = Ray { origin: ray.at(from), direction: ray.direction, t_max: to - from };
        let Some(node_ray) = NodeRay::new(&self.space, &range) else { return };
        let packet_ray = PacketRay::new(&RaySpace::new(ray));
        let mut waiting: SmallVec<[Child; 64]> = SmallVec::new();
        let mut next = (self.stack_size > 0).then(|| Child::of_node(0));
        while let Some(child) = next {
            if let Some(index) = child.node() {
                let node = &self.nodes[index];
                let (mut mask, _) = node.entered(&node_ray);
                while mask != 0 {
                    waiting.push(node.child(mask.trailing_zeros() as usize));
                    mask &= mask - 1;
                }
            } else if child.is_other() {
                for (index, other) in &self.others[child.items()] {
                    self.cross_other(*index, other, ray, time, [from, to], report);
                }
            } else {
                for packet in &self.packets[child.items()] {
                    packet.intersect(&packet_ray, to, |hit| {
                        if hit.t >= from {
                            report(hit, None);
                        }
                    });
                }
            }
            next = waiting.pop();
        }
    }

    fn cross_other(
        &self,
        index: u32,
        other: &Other,
        ray: &Ray,
        time: f64,
        [from, to]: [f64; 2],
        report: &mut dyn FnMut(Hit, Option<f64>),
    ) {
        let mut report_within = |crossings: Crossings| {
            for crossing in crossings {
                if crossing.hit.t >= from && crossing.hit.t <= to {
                    report(Hit { shape: index, ..crossing.hit }, Some(crossing.error));
                }
            }
        };
        match other {
            Other::Shape(shape) => report_within(shape.crossings(ray)),
            Other::Piece { pieces, piece } => report_within(pieces.crossings(*piece, ray)),
            Other::Instance { during: [start, end] } if *start <= time && time <= *end => {
                self.instances[index as usize].crossings(ray, time, [from, to], &mut |hit, error| {
                    let instance = self.numbering.joined(index, hit.instance);
                    report(Hit { instance, ..hit }, error);
                });
            }
            Other::Instance { .. } => {}
            Other::Solid(solid) => {
                // A solid need not tell of places that the ray does not come near.
                let line = Ray { t_max: ray.t_max.max(to), ..*ray };
                solid.walk(&line, time, |boundary| {
                    let crossing = boundary.crossing;
                    if crossing.hit.t > to {
                        return ControlFlow::Break(());
                    }
                    if crossing.hit.t >= from {
                        report(crossing.hit, Some(crossing.error));
                    }
                    ControlFlow::Continue(())
                });
            }
        }
    }
}
