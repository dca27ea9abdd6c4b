//! Paths that are followed together, one in each lane. They are the paths of [`super::path`], and take the
//! same steps, each for all of them at once.
//!
//! A bundle holds paths whose surfaces all scatter with a density: such paths have as many segments as one
//! another. A path that meets anything else leaves the bundle, and [`super::path`] follows it to its end.

mod alone;
mod pool;
mod turn;

pub(super) use pool::{Found, follow};
pub(super) use turn::{Each, Turn};

use super::caustics::{self, FirstSurface};
use super::contributions::{crossings, media_beyond};
use super::path::Contested;
use super::surfaces::{Scatters, Surfaces};
use super::weights::{late_survival, light_sample_weights, roulette_survival, scattering_weight};
use crate::accel::Rays;
use crate::geometry::{Points, Ray};
use crate::lanes::{
    LANES, Mask, REGISTERS, Real, Register, Row, Truth, Vec3Lanes, WIDTH, ZERO, get, lanes_of, mask_of, part,
    set,
};
use crate::light::{LampLight, LightSamples, Lit, Receivers};
use crate::material::Shading;
use crate::medium::{Media, MediumStack};
use crate::sampling::{Density, Dimensions, Stream};
use crate::scene::{Intersection, Intersections, PathEnd, RayKind, Scene, Side, Techniques};
use crate::spectrum::{Sampled, SampledLanes, Wavelengths};
use std::borrow::Cow;

/// Where the path of a lane has begun: the number of its turn, and its lane there.
#[derive(Clone, Copy)]
struct Source<'a, const C: usize> {
    turn: &'a Turn<'a, C>,
    number: usize,
    lane: usize,
}

/// What has become of the paths so far; see [`super::path::Path`] for the same of one.
#[derive(Clone)]
pub(super) struct Bundle<'a, const C: usize> {
    scene: &'a Scene,
    /// When all of it happens.
    time: f64,
    sources: [Source<'a, C>; LANES],
    /// Paths that go on along their rays.
    pub alive: Mask,
    pub rays: Rays,
    /// Number of segments before the next surface, and of surfaces.
    pub depth: u32,
    pub throughput: SampledLanes<C>,
    pub ratio: SampledLanes<C>,
    /// Where the rays were scattered, and the sides from which light counts there.
    from_point: [Points<Register>; REGISTERS],
    from_facing: [Vec3Lanes; REGISTERS],
    /// With which density, and Σⱼ pⱼ / p₀ before over that.
    density: Row,
    pub prior_over_density: Row,
    pub prior_throughput: Row,
    /// Whether the paths are suffixes that several first surfaces share.
    pub is_shared: bool,
    /// See [`Scene::has_plain_segments`].
    is_plain: bool,
    /// By lane, where segments are not plain.
    media: Vec<Media>,
    /// By lane, in scenes with light tracing: how paths have left their first surfaces.
    firsts: Vec<FirstSurface>,
    lamp_light: LampLight<C>,
    /// Light that has come along the rays, weighed by all that was before.
    pub arriving: SampledLanes<C>,
    /// Lanes whose last surface is shared and [`Competing::Shared`].
    pub competing: Mask,
    /// What the paths have found that light subpaths compete for, by the number of the turn and the lane
    /// there.
    pub contested: Vec<(usize, usize, Contested<C>)>,
}

