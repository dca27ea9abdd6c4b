//! Path tracing for a group of pixels that share the suffixes of their paths.
//!
//! The camera ray of each pixel i leads to a first surface xᵢ, and scattering there on to a next one, yᵢ. What yᵢ sends on, its
//! light samples and all beyond, serves every pixel of the group that sees yᵢ. Pixel i gets of what lies behind the points yⱼ of all
//! pixels
//!
//! Σⱼ fᵢ(yⱼ) Gᵢⱼ Vᵢⱼ L(yⱼ → xᵢ) / Σₖ pₖ(yⱼ) Vₖⱼ,
//!
//! where pₖ is the density per unit of area with which pixel k samples yⱼ: the balance heuristic over the whole group, visibility
//! included, for a pixel samples only what it sees (Bekaert, Sbert, Halton, "Accelerating path tracing by re-using paths", EGWR 2002).
//! Where yⱼ scatters in dependence on the direction to xᵢ, its BSDF is evaluated for each pixel, and the density of the direction
//! in which the suffix goes on joins each pₖ. The group shares the wavelengths of its paths and their time; each pₖ is summed over the
//! wavelengths, as in [`super::path`].
//!
//! The pixel keeps for itself what yᵢ emits, and all that is decided by directions without a density. Which paths are shared is told
//! by what lies before yⱼ and by the kind of surface that yⱼ is, never by what the suffix finds. So the sum over what is shared and
//! what is not is that of the path tracer.

use super::Seen;
use super::caustics::FirstSurface;
use super::path::{Beside, LastChoice, Path, light_sample_weight, receiver};
use crate::bsdf::{Density, Evaluation};
use crate::geometry::{Ray, Vec3};
use crate::material::Shading;
use crate::sampling::{Dimensions, Stream};
use crate::scene::{Intersection, Scene};
use crate::spectrum::{Sampled, Wavelengths};
use smallvec::SmallVec;

/// The camera ray of a pixel of a group.
#[derive(Clone, Copy, Debug)]
pub struct Sight<'a> {
    /// Which pixel of the group it is.
    pub member: usize,
    pub ray: Ray,
    pub stream: Stream<'a>,
}

/// Most pixels of a group that are kept without an allocation.
const MEMBERS: usize = 16;

/// A first surface that shares.
struct First<const C: usize> {
    /// Whose it is, among the sights.
    sight: usize,
    /// As it comes to the surface.
    path: Path<C>,
    hit: Intersection,
    shading: Shading<C>,
}

/// A next surface, and how it was found.
struct Next<const C: usize> {
    /// By which of the first surfaces.
    owner: usize,
    ray: Ray,
    /// The owner's path as it comes to this surface.
    path: Path<C>,
    hit: Intersection,
    shading: Shading<C>,
}

/// A first surface that sees a next one.
struct Link<const C: usize> {
    first: usize,
    /// From the next surface to the first.
    toward_first: Vec3,
    /// What of the radiance of the next surface the sensor gets per unit of its area: throughput · f · G · transmittance.
    reach: Sampled<C>,
    /// Density with which the first surface samples the next one, per unit of its area, for each wavelength as the hero.
    density: Sampled<C>,
}

/// Adds to each pixel of a group the spectral radiance along its camera ray, as [`super::radiance`] gives it for one alone. `seen` is
/// by the members' numbers; `light_samples` says how many each first surface takes.
pub fn radiance_of_group<const C: usize>(
    scene: &Scene,
    sights: &[Sight],
    time: f64,
    wavelengths: &Wavelengths<C>,
    light_samples: u32,
    seen: &mut [Seen<C>],
) {
    let group = Group { scene, sights, time, wavelengths, light_samples };
    let mut firsts: SmallVec<[First<C>; MEMBERS]> = SmallVec::new();
    for sight in 0..sights.len() {
        firsts.extend(group.first(sight, seen));
    }
    let nexts: SmallVec<[Next<C>; MEMBERS]> =
        (0..firsts.len()).filter_map(|owner| group.next(&firsts, owner, seen)).collect();
    for next in nexts {
        let links = group.links(&firsts, &next);
        group.serve(&firsts, next, &links, seen);
    }
}

struct Group<'a, const C: usize> {
    scene: &'a Scene,
    sights: &'a [Sight<'a>],
    time: f64,
    wavelengths: &'a Wavelengths<C>,
    light_samples: u32,
}

