//! A tree over many emitters, by which one is chosen for a place that it may light
//! (Conty Estevez and Kulla, "Importance Sampling of Many Lights with Adaptive Tree Splitting", PACMCGIT
//! 1(2), 2018).
//!
//! Each node says of up to eight parts about what they bring to a place: the expectation, where the paper has
//! a bound, for a bound sends too many samples to emitters that show their backs. From the root down the
//! choice falls on one of the parts in proportion to that, all by one sample value, what is left of which is
//! as good as new. The density of the choice is found from the emitter up.

mod bound;
mod build;
mod node;

pub use bound::Bound;
pub use node::Viewpoint;

use crate::sampling::warp::pick;
use build::{Leaf, build};
use node::{Eye, Frame, LEAF, Node, PARTS};

/// Emitters are told by their numbers, from 0.
#[derive(Clone, Debug)]
pub struct Tree {
    frame: Frame,
    /// All emitters as one part.
    root: Node,
    nodes: Vec<Node>,
    /// By node, the part above it: eight times the number of its node, and that of the part. That of the
    /// first node means nothing.
    parents: Vec<u32>,
    /// By emitter, the part that it is, counted likewise; [`NONE`] for those that are not in the tree.
    places: Vec<u32>,
}

const NONE: u32 = u32::MAX;

impl Tree {
    /// Tree of fewer than 2²⁹ emitters. An emitter without intensity, `None`, is never chosen. `None` if all
    /// are.
    pub fn new(bounds: Vec<Option<Bound>>) -> Option<Self> {
        let count = bounds.len();
        let emits = |bound: &Bound| bound.intensity > 0.0 && bound.intensity.is_finite();
        let mut leaves: Vec<Leaf> = (0..)
            .zip(bounds)
            .filter_map(|(unit, bound)| Some(Leaf { bound: bound.filter(emits)?, unit }))
            .collect();
        let bound = leaves.iter().map(|leaf| leaf.bound).reduce(Bound::union)?;
        if !bound.intensity.is_finite() {
            return None;
        }
        let frame = Frame::new(&bound.bounds, bound.intensity);
        let mut root = Node::default();
        root.put(0, &bound, 0, &frame);
        let mut nodes = Vec::new();
        build(&mut leaves, &frame, &mut nodes);
        let (mut parents, mut places) = (vec![NONE; nodes.len()], vec![NONE; count]);
        for (index, node) in (0..).zip(&nodes) {
            for (part, &child) in (PARTS as u32 * index..).zip(&node.children) {
                match child {
                    0 => {}
                    _ if child & LEAF != 0 => places[(child & !LEAF) as usize] = part,
                    _ => parents[(index + child) as usize] = part,
                }
            }
        }
        Some(Self { frame, root, nodes, parents, places })
    }

    /// The binary logarithm of the number of emitters.
    pub fn levels(&self) -> f64 {
        (self.places.len() as f64).log2()
    }

    /// About the irradiance that all emitters together bring to a place, up to the factor of their
    /// intensities.
    pub fn estimate(&self, from: &Viewpoint) -> f64 {
        let [importance, ..] = self.root.importances(&self.frame.eye(from));
        self.frame.whole * f64::from(importance) / self.frame.squared_distance(from)
    }

    /// An emitter and the probability of its choice. What is left of the sample value `u` is uniform again.
    pub fn choose(&self, from: &Viewpoint, u: &mut f64) -> Option<(u32, f64)> {
        let eye = self.frame.eye(from);
        let (mut node, mut probability) = (0, 1.0);
        loop {
            let (weights, all) = weights(&self.nodes[node], &eye);
            let (part, share) = pick(&weights, all, u)?;
            probability *= share;
            match self.nodes[node].children[part] {
                child if child & LEAF != 0 => return Some((child & !LEAF, probability)),
                child => node += child as usize,
            }
        }
    }

    /// The probability with which [`Self::choose`] takes an emitter.
    pub fn probability(&self, from: &Viewpoint, unit: u32) -> f64 {
        let mut place = self.places[unit as usize];
        if place == NONE {
            return 0.0;
        }
        let eye = self.frame.eye(from);
        let mut probability = 1.0;
        loop {
            let (node, part) = (place as usize / PARTS, place as usize % PARTS);
            let (weights, all) = weights(&self.nodes[node], &eye);
            if weights[part] == 0.0 {
                return 0.0;
            }
            probability *= weights[part] / all;
            if node == 0 {
                return probability;
            }
            place = self.parents[node];
        }
    }
}

