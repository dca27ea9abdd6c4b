//! What polygons bound: closed contours in the plane, which may be concave, have holes, and cross themselves.
//!
//! Whether a point is inside is decided by counting the crossings of a half line with the edges (Glassner,
//! *An Introduction to Ray Tracing*, ch. 2, 3.2), corners and edges going by one rule: of two outlines that
//! share an edge exactly one has its points.

use crate::geometry::orientation;
use crate::shape::ShapeError;
use glam::DVec2;
use smallvec::SmallVec;

/// What is inside of contours that overlap.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FillRule {
    /// What an odd number of contours goes around.
    EvenOdd,
    /// What the contours go around a number of times other than zero in all, counted with their direction.
    Winding,
}

/// An edge from one corner to the next.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edge {
    pub from: DVec2,
    pub to: DVec2,
    /// Where it begins and ends along its contour, whose length is 1.
    pub along: [f64; 2],
}

#[derive(Clone, Debug)]
pub(super) struct Outline {
    pub edges: Vec<Edge>,
    rule: FillRule,
    pub min: DVec2,
    pub max: DVec2,
}

/// Where a line crosses the boundary.
#[derive(Clone, Copy, Debug)]
pub(super) struct EdgeCrossing {
    /// Distance in units of the direction's length.
    pub t: f64,
    pub edge: u32,
    pub enters: bool,
    /// Whether the outside is to the left of the edge there.
    pub outside_left: bool,
    /// How fast the line leaves the edge's own line.
    pub rate: f64,
}

/// A part of an edge that is boundary.
#[derive(Clone, Copy, Debug)]
pub(super) struct BoundarySegment {
    pub edge: u32,
    pub from: DVec2,
    pub to: DVec2,
    pub outside_left: bool,
}

/// A part of the inside between two horizontal lines, its sides straight.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trapezoid {
    /// Lower and upper.
    pub y: [f64; 2],
    /// Left end at the lower line, then at the upper one.
    pub left: [f64; 2],
    pub right: [f64; 2],
}

impl Trapezoid {
    pub fn area(&self) -> f64 {
        let widths = (self.right[0] - self.left[0]) + (self.right[1] - self.left[1]);
        0.5 * widths * (self.y[1] - self.y[0])
    }

    /// Uniform in area.
    pub fn point(&self, [a, b]: [f64; 2]) -> DVec2 {
        let [low, high] = [0, 1].map(|i| (self.right[i] - self.left[i]).max(0.0));
        let up = a * (low + high) / (low + (low * low + a * (high * high - low * low)).max(0.0).sqrt());
        let up = if up.is_finite() { up.min(1.0) } else { 0.5 };
        let mix = |[from, to]: [f64; 2], at: f64| from + at * (to - from);
        let (left, right) = (mix(self.left, up), mix(self.right, up));
        DVec2::new(mix([left, right], b), mix(self.y, up))
    }
}

