//! The slow, obvious estimate that the clever one must agree with: a random walk of one wavelength that finds
//! lights by running into them. No light sampling, no weights between techniques, no companions. Media that
//! scatter are tracked by a majorant with null collisions (Woodcock et al., "Techniques used in the GEM code
//! for Monte Carlo neutronics calculations", 1965), so that nothing of how [`super::volume`] finds its
//! distances is taken on trust.

use super::RadianceSample;
use crate::geometry::{Ray, Vec3};
use crate::medium::{Extinction, Medium, MediumStack, Scattering};
use crate::sampling::{Dimensions, Stream, mix};
use crate::scene::{PathEnd, RayKind, Scene};
use crate::spectrum::{Sampled, Wavelengths};

/// Most probability with which a walk goes on.
const LIKELIEST: f64 = 0.95;

/// Spectral radiance that arrives along a camera ray, for the hero alone. Point and directional lights are
/// never found.
pub fn radiance<const C: usize>(
    scene: &Scene,
    mut ray: Ray,
    time: f64,
    wavelengths: &Wavelengths<C>,
    stream: &Stream,
) -> RadianceSample<C> {
    let hero = Wavelengths::<1> { nm: [wavelengths.nm[0]], density: Sampled([wavelengths.density[0]]) };
    let mut media = scene.media_at_sensor(&ray, time);
    let (mut arriving, mut throughput) = (0.0, 1.0);
    let mut alpha_hit = scene.limits.sky_covers(scene);
    // Whether the path is still what the camera sees beyond the scene: surfaces that let it pass may not
    // count.
    let mut camera_visible = true;
    let chance_to_go_on = |throughput: f64, vertex: u32| match vertex + 1 < scene.limits.rr_depth {
        true => f64::from(u8::from(throughput > 0.0)),
        false => throughput.min(LIKELIEST),
    };
    for vertex in 0.. {
        let kind = if vertex == 0 { RayKind::Camera } else { RayKind::Scattered };
        let mut tracker = Tracker::new(stream, vertex, hero.nm[0]);
        let hit = scene.intersect(&ray, time, kind, &mut media, |around, segment| {
            if tracker.collision.is_some() {
                return;
            }
            match scene.medium(around) {
                Some(medium) if medium.scattering.is_some() || medium.emission.is_some() => {
                    tracker.follow(medium, around, segment);
                    arriving += throughput * std::mem::take(&mut tracker.emitted);
                }
                _ => {
                    if let Some(transmittance) = scene.transmittance(around, segment, &hero) {
                        throughput *= transmittance.hero();
                    }
                }
            }
        });
        if let Some((position, scattering, around)) = tracker.collision {
            let Some(scattering) = scattering else {
                scene.path_ended(PathEnd::Absorbed, vertex + 1);
                break;
            };
            alpha_hit = true;
            camera_visible = false;
            throughput *= scattering.albedo(position, &hero.nm).hero();
            let [u, v, choice, survival] = stream.draw(Dimensions::Scattering(vertex));
            let survival_probability = chance_to_go_on(throughput, vertex);
            let last = vertex + 1 >= scene.limits.max_depth;
            if last || survival >= survival_probability {
                scene.path_ended(if last { PathEnd::MaxDepth } else { PathEnd::Roulette }, vertex + 1);
                break;
            }
            throughput /= survival_probability;
            media.here = around;
            let sample = scattering.phase.sample(ray.direction, position, &hero.nm, [u, v, choice]);
            ray = Ray::new(position, sample.direction);
            continue;
        }
        let Some(hit) = hit else {
            let hidden = camera_visible && scene.limits.hide_emitters;
            if let Some(environment) = scene.lights.environment().filter(|_| !hidden) {
                arriving += throughput * environment.radiance(ray.direction, &hero.nm).hero();
            }
            scene.path_ended(PathEnd::Escaped, vertex + 1);
            break;
        };
        if let Some(light) = hit.light
            && ray.direction.dot(hit.point.normal) < 0.0
        {
            arriving +=
                throughput * scene.lights.radiance(light, &scene.texture_point(&hit), &hero.nm).hero();
        }
        let last = vertex + 1 >= scene.limits.max_depth;
        if last && (alpha_hit || !scene.film.alpha) {
            scene.path_ended(PathEnd::MaxDepth, vertex + 1);
            break;
        }
        let choice = scene.material_choice(stream, vertex);
        let shading = scene.shade(&hit, -ray.direction, &media, &hero, choice);
        let [u, v, lobe, survival] = stream.draw(Dimensions::Scattering(vertex));
        let scatter = shading.sample(lobe, [u, v]);
        let passes = scatter.as_ref().is_some_and(|scatter| shading.passes(scatter));
        let covers = scene.limits.surface_covers(passes);
        (alpha_hit, camera_visible) = (alpha_hit || covers, camera_visible && !covers);
        let Some(scatter) = scatter.filter(|_| !last) else {
            scene.path_ended(if last { PathEnd::MaxDepth } else { PathEnd::Absorbed }, vertex + 1);
            break;
        };
        let direction = scatter.toward_light;
        if scatter.transmitted {
            scene.pass_through(&hit, direction, &mut media);
        }
        throughput *= scatter.weight.hero();
        let survival_probability = chance_to_go_on(throughput, vertex);
        if survival >= survival_probability {
            let end = if throughput > 0.0 { PathEnd::Roulette } else { PathEnd::Absorbed };
            scene.path_ended(end, vertex + 1);
            break;
        }
        throughput /= survival_probability;
        ray = hit.point.ray(direction);
    }
    RadianceSample { radiance: Sampled::hero_alone(arriving), alpha_hit }
}

