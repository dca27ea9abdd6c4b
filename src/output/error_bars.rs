//! What the spread of a few replicates leaves open: error bars that hold the truth as often as they say.
//!
//! The noise of a pixel is often skewed: most replicates miss what few meet, so a mean that is too low comes
//! with an error that is too small, and replicates that all miss agree by chance. What a pixel's neighbours
//! met says how much it may have missed. So each variance is moderated by theirs, the more weight remaining
//! with the pixel's own because neighbours across an edge know little of it. With more replicates of the same
//! samples it does not get better: the skewness is that of the mean of all samples.
//! `validation/noise/coverage` measures what this does.

use crate::film::{Region, Told};
use std::collections::BTreeMap;

/// Weight of a pixel's own variance. The rest is that of the mean of its neighbours, up to eight.
const OWN: f64 = 2.0 / 3.0;

/// How far away from a pixel its neighbours are, pixels.
pub const REACH: u32 = 1;

/// Whether the pixels of a picture of this size have neighbours all around: those of a single row, or of a
/// meter with one pixel, need not look at the same thing.
fn is_moderated(picture: [u32; 2]) -> bool {
    picture.iter().all(|&size| size >= 3)
}

/// A pixel of a picture of this width and height and its neighbours, by their places row by row.
pub fn near([width, height]: [usize; 2], [x, y]: [usize; 2]) -> impl Iterator<Item = usize> {
    let columns = x.saturating_sub(1)..(x + 2).min(width);
    (y.saturating_sub(1)..(y + 2).min(height))
        .flat_map(move |row| columns.clone().map(move |x| row * width + x))
}

/// The sum of variances, of those that are finite, and their number; `None` where there are none.
pub fn finite_sum(variances: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    let finite = variances.filter(|variance| variance.is_finite());
    let [sum, count] = finite.fold([0.0; 2], |[sum, count], variance| [sum + variance, count + 1.0]);
    (count > 0.0).then_some([sum, count])
}

/// Variances of the means of all pixels of a part of a picture, row by row, moderated by their neighbours'.
/// Neighbours whose variance is not known are left out; infinite ones stay. Each size is width and height.
pub fn moderated(picture: [u32; 2], part: [u32; 2], variances: &[f64]) -> Vec<f64> {
    let [width, height] = part.map(|size| size as usize);
    if !is_moderated(picture) {
        return variances.to_vec();
    }
    let moderate = |pixel: usize| {
        let (x, y, own) = (pixel % width, pixel / width, variances[pixel]);
        let others = near([width, height], [x, y]).filter(|&other| other != pixel);
        match finite_sum(others.map(|other| variances[other])) {
            Some([sum, count]) => OWN * own + (1.0 - OWN) * sum / count,
            None => own,
        }
    };
    (0..variances.len()).map(moderate).collect()
}

/// Edge of the squares over which the variances that nets tell are pooled, pixels, on the grid of the whole
/// film.
pub const SQUARE: u32 = 32;

/// The fewest pixels that are pooled.
const ALIKE: usize = 32;

/// What pixels that are pooled are expected to tell counts as much as so many of them: a few pixels tell
/// little.
const PRIOR: f64 = 32.0;

/// Pixels as far apart as this, in pixels, are as unlike as those of which one is e times as noisy.
const FAR: f64 = 16.0;

/// What counts as perfectly even, in units of the variance.
const EVEN: f64 = 1e-12;

/// The same of replicates that are runs of nets, and so tell too large a variance: `of_nets` are the
/// variances that the nets tell, which are right on average. Their ratio over pixels of a square of the film
/// that are alike says by how much: as noisy as one another, as uneven where their `means` are known, and
/// close together. `part` is where the pixels are on the whole film.
pub fn calibrated(
    picture: [u32; 2],
    part: Region,
    means: Option<&[f64]>,
    variances: &[f64],
    of_nets: Option<&[f64]>,
) -> Vec<f64> {
    let mut moderated = moderated(picture, part.size, variances);
    let Some(of_nets) = of_nets else { return moderated };
    let mut squares: BTreeMap<[u32; 2], Vec<Vote>> = BTreeMap::new();
    for (pixel, [x, y]) in part.pixels().enumerate() {
        let (scale, own, net) = (moderated[pixel], variances[pixel], of_nets[pixel]);
        if scale > 0.0 && [scale, own, net].iter().all(|variance| variance.is_finite()) {
            let uneven = means.map_or(1.0, |means| uneven(part.size, means, pixel).max(EVEN * scale));
            let [x_trait, y_trait] = [x, y].map(|place| f64::from(place) / FAR);
            let traits = [scale.ln(), uneven.ln(), x_trait, y_trait];
            // Each pixel has one vote, however noisy it is.
            let vote = Vote { pixel, runs: own / scale, nets: net / scale, traits };
            squares.entry([x / SQUARE, y / SQUARE]).or_default().push(vote);
        }
    }
    squares.into_values().for_each(|mut votes| calibrate(&mut votes, 1.0, &mut moderated));
    moderated
}

