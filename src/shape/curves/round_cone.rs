//! Round cones: what a ball sweeps that moves straight on and grows or shrinks steadily, the hull of two
//! balls.

use super::{Near, Span};
use crate::geometry::{Bounds, Vec3};
use std::f64::consts::{PI, TAU};

/// The ball with u from 0 to 1 is around `from` + u `along`, with the radius `radius` + u `growth`.
#[derive(Clone, Copy, Debug)]
pub struct RoundCone {
    pub from: Vec3,
    pub along: Vec3,
    pub radius: f64,
    pub growth: f64,
}

impl RoundCone {
    pub fn new([from, to]: [Vec3; 2], [radius, other]: [f64; 2]) -> Self {
        Self { from, along: to - from, radius, growth: other - radius }
    }

    pub fn centre(&self, u: f64) -> Vec3 {
        // The other end exactly as the next one begins, or nearly so.
        self.from + self.along * u
    }

    pub fn radius(&self, u: f64) -> f64 {
        self.radius + self.growth * u
    }

    /// Where its middle is.
    pub fn middle(&self) -> Vec3 {
        self.centre(0.5)
    }

    pub fn bounds(&self) -> Bounds {
        let ball = |u: f64| {
            let half = Vec3::splat(self.radius(u));
            Bounds { min: self.centre(u) - half, max: self.centre(u) + half }
        };
        ball(0.0).union(ball(1.0))
    }

    /// The largest distance of a point of it from its middle.
    pub fn reach(&self) -> f64 {
        0.5 * self.along.length() + self.radius.max(self.radius + self.growth)
    }

    /// Where a line is within it: from the first entry into one of its balls to the last exit.
    ///
    /// The line enters the ball u at s(u) − √D(u), where s is how far along the line the ball's centre is,
    /// and D its squared radius less the squared distance of its centre from the line, A u² + 2 B u + C. The
    /// first entry and the last exit are where that is stationary, √D s' = ± D'/2, or those of the balls at
    /// the ends. As both are stationary, an error of u matters only by its square.
    pub fn span(&self, line: &Near) -> Option<Span> {
        let (from, ahead) = (self.from - line.start, line.direction);
        let (off, aside) = (from.cross(ahead), self.along.cross(ahead));
        let (s0, s1) = (from.dot(ahead), self.along.dot(ahead));
        let mut span: Option<Span> = None;
        let mut consider = |u: f64, half: f64| {
            let here = line.chord(u, s0 + u * s1, half, self.radius(u));
            span = Some(span.map_or(here, |span| span.around(here)));
        };
        let half = |u: f64| {
            let (radius, distance) = (self.radius(u), (off + aside * u).length());
            (radius > distance).then(|| ((radius - distance) * (radius + distance)).sqrt())
        };
        let excess = self.along.length_squared() - self.growth * self.growth;
        if excess <= 0.0 {
            // One ball holds all others.
            let largest = if self.growth > 0.0 { 1.0 } else { 0.0 };
            half(largest).into_iter().for_each(|half| consider(largest, half));
            return span.map(|span| span.settled(line, self.radius(largest)));
        }
        for end in [0.0, 1.0] {
            half(end).into_iter().for_each(|half| consider(end, half));
        }
        let a = self.growth * self.growth - aside.length_squared();
        let b = self.radius * self.growth - off.dot(aside);
        let c = self.radius * self.radius - off.length_squared();
        // B² − A C without its cancellation, which would be total at the tip of a thin cone.
        let widening = (aside * self.radius - off * self.growth).length();
        let passing = off.cross(aside).dot(ahead).abs();
        let discriminant = (widening - passing) * (widening + passing);
        if discriminant > 0.0 {
            // A u² + 2 B u + (s'² C − B²)/excess = 0, and at both roots D is the same.
            let stationary = (discriminant / excess).sqrt();
            let root = s1.abs() * stationary;
            let far = -(b + root.copysign(b));
            let near = if a.abs() > 1e-3 * excess {
                (root.copysign(b) - b) / a
            } else {
                (s1 * s1 * c - b * b) / (excess * far)
            };
            for u in [far / a, near] {
                if u > 0.0 && u < 1.0 {
                    // By u's own D an error of u cancels, unless the line all but touches.
                    let own = half(u).filter(|own| (own / stationary - 1.0).abs() < 0.1);
                    consider(u, own.unwrap_or(stationary));
                }
            }
        }
        span.map(|span| span.settled(line, self.radius.max(self.radius + self.growth)))
    }

    /// The u of the ball that touches the surface at a point near it.
    pub fn ball_at(&self, point: Vec3) -> f64 {
        let excess = self.along.length_squared() - self.growth * self.growth;
        if excess <= 0.0 {
            return if self.growth > 0.0 { 1.0 } else { 0.0 };
        }
        // A ball touches not across the axis, but behind its centre by growth / length of its radius.
        (((point - self.from).dot(self.along) + self.radius * self.growth) / excess).clamp(0.0, 1.0)
    }

    /// The mantle between the two circles of contact, and the caps beyond them.
    pub fn area(&self) -> f64 {
        let (first, last) = (self.radius, self.radius + self.growth);
        let length = self.along.length();
        if length <= self.growth.abs() {
            return 4.0 * PI * first.max(last).powi(2);
        }
        // Sine and cosine of half the cone's angle.
        let sin = self.growth / length;
        let cos = (1.0 - sin * sin).sqrt();
        let mantle = PI * (first + last) * cos * length * cos;
        mantle + TAU * (first * first * (1.0 - sin) + last * last * (1.0 + sin))
    }
}
