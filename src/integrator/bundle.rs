//! Paths that are followed together, one in each lane. They are the paths of [`super::path`], and take the
//! same steps, each for all of them at once.
//!
//! A bundle holds paths whose surfaces all scatter with a density, back to the side that light comes from:
//! such paths have as many segments as one another, and are in the medium that they began in. A path that
//! meets anything else leaves the bundle, and [`super::path`] follows it to its end.

use super::caustics::FirstSurface;
use super::path::{
    Beside, Parted, Path, PreviousSample, late_survival, light_sample_weight, power_heuristic,
};
use super::surfaces::{Scatters, Surfaces};
use crate::accel::Rays;
use crate::bsdf::Scatter;
use crate::geometry::Ray;
use crate::lanes::{LANES, Mask, REGISTERS, Real, Row, Truth, WIDTH, ZERO, get, lanes_of, part};
use crate::light::{Environment, LightSamples, Receivers};
use crate::medium::Media;
use crate::sampling::{Dimensions, Stream};
use crate::scene::{Intersection, Intersections, PathEnd, RayKind, Scene, Side, Techniques};
use crate::spectrum::{Sampled, SampledLanes, Wavelengths};
use smallvec::SmallVec;
use std::borrow::Cow;
use wide::f64x4;

/// What all paths of a bundle have in common.
pub(super) struct Setting<'a, const C: usize> {
    pub scene: &'a Scene,
    pub time: f64,
    pub wavelengths: &'a Wavelengths<C>,
    /// Sample values of each lane.
    pub streams: &'a [Stream<'a>],
    /// Reflectances of even surfaces at the wavelengths, by their numbers: those of few, once and for all.
    reflectances: SmallVec<[Sampled<C>; 8]>,
    /// Whether a segment leads through nothing, and what it meets is a surface.
    is_plain: bool,
}

/// Up to this number of reflectances are looked up before any is asked for.
const LOOKED_UP: usize = 8;

/// What has become of the paths so far; see [`Path`] for the same of one.
#[derive(Clone)]
pub(super) struct Bundle<const C: usize> {
    /// Paths that go on along their rays.
    pub alive: Mask,
    pub rays: Rays,
    /// Number of segments before the next surface, and of surfaces.
    pub depth: u32,
    pub throughput: SampledLanes<C>,
    pub ratio: SampledLanes<C>,
    /// Where the rays were scattered.
    from: Receivers,
    /// With which density, and Σⱼ pⱼ / p₀ before over that.
    density: Row,
    pub prior_over_density: Row,
    pub prior_throughput: Row,
    /// Whether the paths are suffixes that several first surfaces share.
    pub is_shared: bool,
    /// By lane, where segments are not plain.
    media: Vec<Media>,
    /// What paths that have left the bundle have found that light subpaths compete for, and the light's part
    /// in the ratio of the densities.
    pub contested: Vec<(usize, Sampled<C>, f64)>,
}

