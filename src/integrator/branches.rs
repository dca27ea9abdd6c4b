//! Paths that go on along several ways at once: into reflection and refraction at glass, into branches at the
//! first diffuse surface behind specular ones, into coat and base at the first surface.

use super::observe::{Observe, Step};
use super::path::{Contested, Path, ScatteredBy};
use super::weights::late_survival;
use crate::bsdf::Scatter;
use crate::material::Shading;
use crate::sampling::Stream;
use crate::scene::{Intersection, Scene};
use crate::spectrum::{Sampled, Wavelengths};
use smallvec::{SmallVec, smallvec};

/// Number of branches when a whole path first meets a diffuse surface after specular ones. Such a path shares
/// nothing with others, and the segments before that surface are most of its work. A branch of a path that
/// has split at glass splits into fewer, by its weight.
const BRANCHES: u32 = 8;

/// The least number of them in a scene with light tracing. Light subpaths cannot connect such a surface to
/// the camera, and camera paths find the caustics on it seldom but bright.
const BRANCHES_BESIDE_LIGHT_TRACING: u32 = 4;

/// A path splits at clear glass into reflection and refraction where each of the two may bring at least this
/// fraction of the sample's value. At the rim of a glass body, in its mirror image of a lamp, and in its
/// shadow, the random choice between the two makes most of the noise. The threshold is below the 4 % that
/// glass reflects at normal incidence, behind a grey surface, too.
const WORTH_FOLLOWING: f64 = 1.0 / 64.0;

impl<const C: usize, O: Observe> Path<C, O> {
    /// Light that the smooth coat of a first surface mirrors. That reflection is taken out of the surface: a
    /// random choice between coat and base makes much of the noise of plastic.
    #[inline(always)]
    pub(super) fn mirrored(
        &self,
        scene: &Scene,
        hit: &Intersection,
        shading: &mut Shading<C>,
        wavelengths: &Wavelengths<C>,
        stream: &Stream,
    ) -> Sampled<C> {
        if self.vertex > 0 || self.is_last(scene) {
            return Sampled::ZERO;
        }
        match shading.take_mirror() {
            Some(mirror) => self.follow_mirror(scene, hit, shading, &mirror, wavelengths, stream),
            None => Sampled::ZERO,
        }
    }

    /// The same, where there is such a coat. `rest`: the surface without it.
    #[inline(never)]
    pub(super) fn follow_mirror(
        &self,
        scene: &Scene,
        hit: &Intersection,
        rest: &Shading<C>,
        mirror: &Scatter<C>,
        wavelengths: &Wavelengths<C>,
        stream: &Stream,
    ) -> Sampled<C> {
        let (mut path, stream) = (self.clone(), stream.branch(1));
        path.seen.tell(path.vertex, || Step::Branch { number: 1, of: 2, weight: path.branch_weight });
        path.is_lesser = true;
        let ray = path.leave(scene, hit, rest, mirror);
        path.tell_of_scatter(mirror.toward_light, mirror.transmitted, mirror.density);
        let light = path.follow(scene, ray, wavelengths, &stream);
        self.seen.tell(self.vertex, || Step::Branch { number: 0, of: 2, weight: self.branch_weight });
        light
    }

    /// The branches into which the path splits here, if it does: the end of each in the values that choose a
    /// lobe. Each branch gets the values from the end of the one before to its own, so the branches cover
    /// [0, 1) once and their weights sum to 1.
    pub(super) fn split(
        &self,
        scene: &Scene,
        shading: &Shading<C>,
    ) -> Option<SmallVec<[f64; BRANCHES as usize]>> {
        // Paths that roulette may end without loss grow in weight when they survive: that must not make them
        // split without end.
        if scene.limits.splits_at_glass
            && late_survival(self.depth) == 1.0
            && let Some(reflection) = shading.reflection_probability()
        {
            let lesser = reflection.min(1.0 - reflection) * self.branch_weight * self.roulette_throughput();
            return (lesser > WORTH_FOLLOWING).then(|| smallvec![reflection, 1.0]);
        }
        // The first diffuse surface, unless the camera sees it directly.
        let is_behind_specular = self.scattered_by == ScatteredBy::Specular;
        if !is_behind_specular || shading.bsdf.is_discrete() || shading.bsdf.transmits() {
            return None;
        }
        let least = if scene.features().caustics { BRANCHES_BESIDE_LIGHT_TRACING } else { 1 };
        let by_weight = if self.through_discrete { f64::from(BRANCHES) * self.branch_weight } else { 1.0 };
        let branches = (by_weight.round() as u32).max(least);
        (branches > 1).then(|| (1..=branches).map(|branch| f64::from(branch) / f64::from(branches)).collect())
    }

    /// Sum of what the branches find, each by its weight. What they contest comes to the path by that weight,
    /// too. A function of its own keeps the code of other scenes' paths small.
    #[inline(never)]
    pub(super) fn follow_branches(
        &mut self,
        scene: &Scene,
        hit: &Intersection,
        shading: &Shading<C>,
        wavelengths: &Wavelengths<C>,
        stream: &Stream,
        ends: &[f64],
    ) -> Sampled<C> {
        if !shading.bsdf.is_discrete() {
            self.scattered_by = ScatteredBy::Any;
        }
        // A path does not split by null transmission.
        self.alpha_hit = true;
        let mut arriving = Sampled::ZERO;
        let mut contested = std::mem::take(&mut self.contested);
        let mut start = 0.0;
        for (branch, &end) in (0..).zip(ends) {
            let (mut path, stream) = (self.clone(), stream.branch(branch));
            let weight = end - start;
            path.branch_weight *= weight;
            path.seen.tell(path.vertex, || Step::Branch {
                number: branch,
                of: ends.len() as u32,
                weight: path.branch_weight,
            });
            if let Some(ray) = path.scatter(scene, hit, shading, &stream, start..end) {
                // Roulette ignores the weight: the path has split for the branch to be followed.
                arriving += path.follow(scene, ray, wavelengths, &stream) * weight;
                contested.extend(
                    path.contested.iter().map(|found| Contested { light: found.light * weight, ..*found }),
                );
            }
            start = end;
        }
        self.contested = contested;
        arriving
    }
}