impl<const C: usize> Group<'_, C> {
    /// The first surface of a camera ray, with the light that reaches it straight. `None` where it does not share: then the path is
    /// followed to its end.
    fn first(&self, sight: usize, seen: &mut [Seen<C>]) -> Option<First<C>> {
        let Sight { member, ray, ref stream } = self.sights[sight];
        let mut path = Path::from_camera(self.scene, &ray, self.time);
        let Seen { radiance, met } = &mut seen[member];
        let first = self
            .first_of(&mut path, &ray, stream, radiance)
            .map(|(hit, shading)| (hit, shading, path.clone()));
        *met = path.met || first.is_some();
        let (hit, shading, path) = first?;
        Some(First { sight, path, hit, shading })
    }

    fn first_of(
        &self,
        path: &mut Path<C>,
        ray: &Ray,
        stream: &Stream,
        radiance: &mut Sampled<C>,
    ) -> Option<(Intersection, Shading<C>)> {
        let hit = path.meet(self.scene, ray, self.wavelengths, radiance)?;
        let shading = path.shade(self.scene, ray, &hit, self.wavelengths, stream)?;
        if path.is_last(self.scene) || !shares(&shading) {
            self.go_on_alone(path, ray, &hit, &shading, stream, radiance);
            return None;
        }
        let mut direct = path.direct_light(self.scene, ray, &hit, &shading, self.wavelengths, stream);
        for branch in 1..self.light_samples {
            let stream = &stream.branch(branch);
            direct += path.direct_light(self.scene, ray, &hit, &shading, self.wavelengths, stream);
        }
        *radiance += direct / f64::from(self.light_samples);
        Some((hit, shading))
    }

    /// Follows a path that is not shared from a surface to its end.
    fn go_on_alone(
        &self,
        path: &mut Path<C>,
        ray: &Ray,
        hit: &Intersection,
        shading: &Shading<C>,
        stream: &Stream,
        radiance: &mut Sampled<C>,
    ) {
        if let Some(ray) = path.go_on(self.scene, ray, hit, shading, self.wavelengths, stream, radiance) {
            *radiance += path.follow(self.scene, ray, self.wavelengths, stream);
        }
    }

    /// The next surface that scattering at a first one leads to. `None` where it does not share, and where there is none.
    fn next(&self, firsts: &[First<C>], owner: usize, seen: &mut [Seen<C>]) -> Option<Next<C>> {
        let First { sight, hit, shading, path, .. } = &firsts[owner];
        let Sight { member, ref stream, .. } = self.sights[*sight];
        let radiance = &mut seen[member].radiance;
        let [u, v, lobe, _] = stream.draw(Dimensions::Scattering(path.vertex));
        let scatter = shading.sample(lobe, [u, v])?;
        let mut path = path.clone();
        let ray = path.leave(self.scene, hit, shading, &scatter);
        if scatter.density == Density::Discrete {
            *radiance += path.follow(self.scene, ray, self.wavelengths, stream);
            return None;
        }
        let hit = path.meet(self.scene, &ray, self.wavelengths, radiance)?;
        let shading = path.shade(self.scene, &ray, &hit, self.wavelengths, stream)?;
        if path.is_last(self.scene) || !shares(&shading) || shading.seen_from(-ray.direction).is_none() {
            self.go_on_alone(&mut path, &ray, &hit, &shading, stream, radiance);
            return None;
        }
        Some(Next { owner, ray, path, hit, shading })
    }

    /// The first surfaces that see a next one.
    fn links(&self, firsts: &[First<C>], next: &Next<C>) -> SmallVec<[Link<C>; MEMBERS]> {
        let target = &next.hit.point;
        let side = next.ray.direction.dot(target.normal);
        let link = |(index, first): (usize, &First<C>)| {
            let from = &first.hit.point;
            let between = target.position - from.position;
            let direction = between.normalize();
            let cos = direction.dot(target.normal);
            let geometry = cos.abs() / between.length_squared();
            // The other side of a surface is another one.
            if cos * side <= 0.0 || !geometry.is_finite() {
                return None;
            }
            let value = first.shading.evaluate(direction);
            let density = value.density * geometry;
            if density.is_zero() && value.f_cos.is_zero() {
                return None;
            }
            let owns = index == next.owner;
            let media = &first.path.media.here;
            let between = match from.segment_to(target) {
                Some(ray) if owns && !self.scene.needs().meetings() => {
                    self.scene.transmittance(media, &ray, self.wavelengths).unwrap_or(Sampled::ONE)
                }
                Some(ray) => {
                    self.scene.transmittance_between_surfaces(&ray, self.time, media, self.wavelengths)
                }
                None => Sampled::ZERO,
            };
            // What sampled the surface sees it.
            if between.is_zero() && !owns {
                return None;
            }
            let reach = first.path.throughput * value.f_cos * between * geometry;
            Some(Link { first: index, toward_first: -direction, reach, density })
        };
        firsts.iter().enumerate().filter_map(link).collect()
    }

    /// Gives each first surface what a next one that it sees sends toward it.
    fn serve(&self, firsts: &[First<C>], next: Next<C>, links: &[Link<C>], seen: &mut [Seen<C>]) {
        let Next { owner, ray, path, hit, shading } = next;
        let prior = links.iter().fold(Sampled::ZERO, |sum, link| sum + link.density);
        if prior.hero() <= 0.0 {
            return;
        }
        let stream = &self.sights[firsts[owner].sight].stream;
        let member = |link: &Link<C>| self.sights[firsts[link.first].sight].member;
        if let Some(sample) = path.light_sample(self.scene, &hit, &shading, self.wavelengths, stream) {
            let values = self.values(&shading, links, sample.shadow_ray.direction);
            if values.iter().any(|value| !value.f_cos.is_zero()) {
                let weight = light_sample_weight(self.scene, sample.density, prior.sum(), || {
                    joint_density(links, &values).sum()
                });
                let visibility = if weight == 0.0 {
                    Sampled::ZERO
                } else {
                    path.visibility(self.scene, &ray, &hit, &sample.shadow_ray, self.wavelengths)
                };
                let arriving = sample.radiance * visibility * weight;
                for (link, value) in links.iter().zip(&values) {
                    seen[member(link)].radiance += link.reach * value.f_cos * arriving;
                }
            }
        }
        let [u, v, lobe, survival] = stream.draw(Dimensions::Scattering(path.vertex));
        let Some(scatter) = shading.sample(lobe, [u, v]) else { return };
        let mut path = path;
        if scatter.density == Density::Discrete {
            // What has no density is the owner's alone.
            let ray = path.leave(self.scene, &hit, &shading, &scatter);
            let kept = path.survival(self.scene);
            if survival < kept {
                path.throughput /= kept;
                let sight = firsts[owner].sight;
                seen[self.sights[sight].member].radiance +=
                    path.follow(self.scene, ray, self.wavelengths, stream);
            }
            return;
        }
        let values = self.values(&shading, links, scatter.toward_light);
        let joint = joint_density(links, &values);
        if joint.hero() <= 0.0 {
            return;
        }
        let ray = path.leave(self.scene, &hit, &shading, &scatter);
        let suffix = links
            .iter()
            .zip(&values)
            .fold(Sampled::ZERO, |sum, (link, value)| sum + link.reach * value.f_cos);
        if suffix.is_zero() {
            return;
        }
        let alive = joint.0.iter().filter(|&&density| density > 0.0).count() as f64;
        path.prior_strength = alive * suffix.max() / joint.sum();
        path.throughput = Sampled::ONE;
        path.ratio = joint / joint.hero();
        path.last = LastChoice::Scattered {
            from: receiver(&hit, &shading),
            prior_over_density: prior.sum() / joint.hero(),
            by_scattering: path.ratio,
        };
        if let Beside::First(_) = path.beside_light_paths {
            path.beside_light_paths = Beside::Shared;
        }
        let kept = path.survival(self.scene);
        if survival >= kept {
            return;
        }
        path.throughput /= kept;
        let arriving = path.follow(self.scene, ray, self.wavelengths, stream);
        let contested = std::mem::take(&mut path.contested);
        for (link, value) in links.iter().zip(&values) {
            let carried = link.reach * value.f_cos / joint.hero();
            let mut radiance = arriving;
            for (light, from_light) in &contested {
                let first = &firsts[link.first];
                radiance += *light * self.weight_beside_light_paths(first, link, *from_light);
            }
            seen[member(link)].radiance += carried * radiance;
        }
    }

    /// How a surface scatters light from a direction toward each of the first surfaces.
    fn values(
        &self,
        shading: &Shading<C>,
        links: &[Link<C>],
        toward_light: Vec3,
    ) -> SmallVec<[Evaluation<C>; MEMBERS]> {
        if shading.is_diffuse() {
            return SmallVec::from_elem(shading.evaluate(toward_light), links.len());
        }
        let toward = |link: &Link<C>| {
            shading
                .seen_from(link.toward_first)
                .map_or(Evaluation::ZERO, |shading| shading.evaluate(toward_light))
        };
        links.iter().map(toward).collect()
    }

    /// The weight, beside light subpaths that reach a first surface, of what it gets of a suffix.
    fn weight_beside_light_paths(&self, first: &First<C>, link: &Link<C>, from_light: f64) -> f64 {
        let Some(caustics) = self.scene.caustics() else { return 1.0 };
        let leaves = -link.toward_first;
        let density = first.shading.evaluate(leaves).density.sum() / C as f64;
        let surface = FirstSurface { point: first.hit.point, leaves, density };
        caustics.weight_beside(self.scene, &surface, from_light, self.time)
    }
}

/// The density of a next surface together with the direction in which the path goes on from it, over all first surfaces.
fn joint_density<const C: usize>(links: &[Link<C>], values: &[Evaluation<C>]) -> Sampled<C> {
    links.iter().zip(values).fold(Sampled::ZERO, |sum, (link, value)| sum + link.density * value.density)
}

/// Whether a surface may be one of those between which paths are shared: it scatters with a density, back to the side that light comes
/// from.
fn shares<const C: usize>(shading: &Shading<C>) -> bool {
    !shading.bsdf.is_discrete() && !shading.bsdf.transmits()
}
