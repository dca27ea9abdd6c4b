use super::*;
use crate::sampling::mix;
use crate::units::WavelengthRange;

fn film(reference: f64, replicates: usize, bins: Option<SpectralBins>) -> Film {
    let extras = Extras { bins, ..Extras::default() };
    Film::new(2, 1, replicates as u32, extras, FixedPoint::for_reference(reference))
}

/// A film whose first pixel has had one sample in each replicate.
fn exposed(reference: f64, values: &[[f64; 3]]) -> Film {
    let mut film = film(reference, values.len(), None);
    let mut tile = film.extras.tile([0, 0], [1, 1], 0..values.len() as u32);
    for (replicate, xyz) in (0..).zip(values) {
        tile.begin(mix(u64::from(replicate)), [0, 0]);
        for (channel, &value) in xyz.iter().enumerate() {
            tile.add(0, replicate, channel, value, film.scale());
        }
        tile.add_weighed(0, replicate, &Tristimulus::BLACK, 1.0);
        tile.count(0, 1);
    }
    film.add(&tile);
    film
}

#[test]
fn mean_and_standard_error_are_those_of_the_replicates() {
    let film = exposed(1.0, &[[1.0, 2.0, 0.5], [3.0, 2.5, 0.25], [2.0, 1.0, 0.75], [2.0, 4.5, 0.0]]);
    let x = film.combined(0, 0, [1.0, 0.0, 0.0]);
    assert_eq!(x.mean, 2.0);
    assert!((x.error - (2.0f64 / 3.0 / 4.0).sqrt()).abs() < 1e-15);
    // X − Y has the values −1, 0.5, 1, −2.5: mean −0.5, sum of squared deviations 7.5.
    let difference = film.combined(0, 0, [1.0, -1.0, 0.0]);
    assert_eq!(difference.mean, -0.5);
    assert!((difference.error - (7.5f64 / 3.0 / 4.0).sqrt()).abs() < 1e-14);
    assert_eq!(film.samples(0, 0), 4);
    let of_each = (0..4).map(|replicate| film.of_replicate(0, 0, replicate, [1.0, -1.0, 0.0]));
    assert_eq!(of_each.collect::<Vec<_>>(), [-1.0, 0.5, 1.0, -2.5]);
    assert_eq!(film.of_replicate(1, 0, 2, [1.0, 0.0, 0.0]), 0.0);
    assert_eq!(film.combined(1, 0, [1.0, 0.0, 0.0]).mean, 0.0);
}

/// What light paths bring is divided by their number, in a replicate by that of its own.
#[test]
fn light_paths_count_for_all_pixels() {
    let extras = Extras { light_paths: true, ..Extras::default() };
    let mut film = Film::new(2, 1, 2, extras, FixedPoint::for_reference(1.0));
    let mut tile = film.extras.tile([0, 0], [2, 1], 0..2);
    for (place, replicate) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        tile.add(place, replicate, 1, 1.0, film.scale());
        tile.add_weighed(place, replicate, &Tristimulus::BLACK, 1.0);
    }
    film.add(&tile);
    let mut light = film.extras.tile([0, 0], [1, 1], 0..1);
    for (replicate, value, paths) in [(0, 6.0, 3), (1, 16.0, 4)] {
        light.add(0, 0, 1, value, film.light_scale());
        film.add_light([1, 0], replicate, &light.take());
        film.count_light(replicate, paths);
    }
    let y = [0.0, 1.0, 0.0];
    assert_eq!(film.combined(0, 0, y), Measured { mean: 1.0, error: 0.0 });
    assert_eq!([0, 1].map(|replicate| film.of_replicate(1, 0, replicate, y)), [3.0, 5.0]);
    // 22 by seven paths. The first replicate's three have brought 24/7 too little, the other's so much more.
    let Measured { mean, error } = film.combined(1, 0, y);
    assert!((mean - 1.0 - 22.0 / 7.0).abs() < 1e-15 && (error - 48.0 / 49.0).abs() < 1e-15, "{mean} {error}");
}