/// What a pixel says of the ratio of the variances that nets and runs tell.
#[derive(Debug)]
struct Vote {
    pixel: usize,
    /// The variances, in units of the moderated one.
    runs: f64,
    nets: f64,
    /// Pixels that differ in none of them are alike.
    traits: [f64; 4],
}

/// Multiplies the variances of some pixels by the ratio that they tell, of which something is expected.
/// Halves that are unlike tell their own, and expect that of both: nets complete the runs of a smooth pixel
/// far better than those of one on an edge, which has a part in the pixel's variance by the square of its
/// contrast.
fn calibrate(votes: &mut [Vote], expected: f64, variances: &mut [f64]) {
    let sum = |of: fn(&Vote) -> f64| votes.iter().map(of).sum::<f64>();
    let ratio = (PRIOR * expected + sum(|vote| vote.nets)) / (PRIOR + sum(|vote| vote.runs));
    if votes.len() < 2 * ALIKE {
        votes.iter().for_each(|vote| variances[vote.pixel] *= ratio);
        return;
    }
    let spread = |of: usize| {
        let mean = votes.iter().map(|vote| vote.traits[of]).sum::<f64>() / votes.len() as f64;
        votes.iter().map(|vote| (vote.traits[of] - mean).powi(2)).sum::<f64>()
    };
    let spreads: [f64; 4] = std::array::from_fn(spread);
    let widest = (0..4).fold(0, |widest, of| if spreads[of] > spreads[widest] { of } else { widest });
    let middle = votes.len() / 2;
    votes.select_nth_unstable_by(middle, |a, b| {
        a.traits[widest].total_cmp(&b.traits[widest]).then(a.pixel.cmp(&b.pixel))
    });
    let (lower, upper) = votes.split_at_mut(middle);
    [lower, upper].into_iter().for_each(|half| calibrate(half, ratio, variances));
}

/// Sum of the squares by which the values of a pixel and its neighbours, row by row, depart from a plane:
/// what is even may slope. Beyond the border values slope on.
fn uneven(size: [u32; 2], values: &[f64], pixel: usize) -> f64 {
    let [width, height] = size.map(|size| size as usize);
    let (x, y) = (pixel % width, pixel / width);
    let own = values[pixel];
    let row = |y: usize| {
        let value = |x: usize| values[y * width + x] - own;
        sloping((x > 0).then(|| value(x - 1)), value(x), (x + 1 < width).then(|| value(x + 1)))
    };
    let (above, here, below) = ((y > 0).then(|| row(y - 1)), row(y), (y + 1 < height).then(|| row(y + 1)));
    let [mut sum, mut squares, mut across, mut down] = [0.0; 4];
    for column in 0..3 {
        let of_column = sloping(above.map(|row| row[column]), here[column], below.map(|row| row[column]));
        for (row, value) in of_column.into_iter().enumerate() {
            sum += value;
            squares += value * value;
            across += (column as f64 - 1.0) * value;
            down += (row as f64 - 1.0) * value;
        }
    }
    // The sums of 1 and of the squares of the steps are 9 and 6.
    squares - sum * sum / 9.0 - (across * across + down * down) / 6.0
}

/// Three values in a line, of which one may be beyond the border.
fn sloping(before: Option<f64>, here: f64, after: Option<f64>) -> [f64; 3] {
    let opposite = |other: Option<f64>| other.map_or(here, |other| 2.0 * here - other);
    [before.unwrap_or_else(|| opposite(after)), here, after.unwrap_or_else(|| opposite(before))]
}

