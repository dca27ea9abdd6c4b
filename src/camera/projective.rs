//! Cameras that project the scene onto a plane.

use super::Projected;
use crate::geometry::{Bounds, Placed, Ray, Vec3};
use crate::sampling::warp;

/// A pinhole, thin-lens or orthographic camera. It looks along its local +z, local +x is the picture's left
/// and +y its top.
#[derive(Clone, Debug)]
pub struct Projective {
    placed: Placed,
    projection: Projection,
    /// Film positions in pixels to the local plane z = 1: scale and offset of each axis.
    scale: [f64; 2],
    offset: [f64; 2],
    /// Width and height in pixels.
    film: [f64; 2],
    /// Depths between which surfaces are seen.
    near_clip: f64,
    far_clip: f64,
}

/// How rays run through the film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// All through one point.
    Pinhole,
    /// Through one point of the lens each.
    ThinLens(ThinLens),
    /// All along the axis.
    Orthographic,
}

/// An ideal lens without thickness that images the plane at `focus_distance` onto the film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinLens {
    /// Shape and size of the opening.
    pub aperture: Aperture,
    /// Distance along the axis of the plane that is in focus, in scene units.
    pub focus_distance: f64,
}

/// The opening of a lens, evenly lit. Scene units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Aperture {
    /// A disk.
    Disk {
        /// In scene units. Above 0.
        radius: f64,
    },
    /// A regular polygon with corners on the circle of this radius, one of them `rotation` radians from the
    /// camera's +y towards its +x: counter-clockwise for who stands behind the camera.
    Polygon {
        /// Radius of the circle through its corners, in scene units. Above 0.
        radius: f64,
        /// Number of corners, at least 3.
        blades: u32,
        /// Where the first corner is, in radians.
        rotation: f64,
    },
}

impl Aperture {
    fn radius(self) -> f64 {
        match self {
            Self::Disk { radius } | Self::Polygon { radius, .. } => radius,
        }
    }

    /// The point that a place in the unit square stands for; strata stay in one piece.
    fn point(self, u: [f64; 2]) -> [f64; 2] {
        match self {
            Self::Disk { radius } => warp::disk(u).map(|c| c * radius),
            Self::Polygon { radius, blades, rotation } => {
                warp::polygon(u, blades, rotation).map(|c| c * radius)
            }
        }
    }
}

/// What [`Projective::new`] is made from.
#[derive(Clone, Debug)]
pub struct ProjectiveSettings {
    /// By a rigid map or a mirror image of one; by any affine map for an orthographic camera.
    pub placed: Placed,
    /// Pinhole, thin lens or parallel rays.
    pub projection: Projection,
    /// Width and height of the whole film in pixels.
    pub film: [f64; 2],
    /// Half the width of what is seen at distance 1: the tangent of half the horizontal field of view.
    pub half_width: f64,
    /// Offset of the principal point in parts of the film's width and height.
    pub principal_point: [f64; 2],
    /// Distance along the axis before which nothing is seen, in scene units.
    pub near_clip: f64,
    /// Distance along the axis beyond which nothing is seen, in scene units.
    pub far_clip: f64,
}

impl Projective {
    /// The camera of these settings.
    pub fn new(settings: ProjectiveSettings) -> Self {
        let [width, height] = settings.film;
        let [px, py] = settings.principal_point;
        // The same for both axes: pixels are square.
        let per_pixel = 2.0 * settings.half_width / width;
        Self {
            placed: settings.placed,
            projection: settings.projection,
            scale: [-per_pixel; 2],
            offset: [-per_pixel * width * (px - 0.5), -per_pixel * height * (py - 0.5)],
            film: settings.film,
            near_clip: settings.near_clip,
            far_clip: settings.far_clip,
        }
    }

    /// Whether [`Self::ray`] uses its lens sample.
    pub fn has_lens(&self) -> bool {
        matches!(self.projection, Projection::ThinLens(_))
    }

    /// Whether the camera moves while the shutter is open.
    pub fn is_moving(&self) -> bool {
        self.placed.is_moving()
    }

    /// A box around where its rays begin, from one time to another, also of those a film's width beyond its
    /// border.
    pub fn origins(&self, during: [f64; 2]) -> Bounds {
        let film = [0, 1].map(|i| self.offset[i].abs() + 2.0 * (self.scale[i] * self.film[i]).abs());
        let radius = match self.projection {
            // Rays have come this far from their point of the lens toward one of the plane in focus.
            Projection::ThinLens(ThinLens { aperture, focus_distance }) => {
                aperture.radius() * (1.0 - self.near_clip / focus_distance).abs()
            }
            Projection::Pinhole | Projection::Orthographic => 0.0,
        };
        let across = match self.projection {
            Projection::Orthographic => 1.0,
            Projection::Pinhole | Projection::ThinLens(_) => self.near_clip,
        };
        let half = |i: usize| across * film[i] + radius;
        let [min, max] = [-1.0, 1.0].map(|side| Vec3::new(side * half(0), side * half(1), self.near_clip));
        self.placed.bounds(Bounds { min, max }, during)
    }

