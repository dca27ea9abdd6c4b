//! Cameras whose picture is a map of directions: what is seen may be more than half of all around.

use crate::geometry::{Bounds, Placed, Ray, Vec3};
use std::f64::consts::{PI, TAU};

/// A fisheye or panorama at one point. It looks along its local +z, local +x is the picture's left and +y its
/// top.
#[derive(Clone, Debug)]
pub struct Angular {
    placed: Placed,
    map: DirectionMap,
    /// Width and height of the whole film in pixels.
    film: [f64; 2],
    /// Distances from the camera between which surfaces are seen.
    near: f64,
    far: f64,
}

/// Which direction is seen where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DirectionMap {
    /// A cone around the axis on the largest circle about the film's middle that fits; nothing outside of it.
    Fisheye {
        /// How the angle from the axis becomes a distance on the film.
        projection: FisheyeProjection,
        /// Between the axis and the circle's edge, radians. In (0, π], below π for a stereographic one, up to
        /// π/2 for an orthographic one.
        half_angle: f64,
    },
    /// Longitude across and latitude up, both in proportion, the axis in the middle: equirectangular. Beyond
    /// its edges the picture of the whole sphere goes on on its other side.
    Panorama {
        /// Angles across and up, radians: at most 2π and π.
        angles: [f64; 2],
    },
}

/// How the distance r from the middle of a fisheye's picture grows with the angle θ from the axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FisheyeProjection {
    /// r ∝ θ.
    Equidistant,
    /// r ∝ sin(θ/2): equal areas for equal solid angles.
    Equisolid,
    /// r ∝ tan(θ/2): circles stay circles.
    Stereographic,
    /// r ∝ sin θ: equal areas for equal irradiances on a plane across the axis.
    Orthographic,
}

impl FisheyeProjection {
    /// Each with the name that scene files have for it.
    pub const NAMES: [(&str, Self); 4] = [
        ("equidistant", Self::Equidistant),
        ("equisolid", Self::Equisolid),
        ("stereographic", Self::Stereographic),
        ("orthographic", Self::Orthographic),
    ];

    /// The largest angle from the axis that can be shown, radians, and whether it can itself.
    pub fn limit(self) -> (f64, bool) {
        match self {
            Self::Equidistant | Self::Equisolid => (PI, true),
            Self::Stereographic => (PI, false),
            Self::Orthographic => (0.5 * PI, true),
        }
    }

    /// The angle from the axis at a fraction of the radius that shows `half_angle`.
    fn angle(self, fraction: f64, half_angle: f64) -> f64 {
        match self {
            Self::Equidistant => fraction * half_angle,
            Self::Equisolid => 2.0 * (fraction * (0.5 * half_angle).sin()).asin(),
            Self::Stereographic => 2.0 * (fraction * (0.5 * half_angle).tan()).atan(),
            Self::Orthographic => (fraction * half_angle.sin()).asin(),
        }
    }
}

impl Angular {
    /// `placed` by a rigid map or a mirror image of one.
    pub fn new(placed: Placed, map: DirectionMap, film: [f64; 2], [near, far]: [f64; 2]) -> Self {
        Self { placed, map, film, near, far }
    }

    /// Whether the camera moves while the shutter is open.
    pub fn is_moving(&self) -> bool {
        self.placed.is_moving()
    }

    /// A box around where its rays begin, from one time to another.
    pub fn origins(&self, during: [f64; 2]) -> Bounds {
        let reach = Vec3::splat(self.near);
        self.placed.bounds(Bounds { min: -reach, max: reach }, during)
    }

    /// The ray seen at a film position (pixels from the top left corner of the film) at a time. `None`
    /// outside a fisheye's circle.
    pub fn ray(&self, film: [f64; 2], time: f64) -> Option<Ray> {
        let local = self.direction(film)?;
        let pose = self.placed.at(time);
        let direction = pose.world_vector(local).normalize();
        let origin = pose.world_point(Vec3::ZERO) + direction * self.near;
        Some(Ray { origin, direction, t_max: self.far - self.near })
    }

    /// Unit direction in the camera's own coordinates.
    fn direction(&self, [x, y]: [f64; 2]) -> Option<Vec3> {
        let [width, height] = self.film;
        let (right, down) = (x - 0.5 * width, y - 0.5 * height);
        match self.map {
            DirectionMap::Fisheye { projection, half_angle } => {
                let radius = 0.5 * width.min(height);
                let distance = right.hypot(down);
                if distance > radius {
                    return None;
                }
                let (sin, cos) = projection.angle(distance / radius, half_angle).sin_cos();
                let across = if distance > 0.0 { sin / distance } else { 0.0 };
                Some(Vec3::new(-right * across, -down * across, cos))
            }
            DirectionMap::Panorama { angles: [across, up] } => {
                let (longitude, latitude) = (right / width * across, -down / height * up);
                let ((sin, cos), (top, level)) = (longitude.sin_cos(), latitude.sin_cos());
                Some(Vec3::new(-sin * level, top, cos * level))
            }
        }
    }
}

