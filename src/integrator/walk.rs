//! The slow, obvious estimate that the clever one must agree with: a random walk of one wavelength that finds lights by
//! running into them. No light sampling, no weights between techniques, no companions.

use super::Seen;
use crate::geometry::Ray;
use crate::sampling::{Dimensions, Stream};
use crate::scene::Scene;
use crate::spectrum::{Sampled, Wavelengths};

/// Spectral radiance that arrives along a camera ray, for the hero alone. Point and directional lights are never found.
pub fn radiance<const C: usize>(
    scene: &Scene,
    mut ray: Ray,
    time: f64,
    wavelengths: &Wavelengths<C>,
    stream: &Stream,
) -> Seen<C> {
    let hero = Wavelengths::<1> { nm: [wavelengths.nm[0]], density: Sampled([wavelengths.density[0]]) };
    let mut media = scene.media_at_sensor(&ray, time);
    let (mut arriving, mut throughput) = (0.0, 1.0);
    let mut met = scene.limits.sky_covers(scene);
    for vertex in 0.. {
        let shown = vertex > 0 || !scene.limits.hide_emitters;
        let hit = scene.intersect(&ray, time, vertex == 0, &mut media, |media, distance| {
            if let Some(transmittance) = scene.transmittance(media, distance, &hero) {
                throughput *= transmittance.hero();
            }
        });
        let Some(hit) = hit else {
            if let Some(environment) = scene.lights.environment().filter(|_| shown) {
                arriving += throughput * environment.radiance(ray.direction, &hero.nm).hero();
            }
            break;
        };
        if let Some(light) = hit.light
            && ray.direction.dot(hit.point.normal) < 0.0
        {
            arriving +=
                throughput * scene.lights.radiance(light, &scene.texture_point(&hit), &hero.nm).hero();
        }
        let last = vertex + 1 >= scene.limits.max_depth;
        if last && (met || !scene.film.alpha) {
            break;
        }
        let choice = if scene.needs().choices { stream.draw(Dimensions::Light(vertex))[3] } else { 0.0 };
        let shading = scene.shade(&hit, -ray.direction, &media, &hero, choice);
        let [u, v, lobe, survival] = stream.draw(Dimensions::Scattering(vertex));
        let scatter = shading.sample(lobe, [u, v]);
        let passes =
            scatter.as_ref().is_some_and(|scatter| scatter.transmitted) && shading.bsdf.passes_straight();
        met |= scene.limits.surface_covers(passes);
        let Some(scatter) = scatter.filter(|_| !last) else { break };
        let direction = scatter.toward_light;
        if scatter.transmitted {
            scene.pass_through(&hit, direction, &mut media);
        }
        throughput *= scatter.weight.hero();
        let chance = throughput.min(0.95);
        if survival >= chance {
            break;
        }
        throughput /= chance;
        ray = hit.point.ray(direction);
    }
    Seen { radiance: Sampled::hero_alone(arriving), met }
}