    /// The ray seen at a film position (pixels from the top left corner of the film) through the point of the
    /// lens that `lens_u` chooses, at a time.
    pub fn ray(&self, film: [f64; 2], lens_u: [f64; 2], time: f64) -> Ray {
        let axis = |i: usize| film[i] * self.scale[i] + self.offset[i];
        let on_plane = Vec3::new(axis(0), axis(1), 1.0);
        let (origin, direction) = match self.projection {
            Projection::Pinhole => (Vec3::ZERO, on_plane),
            Projection::ThinLens(lens) => {
                let [x, y] = lens.aperture.point(lens_u);
                let origin = Vec3::new(x, y, 0.0);
                (origin, on_plane - origin / lens.focus_distance)
            }
            Projection::Orthographic => (on_plane.with_z(0.0), Vec3::Z),
        };
        // z is 1 here, so depths along the axis are distances over the direction's length.
        let length = direction.length();
        let near = origin + direction * self.near_clip;
        let pose = self.placed.at(time);
        Ray {
            origin: pose.world_point(near),
            direction: pose.world_vector(direction / length).normalize(),
            // In world units even where the camera's map scales, as in Mitsuba 3.
            t_max: (self.far_clip - self.near_clip) * length,
        }
    }

    /// Whether all rays come through a point or a lens.
    pub fn has_eye(&self) -> bool {
        self.projection != Projection::Orthographic
    }

