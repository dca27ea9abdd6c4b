//! Samplers. They differ in noise, never in expectation. One that Mitsuba 3 has is no part of what a scene
//! means: the best that there is here takes its place. Those that are abbe's own, and the command line, force
//! one.

use super::fields::Integer;
use super::{Field, Ignored, Parameter, Simple, Takes, declare, ignored, integer};
use crate::sampling::SamplerKind;
use crate::scene::description::Sampler;
use crate::scene::read::{Class, Query};
use crate::scene::write::{Node, Writer};

/// Taken where the file forces none.
const BEST: SamplerKind = SamplerKind::Sobol;

declare! {
    Class::Sampler => SamplerKind, common common;

    "independent", "stands for the best, `sobol`, as all of Mitsuba 3's samplers do"
        => SamplerKind::Independent {} {} ignoring [jitter()];
    "stratified", "the same" => SamplerKind::Independent {} {} ignoring [jitter()];
    "multijitter", "the same" => SamplerKind::Independent {} {} ignoring [jitter()];
    "orthogonal", "the same"
        => SamplerKind::Independent {} {}
        ignoring [jitter(), ignored("strength", Takes::Integer(1, i64::MAX), "")];
    "ldsampler", "the same" => SamplerKind::Independent {} {} ignoring [jitter()];
    "regular" extension "the same grid in every pixel",
        "the same grid in every pixel, which has no error bars: for studies of aliasing"
        => SamplerKind::Regular {} {};
    "jittered" extension "one sample in each of equal shares" => SamplerKind::Jittered {} {};
    "poisson" extension "Poisson disk patterns" => SamplerKind::Poisson {} {};
    "sobol" extension "Owen-scrambled Sobol" => SamplerKind::Sobol {} {};
    "bluenoise" extension "Owen-scrambled Sobol with the error arranged as blue noise",
        "the same with the error arranged as blue noise over the picture"
        => SamplerKind::BlueNoise {} {};
}

fn jitter() -> Ignored {
    ignored("jitter", Takes::Boolean, "")
}

fn sample_count() -> Simple<Integer<u32>> {
    integer("sample_count", 4, [1, i64::from(u32::MAX)], "number of samples per pixel")
}

fn seed() -> Simple<Integer<u64>> {
    integer("seed", 0, [0, i64::MAX], "what random numbers follow from")
}

fn common() -> Vec<Parameter> {
    [sample_count().parameters(), seed().parameters()].concat()
}

/// The sampler of the sensor that is asked.
pub fn of_sensor(sensor: &Query<'_>) -> Sampler {
    let mut sampler = Sampler {
        place: sensor.object.place.clone(),
        kind: BEST,
        forced: false,
        sample_count: sample_count().default(),
        seed: seed().default(),
    };
    let Some((_, id)) = sensor.object(Class::Sampler) else { return sampler };
    let query = Query::new(sensor.reader, id);
    sampler.place = query.object.place.clone();
    let Some(kind) = read(&query) else { return sampler };
    if kind == SamplerKind::Independent {
        let taken = format!(
            "sampler \"{}\": \"{BEST}\" is taken, which has less noise; --sampler forces another",
            query.object.plugin
        );
        query.reader.remark(&query.object.plugin_place, taken);
    } else {
        (sampler.kind, sampler.forced) = (kind, true);
    }
    sampler.sample_count = sample_count().read(&query).unwrap_or(sampler.sample_count);
    sampler.seed = seed().read(&query).unwrap_or(sampler.seed);
    query.finish();
    sampler
}

pub fn node(sampler: &Sampler, writer: &mut Writer) -> Node {
    let kind = if sampler.forced { sampler.kind } else { SamplerKind::Independent };
    let node = write(&kind, &sampler.place, writer);
    let node = sample_count().write(node, &sampler.sample_count, writer);
    seed().write(node, &sampler.seed, writer)
}