#[test]
fn nets_are_the_sums_of_their_runs() {
    let mut film = exposed(1.0, &[[1.0; 3], [3.0; 3], [2.0; 3], [4.0; 3]]);
    assert!(film.nets().is_none());
    film.per_net = 2;
    // Nets have the means 2 and 3.
    let y = Quantity::Combined([0.0, 1.0, 0.0]);
    assert_eq!(film.nets(), Some(2));
    assert_eq!(film.measured_by(2, 0, 0, y), Measured { mean: 2.5, error: 0.5 });
    assert_eq!(film.measured(0, 0, y).mean, 2.5);
    film.per_net = 4;
    assert!(film.nets().is_none());
}

#[test]
fn the_order_of_samples_leaves_no_trace() {
    let values: Vec<f64> = (0..64).map(|i| 1e-9 + 1e3 * (1.0 + (f64::from(i) * 0.7).sin())).collect();
    let exposed_in = |order: &mut dyn Iterator<Item = &f64>| {
        let mut film = film(100.0, 2, None);
        for (i, &value) in order.enumerate() {
            let mut tile = film.extras.tile([0, 0], [1, 1], 0..2);
            tile.add(0, 0, 1, value, film.scale());
            tile.add_weighed(0, 0, &Tristimulus::BLACK, 1.0);
            tile.count(0, u32::from(i % 2 == 0));
            film.add(&tile);
        }
        film.combined(0, 0, [0.3, 0.4, 0.1])
    };
    assert_eq!(exposed_in(&mut values.iter()), exposed_in(&mut values.iter().rev()));
}

#[test]
fn rounding_stays_below_the_noise_in_the_darkest_corner_of_a_sunlit_scene() {
    // The sun's disk is about 10⁹ times brighter than a wall in deep shade (2·10⁷ against 0.02 W·m⁻²·sr⁻¹).
    let values: Vec<f64> = (0..16).map(|i| 0.02 * (1.0 + (f64::from(i) * 2.3).sin())).collect();
    let film = exposed(2e7, &values.iter().map(|&v| [v, v, v]).collect::<Vec<_>>());
    let found = film.combined(0, 0, [0.0, 1.0, 0.0]);
    let mean = values.iter().sum::<f64>() / 16.0;
    let noise = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 15.0 / 16.0).sqrt();
    assert!((found.mean - mean).abs() < 3e-3 * noise, "{found:?}");
    assert!((found.error / noise - 1.0).abs() < 3e-3, "{found:?} {noise}");
}

/// A lamp of 10⁻⁶ units that lights a floor as brightly as the sun does is 10¹² times brighter than it.
#[test]
fn what_is_smaller_than_the_quantum_is_right_on_average() {
    for value in [1e-12, 0.3e-12, 1.7e-12, 7.3e-9] {
        let mut film = film(1.0, 1, None);
        let count = 1 << 20;
        let mut tile = film.extras.tile([0, 0], [1, 1], 0..1);
        for key in 0..count {
            tile.begin(mix(key), [0, 0]);
            tile.add(0, 0, 1, value, film.scale());
            tile.add_weighed(0, 0, &Tristimulus::BLACK, 1.0);
        }
        film.add(&tile);
        let found = film.combined(0, 0, [0.0, 1.0, 0.0]).mean;
        // Rounding one up or down has a variance of a quarter of a quantum's square at most.
        let error = 0.5 * film.scale().quantum / (count as f64).sqrt();
        assert!((found - value).abs() < 4.5 * error, "{found:e}, {value:e} ± {error:e}");
    }
}

#[test]
fn bad_values_are_counted_not_hidden() {
    let mut bad = BadValues::default();
    let values = [1.0, f64::NAN, f64::INFINITY, -1e-300, 0.0];
    let admitted = values.into_iter().filter(|&v| bad.admits(v)).count();
    assert_eq!(admitted, 2);
    assert_eq!(bad, BadValues { not_a_number: 1, infinite: 1, negative: 1, overflow: 0 });
    let film = exposed(1.0, &[[1e30, 0.0, 0.0], [1.0, 0.0, 0.0]]);
    assert_eq!(film.bad.overflow, 1);
    assert_eq!(film.combined(0, 0, [1.0, 0.0, 0.0]).mean, 0.5);
}

