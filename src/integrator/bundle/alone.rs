//! Paths that leave a bundle: [`Path`] follows them to their ends.

use super::super::path::{Beside, Competing, Parted, Path, PreviousSample};
use super::super::surfaces::Surfaces;
use super::{Bundle, Source};
use crate::bsdf::Scatter;
use crate::geometry::Ray;
use crate::lanes::get;
use crate::material::Shading;
use crate::scene::{Intersection, Intersections};
use crate::spectrum::Sampled;

impl<const C: usize> Bundle<'_, C> {
    /// The path of a lane, to be followed alone.
    pub fn path(&self, lane: usize) -> Path<C> {
        let (scene, ray) = (self.scene, self.rays.get(lane));
        if self.depth == 0 {
            let mut path = Path::from_camera(scene, &ray, self.time);
            path.throughput = self.throughput.get(lane);
            if let Some(media) = self.media.get(lane) {
                path.media.clone_from(media);
            }
            return path;
        }
        let beside = match self.firsts.get(lane) {
            None => Beside::Nothing,
            Some(_) if self.is_shared => Beside::Shared,
            Some(first) => Beside::First(*first),
        };
        let competing = self.competing >> lane & 1 == 1;
        Path::parted(Parted {
            time: self.time,
            depth: self.depth,
            throughput: self.throughput.get(lane),
            ratio: self.ratio.get(lane),
            last: PreviousSample::Scattered {
                from: self.from().get(lane),
                prior_over_density: get(&self.prior_over_density, lane),
                by_scattering: self.ratio.get(lane),
            },
            media: self.media(lane).into_owned(),
            beside_light_subpaths: beside,
            competing: if competing { Competing::Shared } else { Competing::No },
            prior_throughput: get(&self.prior_throughput, lane),
        })
    }

    /// The path of a lane leaves the bundle at a surface and is followed to its end. What it finds, and
    /// whether it meets what alpha counts.
    pub fn go_on_alone(&mut self, surfaces: &Surfaces<C>, lane: usize) -> (Sampled<C>, bool) {
        self.alive &= !(1 << lane);
        let (hit, ray) = (surfaces.hits.get(self.scene, lane), self.rays.get(lane));
        let Some(shading) = surfaces.shading(lane) else { return (Sampled::ZERO, false) };
        self.follow_from(lane, &ray, &hit, shading)
    }

    /// Past the last segment: what is left to do at a surface for the path of a lane.
    pub fn end_alone(&mut self, hits: &Intersections, lane: usize) -> (Sampled<C>, bool) {
        let (hit, ray) = (hits.get(self.scene, lane), self.rays.get(lane));
        let (wavelengths, stream) = (self.wavelengths(lane), self.stream(lane));
        let path = self.path(lane);
        match path.shade(self.scene, &ray, &hit, wavelengths, stream) {
            Some(shading) => self.follow_from(lane, &ray, &hit, &shading),
            None => (Sampled::ZERO, path.alpha_hit),
        }
    }

    /// The same with how the surface scatters.
    fn follow_from(
        &mut self,
        lane: usize,
        ray: &Ray,
        hit: &Intersection,
        shading: &Shading<C>,
    ) -> (Sampled<C>, bool) {
        let (wavelengths, stream) = (self.wavelengths(lane), self.stream(lane));
        let mut path = self.path(lane);
        let mut light = Sampled::ZERO;
        if let Some(ray) = path.go_on(self.scene, ray, hit, shading, wavelengths, stream, &mut light) {
            light += path.follow(self.scene, ray, wavelengths, stream);
        }
        self.keep_contested(lane, &mut path);
        (light, path.alpha_hit)
    }

    /// Follows a path that has left its first surface in a single direction, which decides alone.
    pub fn follow_single(&self, surfaces: &Surfaces<C>, lane: usize, scatter: &Scatter<C>) -> Sampled<C> {
        let Some(shading) = surfaces.shading(lane) else { return Sampled::ZERO };
        let mut path = self.path(lane);
        let ray = path.leave(self.scene, &surfaces.hits.get(self.scene, lane), shading, scatter);
        path.follow(self.scene, ray, self.wavelengths(lane), self.stream(lane))
    }

    /// Follows what the coat of a first surface mirrors; see [`Path::follow_mirror`].
    pub fn follow_mirror(&self, surfaces: &Surfaces<C>, lane: usize, mirror: &Scatter<C>) -> Sampled<C> {
        let Some(rest) = surfaces.shading(lane) else { return Sampled::ZERO };
        let hit = surfaces.hits.get(self.scene, lane);
        let (wavelengths, stream) = (self.wavelengths(lane), self.stream(lane));
        self.path(lane).follow_mirror(self.scene, &hit, rest, mirror, wavelengths, stream)
    }

    /// Follows a path from where it has been scattered. `survival` is the value that decides whether it
    /// survives.
    pub fn scatter_alone(
        &mut self,
        surfaces: &Surfaces<C>,
        lane: usize,
        scatter: &Scatter<C>,
        survival: f64,
    ) -> Sampled<C> {
        let Some(shading) = surfaces.shading(lane) else { return Sampled::ZERO };
        let mut path = self.path(lane);
        let ray = path.leave(self.scene, &surfaces.hits.get(self.scene, lane), shading, scatter);
        if !path.survives(self.scene, survival) {
            return Sampled::ZERO;
        }
        let light = path.follow(self.scene, ray, self.wavelengths(lane), self.stream(lane));
        self.keep_contested(lane, &mut path);
        light
    }

    pub(super) fn keep_contested(&mut self, lane: usize, path: &mut Path<C>) {
        let Source { number, lane, .. } = self.sources[lane];
        let contested = std::mem::take(&mut path.contested);
        self.contested.extend(contested.into_iter().map(|found| (number, lane, found)));
    }
}
