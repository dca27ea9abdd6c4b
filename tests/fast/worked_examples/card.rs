//! The ray tracer on Heckbert's business card.

use super::{assert_near_vector, scattered};
use abbe::geometry::{Ray, SurfacePoint, Transform, Vec3};
use abbe::shape::Sphere;

/// One of the five spheres on Heckbert's card: shares of diffuse, reflected, transmitted and emitted light,
/// and the index inside over that outside.
struct CardSphere {
    shape: Sphere,
    centre: Vec3,
    colour: Vec3,
    diffuse: f64,
    reflected: f64,
    transmitted: f64,
    emitted: f64,
    index: f64,
}

/// Its ray tracer in the style of Whitted, on this program's spheres, reflection and refraction.
struct Card(Vec<CardSphere>);

const CARD_AMBIENT: f64 = 0.02;

impl Card {
    /// `third` is the red of the third sphere, `radii` are those of the fourth and the fifth: what is
    /// misprinted in some copies.
    fn new(third: f64, radii: [f64; 2]) -> Self {
        let sphere = |centre: [f64; 3], colour: [f64; 3], radius: f64, shares: [f64; 4], index: f64| {
            let centre = Vec3::from_array(centre);
            CardSphere {
                shape: Sphere::new(&Transform::IDENTITY, centre, radius, false).unwrap(),
                centre,
                colour: Vec3::from_array(colour),
                diffuse: shares[0],
                reflected: shares[1],
                transmitted: shares[2],
                emitted: shares[3],
                index,
            }
        };
        Self(vec![
            sphere([0.0, 6.0, 0.5], [1.0, 1.0, 1.0], 0.9, [0.05, 0.2, 0.85, 0.0], 1.7),
            sphere([-1.0, 8.0, -0.5], [1.0, 0.5, 0.2], 1.0, [0.7, 0.3, 0.0, 0.05], 1.2),
            sphere([1.0, 8.0, -0.5], [third, 0.8, 0.8], 1.0, [0.3, 0.7, 0.0, 0.0], 1.2),
            sphere([3.0, -6.0, 15.0], [1.0, 0.8, 1.0], radii[0], [0.0, 0.0, 0.0, 0.6], 1.5),
            sphere([-3.0, -3.0, 12.0], [0.8, 1.0, 1.0], radii[1], [0.0, 0.0, 0.0, 0.5], 1.5),
        ])
    }

    fn nearest(&self, ray: &Ray) -> Option<(usize, f64)> {
        let hits =
            self.0.iter().enumerate().filter_map(|(i, sphere)| Some((i, sphere.shape.intersect(ray)?)));
        hits.min_by(|a, b| a.1.total_cmp(&b.1))
    }

    fn trace(&self, level: u32, ray: &Ray) -> Vec3 {
        if level == 0 {
            return Vec3::ZERO;
        }
        let Some((index, t)) = self.nearest(ray) else { return Vec3::splat(CARD_AMBIENT) };
        let sphere = &self.0[index];
        let point: SurfacePoint = sphere.shape.surface(ray.at(t)).point;
        let inside = point.normal.dot(ray.direction) > 0.0;
        let normal = if inside { -point.normal } else { point.normal };
        let mut light = Vec3::splat(CARD_AMBIENT);
        for (other, lamp) in self.0.iter().enumerate() {
            let toward = (lamp.centre - point.position).normalize();
            let received = lamp.emitted * normal.dot(toward);
            let shadow = self.nearest(&point.ray(toward));
            if received > 0.0 && shadow.is_some_and(|(met, _)| met == other) {
                light += received * lamp.colour;
            }
        }
        let further = |direction: Option<Vec3>| {
            direction.map_or(Vec3::ZERO, |direction| self.trace(level - 1, &point.ray(direction)))
        };
        let eta = if inside { 1.0 / sphere.index } else { sphere.index };
        sphere.emitted * sphere.colour
            + sphere.diffuse * light * sphere.colour
            + sphere.reflected * further(scattered(ray.direction, normal, eta, false))
            + sphere.transmitted * further(scattered(ray.direction, normal, eta, true))
    }

    /// 32 × 32 pixels of 25°, red, green and blue up to 255.
    fn picture(&self) -> Vec<Vec3> {
        let distance = 16.0 / 12.5f64.to_radians().tan();
        (0..32 * 32)
            .map(|i| {
                let direction = Vec3::new(f64::from(i % 32) - 16.0, distance, 16.0 - f64::from(i / 32));
                (255.0 * self.trace(3, &Ray::new(Vec3::ZERO, direction.normalize()))).map(f64::round)
            })
            .collect()
    }
}

#[test]
fn n15_heckberts_card() {
    let mean = |picture: &[Vec3]| picture.iter().sum::<Vec3>() / picture.len() as f64;
    let card = Card::new(0.1, [7.0, 5.0]).picture();
    let pixels = [
        ([8, 20], [64.0, 38.0, 15.0]),
        ([24, 20], [4.0, 22.0, 27.0]),
        ([16, 12], [10.0; 3]),
        ([16, 16], [6.0; 3]),
        ([4, 4], [5.0; 3]),
    ];
    for ([column, row], expected) in pixels {
        assert_near_vector(card[32 * row + column], expected, 0.0);
    }
    assert_near_vector(mean(&card), [23.872, 19.420, 15.694], 5.1e-4);
    // As the course notes print it.
    let printed = Card::new(1.0, [0.7, 0.5]).picture();
    assert_near_vector(printed[32 * 20 + 24], [34.0, 22.0, 27.0], 0.0);
    assert_near_vector(mean(&printed), [27.569, 18.173, 14.255], 5.1e-4);
}
