//! Weights of techniques beside one another, and survival of long paths.

use crate::lanes::{REGISTERS, Real, Register, Row, Truth, ZERO, get, lanes_of, part, set};
use crate::light::LightSamples;
use crate::sampling::Density;
use crate::scene::{Scene, Techniques};

/// What a light sample is multiplied by: its weight beside scattering, over the density of both. `prior`: Σⱼ
/// pⱼ / p₀ of the path; `by_scattering`: the same with the density of scattering toward the light.
#[inline(always)]
pub(super) fn light_sample_weight(
    scene: &Scene,
    density: Density,
    prior: f64,
    by_scattering: impl FnOnce() -> f64,
) -> f64 {
    match (density, scene.limits.techniques) {
        (_, Techniques::Scattering) => 0.0,
        (Density::Discrete, _) => 1.0 / prior,
        (Density::PerSolidAngle(density), Techniques::LightSamples) => 1.0 / (prior * density),
        (Density::PerSolidAngle(density), Techniques::Both) => {
            let by_light = prior * density;
            power_heuristic(by_light, by_scattering()) / by_light
        }
    }
}

/// The weight of light that scattering finds beside light samples. `by_light`: the density with which these
/// find it, 0 where they don't look for it; `by_scattering`: that of having been scattered toward it. Both
/// are Σⱼ pⱼ over a density that the two have in common, such as that of the hero.
#[inline(always)]
pub(super) fn scattering_weight<R: Real>(
    scene: &Scene,
    by_light: impl FnOnce() -> R,
    by_scattering: impl FnOnce() -> R,
) -> R {
    let one = R::of(1.0);
    // What light samples leave to scattering, such as a constant environment, has the weight 1.
    let unless_sought = |by_light: R, sought: R| R::choose(by_light.gt(R::of(0.0)), sought, one);
    match scene.limits.techniques {
        Techniques::Scattering => one,
        Techniques::LightSamples => unless_sought(by_light(), R::of(0.0)),
        Techniques::Both => {
            let by_light = by_light();
            unless_sought(by_light, power_heuristic(by_scattering(), by_light))
        }
    }
}

/// What light samples are multiplied by; see [`light_sample_weight`] for the same of one.
#[inline(always)]
pub(super) fn light_sample_weights<const C: usize>(
    scene: &Scene,
    samples: &LightSamples<C>,
    prior: &Row,
    by_scattering: &Row,
) -> Row {
    let mut weights = ZERO;
    if scene.limits.techniques != Techniques::Both {
        for lane in lanes_of(samples.found) {
            let density = samples.density_of(lane);
            let weight = light_sample_weight(scene, density, get(prior, lane), || get(by_scattering, lane));
            set(&mut weights, lane, weight);
        }
        return weights;
    }
    for register in 0..REGISTERS {
        let prior = prior[register];
        let by_light = prior * samples.density[register];
        let weight = power_heuristic(by_light, by_scattering[register]) / by_light;
        let discrete = Truth::of(part(samples.discrete, register));
        weights[register] = Register::choose(discrete, Register::ONE / prior, weight);
    }
    weights
}

/// Survival probability of Russian roulette, by the path's throughput and the largest one of its length.
///
/// Squared error times CPU time is least where the number of paths that go on is proportional to their
/// throughput, by a factor that depends on the scene (compare Vorba and Křivánek, "Adjoint-Driven Russian
/// Roulette and Splitting in Light Transport Simulation", ACM TOG 35(4), 2016).
#[inline(always)]
pub(super) fn roulette_survival<R: Real>(throughput: R, largest: f64) -> R {
    /// With 1 the few survivors make much of the noise of rooms, glass and fog. With 2 or 4 squared error
    /// times CPU time is 0.72 to 0.96 of that there, and about the same in other scenes.
    const FACTOR: f64 = 3.0;
    (R::of(FACTOR) * throughput).lesser(R::of(largest))
}

/// Largest survival probability of a path of `depth` segments: between perfect mirrors nothing is ever lost.
///
/// The fraction of paths that survive falls with the square of their length, so that their mean length is
/// finite. If it fell exponentially, the weights of the survivors would grow exponentially, and light that
/// leaves a body only after many reflections would be estimated with infinite variance.
pub(super) fn late_survival(depth: u32) -> f64 {
    /// Segments after which a path without loss may end too.
    const LATE: u32 = 64;
    if depth <= LATE {
        return 1.0;
    }
    let kept = 1.0 - 1.0 / f64::from(depth);
    kept * kept
}

/// The same where media scatter. A thick medium of albedo 1 sends light back of which a fraction ∝ 1/√n takes
/// more than n segments. If the number of paths fell with n², nearly all of that light would be in few
/// samples.
pub(super) fn late_survival_in_media(depth: u32) -> f64 {
    const LATE: u32 = 4096;
    if depth <= LATE { 1.0 } else { (1.0 - 1.0 / f64::from(depth)).powf(1.25) }
}

/// Weight of a technique of density `own` beside one of density `other`, with exponent 2 (Veach, *Robust
/// Monte Carlo Methods for Light Transport Simulation*, 1997, sec. 9.2.2).
#[inline(always)]
pub(super) fn power_heuristic<R: Real>(own: R, other: R) -> R {
    let ratio = other / own;
    let weight = R::of(1.0) / (R::of(1.0) + ratio * ratio);
    R::choose(own.eq(R::of(0.0)), R::of(0.0), weight)
}
