//! Samplers. They differ in noise, never in expectation. One that Mitsuba 3 has is no part of what a scene
//! means: the best that there is here takes its place. Those that are abbe's own, and the command line, force
//! one.

use super::super::description::Sampler;
use super::super::source::Place;
use super::query::Query;
use super::tree::Class;
use crate::sampling::SamplerKind;

/// Mitsuba 3's default number of samples per pixel.
const DEFAULT_SAMPLES: u32 = 4;

/// Taken where the file forces none.
const BEST: SamplerKind = SamplerKind::Sobol;

/// The sampler of the sensor that is asked.
pub(super) fn of_sensor(query: &Query<'_>) -> Sampler {
    let default = |place: &Place| Sampler {
        place: place.clone(),
        kind: BEST,
        forced: false,
        sample_count: DEFAULT_SAMPLES,
        seed: 0,
    };
    let Some((_, id)) = query.object(Class::Sampler) else { return default(&query.object.place) };
    let query = Query::new(query.reader, id);
    let object = query.object;
    let (kind, forced) = match object.plugin.as_str() {
        name @ ("independent" | "stratified" | "multijitter" | "orthogonal" | "ldsampler") => {
            let taken = format!(
                "sampler \"{name}\": \"{}\" is taken, which has less noise; --sampler forces another",
                BEST.name()
            );
            query.reader.remark(&object.plugin_place, taken);
            if query.has("jitter") {
                query.boolean("jitter", true);
                query.reader.remark(&query.place("jitter"), "jitter changes nothing".to_owned());
            }
            if name == "orthogonal" && query.integer("strength", 1, i64::MAX).is_some() {
                query.reader.remark(&query.place("strength"), "strength changes nothing".to_owned());
            }
            (BEST, false)
        }
        name => {
            let Some(kind) = SamplerKind::named(name) else {
                query.reader.unknown_plugin(object);
                return default(&object.place);
            };
            query.reader.extension(&object.plugin_place, format!("sampler \"{name}\": {}", what(kind)));
            (kind, true)
        }
    };
    let sample_count = query.integer("sample_count", 1, i64::from(u32::MAX));
    let seed = query.integer("seed", 0, i64::MAX);
    query.finish();
    Sampler {
        place: object.place.clone(),
        kind,
        forced,
        sample_count: sample_count.map_or(DEFAULT_SAMPLES, |count| count as u32),
        seed: seed.unwrap_or(0) as u64,
    }
}

/// Description in a word, for the list of extensions.
fn what(kind: SamplerKind) -> &'static str {
    match kind {
        SamplerKind::Regular => "the same grid in every pixel",
        SamplerKind::Independent => "independent random numbers",
        SamplerKind::Jittered => "one sample in each of equal shares",
        SamplerKind::Poisson => "Poisson disk patterns",
        SamplerKind::Sobol => "Owen-scrambled Sobol",
        SamplerKind::BlueNoise => "Owen-scrambled Sobol with the error arranged as blue noise",
    }
}