/// How much of the variance that runs of nets tell of a mean over a picture is right, going by the variances
/// of sums over its pixels and over squares of twice the edge each: as runs tell them, and as nets do. 1
/// where there are no nets.
///
/// The larger the squares, the more is known of how nets complete a mean, and the fewer squares say it: few
/// tiles may have all the noise of a picture. So what squares of one size say is expected of those of the
/// next.
pub fn share_of_mean(sizes: &[Told]) -> f64 {
    /// Squares that are taken to be as expected.
    const PRIOR: f64 = 4.0;
    sizes.iter().fold(1.0, |expected, told| {
        // So many squares would say as much if all had the same noise.
        let squares = told.runs * told.runs / told.squares;
        match squares.is_finite() {
            true => (PRIOR * expected + squares * told.nets / told.runs) / (PRIOR + squares),
            false => expected,
        }
    })
}

/// By how much neighbours raise the degrees of freedom of a variance where they are alike: those of Welch and
/// Satterthwaite.
pub const LENT: f64 = 1.0 / (OWN * OWN + (1.0 - OWN) * (1.0 - OWN) / 8.0);

/// Degrees of freedom of such a variance from `replicates` each.
pub fn degrees(picture: [u32; 2], replicates: u32) -> f64 {
    let own = f64::from(replicates.saturating_sub(1));
    if !is_moderated(picture) {
        return own;
    }
    own * LENT
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nets_say_how_much_too_wide_runs_are() {
        let part = Region { offset: [16, 0], size: [32, 32] };
        let (means, runs) = (vec![1.0; 1024], vec![4.0; 1024]);
        // Half of what the runs say in the left square, as much in the right one.
        let nets: Vec<f64> = part.pixels().map(|[x, _]| if x < 32 { 2.0 } else { 4.0 }).collect();
        let found = calibrated([64, 32], part, Some(&means), &runs, Some(&nets));
        // 512 pixels, then halves down to 32, which expect what all of them say.
        let halves = [512.0, 256.0, 128.0, 64.0, 32.0];
        let left = 4.0 * halves.iter().fold(1.0, |told, n| (PRIOR * told + n / 2.0) / (PRIOR + n));
        let ends = [found[0], found[31]];
        assert!((ends[0] - left).abs() < 1e-12 && (ends[1] - 4.0).abs() < 1e-12, "{ends:?}");
        assert_eq!(calibrated([64, 32], part, Some(&means), &runs, None), runs);
    }

    /// Runs that complete each other in a smooth sky, and a band whose runs know nothing of each other.
    #[test]
    fn pixels_of_a_square_that_are_unlike_do_not_vote_together() {
        let part = Region::whole([32, 32]);
        let by_row = |band: f64, sky: f64| -> Vec<f64> {
            part.pixels().map(|[_, y]| if (14..18).contains(&y) { band } else { sky }).collect()
        };
        let (runs, nets) = (by_row(100.0, 1.0), by_row(100.0, 0.05));
        let found = calibrated([32, 32], part, None, &runs, Some(&nets));
        let [sky, band] = [found[0], found[16 * 32 + 8]];
        assert!(sky < 0.15 && (80.0..=100.0).contains(&band), "{sky} {band}");
    }

    /// An edge and both its sides err alike as runs tell it: only the values tell that nets complete the runs
    /// of some pixels alone.
    #[test]
    fn pixels_on_an_edge_vote_by_themselves() {
        let part = Region::whole([32, 32]);
        let is_edge = |x: u32| (15..17).contains(&x);
        let of = |value: &dyn Fn(u32) -> f64| -> Vec<f64> { part.pixels().map(|[x, _]| value(x)).collect() };
        // A slope of a hundred errors a pixel, with a step of as many.
        let means = of(&|x| 100.0 * f64::from(x) + if x > 15 { 100.0 } else { 0.0 });
        let (runs, nets) = (vec![1.0; 1024], of(&|x| if is_edge(x) { 1.0 } else { 0.05 }));
        let found = calibrated([32, 32], part, Some(&means), &runs, Some(&nets));
        for ([x, _], found) in part.pixels().zip(found) {
            // A square whose pixels vote together has 0.11 for all of them.
            assert!(if is_edge(x) { (0.75..=1.0).contains(&found) } else { found < 0.3 }, "{x}: {found}");
        }
    }

    /// A noisy body in front of a sky as bright whose runs complete each other.
    #[test]
    fn a_small_body_votes_by_itself() {
        let part = Region::whole([32, 32]);
        let is_body = |[x, y]: [u32; 2]| [x, y].iter().all(|place| (10..18).contains(place));
        let of = |body: f64, sky: f64| -> Vec<f64> {
            part.pixels().map(|place| if is_body(place) { body } else { sky }).collect()
        };
        let (runs, nets) = (of(20.0, 1.0), of(20.0, 0.05));
        // As noisy as the nets tell: equally spread with a variance of 1, in an order that looks random.
        let spread = |pixel: usize| (((pixel * 397 + 59) % 1021) as f64 / 1021.0 - 0.5) * 12_f64.sqrt();
        let means: Vec<f64> = nets
            .iter()
            .enumerate()
            .map(|(pixel, variance)| 100.0 + spread(pixel) * variance.sqrt())
            .collect();
        let found = calibrated([32, 32], part, Some(&means), &runs, Some(&nets));
        for (place, found) in part.pixels().zip(found) {
            // If all of the square voted together, each pixel would have 0.14 of what its runs tell.
            let inner = place.iter().all(|place| (11..17).contains(place));
            let outer = place.iter().any(|place| !(9..19).contains(place));
            assert!(!inner || (12.0..=20.0).contains(&found), "{place:?}: {found}");
            assert!(!outer || found < 0.3, "{place:?}: {found}");
        }
    }

    #[test]
    fn what_is_even_may_slope() {
        let size = [4, 5];
        let plane: Vec<f64> =
            (0..20).map(|pixel| 2.0 + 3.0 * f64::from(pixel % 4) - 7.0 * f64::from(pixel / 4)).collect();
        for pixel in 0..20 {
            assert!(uneven(size, &plane, pixel).abs() < 1e-10, "{pixel}");
        }
        // A step s between columns: values 0, 0, s in each of three rows, where a plane leaves s²/2.
        let step: Vec<f64> = (0..20).map(|pixel| if pixel % 4 > 1 { 2.0 } else { 0.0 }).collect();
        assert!((uneven(size, &step, 5) - 2.0).abs() < 1e-12, "{}", uneven(size, &step, 5));
        // The rows above the first go on as it does.
        assert!((uneven(size, &step, 1) - 2.0).abs() < 1e-12);
    }

    #[test]
    fn a_mean_is_as_certain_as_its_squares_say() {
        let alike = |squares: f64, share: f64| Told {
            runs: 2.0 * squares,
            squares: 4.0 * squares,
            nets: 2.0 * squares * share,
        };
        assert_eq!(share_of_mean(&[alike(36.0, 0.25)]), (4.0 + 36.0 / 4.0) / 40.0);
        // One tile has all the noise, and its many pixels say what becomes of it.
        let pixels = (4.0 + 396.0 * 0.3) / 400.0;
        let found = share_of_mean(&[alike(396.0, 0.3), alike(1.0, 1e-3)]);
        assert!((found - (4.0 * pixels + 1e-3) / 5.0).abs() < 1e-12, "{found}");
        assert_eq!([share_of_mean(&[]), share_of_mean(&[Told::default(); 4])], [1.0; 2]);
    }

    #[test]
    fn neighbours_moderate_and_meters_stand_alone() {
        let mut variances = [0.0; 12];
        variances[5] = 24.0; // column 1, row 1 of 4 × 3
        variances[2] = f64::INFINITY;
        let found = moderated([4, 3], [4, 3], &variances);
        assert_eq!(found[5], 16.0);
        // A corner has three neighbours; one has an infinite one that does not count, and stays infinite
        // itself.
        assert!(
            (found[0] - 24.0 / 3.0 / 3.0).abs() < 1e-12 && (found[1] - 24.0 / 3.0 / 4.0).abs() < 1e-12,
            "{found:?}"
        );
        assert_eq!((found[2], found[3], found[7]), (f64::INFINITY, 0.0, 0.0));
        assert_eq!(
            moderated([6, 1], [6, 1], &[1.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
            [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]
        );
        // A part of two columns of a picture that has more.
        assert_eq!(moderated([4, 3], [2, 1], &[9.0, 3.0]), [7.0, 5.0]);
        assert_eq!(degrees([6, 1], 8), 7.0);
        assert!((degrees([4, 3], 8) - 7.0 / (4.0 / 9.0 + 1.0 / 72.0)).abs() < 1e-12);
    }
}