    /// See [`super::Camera::project`]. `None` too for what has no eye.
    pub fn project(&self, point: Vec3, lens_u: [f64; 2], time: f64) -> Option<Projected<'static>> {
        let pose = self.placed.at(time);
        let local = pose.local_point(point);
        let (lens, focused) = match self.projection {
            Projection::Pinhole => (Vec3::ZERO, Vec3::ZERO),
            Projection::ThinLens(lens) => {
                let [x, y] = lens.aperture.point(lens_u);
                let origin = Vec3::new(x, y, 0.0);
                (origin, origin / lens.focus_distance)
            }
            Projection::Orthographic => return None,
        };
        if !(local.z > self.near_clip && local.z < self.far_clip) {
            return None;
        }
        let direction = (local - lens) / local.z;
        let on_plane = direction + focused;
        let axis = |i: usize| (on_plane[i] - self.offset[i]) / self.scale[i];
        let away = pose.world_point(lens) - point;
        let distance = away.length();
        // The plane z = 1 is as far away as the direction is long, and seen at a slant of the same.
        let length = direction.length();
        let pixels_per_steradian = length.powi(3) / (self.scale[0] * self.scale[1]);
        Some(Projected {
            film: [axis(0), axis(1)],
            begins: pose.world_point(lens + direction * self.near_clip),
            toward_lens: away / distance,
            distance,
            pixels_per_steradian,
            response: None,
        })
    }

    /// See [`super::Camera::circle_of_confusion_radius`]. A polygon has that of the circle through its
    /// corners.
    pub fn circle_of_confusion_radius(&self, point: Vec3, time: f64) -> Option<f64> {
        let Projection::ThinLens(ThinLens { aperture, focus_distance }) = self.projection else {
            return None;
        };
        let depth = self.placed.at(time).local_point(point).z;
        let on_plane = aperture.radius() * (1.0 / focus_distance - 1.0 / depth).abs();
        (depth > self.near_clip && depth < self.far_clip).then(|| on_plane / self.scale[0].abs())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Transform;
    use glam::DMat4;

    fn settings() -> ProjectiveSettings {
        ProjectiveSettings {
            placed: Placed::still(&Transform::IDENTITY).unwrap(),
            projection: Projection::Pinhole,
            film: [200.0, 100.0],
            half_width: 0.5,
            principal_point: [0.0, 0.0],
            near_clip: 0.01,
            far_clip: 1e4,
        }
    }

    /// Where a ray meets the plane z = 1.
    fn at_unit_depth(camera: &Projective, film: [f64; 2], lens: [f64; 2]) -> Vec3 {
        let ray = camera.ray(film, lens, 0.0);
        ray.at((1.0 - ray.origin.z) / ray.direction.z)
    }

    #[test]
    fn left_of_the_picture_is_local_plus_x_and_top_is_plus_y() {
        let camera = Projective::new(settings());
        assert!((at_unit_depth(&camera, [0.0, 0.0], [0.5; 2]) - Vec3::new(0.5, 0.25, 1.0)).length() < 1e-12);
        assert!((at_unit_depth(&camera, [100.0, 50.0], [0.5; 2]) - Vec3::Z).length() < 1e-12);
    }

    #[test]
    fn a_positive_principal_point_moves_content_left_and_up() {
        let camera = Projective::new(ProjectiveSettings { principal_point: [0.1, 0.2], ..settings() });
        // What is on the axis is seen a tenth of the width to the left and a fifth of the height higher.
        assert!((at_unit_depth(&camera, [80.0, 30.0], [0.5; 2]) - Vec3::Z).length() < 1e-12);
    }

    #[test]
    fn clips_are_planes() {
        let camera = Projective::new(ProjectiveSettings { near_clip: 2.0, far_clip: 5.0, ..settings() });
        let ray = camera.ray([3.0, 7.0], [0.5; 2], 0.0);
        assert!((ray.origin.z - 2.0).abs() < 1e-12);
        assert!((ray.at(ray.t_max).z - 5.0).abs() < 1e-12);
    }

    #[test]
    fn the_focal_surface_is_a_plane_and_blur_has_the_diameter_of_similar_triangles() {
        let lens = ThinLens { aperture: Aperture::Disk { radius: 0.1 }, focus_distance: 4.0 };
        let camera =
            Projective::new(ProjectiveSettings { projection: Projection::ThinLens(lens), ..settings() });
        for film in [[3.0, 7.0], [100.0, 50.0], [199.0, 99.0]] {
            let at = |depth: f64, u: [f64; 2]| {
                let ray = camera.ray(film, u, 0.0);
                ray.at((depth - ray.origin.z) / ray.direction.z)
            };
            let edge = [[0.999_999_9, 0.5], [0.000_000_1, 0.5]];
            assert!((at(4.0, edge[0]) - at(4.0, edge[1])).length() < 1e-6);
            let blur = (at(6.0, edge[0]) - at(6.0, edge[1])).length();
            assert!((blur - 2.0 * 0.1 * (6.0 - 4.0) / 4.0).abs() < 1e-6, "{blur}");
            // The other way round: over so many pixels a point is spread.
            let point = at(6.0, [0.5; 2]);
            let seen = edge.map(|u| camera.project(point, u, 0.0).unwrap().film[0]);
            let circle = camera.circle_of_confusion_radius(point, 0.0).unwrap();
            assert!((circle - 0.5 * (seen[0] - seen[1]).abs()).abs() < 1e-5 * circle, "{circle} {seen:?}");
            assert!(camera.circle_of_confusion_radius(at(4.0, edge[0]), 0.0).unwrap() < 1e-9);
        }
    }

    /// Points along a ray are seen where the ray comes from, and as large as the rays around it say.
    #[test]
    fn points_are_seen_where_their_rays_come_from() {
        let turned = DMat4::from_axis_angle(Vec3::new(1.0, 2.0, -0.5).normalize(), 0.7);
        let placed = Transform::new(DMat4::from_translation(Vec3::new(3.0, -1.0, 2.0)) * turned).unwrap();
        let lens = ThinLens { aperture: Aperture::Disk { radius: 0.3 }, focus_distance: 4.0 };
        for projection in [Projection::Pinhole, Projection::ThinLens(lens)] {
            let placed = Placed::still(&placed).unwrap();
            let camera = Projective::new(ProjectiveSettings {
                placed,
                projection,
                principal_point: [0.1, -0.2],
                ..settings()
            });
            for (film, u, t) in [
                ([3.0, 7.0], [0.2, 0.7], 2.5),
                ([100.0, 50.0], [0.5, 0.5], 7.0),
                ([190.0, 99.0], [0.9, 0.1], 0.4),
            ] {
                let ray = camera.ray(film, u, 0.0);
                let seen = camera.project(ray.at(t), u, 0.0).unwrap();
                assert!((seen.film[0] - film[0]).hypot(seen.film[1] - film[1]) < 1e-10, "{seen:?}");
                assert!((seen.toward_lens + ray.direction).length() < 1e-14);
                assert!((seen.begins - ray.origin).length() < 1e-14);
                let step = 1e-3;
                let at = |dx: f64, dy: f64| {
                    camera.ray([film[0] + dx * step, film[1] + dy * step], u, 0.0).direction
                };
                let solid_angle = (at(0.5, 0.0) - at(-0.5, 0.0)).cross(at(0.0, 0.5) - at(0.0, -0.5)).length();
                let expected = step * step / solid_angle;
                assert!((seen.pixels_per_steradian / expected - 1.0).abs() < 1e-6, "{seen:?} {expected}");
                assert!(camera.project(ray.origin - ray.direction, u, 0.0).is_none());
            }
        }
    }
}