impl DirectionMap {
    /// A panorama of everything.
    pub const WHOLE: [f64; 2] = [TAU, PI];
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Projection, Projective, ProjectiveSettings};
    use crate::geometry::Transform;

    fn camera(map: DirectionMap, film: [f64; 2]) -> Angular {
        Angular::new(Placed::still(&Transform::IDENTITY).unwrap(), map, film, [0.01, 1e4])
    }

    /// Where a point is seen, by Newton's method on the rays: independent of how the map is inverted.
    fn seen_at(camera: &Angular, point: Vec3, guess: [f64; 2]) -> [f64; 2] {
        let toward = point.normalize();
        let mut film = guess;
        for _ in 0..50 {
            let at = |film: [f64; 2]| camera.direction(film).unwrap() - toward;
            let h = 1e-5;
            let here = at(film);
            let dx = (at([film[0] + h, film[1]]) - here) / h;
            let dy = (at([film[0], film[1] + h]) - here) / h;
            let (a, b, c) = (dx.dot(dx), dx.dot(dy), dy.dot(dy));
            let (p, q) = (dx.dot(here), dy.dot(here));
            let determinant = a * c - b * b;
            film[0] -= (p * c - q * b) / determinant;
            film[1] -= (q * a - p * b) / determinant;
        }
        film
    }

    #[test]
    fn points_are_seen_where_the_projections_put_them() {
        // 60° from the axis, toward the picture's left and a little up.
        let (theta, turn) = (60f64.to_radians(), 20f64.to_radians());
        let point = 3.0 * Vec3::new(theta.sin() * turn.cos(), theta.sin() * turn.sin(), theta.cos());
        let cases = [
            (FisheyeProjection::Equidistant, 180.0, 60.0 / 90.0),
            (FisheyeProjection::Equidistant, 360.0, 60.0 / 180.0),
            (FisheyeProjection::Equisolid, 180.0, 0.5 / 0.5f64.sqrt()),
            (FisheyeProjection::Stereographic, 180.0, 1.0 / 3f64.sqrt()),
            (FisheyeProjection::Orthographic, 180.0, 0.75f64.sqrt()),
            (FisheyeProjection::Equisolid, 200.0, 30f64.to_radians().sin() / 50f64.to_radians().sin()),
            (FisheyeProjection::Stereographic, 270.0, 30f64.to_radians().tan() / 67.5f64.to_radians().tan()),
        ];
        for (projection, fov, fraction) in cases {
            let map = DirectionMap::Fisheye { projection, half_angle: 0.5 * f64::to_radians(fov) };
            let camera = camera(map, [640.0, 480.0]);
            let expected = [320.0 - 240.0 * fraction * turn.cos(), 240.0 - 240.0 * fraction * turn.sin()];
            let found = seen_at(&camera, point, [expected[0] + 3.0, expected[1] - 2.0]);
            let off = (found[0] - expected[0]).hypot(found[1] - expected[1]);
            assert!(off < 1e-6, "{projection:?} {fov}: {found:?} {expected:?}");
        }
    }

    #[test]
    fn nothing_is_seen_outside_the_circle() {
        let projection = FisheyeProjection::Equidistant;
        let camera = camera(DirectionMap::Fisheye { projection, half_angle: 0.5 * PI }, [640.0, 480.0]);
        assert!(camera.ray([320.0 - 239.99, 240.0], 0.0).is_some());
        assert!(camera.ray([320.0 - 240.01, 240.0], 0.0).is_none());
        let edge = camera.direction([320.0, 480.0]).unwrap();
        assert!((edge - -Vec3::Y).length() < 1e-12, "{edge}");
        assert_eq!(camera.direction([320.0, 240.0]), Some(Vec3::Z));
    }

    #[test]
    fn a_panorama_wraps() {
        let camera = camera(DirectionMap::Panorama { angles: DirectionMap::WHOLE }, [800.0, 400.0]);
        let near = |film: [f64; 2], expected: Vec3| {
            let found = camera.direction(film).unwrap();
            assert!((found - expected).length() < 1e-12, "{film:?}: {found} {expected}");
        };
        near([400.0, 200.0], Vec3::Z);
        near([200.0, 200.0], Vec3::X);
        near([600.0, 200.0], -Vec3::X);
        near([123.0, 0.0], Vec3::Y);
        near([0.0, 200.0], -Vec3::Z);
        near([800.0, 200.0], -Vec3::Z);
        near([-7.0, 90.0], camera.direction([793.0, 90.0]).unwrap());
        // Over the pole it goes on on the other side.
        near([100.0, -30.0], camera.direction([500.0, 30.0]).unwrap());
        let point = Vec3::new(1.0, 2.0, -3.0);
        let longitude = (-1.0f64).atan2(-3.0);
        let expected = [400.0 + 800.0 * longitude / TAU, 200.0 - 400.0 * (2.0 / 10f64.sqrt()).atan() / PI];
        let found = seen_at(&camera, point, [expected[0] + 1.0, expected[1] + 1.0]);
        assert!((found[0] - expected[0]).hypot(found[1] - expected[1]) < 1e-6, "{found:?} {expected:?}");
    }

    /// Near the axis all show the same side as a pinhole does, and the same size at the same scale.
    #[test]
    fn a_point_is_on_the_same_side_as_in_a_perspective() {
        let film = [300.0, 300.0];
        let pinhole = Projective::new(ProjectiveSettings {
            placed: Placed::still(&Transform::IDENTITY).unwrap(),
            projection: Projection::Pinhole,
            film,
            half_width: 0.01,
            principal_point: [0.0; 2],
            near_clip: 0.01,
            far_clip: 1e4,
        });
        let half_angle = 0.01f64.atan();
        let maps = FisheyeProjection::NAMES.map(|(_, p)| DirectionMap::Fisheye { projection: p, half_angle });
        let panorama = DirectionMap::Panorama { angles: [2.0 * half_angle; 2] };
        for map in maps.into_iter().chain([panorama]) {
            for place in [[100.0, 150.0], [150.0, 80.0], [210.0, 190.0]] {
                let found = camera(map, film).ray(place, 0.0).unwrap().direction;
                let expected = pinhole.ray(place, [0.5; 2], 0.0).direction;
                // A hundredth of a pixel is 6.7e-7.
                assert!((found - expected).length() < 6.7e-7, "{map:?} {place:?}");
            }
        }
    }
}
