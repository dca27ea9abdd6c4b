use super::super::bundle::{Each, Scratch};
use super::super::{GroupSample, Plan, RadianceSample, Sight, Workspace, radiance, radiance_of_group};
use super::*;
use crate::bsdf::microfacet::Distribution;
use crate::geometry::Vec3;
use crate::lanes::get;
use crate::material::Shading;
use crate::sampling::{Dimensions, Sampler, SamplerKind};
use crate::scene::description::{
    Alpha, Bsdf, BsdfKind, ConductorIndex, Roughness, ShapeDescription, ShapeKind,
};
use crate::scene::fixture::{self, bsdf, constant, diffuse, glass, medium, shape, sloped};
use crate::shape::QuadricKind;
use glam::DMat4;
use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

/// The fraction of a next surface's radiance that a first one gets, and the density of sampling it.
/// `shading`: how the first one scatters.
fn link(
    firsts: &Firsts<4>,
    shading: &Shading<4>,
    lane: usize,
    next: &Next,
    wavelengths: &Wavelengths<4>,
) -> Option<(Sampled<4>, Sampled<4>)> {
    let (scene, owns) = (firsts.scene, lane == next.owner);
    let (from, target) = (firsts.receivers.get(lane).point, &next.point);
    let between = target.position - from.position;
    let direction = between.normalize();
    let cos = direction.dot(target.normal);
    let geometry = cos.abs() / between.length_squared();
    if cos * next.direction.dot(target.normal) <= 0.0 || !geometry.is_finite() {
        return None;
    }
    let value = shading.evaluate(direction);
    if value.density.is_zero() && value.f_cos.is_zero() {
        return None;
    }
    let media = firsts.bundle.media(lane);
    let ray = from.segment_to(target)?;
    let between = if owns && !scene.features().interface_events() {
        scene.transmittance(&media.here, &ray, wavelengths).unwrap_or(Sampled::ONE)
    } else {
        scene.transmittance_between_surfaces(&ray, 0.0, &media.here, wavelengths)
    };
    let reach = firsts.bundle.throughput.get(lane) * value.f_cos * between * geometry;
    (owns || !between.is_zero()).then(|| (reach, value.density * geometry))
}

fn same(a: Sampled<4>, b: Sampled<4>) -> bool {
    a.0.iter().zip(b.0).all(|(a, b)| (a - b).abs() <= 1e-12 * b.abs())
}

/// A floor at y = −1 and a lamp that shines on it.
fn room(floor: Arc<Bsdf>) -> Vec<ShapeDescription> {
    let quarter = DMat4::from_rotation_x(-FRAC_PI_2);
    let down = DMat4::from_translation(2.0 * Vec3::Y) * quarter.inverse();
    let up = DMat4::from_translation(-Vec3::Y) * quarter * DMat4::from_scale(Vec3::splat(3.0));
    let lamp = shape(ShapeKind::Rectangle, down, diffuse(constant(0.0)));
    let lamp = ShapeDescription { emission: Some(constant(3.0)), ..lamp };
    vec![shape(ShapeKind::Rectangle, up, floor), lamp]
}

fn ball(x: f64, radius: f64, bsdf: Arc<Bsdf>) -> ShapeDescription {
    let kind = ShapeKind::Sphere { centre: Vec3::new(x, radius - 1.0, 0.0), radius };
    shape(kind, DMat4::IDENTITY, bsdf)
}

/// A cube that stands on the floor.
fn block(x: f64, bsdf: Arc<Bsdf>, extinction: [f64; 2]) -> ShapeDescription {
    let place = DMat4::from_translation(Vec3::new(x, -0.5, 0.0)) * DMat4::from_scale(Vec3::splat(0.5));
    let interior = Some(medium(sloped(extinction), 0.0));
    ShapeDescription { interior, ..shape(ShapeKind::Cube, place, bsdf) }
}

fn rough(distribution: Distribution, alpha: f64) -> Option<Roughness> {
    Some(Roughness { distribution, alpha: Alpha::Isotropic(constant(alpha)) })
}

