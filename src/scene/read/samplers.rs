//! Samplers. They differ in noise, never in expectation: the names that Mitsuba 3 has stand for what there is here.

use super::super::description::Sampler;
use super::super::source::Place;
use super::query::Query;
use super::tree::Class;
use crate::sampling::SamplerKind;

/// Mitsuba 3's default number of samples per pixel.
const DEFAULT_SAMPLES: u32 = 4;

/// The sampler of the sensor that is asked.
pub(super) fn of_sensor(query: &Query<'_>) -> Sampler {
    // Mitsuba 3 takes independent numbers where a file names no sampler; the picture is the same in expectation.
    let default = |place: &Place| Sampler {
        place: place.clone(),
        kind: SamplerKind::Sobol,
        sample_count: DEFAULT_SAMPLES,
        seed: 0,
    };
    let Some((_, id)) = query.object(Class::Sampler) else { return default(&query.object.place) };
    let query = Query::new(query.reader, id);
    let object = query.object;
    let kind = match object.plugin.as_str() {
        "independent" => SamplerKind::Independent,
        name @ ("stratified" | "multijitter" | "orthogonal" | "ldsampler") => {
            let kind = if name == "stratified" { SamplerKind::Jittered } else { SamplerKind::Sobol };
            let stands_for = format!("sampler \"{name}\" stands for \"{}\" here", kind.name());
            query.reader.remark(&object.plugin_place, stands_for);
            if query.has("jitter") {
                query.boolean("jitter", true);
                query.reader.remark(&query.place("jitter"), "jitter changes nothing".to_owned());
            }
            if name == "orthogonal" && query.integer("strength", 1, i64::MAX).is_some() {
                query.reader.remark(&query.place("strength"), "strength changes nothing".to_owned());
            }
            kind
        }
        name => {
            let Some(kind) = SamplerKind::named(name) else {
                query.reader.unknown_plugin(object);
                return default(&object.place);
            };
            query.reader.extension(&object.plugin_place, format!("sampler \"{name}\": {}", what(kind)));
            kind
        }
    };
    let sample_count = query.integer("sample_count", 1, i64::from(u32::MAX));
    let seed = query.integer("seed", 0, i64::MAX);
    query.finish();
    Sampler {
        place: object.place.clone(),
        kind,
        sample_count: sample_count.map_or(DEFAULT_SAMPLES, |count| count as u32),
        seed: seed.unwrap_or(0) as u64,
    }
}

/// In a word, for the list of what Mitsuba does not have.
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