impl Outline {
    pub fn new(contours: &[Vec<[f64; 2]>], rule: FillRule) -> Result<Self, ShapeError> {
        let mut edges = Vec::new();
        for contour in contours {
            let corners: Vec<DVec2> = contour.iter().map(|&corner| DVec2::from(corner)).collect();
            if corners.iter().any(|corner| !corner.is_finite()) {
                return Err(ShapeError::Outline);
            }
            let pairs = || (0..corners.len()).map(|i| (corners[i], corners[(i + 1) % corners.len()]));
            let length: f64 = pairs().map(|(from, to)| from.distance(to)).sum();
            let mut along = 0.0;
            for (from, to) in pairs().filter(|(from, to)| from != to) {
                let end = along + from.distance(to) / length;
                edges.push(Edge { from, to, along: [along, end] });
                along = end;
            }
        }
        let (min, max) = edges
            .iter()
            .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(min, max), e| (min.min(e.from), max.max(e.from)));
        let outline = Self { edges, rule, min, max };
        if (max - min).min_element() > 0.0 && (max - min).is_finite() && outline.area() > 0.0 {
            Ok(outline)
        } else {
            Err(ShapeError::Outline)
        }
    }

    pub fn scaled(&self, factor: f64) -> Self {
        let mut scaled = self.clone();
        (scaled.min, scaled.max) = (self.min * factor, self.max * factor);
        for edge in &mut scaled.edges {
            (edge.from, edge.to) = (edge.from * factor, edge.to * factor);
        }
        scaled
    }

    fn fills(&self, winding: i32) -> bool {
        match self.rule {
            FillRule::EvenOdd => winding & 1 != 0,
            FillRule::Winding => winding != 0,
        }
    }

    /// Exact: the half line towards +x is taken to pass just above the point and just to the right of it.
    pub fn contains(&self, p: DVec2) -> bool {
        let mut winding = 0;
        for Edge { from, to, .. } in &self.edges {
            if (from.y > p.y) == (to.y > p.y) {
                continue;
            }
            let up = from.y < to.y;
            let (low, high) = if up { (*from, *to) } else { (*to, *from) };
            if orientation(low, high, p) > 0.0 {
                winding += if up { 1 } else { -1 };
            }
        }
        self.fills(winding)
    }

    /// All crossings of a line with the boundary, in ascending order, each the other way through it than the
    /// one before.
    ///
    /// Each corner is on one side of the line, on which all edges that meet there agree: no line slips
    /// between two edges or crosses them only half. A line along an edge, or through a corner without
    /// entering, crosses nothing.
    pub fn crossed(&self, start: DVec2, direction: DVec2) -> SmallVec<[EdgeCrossing; 8]> {
        let side = |corner: DVec2| direction.perp_dot(corner - start);
        let speed = direction.length();
        let mut all: SmallVec<[(f64, u32, f64); 8]> = SmallVec::new();
        for (i, Edge { from, to, .. }) in self.edges.iter().enumerate() {
            let (a, b) = (side(*from), side(*to));
            if (a > 0.0) == (b > 0.0) {
                continue;
            }
            // From the same end whichever way the edge runs: edges that coincide are crossed at the same
            // place.
            let first = (from.x, from.y) < (to.x, to.y);
            let (low, high, at) = if first { (*from, *to, a / (a - b)) } else { (*to, *from, b / (b - a)) };
            let t = ((low - start) + (high - low) * at).dot(direction / speed) / speed;
            all.push((t, i as u32, b - a));
        }
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut found = SmallVec::new();
        let (mut winding, mut inside) = (0, false);
        for same in all.chunk_by(|a, b| a.0 == b.0) {
            winding += same.iter().map(|(_, _, turn)| turn.signum() as i32).sum::<i32>();
            if self.fills(winding) == inside {
                continue;
            }
            inside = !inside;
            // One of the edges at this place through which the line goes this way.
            let (t, edge, turn) = same[0];
            let Edge { from, to, .. } = self.edges[edge as usize];
            found.push(EdgeCrossing {
                t,
                edge,
                enters: inside,
                outside_left: inside == (turn > 0.0),
                rate: turn.abs() / from.distance(to),
            });
        }
        found
    }

    /// Where a part of an edge is crossed by other edges or touched by their corners: fractions in (0, 1).
    fn cuts(&self) -> Vec<SmallVec<[f64; 2]>> {
        let mut order: Vec<usize> = (0..self.edges.len()).collect();
        let reach = |edge: &Edge| (edge.from.min(edge.to), edge.from.max(edge.to));
        order.sort_by(|&a, &b| reach(&self.edges[a]).0.x.total_cmp(&reach(&self.edges[b]).0.x));
        let mut cuts = vec![SmallVec::new(); self.edges.len()];
        for (k, &i) in order.iter().enumerate() {
            let a = &self.edges[i];
            let (a_min, a_max) = reach(a);
            for &j in &order[k + 1..] {
                let b = &self.edges[j];
                let (b_min, b_max) = reach(b);
                if b_min.x > a_max.x {
                    break;
                }
                if b_min.y > a_max.y || b_max.y < a_min.y {
                    continue;
                }
                for (cut, by, index) in [(a, b, i), (b, a, j)] {
                    let [s, t] = [by.from, by.to].map(|corner| orientation(cut.from, cut.to, corner));
                    let along = cut.to - cut.from;
                    let mut add = |at: f64| {
                        if at > 0.0 && at < 1.0 {
                            cuts[index].push(at);
                        }
                    };
                    for (value, corner) in [(s, by.from), (t, by.to)] {
                        if value == 0.0 {
                            add((corner - cut.from).dot(along) / along.length_squared());
                        }
                    }
                    let [u, v] = [cut.from, cut.to].map(|corner| orientation(by.from, by.to, corner));
                    if (s > 0.0) != (t > 0.0) && (u > 0.0) != (v > 0.0) {
                        add(u / (u - v));
                    }
                }
            }
        }
        cuts
    }

    /// The boundary without what is inside or outside on both sides.
    pub fn boundary(&self) -> Vec<BoundarySegment> {
        let cuts = self.cuts();
        let simple = cuts.iter().all(|cuts| cuts.is_empty());
        let mut segments = Vec::new();
        // Where nothing crosses, all of a contour has its outside on the same side.
        let mut of_contour = None;
        for (i, (edge, mut cuts)) in self.edges.iter().zip(cuts).enumerate() {
            cuts.extend([0.0, 1.0]);
            cuts.sort_by(f64::total_cmp);
            for pair in cuts.windows(2).filter(|pair| pair[0] < pair[1]) {
                let [from, to] = [pair[0], pair[1]].map(|at| edge.from.lerp(edge.to, at));
                let across = (edge.to - edge.from).perp().normalize();
                let found = match of_contour.filter(|_| simple && edge.along[0] > 0.0) {
                    Some(left) => Some(left),
                    None => {
                        let crossings = self.crossed(from.midpoint(to), across);
                        let here = crossings.iter().filter(|crossing| crossing.edge == i as u32);
                        here.min_by(|a, b| a.t.abs().total_cmp(&b.t.abs())).map(|here| here.outside_left)
                    }
                };
                of_contour = found;
                segments.extend(found.map(|outside_left| BoundarySegment {
                    edge: i as u32,
                    from,
                    to,
                    outside_left,
                }));
            }
        }
        segments
    }

    /// The inside, cut at the height of every corner and of every crossing of edges.
    pub fn trapezoids(&self) -> Vec<Trapezoid> {
        let mut heights: Vec<f64> = self.edges.iter().map(|edge| edge.from.y).collect();
        for (edge, cuts) in self.edges.iter().zip(self.cuts()) {
            heights.extend(cuts.iter().map(|&at| edge.from.lerp(edge.to, at).y));
        }
        heights.sort_by(f64::total_cmp);
        heights.dedup();
        let mut rising: Vec<&Edge> = self.edges.iter().filter(|edge| edge.from.y != edge.to.y).collect();
        rising.sort_by(|a, b| a.from.y.min(a.to.y).total_cmp(&b.from.y.min(b.to.y)));
        let mut next = rising.into_iter().peekable();
        let mut active: Vec<&Edge> = Vec::new();
        let mut found = Vec::new();
        for pair in heights.windows(2) {
            let [low, high] = [pair[0], pair[1]];
            active.retain(|edge| edge.from.y.max(edge.to.y) > low);
            while let Some(edge) = next.next_if(|edge| edge.from.y.min(edge.to.y) <= low) {
                active.push(edge);
            }
            let x = |edge: &Edge, y: f64| {
                let at = ((y - edge.from.y) / (edge.to.y - edge.from.y)).clamp(0.0, 1.0);
                edge.from.x + at * (edge.to.x - edge.from.x)
            };
            let middle = 0.5 * (low + high);
            active.sort_by(|a, b| x(a, middle).total_cmp(&x(b, middle)));
            let (mut winding, mut left) = (0, None);
            for edge in &active {
                winding += if edge.from.y < edge.to.y { 1 } else { -1 };
                match (self.fills(winding), left) {
                    (true, None) => left = Some(edge),
                    (false, Some(from)) => {
                        found.push(Trapezoid {
                            y: [low, high],
                            left: [x(from, low), x(from, high)],
                            right: [x(edge, low), x(edge, high)],
                        });
                        left = None;
                    }
                    _ => {}
                }
            }
        }
        found
    }

    /// Area of the inside.
    pub fn area(&self) -> f64 {
        self.trapezoids().iter().map(Trapezoid::area).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg as Random;

    fn outline(contours: &[&[[f64; 2]]], rule: FillRule) -> Outline {
        let contours: Vec<Vec<[f64; 2]>> = contours.iter().map(|contour| contour.to_vec()).collect();
        Outline::new(&contours, rule).unwrap()
    }

    fn pentagram() -> Vec<[f64; 2]> {
        (0..5).map(|i| std::f64::consts::TAU * f64::from(2 * i) / 5.0).map(|a| [a.cos(), a.sin()]).collect()
    }

    /// The middle of a pentagram is inside by winding, outside by odd and even (Glassner ch. 2, 3.2).
    #[test]
    fn a_pentagram() {
        let star = pentagram();
        let odd = outline(&[&star], FillRule::EvenOdd);
        let winding = outline(&[&star], FillRule::Winding);
        assert!(!odd.contains(DVec2::ZERO) && winding.contains(DVec2::ZERO));
        for found in [&odd, &winding] {
            assert!(found.contains(DVec2::X * 0.7) && !found.contains(DVec2::X * -0.7));
        }
        // The points and the pentagon in the middle, whose radius is cos 72° / cos 36°.
        let (small, turn) = (72f64.to_radians().cos() / 36f64.to_radians().cos(), 36f64.to_radians());
        let whole = 5.0 * small * turn.sin();
        let middle = 2.5 * small * small * (2.0 * turn).sin();
        assert!((winding.area() - whole).abs() < 1e-14, "{} {whole}", winding.area());
        assert!((odd.area() - (whole - middle)).abs() < 1e-14);
        // Inner segments bound the middle only where it is outside.
        assert_eq!((odd.boundary().len(), winding.boundary().len()), (15, 10));
        assert_eq!(odd.crossed(DVec2::ZERO, DVec2::X).len(), 4);
        assert_eq!(winding.crossed(DVec2::ZERO, DVec2::X).len(), 2);
    }

    /// The example of 3.2: V is the dropped coordinate's neighbour; the point is outside.
    #[test]
    fn the_worked_example() {
        let found = outline(&[&[[-3.0, 7.0], [3.0, 3.0], [4.0, 4.0]]], FillRule::EvenOdd);
        assert!(!found.contains(DVec2::new(-2.0, 4.0)));
        assert!(found.contains(DVec2::new(4.0 / 3.0, 14.0 / 3.0)));
    }

    /// Exactly one of the triangles around a point holds each point, on edges and corners too.
    #[test]
    fn shared_edges_have_one_owner() {
        let mut random = Random::seed_from_u64(1);
        for _ in 0..200 {
            let mut any = || DVec2::new(random.random_range(-0.3..0.3), random.random_range(-0.3..0.3));
            let centre = any();
            let corners: Vec<DVec2> = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]]
                .map(|corner| DVec2::from(corner) + any())
                .to_vec();
            let parts: Vec<Outline> = (0..4)
                .map(|i| {
                    let (a, b) = (corners[i].to_array(), corners[(i + 1) % 4].to_array());
                    outline(&[&[centre.to_array(), a, b]], FillRule::EvenOdd)
                })
                .collect();
            for &corner in &corners {
                for at in [0.0, 1e-17, 0.1, 0.3, 0.5, random.random_range(0.0..1.0)] {
                    let p = centre.lerp(corner, at);
                    let owners = parts.iter().filter(|part| part.contains(p)).count();
                    assert_eq!(owners, 1, "{p} on the edge to {corner}");
                }
            }
        }
    }

    /// Points of trapezoids are inside and fill the area evenly: the mean of a coordinate is that of the
    /// whole.
    #[test]
    fn trapezoids_fill_the_inside() {
        let l_shape = [[0.0, 0.0], [4.0, 0.0], [4.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]];
        let hole = [[0.25, 0.25], [0.75, 0.25], [0.75, 0.75], [0.25, 0.75]];
        let found = outline(&[&l_shape, &hole], FillRule::EvenOdd);
        assert_eq!(found.area(), 6.0 - 0.25);
        let mut random = Random::seed_from_u64(2);
        let parts = found.trapezoids();
        for part in &parts {
            for _ in 0..100 {
                let p = part.point([random.random(), random.random()]);
                assert!(found.contains(p), "{p}");
            }
        }
        let skew = Trapezoid { y: [0.0, 2.0], left: [0.0, 1.0], right: [3.0, 1.5] };
        let count = 100_000;
        let mean: f64 = (0..count).map(|_| skew.point([random.random(), random.random()]).y).sum::<f64>()
            / f64::from(count);
        // ∫ y w / ∫ w for widths from 3 to 0.5; the standard deviation is about 0.5.
        let exact = 2.0 * (3.0 + 2.0 * 0.5) / (3.0 * 3.5);
        assert!((mean - exact).abs() < 4.0 * 0.55 / f64::from(count).sqrt(), "{mean} {exact}");
    }

    #[test]
    fn what_bounds_nothing_is_refused() {
        let refused = |contour: &[[f64; 2]]| Outline::new(&[contour.to_vec()], FillRule::EvenOdd).is_err();
        assert!(refused(&[]) && refused(&[[0.0, 0.0], [1.0, 1.0]]));
        assert!(refused(&[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]]));
        assert!(refused(&[[0.0, 0.0], [1.0, 1.0], [f64::NAN, 2.0]]));
        let twice = vec![vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]; 2];
        assert!(Outline::new(&twice, FillRule::EvenOdd).is_err());
        assert!(Outline::new(&twice, FillRule::Winding).is_ok());
    }
}