fn metal(roughness: Option<Roughness>) -> Arc<Bsdf> {
    let index = ConductorIndex::Complex { n: sloped([1.3, 0.4]), k: sloped([2.0, 6.0]) };
    bsdf(BsdfKind::Conductor { index, specular_reflectance: constant(1.0), roughness })
}

/// Flat and curved shapes, rough surfaces, bodies in contact and media between surfaces.
fn scenes() -> [(&'static str, Vec<ShapeDescription>); 4] {
    let paper = || diffuse(sloped([0.2, 0.9]));
    let sheet =
        BsdfKind::DiffuseTransmitter { reflectance: sloped([0.1, 0.5]), transmittance: sloped([0.6, 0.2]) };
    let upright = DMat4::from_rotation_y(-0.9);
    let kind = QuadricKind::Cone {
        from: Vec3::new(-1.0, -1.0, 0.3),
        to: Vec3::new(-0.9, 0.4, 0.3),
        radii: [0.6, 0.1],
    };
    let cone = ShapeKind::Quadric { kind, capped: true };
    let ring = ShapeKind::Torus { major_radius: 0.4, minor_radius: 0.15 };
    let with = |floor, more: Vec<ShapeDescription>| [room(floor), more].concat();
    [
        (
            "diffuse",
            with(paper(), vec![shape(ShapeKind::Rectangle, upright, bsdf(sheet)), ball(-1.0, 0.5, paper())]),
        ),
        (
            "metals",
            with(
                metal(rough(Distribution::Beckmann, 0.3)),
                vec![ball(0.5, 0.7, metal(rough(Distribution::Ggx, 0.2)))],
            ),
        ),
        (
            "contact",
            with(
                paper(),
                vec![
                    block(-0.8, glass(1.5, None), [0.2, 0.6]),
                    block(0.3, bsdf(BsdfKind::Null), [0.9, 0.3]),
                    ball(1.3, 0.4, glass(1.7, rough(Distribution::Ggx, 0.2))),
                ],
            ),
        ),
        (
            "quadrics",
            with(paper(), vec![shape(cone, DMat4::IDENTITY, paper()), shape(ring, upright, paper())]),
        ),
    ]
}

/// Rough glass, sheets that transmit, metals and bodies with media among them.
#[test]
fn paths_that_go_along_are_those_of_each_alone() {
    for (name, shapes) in scenes() {
        let scene = fixture::compiled(&fixture::described(shapes, Vec3::new(0.5, 2.0, 4.0), Vec3::ZERO));
        let sampler = Sampler::new(SamplerKind::Independent, 5, 1);
        let size = scene.film.extent.whole;
        let (mut lit, mut workspace) = (0, Workspace::default());
        for group in 0..100 {
            let wavelengths: Vec<Wavelengths<4>> =
                (0..LANES).map(|lane| scene.wavelengths.sample((lane as f64 + 0.5) / LANES as f64)).collect();
            let sight = |member: usize| {
                let stream = sampler.stream([member as u32, group], 0, 0);
                let [x, y, ..] = stream.draw(Dimensions::Camera);
                let place = [x * f64::from(size[0]), y * f64::from(size[1])];
                let ray = scene.sensor_ray(place, 0.0, &stream)?.ray;
                Some(Sight { member, ray, lit: None, stream })
            };
            let sights: Vec<Sight> = (0..LANES).filter_map(sight).collect();
            let sample = GroupSample { sights: &sights, time: 0.0, wavelengths: &wavelengths };
            let mut seen = vec![RadianceSample::NOTHING; LANES];
            radiance_of_group(&scene, &[sample], Plan::PLAIN, &mut [&mut seen], &mut workspace);
            for Sight { member, ray, stream, .. } in sights {
                let alone = radiance(&scene, ray, None, 0.0, &wavelengths[member], &stream);
                let found = seen[member];
                assert_eq!(found.alpha_hit, alone.alpha_hit, "{name}: member {member} of group {group}");
                assert!(
                    same(found.radiance, alone.radiance),
                    "{name}: member {member} of group {group}: {:?} {:?}",
                    found.radiance,
                    alone.radiance
                );
                lit += u32::from(!found.radiance.is_zero());
            }
        }
        assert!(lit > 400, "{name}: {lit}");
    }
}

#[test]
fn links_are_those_of_each_pair() {
    for (name, shapes) in scenes() {
        let scene = fixture::compiled(&fixture::described(shapes, Vec3::new(0.5, 2.0, 4.0), Vec3::ZERO));
        let sampler = Sampler::new(SamplerKind::Independent, 5, 1);
        let wavelengths = scene.wavelengths.sample::<4>(0.3);
        let size = scene.film.extent.whole;
        let (mut seen, mut hidden) = (0, 0);
        for group in 0..100 {
            let streams = std::array::from_fn(|lane| sampler.stream([lane as u32, group], 0, 0));
            let rays: Vec<_> = streams
                .iter()
                .filter_map(|stream| {
                    let [x, y, ..] = stream.draw(Dimensions::Camera);
                    let place = [x * f64::from(size[0]), y * f64::from(size[1])];
                    Some(scene.sensor_ray(place, 0.0, stream)?.ray)
                })
                .collect();
            assert_eq!(rays.len(), LANES);
            let turn = Turn::new(&scene, 0.0, Each::Same(&wavelengths), streams);
            let mut bundle = Bundle::from_camera(&scene, &turn, 0, rays.iter());
            let (mut surfaces, mut scratch) = (Surfaces::new(), Scratch::<4>::new());
            bundle.advance(&mut surfaces.hits);
            bundle.escape(&surfaces.hits);
            let shadings: Vec<Option<Shading<4>>> = (0..LANES)
                .map(|lane| {
                    let met = bundle.alive >> lane & 1 == 1;
                    let path = bundle.path(lane);
                    let hit = met.then(|| surfaces.hits.get(&scene, lane))?;
                    path.shade(&scene, &rays[lane], &hit, &wavelengths, &streams[lane])
                })
                .collect();
            bundle.shade(&mut surfaces);
            bundle.alive &= !lanes_of(bundle.alive)
                .filter(|&lane| !surfaces.shares(lane))
                .fold(0, |mask, lane| mask | 1 << lane);
            let sharing = if group % 2 == 0 { Sharing::Sixteen } else { Sharing::Four };
            let firsts = Firsts::new(&scene, &turn, &bundle, &surfaces, sharing);
            let mut nexts = bundle.clone();
            let u = nexts.draw(Dimensions::Scattering(0));
            nexts.leave(&surfaces, &surfaces.sample(&u, bundle.alive));
            let hits = &mut scratch.surfaces.hits;
            nexts.advance(hits);
            for owner in lanes_of(nexts.alive & hits.met) {
                let hit = hits.get(&scene, owner);
                let (point, shading_normal) = (hit.point, hit.shading_normal);
                let direction = nexts.rays.get(owner).direction;
                let next = Next { owner, direction, point, shading_normal, facet: get(hits.facet(), owner) };
                let mut all = std::array::from_fn::<_, LANES, _>(|_| Links::NONE);
                firsts.aim(&next, &mut all[owner]);
                firsts.hide(&mut all, 1 << owner);
                firsts.weigh(&mut all[owner]);
                let links = &all[owner];
                let others = !sharing.partners(owner);
                assert_eq!(links.linked & others, 0);
                for lane in lanes_of(bundle.alive & !others) {
                    let Some(shading) = &shadings[lane] else { continue };
                    let expected = link(&firsts, shading, lane, &next, &wavelengths);
                    let linked = links.linked >> lane & 1 == 1;
                    assert_eq!(linked, expected.is_some(), "{name}: lane {lane} of group {group}");
                    let (reach, density) = expected.unwrap_or((Sampled::ZERO, Sampled::ZERO));
                    assert!(same(links.reach.get(lane), reach), "{name}: {reach:?}");
                    assert!(same(links.density.get(lane), density), "{name}: {density:?}");
                    *(if linked { &mut seen } else { &mut hidden }) += 1;
                }
            }
        }
        assert!(seen > 300 && hidden > 100, "{name}: {seen} linked, {hidden} not");
    }
}