/// Sums that leave the range of integers stay where they were, and are counted: in a tile, in the film, and
/// those of light subpaths. None wraps around.
#[test]
fn sums_beyond_the_range_are_counted_and_left_out() {
    // A quantum is 2⁻⁴⁰ here, and integers end at 2⁶³.
    let large = 2f64.powi(21);
    let extras = Extras { light_paths: true, ..Extras::default() };
    let mut film = Film::new(1, 1, 1, extras, FixedPoint::for_reference(1.0));
    let y = [0.0, 1.0, 0.0];
    let tile = |film: &Film| {
        let mut tile = film.extras.tile([0, 0], [1, 1], 0..1);
        for _ in 0..3 {
            tile.add(0, 0, 1, large, film.scale());
            tile.add_weighed(0, 0, &Tristimulus::BLACK, 1.0);
        }
        tile
    };
    // Three times 2⁶¹ fit.
    let first = tile(&film);
    film.add(&first);
    assert_eq!(film.bad, BadValues::default());
    assert_eq!(film.combined(0, 0, y).mean, large);
    // In the film six do not: the second tile's sum is left out, and its samples dim the pixel.
    film.add(&first);
    assert_eq!(film.bad.overflow, 1);
    assert_eq!(film.combined(0, 0, y).mean, 0.5 * large);
    // In a tile the fifth does not.
    let mut full = film.extras.tile([0, 0], [1, 1], 0..1);
    for sample in 0..5 {
        assert_eq!(full.bad.overflow, 0, "{sample}");
        full.add(0, 0, 1, if sample == 3 { large - 1.0 } else { large }, film.scale());
    }
    assert_eq!(full.bad.overflow, 1);
    film.count_light(0, 1);
    let mut brought = Vec::new();
    for times in [1, 2, 3] {
        film.add_light([0, 0], 0, &[(0, i64::MAX / 2)]);
        assert_eq!(film.bad.overflow, 1 + u64::from(times == 3), "{times}");
        brought.push(film.combined(0, 0, [1.0, 0.0, 0.0]).mean);
    }
    assert!(brought[0] > 0.0 && brought[1] == 2.0 * brought[0] && brought[2] == brought[1], "{brought:?}");
}

#[test]
fn a_narrow_line_falls_into_its_own_bin() {
    let bins = SpectralBins { range: WavelengthRange::VISIBLE, count: 47 };
    assert_eq!(bins.of(360.0), Some(0));
    assert_eq!(bins.of(830.0), Some(46));
    assert_eq!(bins.of(589.3), Some(22));
    assert!((bins.centre(22) - 585.0).abs() < 1e-9);
    assert_eq!(bins.of(359.9), None);
    let mut film = film(1.0, 1, Some(bins));
    let mut tile = film.extras.tile([1, 0], [1, 1], 0..1);
    tile.add(0, 0, film.extras.bin_channel(22), 7.0, film.scale());
    tile.add_weighed(0, 0, &Tristimulus::BLACK, 1.0);
    film.add(&tile);
    assert_eq!(film.bin(1, 0, 22).mean, 7.0);
    assert_eq!(film.bin(1, 0, 21).mean, 0.0);
    assert_eq!(film.bin(0, 0, 22).mean, 0.0);
}

/// Four channels at once are four channels one by one, whatever the size of what is added.
#[test]
fn a_weighed_sample_is_added_as_its_channels_are() {
    let scale = FixedPoint::for_reference(3.0);
    let extras = Extras::default();
    let [mut together, mut apart] = [0, 1].map(|_| extras.tile([0, 0], [1, 1], 0..1));
    let values = [0.0, -0.0, 1e-13, 3e-7, -0.7, 1.3e3, 2e4, -5e6, 1e9];
    for (key, (&x, &y)) in (0..).zip(values.iter().flat_map(|x| values.iter().map(move |y| (x, y)))) {
        let (xyz, weight) = ([x, y, x - y], if key % 3 == 0 { -0.06 } else { 0.73 });
        together.begin(mix(key), [0, 0]);
        together.add_weighed(0, 0, &Tristimulus::new(xyz, scale), weight);
        apart.begin(mix(key), [0, 0]);
        for (channel, value) in xyz.into_iter().enumerate() {
            apart.add(0, 0, channel, value * weight, scale);
        }
        apart.add(0, 0, WEIGHT, weight, FixedPoint::SHARE);
        assert_eq!(together.of(0, 0), apart.of(0, 0), "{x} {y}");
        assert_eq!(together.bad, apart.bad, "{x} {y}");
    }
    assert!(apart.bad.overflow > 0);
}