impl<'a, const C: usize> Setting<'a, C> {
    pub fn new(
        scene: &'a Scene,
        time: f64,
        wavelengths: &'a Wavelengths<C>,
        streams: &'a [Stream<'a>],
    ) -> Self {
        let features = scene.features();
        let reflectances = scene.reflectances().iter().take(LOOKED_UP);
        Self {
            scene,
            time,
            wavelengths,
            streams,
            reflectances: reflectances.map(|spectrum| spectrum.sample(&wavelengths.nm)).collect(),
            is_plain: !features.medium_stack && !features.absorption && !features.interface_events(),
        }
    }

    fn reflectance(&self, number: u32) -> Sampled<C> {
        match self.reflectances.get(number as usize) {
            Some(reflectance) => *reflectance,
            None => self.scene.reflectances()[number as usize].sample(&self.wavelengths.nm),
        }
    }

    /// Paths from a camera, along rays for the lanes in their order.
    pub fn from_camera<'r>(&self, rays: impl Iterator<Item = &'r Ray>) -> Bundle<C> {
        let mut bundle = Bundle {
            alive: 0,
            rays: Rays::NONE,
            depth: 0,
            throughput: SampledLanes::ONE,
            ratio: SampledLanes::ONE,
            from: Receivers::NONE,
            density: ZERO,
            prior_over_density: ZERO,
            prior_throughput: [f64x4::ONE; REGISTERS],
            is_shared: false,
            media: Vec::new(),
            contested: Vec::new(),
        };
        for (lane, ray) in rays.enumerate() {
            bundle.alive |= 1 << lane;
            bundle.rays.set(lane, ray);
            if !self.is_plain {
                bundle.media.push(self.scene.media_at_sensor(ray, self.time));
            }
        }
        bundle
    }

    /// The values of a set for all lanes.
    pub fn draw(&self, dimensions: Dimensions) -> [Row; 4] {
        Stream::draw_in_lanes(self.streams, dimensions)
    }

    /// Those of a branch of each path; the first has the path's own.
    pub fn draw_branch(&self, dimensions: Dimensions, branch: u32) -> [Row; 4] {
        if branch == 0 {
            return self.draw(dimensions);
        }
        let streams: SmallVec<[Stream; LANES]> =
            self.streams.iter().map(|stream| stream.branch(branch)).collect();
        Stream::draw_in_lanes(&streams, dimensions)
    }
}