impl<'a, const C: usize> Bundle<'a, C> {
    /// Paths from a camera, along rays for the lanes in their order.
    pub fn from_camera<'r>(
        scene: &'a Scene,
        turn: &'a Turn<'a, C>,
        number: usize,
        rays: impl Iterator<Item = &'r Ray>,
    ) -> Self {
        let mut bundle = Self {
            scene,
            time: turn.time,
            sources: std::array::from_fn(|lane| Source { turn, number, lane }),
            alive: 0,
            rays: Rays::NONE,
            depth: 0,
            throughput: SampledLanes::ONE,
            ratio: SampledLanes::ONE,
            from_point: [Points::NONE; REGISTERS],
            from_facing: [Vec3Lanes::ZERO; REGISTERS],
            density: ZERO,
            prior_over_density: ZERO,
            prior_throughput: [Register::ONE; REGISTERS],
            is_shared: false,
            is_plain: scene.has_plain_segments(),
            media: Vec::new(),
            firsts: Vec::new(),
            lamp_light: turn.lamp_light.clone(),
            arriving: SampledLanes::ZERO,
            competing: 0,
            contested: Vec::new(),
        };
        if !bundle.is_plain {
            // Also lanes without a path, into which others may come.
            bundle.media.resize_with(LANES, || Media::of(MediumStack::default()));
        }
        for (lane, ray) in rays.enumerate() {
            bundle.alive |= 1 << lane;
            bundle.rays.set(lane, ray);
            if let Some(media) = bundle.media.get_mut(lane) {
                *media = scene.media_at_sensor(ray, turn.time);
            }
        }
        bundle
    }

    pub fn scene(&self) -> &'a Scene {
        self.scene
    }

    fn stream(&self, lane: usize) -> &'a Stream<'a> {
        let Source { turn, lane, .. } = self.sources[lane];
        &turn.streams[lane]
    }

    fn wavelengths(&self, lane: usize) -> &'a Wavelengths<C> {
        let Source { turn, lane, .. } = self.sources[lane];
        turn.wavelengths(lane)
    }

    /// The values of a set for the lanes that are alive.
    pub fn draw(&self, dimensions: Dimensions) -> [Row; 4] {
        Stream::draw_in_lanes(&std::array::from_fn(|lane| self.stream(lane)), dimensions, self.alive)
    }

    /// Those of a branch of each path; the first has the path's own.
    pub fn draw_branch(&self, dimensions: Dimensions, branch: u32) -> [Row; 4] {
        if branch == 0 {
            return self.draw(dimensions);
        }
        let streams: [Stream; LANES] = std::array::from_fn(|lane| self.stream(lane).branch(branch));
        Stream::draw_in_lanes(&streams.each_ref(), dimensions, self.alive)
    }

    pub fn media(&self, lane: usize) -> Cow<'_, Media> {
        match self.media.get(lane) {
            Some(media) => Cow::Borrowed(media),
            None => Cow::Owned(self.scene.media_at_sensor(&self.rays.get(lane), self.time)),
        }
    }

    fn from(&self) -> Receivers<'_> {
        Receivers { point: &self.from_point, facing: &self.from_facing }
    }

    /// Places of some lanes that ask for light.
    fn lit<'s>(
        &'s self,
        from: Receivers<'s>,
        asked: Mask,
    ) -> Lit<'s, impl Fn(usize) -> &'a Wavelengths<C> + use<'s, 'a, C>, C> {
        let wavelengths = |lane: usize| self.wavelengths(lane);
        Lit { from, time: self.time, wavelengths, light: &self.lamp_light, asked }
    }

    fn kind(&self) -> RayKind {
        if self.depth == 0 { RayKind::Camera } else { RayKind::Scattered }
    }

    pub fn arrives(&mut self, lane: usize, light: Sampled<C>) {
        self.arriving.set(lane, &(self.arriving.get(lane) + light));
    }

    /// To the next surfaces; see [`super::path::Path::advance`]. The lanes that meet none have left the
    /// scene.
    pub fn advance(&mut self, found: &mut Intersections) {
        let (scene, kind) = (self.scene, self.kind());
        let mut alone = self.alive;
        if scene.meets_at_once(kind) {
            alone = self.within_media(self.alive);
            scene.intersect_in_lanes(&self.rays, self.time, kind, self.alive & !alone, found);
            alone |= if self.is_plain { 0 } else { scene.interfaces(found) };
        } else {
            found.clear(self.time);
        }
        for lane in lanes_of(alone) {
            let mut path = self.path(lane);
            found.met &= !(1 << lane);
            if let Some(hit) = path.advance(scene, &self.rays.get(lane), self.wavelengths(lane)) {
                found.set(lane, &hit);
            }
            self.throughput.set(lane, &path.throughput);
            if let Some(media) = self.media.get_mut(lane) {
                *media = path.media;
            }
        }
    }

    /// The lanes, among some, whose paths are in a medium that absorbs.
    fn within_media(&self, lanes: Mask) -> Mask {
        if !self.scene.features().absorption {
            return 0;
        }
        mask_of(lanes_of(lanes).filter(|&lane| self.scene.medium(&self.media(lane).here).is_some()))
    }

    /// Light from beyond the scene along the rays that meet no surface, whose paths end; see
    /// [`super::path::Path::escaped`].
    pub fn escape(&mut self, hits: &Intersections) {
        let scene = self.scene;
        let gone = self.alive & !hits.met;
        self.alive &= hits.met;
        scene.paths_ended(PathEnd::Escaped, self.depth + 1, gone);
        let hidden = self.depth == 0 && scene.limits.hide_emitters;
        let Some(environment) = scene.lights.environment().filter(|_| !hidden) else { return };
        if gone == 0 {
            return;
        }
        let of_all = environment.is_sampled() && scene.limits.techniques != Techniques::Both;
        let apart = if of_all { gone } else { gone & self.competing };
        for lane in lanes_of(apart) {
            let mut path = self.path(lane);
            let light = path.escaped(scene, &self.rays.get(lane), self.wavelengths(lane));
            self.arrives(lane, light);
            self.keep_contested(lane, &mut path);
        }
        let gone = gone & !apart;
        if gone == 0 {
            return;
        }
        let seen = environment.seen_in_lanes(&self.rays.direction, gone, |lane| self.wavelengths(lane));
        let weights = self.weights_of_escape(&seen.density, gone);
        let mut light = seen.radiance;
        for (light, throughput) in light.0.iter_mut().zip(&self.throughput.0) {
            for register in 0..REGISTERS {
                light[register] *= throughput[register] * weights[register];
            }
        }
        light.keep(gone);
        self.arriving.add(&light);
    }

    /// The weights of light from beyond the scene beside light samples, which find it with a density per
    /// steradian, over the density of the paths; see [`super::path::PreviousSample::weight_beside_lights`].
    fn weights_of_escape(&self, density: &Row, gone: Mask) -> Row {
        let sums = self.ratio.sum_of_each();
        let is_sought =
            self.depth > 0 && density.iter().any(|density| density.gt(Register::ZERO).mask() != 0);
        if !is_sought {
            // What light samples do not look for has the weight 1.
            return sums.map(|sum| Register::ONE / sum);
        }
        let probability = self.scene.lights.environment_probabilities(&self.lit(self.from(), gone));
        std::array::from_fn(|register| {
            let by_light = density[register] * probability[register];
            let by_light = self.prior_over_density[register] * by_light;
            scattering_weight(self.scene, || by_light, || sums[register]) / sums[register]
        })
    }

    /// Light that the surfaces emit along the rays; see [`super::path::Path::emitted`].
    pub fn emit(&mut self, hits: &Intersections) {
        for lane in lanes_of(hits.on_light & self.alive) {
            let (hit, ray) = (hits.get(self.scene, lane), self.rays.get(lane));
            let mut path = self.path(lane);
            let light = path.emitted(self.scene, &ray, &hit, self.wavelengths(lane));
            self.arrives(lane, light);
            self.keep_contested(lane, &mut path);
        }
    }

    /// Whether the paths have as many segments as they may.
    pub fn is_last(&self) -> bool {
        self.depth + 1 >= self.scene.limits.max_depth
    }

    /// How the surfaces scatter that were met; see [`super::path::Path::shade`]. Paths end where nothing is
    /// scattered.
    pub fn shade(&mut self, surfaces: &mut Surfaces<C>) {
        let scene = self.scene;
        surfaces.clear();
        let (mut seen_from_front, mut even_metals) = (0, 0);
        for register in 0..REGISTERS {
            let normal = surfaces.hits.shading_normal[register];
            let toward = self.rays.direction[register].dot(normal);
            seen_from_front |= toward.lt(Register::ZERO).mask() << (WIDTH * register);
            // On the side that is seen.
            surfaces.normal[register] = normal * Register::ONE.copysign(-toward);
        }
        for lane in lanes_of(surfaces.hits.met & self.alive) {
            match scene.side(&surfaces.hits, lane, seen_from_front >> lane & 1 == 1) {
                Side::Diffuse(number) => {
                    let Source { turn, lane: of_turn, .. } = self.sources[lane];
                    let reflectance = turn.reflectance(scene, number, of_turn);
                    surfaces.diffuse |= 1 << lane;
                    surfaces.reflectance.set(lane, &reflectance);
                }
                Side::Metal(number) if !self.competes_from(&surfaces.hits, lane) => {
                    let Source { turn, lane: of_turn, .. } = self.sources[lane];
                    surfaces.set_metal(lane, &turn.metal(scene, number, of_turn));
                    even_metals |= 1 << lane;
                }
                Side::Black => {}
                Side::Metal(_) | Side::Other => {
                    surfaces.set(lane, self.shading(lane, &surfaces.hits.get(scene, lane)))
                }
            }
        }
        let Surfaces { metals, normal, .. } = surfaces;
        metals.turn(even_metals, normal, |register| -self.rays.direction[register]);
        let absorbed = self.alive & !surfaces.scattering();
        self.end(PathEnd::Absorbed, absorbed);
        self.alive &= !absorbed;
    }

    /// How light subpaths compete for what a light sample brings to the surface of a lane: the light's factor
    /// of the ratio of densities, and the density of the sample per steradian. `None` where they do not.
    pub fn contest_of_sample(
        &self,
        surfaces: &Surfaces<C>,
        lane: usize,
        samples: &LightSamples<C>,
    ) -> Option<(f64, f64)> {
        let (Density::PerSolidAngle(by_light), true) =
            (samples.density_of(lane), self.competes_from(&surfaces.hits, lane))
        else {
            return None;
        };
        let point = surfaces.hits.point[lane / WIDTH].get(lane);
        let ray = point.ray(samples.rays.get(lane).direction);
        let from_light =
            caustics::factor_along(self.scene, self.scene.caustics()?, &ray, self.time, &self.media(lane));
        Some((from_light, by_light))
    }

    /// Whether what the surface of a lane scatters is weighed against light subpaths; see
    /// [`super::path::Path::competes_from`]. Where paths are not shared, they go on alone.
    pub fn competes_from(&self, hits: &Intersections, lane: usize) -> bool {
        self.scene.features().caustics && self.depth > 0 && self.scene.is_nearly_specular_in_lane(hits, lane)
    }

    fn shading(&self, lane: usize, hit: &Intersection) -> Shading<C> {
        let scene = self.scene;
        let choice = scene.material_choice(self.stream(lane), self.depth);
        let toward_eye = -self.rays.get(lane).direction;
        scene.shade(hit, toward_eye, &self.media(lane), self.wavelengths(lane), choice)
    }

    /// Light samples for the surfaces; see [`super::path::Path::light_sample`].
    pub fn sample_lights(&self, surfaces: &Surfaces<C>, u: &[Row; 4], samples: &mut LightSamples<C>) {
        let lights = &self.scene.lights;
        if self.is_last() || lights.is_empty() {
            samples.found = 0;
            return;
        }
        lights.sample_in_lanes(&self.lit(surfaces.receivers(), self.alive), &[u[0], u[1]], samples);
        samples.rays.leaves = *surfaces.hits.facet();
    }

    /// Light that reaches the surfaces straight from lights, and on by scattering, times a weight; see
    /// [`super::path::Path::direct_light`].
    pub fn direct_light(
        &mut self,
        surfaces: &Surfaces<C>,
        u: &[Row; 4],
        weight: f64,
        samples: &mut LightSamples<C>,
    ) {
        self.sample_lights(surfaces, u, samples);
        if samples.found == 0 {
            return;
        }
        let values = surfaces.evaluate(&samples.rays.direction, samples.found);
        let prior = self.ratio.sum_of_each();
        let by_scattering = self.ratio.dot_of_each(&values.density);
        let weights = light_sample_weights(self.scene, samples, &prior, &by_scattering);
        let mut light = values.f_cos;
        for wavelength in 0..C {
            for register in 0..REGISTERS {
                let found = Truth::of(part(samples.found, register));
                let light = &mut light.0[wavelength][register];
                *light = found.only(
                    self.throughput.0[wavelength][register]
                        * *light
                        * samples.radiance.0[wavelength][register]
                        * weights[register],
                );
            }
        }
        let wanted = light.nonzero() & samples.found;
        self.attenuate(surfaces, samples, wanted, &mut light);
        light.add_times(&Sampled::splat(weight), &mut self.arriving);
    }

    /// Takes account of what is in the way of shadow rays; see [`super::path::Path::light_from`].
    pub fn attenuate(
        &self,
        surfaces: &Surfaces<C>,
        samples: &LightSamples<C>,
        asked: Mask,
        light: &mut SampledLanes<C>,
    ) {
        let (scene, shadow_rays) = (self.scene, &samples.rays);
        let absorbed = self.within_media(asked) | self.at_bodies(surfaces, asked);
        // What nothing is in the way of arrives, whatever surfaces may mean.
        let occluded = scene.occluded_in_lanes(RayKind::Shadow, shadow_rays, self.time, asked & !absorbed);
        let features = scene.features();
        let mut unsure = absorbed | occluded;
        if !features.interface_events() && !features.transparent_shadows {
            light.keep(!occluded);
            unsure = absorbed;
        }
        for lane in lanes_of(unsure) {
            let (media, hit) = (self.media(lane), surfaces.hits.get(scene, lane));
            let (ray, shadow_ray) = (self.rays.get(lane), shadow_rays.get(lane));
            let around = media_beyond(scene, &media, &ray, &hit, &shadow_ray);
            let crossings = crossings(scene, self.depth + 2, samples.density_of(lane));
            let passage = scene.passage(&shadow_ray, self.time, &around, self.wavelengths(lane), crossings);
            light.set(lane, &(light.get(lane) * passage.transmittance));
        }
    }

    /// The lanes, among some, at the surfaces of bodies, where media absorb: behind it light samples lead
    /// through what is in the body.
    fn at_bodies(&self, surfaces: &Surfaces<C>, lanes: Mask) -> Mask {
        if !self.scene.features().absorption {
            return 0;
        }
        mask_of(lanes_of(lanes).filter(|&lane| self.scene.is_of_body(&surfaces.hits, lane)))
    }

    /// Leaves the surfaces in the directions that were sampled there, in which alone paths go on; see
    /// [`super::path::Path::leave`].
    pub fn leave(&mut self, surfaces: &Surfaces<C>, scatters: &Scatters<C>) {
        let prior = self.ratio.sum_of_each();
        for register in 0..REGISTERS {
            for wavelength in 0..C {
                let throughput = &mut self.throughput.0[wavelength][register];
                *throughput *= scatters.weight.0[wavelength][register];
            }
            self.prior_over_density[register] = prior[register] / scatters.density[register];
            let direction = scatters.toward_light[register];
            self.rays.origin[register] = surfaces.hits.point[register].leave(direction);
            self.rays.direction[register] = direction;
        }
        for lane in lanes_of(surfaces.others & scatters.spread) {
            self.ratio.set(lane, &(self.ratio.get(lane) * scatters.ratio.get(lane)));
        }
        for lane in lanes_of(scatters.transmitted) {
            self.refract(surfaces, lane);
        }
        // The camera's far clip ends its own rays alone.
        self.rays.t_max = Rays::NONE.t_max;
        self.rays.leaves = *surfaces.hits.facet();
        self.density = scatters.density;
        (self.from_point, self.from_facing) = (surfaces.hits.point, surfaces.normal);
        if self.depth == 0 && self.scene.features().caustics {
            let first = |lane| FirstSurface {
                point: self.from().get(lane).point,
                leaves: self.rays.get(lane).direction,
                density: get(&self.density, lane) * scatters.ratio.get(lane).sum() / C as f64,
            };
            self.firsts = (0..LANES).map(first).collect();
        }
        self.depth += 1;
        self.alive = scatters.spread;
        self.competing = 0;
    }

    /// The path of a lane has just been scattered to the other side: see [`super::path::Path::leave`].
    fn refract(&mut self, surfaces: &Surfaces<C>, lane: usize) {
        if let Some(far_over_near) = surfaces.shading(lane).and_then(Shading::index_beyond) {
            let before = get(&self.prior_throughput, lane);
            set(&mut self.prior_throughput, lane, before * far_over_near * far_over_near);
        }
        if let Some(media) = self.media.get_mut(lane) {
            let hit = surfaces.hits.get(self.scene, lane);
            self.scene.pass_through(&hit, self.rays.get(lane).direction, media);
        }
    }

    /// Ends paths by Russian roulette, by a value for each lane; see [`super::path::Path::survival`].
    pub fn survive(&mut self, values: &Row) {
        let scene = self.scene;
        let carrying = self.throughput.nonzero();
        self.end_before_next(PathEnd::Absorbed, self.alive & !carrying);
        self.alive &= carrying;
        if self.depth < scene.limits.rr_depth {
            return;
        }
        let late = late_survival(self.depth);
        let sums = self.ratio.sum_of_each();
        let mut survive = 0;
        for register in 0..REGISTERS {
            let (mut most, mut alive) = (Register::splat(f64::NEG_INFINITY), Register::ZERO);
            for wavelength in 0..C {
                most = self.throughput.0[wavelength][register].greater(most);
                let goes_along = self.ratio.0[wavelength][register].gt(Register::ZERO);
                alive += goes_along.only(Register::ONE);
            }
            let throughput = alive * most / sums[register] * self.prior_throughput[register];
            let survival = roulette_survival(throughput, late);
            survive |= values[register].lt(survival).mask() << (WIDTH * register);
            for wavelength in 0..C {
                let throughput = &mut self.throughput.0[wavelength][register];
                *throughput /= survival;
            }
        }
        self.end_before_next(PathEnd::Roulette, self.alive & !survive);
        self.alive &= survive;
    }

    /// One step along the rays: to the next surfaces, with the light from there, and on from them.
    pub fn step(&mut self, scratch: &mut Scratch<C>) {
        let Scratch { surfaces, samples } = scratch;
        self.advance(&mut surfaces.hits);
        self.escape(&surfaces.hits);
        self.emit(&surfaces.hits);
        let is_last = self.is_last();
        // Past the last segment light may still pass surfaces as if there were none.
        if is_last && !self.scene.goes_on_past_last() {
            return self.stop();
        }
        self.shade(surfaces);
        let light_tracing = self.scene.features().caustics;
        for lane in lanes_of(surfaces.others & self.alive) {
            if !surfaces.goes_along(lane, light_tracing) || self.competes_from(&surfaces.hits, lane) {
                let (light, _) = self.go_on_alone(surfaces, lane);
                self.arrives(lane, light);
            }
        }
        if is_last {
            return self.stop();
        }
        if self.alive == 0 {
            return;
        }
        self.direct_light(surfaces, &self.draw(Dimensions::Light(self.depth)), 1.0, samples);
        self.scatter(surfaces);
    }

    /// On from the surfaces by scattering; see [`super::path::Path::scatter`].
    pub fn scatter(&mut self, surfaces: &Surfaces<C>) {
        if self.alive == 0 {
            return;
        }
        let u = self.draw(Dimensions::Scattering(self.depth));
        let scatters = surfaces.sample(&u, self.alive);
        self.end_absorbed(&scatters);
        for (lane, scatter) in &scatters.apart {
            let light = self.scatter_alone(surfaces, *lane, scatter, get(&u[3], *lane));
            self.arrives(*lane, light);
        }
        self.leave(surfaces, &scatters);
        self.survive(&u[3]);
    }

    /// All paths have as many segments as they may.
    pub fn stop(&mut self) {
        self.end(PathEnd::MaxDepth, self.alive);
        self.alive = 0;
    }

    /// Some paths end before they leave the surface that they have met.
    pub fn end(&self, end: PathEnd, lanes: Mask) {
        self.scene.paths_ended(end, self.depth + 1, lanes);
    }

    /// They end when they would go on along a new segment.
    pub fn end_before_next(&self, end: PathEnd, lanes: Mask) {
        self.scene.paths_ended(end, self.depth, lanes);
    }

    /// The lanes that scatter nothing end where they are.
    pub fn end_absorbed(&self, scatters: &Scatters<C>) {
        let apart = scatters.apart.iter().fold(0, |mask, (lane, _)| mask | 1 << lane);
        self.end(PathEnd::Absorbed, self.alive & !(scatters.spread | apart));
    }
}

/// What a step fills and the next one fills again.
pub(super) struct Scratch<const C: usize> {
    pub surfaces: Surfaces<C>,
    pub samples: LightSamples<C>,
}

impl<const C: usize> Scratch<C> {
    pub fn new() -> Self {
        Self { surfaces: Surfaces::new(), samples: LightSamples::NONE }
    }
}