/// A flight through media that scatter.
struct Tracker<'a> {
    /// The state of a generator of its own: the number of values that a walk takes has no bound.
    random: u64,
    nm: f64,
    /// What media send out on a segment.
    emitted: f64,
    /// Where it has ended, by what it is scattered there, if it is, and in what.
    collision: Option<(Vec3, Option<&'a Scattering>, MediumStack)>,
}

impl<'a> Tracker<'a> {
    fn new(stream: &Stream, vertex: u32, nm: f64) -> Self {
        let [a, b, ..] = stream.draw(Dimensions::Flight(vertex));
        let random = a.to_bits() ^ b.to_bits().rotate_left(32);
        Self { random, nm, emitted: 0.0, collision: None }
    }

    /// In (0, 1).
    fn draw(&mut self) -> f64 {
        self.random = self.random.wrapping_add(0x9E37_79B9_7F4A_7C15);
        ((mix(self.random) >> 12) as f64 + 0.5) / (1u64 << 52) as f64
    }

    /// Media that send out light are tracked even where they do nothing else. At each collision, null or not,
    /// there is what is sent out over the majorant: an estimate that has nothing in common with that of
    /// [`Medium::emission_along`].
    fn follow(&mut self, medium: &'a Medium, around: &MediumStack, segment: &Ray) {
        /// Some collisions are null in a homogeneous medium, too.
        const ABOVE: f64 = 1.25;
        let (greatest, span) = match &medium.extinction {
            Extinction::Homogeneous(spectrum) => (ABOVE * spectrum.at(self.nm), Some([0.0, segment.t_max])),
            Extinction::Grid(grid) => (grid.max_bound(), grid.span(segment)),
            Extinction::Diluted(diluted) => {
                let density = &diluted.density;
                (diluted.spectrum.at(self.nm) * density.max_bound(), density.span(segment))
            }
        };
        let area = medium.scattering.as_ref().map_or(1.0, |scattering| scattering.phase.max_projected_area());
        let greatest = greatest * area;
        let (majorant, [mut t, end]) = match (&medium.emission, span) {
            (None, Some(span)) => (greatest, span),
            (None, None) => return,
            // Some collisions, where there is little to collide with.
            (Some(_), _) => {
                let least = if segment.t_max.is_finite() { 2.0 / segment.t_max } else { 0.0 };
                (greatest + least, [0.0, segment.t_max])
            }
        };
        loop {
            t -= self.draw().ln() / majorant;
            if t.is_nan() || t >= end {
                return;
            }
            let (position, wavelength) = (segment.at(t), [self.nm]);
            let direction = segment.direction;
            if medium.emission.is_some() {
                self.emitted += medium.emitted_at(position, direction, &wavelength).hero() / majorant;
            }
            let extinction = medium.extinction_at(position, direction, &wavelength).hero();
            if self.draw() * majorant < extinction {
                self.collision = Some((position, medium.scattering.as_ref(), around.clone()));
                return;
            }
        }
    }
}