impl<const C: usize> Bundle<C> {
    pub fn media<'m>(&'m self, lane: usize, setting: &Setting<C>) -> Cow<'m, Media> {
        match self.media.get(lane) {
            Some(media) => Cow::Borrowed(media),
            None => Cow::Owned(
                setting.scene.media_at_sensor(&self.rays.get(lane), setting.time),
            ),
        }
    }

    fn kind(&self) -> RayKind {
        if self.depth == 0 { RayKind::Camera } else { RayKind::Scattered }
    }

    /// The path of a lane, to be followed alone.
    pub fn path(&self, setting: &Setting<C>, lane: usize) -> Path<C> {
        let Setting { scene, time, .. } = *setting;
        let ray = self.rays.get(lane);
        if self.depth == 0 {
            let mut path = Path::from_camera(scene, &ray, time);
            path.throughput = self.throughput.get(lane);
            if let Some(media) = self.media.get(lane) {
                path.media.clone_from(media);
            }
            return path;
        }
        let beside = match (scene.features().light_tracing, self.is_shared) {
            (false, _) => Beside::Nothing,
            (true, true) => Beside::Shared,
            (true, false) => Beside::First(FirstSurface {
                point: self.from.get(lane).point,
                leaves: ray.direction,
                density: get(&self.density, lane) * self.ratio.get(lane).sum() / C as f64,
            }),
        };
        Path::parted(Parted {
            time,
            depth: self.depth,
            throughput: self.throughput.get(lane),
            ratio: self.ratio.get(lane),
            last: self.previous(lane),
            media: self.media(lane, setting).into_owned(),
            beside_light_subpaths: beside,
            prior_throughput: get(&self.prior_throughput, lane),
        })
    }

    /// How the ray of a lane was sampled.
    fn previous(&self, lane: usize) -> PreviousSample<C> {
        match self.depth {
            0 => PreviousSample::Camera,
            _ => PreviousSample::Scattered {
                from: self.from.get(lane),
                prior_over_density: get(&self.prior_over_density, lane),
                by_scattering: self.ratio.get(lane),
            },
        }
    }

    /// To the next surfaces; see [`Path::advance`]. The lanes that meet none have left the scene.
    pub fn advance(&mut self, setting: &Setting<C>) -> Intersections {
        let Setting { scene, time, wavelengths, is_plain, .. } = *setting;
        if is_plain && scene.meets_at_once(self.kind()) {
            return scene.intersect_in_lanes(&self.rays, time, self.kind(), self.alive);
        }
        let mut found = Intersections::none(time);
        for lane in lanes_of(self.alive) {
            let mut path = self.path(setting, lane);
            if let Some(hit) = path.advance(scene, &self.rays.get(lane), wavelengths) {
                found.set(lane, &hit);
            }
            self.throughput.set(lane, &path.throughput);
            if let Some(media) = self.media.get_mut(lane) {
                *media = path.media;
            }
        }
        found
    }

    /// Light from beyond the scene along the rays of some lanes; see [`Path::escaped`].
    pub fn escaped(&self, setting: &Setting<C>, lanes: Mask, arriving: &mut SampledLanes<C>) {
        let Setting { scene, wavelengths, .. } = *setting;
        let hidden = self.depth == 0 && scene.limits.hide_emitters;
        let Some(environment) = scene.lights.environment().filter(|_| !hidden) else { return };
        // What light samples do not look for has the weight 1.
        let even = match environment {
            Environment::Constant(radiance) if lanes != 0 => Some(radiance.sample(&wavelengths.nm)),
            _ => None,
        };
        for lane in lanes_of(lanes) {
            let ray = self.rays.get(lane);
            let light = match even {
                Some(radiance) => {
                    self.throughput.get(lane) * radiance * (1.0 / self.ratio.get(lane).sum())
                }
                None => self.path(setting, lane).escaped(scene, &ray, wavelengths),
            };
            arriving.set(lane, &(arriving.get(lane) + light));
        }
    }

    /// Light that the surfaces emit along the rays; see [`Path::emitted`].
    pub fn emitted(&self, setting: &Setting<C>, hits: &Intersections, arriving: &mut SampledLanes<C>) {
        let Setting { scene, wavelengths, .. } = *setting;
        for lane in lanes_of(hits.on_light & self.alive) {
            let hit = hits.get(scene, lane);
            let light =
                self.path(setting, lane).emitted(scene, &self.rays.get(lane), &hit, wavelengths);
            arriving.set(lane, &(arriving.get(lane) + light));
        }
    }

    /// Whether the paths have as many segments as they may.
    pub fn is_last(&self, scene: &Scene) -> bool {
        self.depth + 1 >= scene.limits.max_depth
    }

    /// How the surfaces scatter; see [`Path::shade`].
    pub fn shade(&self, setting: &Setting<C>, hits: Intersections) -> Surfaces<C> {
        let Setting { scene, wavelengths, streams, .. } = *setting;
        let mut surfaces = Surfaces::new(hits);
        let mut seen_from_front = 0;
        for register in 0..REGISTERS {
            let normal = surfaces.hits.shading_normal[register];
            let toward = self.rays.direction[register].dot(normal);
            seen_from_front |= toward.lt(f64x4::ZERO).mask() << (WIDTH * register);
            // On the side that is seen.
            let side = f64x4::ONE.copysign(-toward);
            surfaces.normal[register] = normal * side;
        }
        for lane in lanes_of(surfaces.hits.met & self.alive) {
            match scene.side(&surfaces.hits, lane, seen_from_front >> lane & 1 == 1) {
                Side::Diffuse(number) => {
                    surfaces.diffuse |= 1 << lane;
                    surfaces.reflectance.set(lane, &setting.reflectance(number));
                }
                Side::Black => {}
                Side::Other => {
                    let hit = surfaces.hits.get(scene, lane);
                    let choice = match scene.features().choices {
                        true => streams[lane].draw(Dimensions::Light(self.depth))[3],
                        false => 0.0,
                    };
                    let toward_eye = -self.rays.get(lane).direction;
                    let media = self.media(lane, setting);
                    let shading = scene.shade(&hit, toward_eye, &media, wavelengths, choice);
                    match shading.diffuse() {
                        Some((normal, reflectance)) => surfaces.set_diffuse(lane, normal, &reflectance),
                        None => surfaces.set_other(lane, shading),
                    }
                }
            }
        }
        surfaces
    }

    /// Light samples for the surfaces of some lanes; see [`Path::light_sample`].
    pub fn light_samples(
        &self,
        setting: &Setting<C>,
        surfaces: &Surfaces<C>,
        u: &[Row; 4],
        asked: Mask,
    ) -> LightSamples<C> {
        let Setting { scene, time, wavelengths, .. } = *setting;
        let none = self.is_last(scene) || scene.lights.is_empty();
        let asked = if none { 0 } else { asked & surfaces.scattering() };
        let mut samples =
            scene.lights.sample_in_lanes(&surfaces.receivers(), time, wavelengths, asked, &[u[0], u[1]]);
        samples.rays.leaves = surfaces.hits.facet;
        samples
    }

    /// Light that reaches the surfaces straight from lights, and on by scattering; see [`Path::direct_light`].
    pub fn direct_light(
        &self,
        setting: &Setting<C>,
        surfaces: &Surfaces<C>,
        u: &[Row; 4],
        asked: Mask,
    ) -> SampledLanes<C> {
        let mut light = SampledLanes::ZERO;
        let samples = self.light_samples(setting, surfaces, u, asked);
        if samples.found == 0 {
            return light;
        }
        let values = surfaces.evaluate(&samples.rays.direction, samples.found);
        let prior = self.ratio.sum_of_each();
        let by_scattering = self.ratio.dot_of_each(&values.density);
        let weights = light_sample_weights(setting.scene, &samples, &prior, &by_scattering);
        for wavelength in 0..C {
            for register in 0..REGISTERS {
                let found = Truth::of(part(samples.found, register));
                light.0[wavelength][register] = found.only(
                    self.throughput.0[wavelength][register]
                        * values.f_cos.0[wavelength][register]
                        * samples.radiance.0[wavelength][register]
                        * weights[register],
                );
            }
        }
        let wanted = light.nonzero() & samples.found;
        self.attenuate(setting, surfaces, &samples.rays, wanted, &mut light);
        light
    }

    /// Takes account of what is in the way of shadow rays; see [`Path::visibility`].
    pub fn attenuate(
        &self,
        setting: &Setting<C>,
        surfaces: &Surfaces<C>,
        shadow_rays: &Rays,
        asked: Mask,
        light: &mut SampledLanes<C>,
    ) {
        let Setting { scene, time, wavelengths, is_plain, .. } = *setting;
        if is_plain && !scene.features().transparent_shadows {
            light.keep(!scene.occluded_in_lanes(shadow_rays, time, asked));
            return;
        }
        for lane in lanes_of(asked) {
            let (path, hit) = (self.path(setting, lane), surfaces.hits.get(scene, lane));
            let (ray, shadow_ray) = (self.rays.get(lane), shadow_rays.get(lane));
            let visibility = path.visibility(scene, &ray, &hit, &shadow_ray, wavelengths);
            light.set(lane, &(light.get(lane) * visibility));
        }
    }

    /// Leaves the surfaces of some lanes in the directions that were sampled there; see [`Path::leave`].
    pub fn leave(&mut self, surfaces: &Surfaces<C>, scatters: &Scatters<C>, lanes: Mask) {
        let prior = self.ratio.sum_of_each();
        for register in 0..REGISTERS {
            for wavelength in 0..C {
                let throughput = &mut self.throughput.0[wavelength][register];
                *throughput = *throughput * scatters.weight.0[wavelength][register];
                let ratio = &mut self.ratio.0[wavelength][register];
                *ratio = *ratio * scatters.ratio.0[wavelength][register];
            }
            self.prior_over_density[register] = prior[register] / scatters.density[register];
            let direction = scatters.toward_light[register];
            self.rays.origin[register] = surfaces.hits.point[register].leave(direction);
            self.rays.direction[register] = direction;
            self.rays.t_max[register] = f64x4::splat(f64::INFINITY);
        }
        self.rays.leaves = surfaces.hits.facet;
        self.density = scatters.density;
        self.from = surfaces.receivers();
        self.depth += 1;
        self.alive = lanes;
    }

    /// Ends paths by Russian roulette, by a value for each lane; see [`Path::survival`].
    pub fn survive(&mut self, scene: &Scene, values: &Row) {
        let (mut kept, roulette) = (self.throughput.nonzero() & self.alive, self.depth >= scene.limits.rr_depth);
        scene.paths_ended(PathEnd::Absorbed, self.depth, self.alive & !kept);
        if roulette {
            let late = f64x4::splat(late_survival(self.depth));
            let sums = self.ratio.sum_of_each();
            let mut died = 0;
            for register in 0..REGISTERS {
                let (mut most, mut alive) = (f64x4::splat(f64::NEG_INFINITY), f64x4::ZERO);
                for wavelength in 0..C {
                    most = self.throughput.0[wavelength][register].greater(most);
                    let goes_along = self.ratio.0[wavelength][register].gt(f64x4::ZERO);
                    alive = alive + goes_along.only(f64x4::ONE);
                }
                let throughput = alive * most / sums[register] * self.prior_throughput[register];
                let survival = throughput.lesser(late);
                died |= (!values[register].lt(survival)).mask() << (WIDTH * register);
                for wavelength in 0..C {
                    let throughput = &mut self.throughput.0[wavelength][register];
                    *throughput = *throughput / survival;
                }
            }
            scene.paths_ended(PathEnd::Roulette, self.depth, kept & died);
            kept &= !died;
        }
        self.alive = kept;
    }

    /// Goes on along the rays to the ends of the paths. Light that comes along them, weighed by all that was
    /// before.
    pub fn follow(&mut self, setting: &Setting<C>) -> SampledLanes<C> {
        let Setting { scene, .. } = *setting;
        let mut arriving = SampledLanes::ZERO;
        while self.alive != 0 {
            let hits = self.advance(setting);
            let gone = self.alive & !hits.met;
            self.escaped(setting, gone, &mut arriving);
            scene.paths_ended(PathEnd::Escaped, self.depth + 1, gone);
            self.alive &= hits.met;
            self.emitted(setting, &hits, &mut arriving);
            let is_last = self.is_last(scene);
            // Past the last segment light may still pass surfaces as if there were none.
            if is_last && !scene.features().transparent_shadows {
                scene.paths_ended(PathEnd::MaxDepth, self.depth + 1, self.alive);
                return arriving;
            }
            let surfaces = self.shade(setting, hits);
            scene.paths_ended(PathEnd::Absorbed, self.depth + 1, self.alive & !surfaces.scattering());
            self.alive &= surfaces.scattering();
            for lane in lanes_of(surfaces.others & self.alive) {
                if !surfaces.shares(lane) {
                    self.alive &= !(1 << lane);
                    let (light, _) = self.go_on_alone(setting, &surfaces, lane);
                    arriving.set(lane, &(arriving.get(lane) + light));
                }
            }
            if is_last {
                scene.paths_ended(PathEnd::MaxDepth, self.depth + 1, self.alive);
                return arriving;
            }
            if self.alive == 0 {
                return arriving;
            }
            let light = setting.draw(Dimensions::Light(self.depth));
            arriving.add(&self.direct_light(setting, &surfaces, &light, self.alive));
            let u = setting.draw(Dimensions::Scattering(self.depth));
            let scatters = surfaces.sample(&u, self.alive);
            self.end_absorbed(scene, &scatters);
            for (lane, scatter) in &scatters.apart {
                let light = self.scatter_alone(setting, &surfaces, *lane, scatter, get(&u[3], *lane));
                arriving.set(*lane, &(arriving.get(*lane) + light));
            }
            self.leave(&surfaces, &scatters, scatters.spread);
            self.survive(scene, &u[3]);
        }
        arriving
    }

    /// Some paths end before they leave the surface that they have met.
    pub fn end(&self, scene: &Scene, end: PathEnd, lanes: Mask) {
        scene.paths_ended(end, self.depth + 1, lanes);
    }

    /// They end when they would go on along a new segment.
    pub fn end_before_next(&self, scene: &Scene, end: PathEnd, lanes: Mask) {
        scene.paths_ended(end, self.depth, lanes);
    }

    /// The lanes that scatter nothing end where they are.
    pub fn end_absorbed(&self, scene: &Scene, scatters: &Scatters<C>) {
        let apart = scatters.apart.iter().fold(0, |mask, (lane, _)| mask | 1 << lane);
        scene.paths_ended(PathEnd::Absorbed, self.depth + 1, self.alive & !(scatters.spread | apart));
    }

    /// Follows the path of a lane from a surface to its end. What it finds, and whether it meets what alpha
    /// counts.
    pub fn go_on_alone(
        &mut self,
        setting: &Setting<C>,
        surfaces: &Surfaces<C>,
        lane: usize,
    ) -> (Sampled<C>, bool) {
        let Setting { scene, wavelengths, streams, .. } = *setting;
        let (hit, ray) = (surfaces.hits.get(scene, lane), self.rays.get(lane));
        let mut path = self.path(setting, lane);
        let mut light = Sampled::ZERO;
        if let Some(shading) = surfaces.shading(lane)
            && let Some(ray) =
                path.go_on(scene, &ray, &hit, shading, wavelengths, &streams[lane], &mut light)
        {
            light += path.follow(scene, ray, wavelengths, &streams[lane]);
        }
        self.keep_contested(lane, &mut path);
        (light, path.alpha_hit)
    }

    /// The same from where it has been scattered. `survival` is the value that decides whether it survives.
    pub fn scatter_alone(
        &mut self,
        setting: &Setting<C>,
        surfaces: &Surfaces<C>,
        lane: usize,
        scatter: &Scatter<C>,
        survival: f64,
    ) -> Sampled<C> {
        let Setting { scene, wavelengths, streams, .. } = *setting;
        let Some(shading) = surfaces.shading(lane) else { return Sampled::ZERO };
        let hit: Intersection = surfaces.hits.get(scene, lane);
        let mut path = self.path(setting, lane);
        let ray = path.leave(scene, &hit, shading, scatter);
        let kept = path.survival(scene);
        if survival >= kept {
            path.end_before_next(scene, kept);
            return Sampled::ZERO;
        }
        path.throughput /= kept;
        let light = path.follow(scene, ray, wavelengths, &streams[lane]);
        self.keep_contested(lane, &mut path);
        light
    }

    fn keep_contested(&mut self, lane: usize, path: &mut Path<C>) {
        let contested = std::mem::take(&mut path.contested);
        self.contested.extend(contested.into_iter().map(|(light, part)| (lane, light, part)));
    }
}

/// What light samples are multiplied by; see [`light_sample_weight`] for the same of one.
#[inline(always)]
fn light_sample_weights<const C: usize>(
    scene: &Scene,
    samples: &LightSamples<C>,
    prior: &Row,
    by_scattering: &Row,
) -> Row {
    let mut weights = ZERO;
    if scene.limits.techniques != Techniques::Both {
        for lane in lanes_of(samples.found) {
            let density = samples.density_of(lane);
            let weight =
                light_sample_weight(scene, density, get(prior, lane), || get(by_scattering, lane));
            crate::lanes::set(&mut weights, lane, weight);
        }
        return weights;
    }
    for register in 0..REGISTERS {
        let prior = prior[register];
        let by_light = prior * samples.density[register];
        let weight = power_heuristic(by_light, by_scattering[register]) / by_light;
        let discrete = Truth::of(part(samples.discrete, register));
        weights[register] = f64x4::choose(discrete, f64x4::ONE / prior, weight);
    }
    weights
}