/// What each part weighs in the choice, and the sum.
#[inline]
fn weights(node: &Node, eye: &Eye) -> ([f64; PARTS], f64) {
    let weights = node.importances(eye).map(f64::from);
    (weights, weights.iter().sum())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Bounds, Vec3};
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    /// Points that shine to one side by the cosine, or all around, and what each brings to a place.
    struct Emitters {
        points: Vec<(Vec3, Option<Vec3>, f64)>,
        tree: Tree,
    }

    impl Emitters {
        /// In a box of half a size around a place.
        fn new(count: usize, centre: Vec3, half: Vec3, one_sided: bool, seed: u64) -> Self {
            let mut random = Pcg64::seed_from_u64(seed);
            let mut inside =
                || Vec3::new(random.random(), random.random(), random.random()) * 2.0 - Vec3::ONE;
            let points: Vec<_> = (0..count)
                .map(|i| {
                    let normal = one_sided.then(|| inside().normalize());
                    (centre + half * inside(), normal, [1.0, 5.0, 30.0][i % 3])
                })
                .collect();
            let bound = |&(position, normal, intensity): &(Vec3, Option<Vec3>, f64)| {
                let bounds = Bounds::of([position]);
                Some(match normal {
                    Some(normal) => Bound::flat(bounds, normal, intensity),
                    None => Bound::round(bounds, intensity),
                })
            };
            let tree = Tree::new(points.iter().map(bound).collect()).unwrap();
            Self { points, tree }
        }

        fn brings(&self, unit: usize, from: &Viewpoint) -> f64 {
            let (position, normal, intensity) = self.points[unit];
            let away = position - from.position;
            let direction = away.normalize();
            let leaving = normal.map_or(1.0, |normal| -normal.dot(direction)).max(0.0);
            let received = if from.facing == Vec3::ZERO { 1.0 } else { from.facing.dot(direction) };
            intensity * leaving * received.max(0.0) / away.length_squared()
        }

        /// The relative variance of the irradiance by one choice, the sum of the probabilities, and the
        /// irradiance over its estimate.
        fn judge(&self, from: &Viewpoint) -> [f64; 3] {
            let (mut squares, mut sum, mut all) = (0.0, 0.0, 0.0);
            for unit in 0..self.points.len() {
                let (brings, probability) =
                    (self.brings(unit, from), self.tree.probability(from, unit as u32));
                all += probability;
                if brings > 0.0 {
                    assert!(probability > 0.0, "{unit} is never chosen");
                    squares += brings * brings / probability;
                    sum += brings;
                }
            }
            [squares / (sum * sum) - 1.0, all, sum / self.tree.estimate(from)]
        }
    }

    /// Whatever brings light can be chosen, at any scale and from anywhere. One choice tells the irradiance
    /// within 20 % where emitters shine all around, and within 45 % where they face anywhere.
    #[test]
    fn emitters_are_chosen_by_what_they_bring() {
        for (scale, far) in [(1.0, 0.0), (1e-12, 0.0), (1e12, 0.0), (1.0, 1e6), (1e-3, 1e9)] {
            for (one_sided, deviation) in [(false, 0.2), (true, 0.45)] {
                let centre = Vec3::new(far, -far, 0.5 * far);
                let half = scale * Vec3::new(4.0, 3.0, 0.8);
                let emitters = Emitters::new(3000, centre, half, one_sided, 7);
                let from = |x: f64, z: f64, facing: Vec3| {
                    emitters.judge(&Viewpoint { position: centre + scale * Vec3::new(x, 1.0, z), facing })
                };
                for (x, z) in [(0.0, -3.0), (2.0, -2.0), (-7.0, -2.5), (0.5, -1e4)] {
                    for facing in [Vec3::Z, Vec3::ZERO, Vec3::new(0.6, 0.0, 0.8)] {
                        let [variance, all, ratio] = from(x, z, facing);
                        let judged = format!("{one_sided} {scale} {far} {x} {z}: {variance} {all} {ratio}");
                        assert!(variance.sqrt() < deviation && all <= 1.0 + 1e-9, "{judged}");
                        assert!((0.2..5.0).contains(&ratio), "{judged}");
                    }
                }
                // Among them, below a slanted horizon, and where nothing of them is seen.
                from(0.3, 0.1, Vec3::new(0.0, 0.8, -0.6));
                from(0.3, -1.0, Vec3::new(1.0, 0.0, 0.0));
                from(0.0, 2.0, Vec3::Z);
            }
        }
    }
}
