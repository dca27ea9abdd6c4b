//! Every warp follows its density whichever sampler feeds it.

use super::random_kinds;
use abbe::geometry::Vec3;
use abbe::sampling::{Dimensions, Sampler, warp};
use abbe::stats::{SphereCells, chi_square, sidak, sphere_chi_square};
use std::f64::consts::PI;

/// One sample of each pixel, every index in turn: pixels are independent, or (for blue noise) more even than
/// that.
fn draws(sampler: &Sampler, dimensions: Dimensions) -> impl Iterator<Item = [f64; 4]> {
    (0u32..).map(move |pixel| sampler.stream([pixel % 300, pixel / 300], 0, pixel % 16).draw(dimensions))
}

#[test]
fn directions_and_disks_follow_their_densities() {
    const COUNT: usize = 60_000;
    for (name, kind) in random_kinds() {
        let sampler = Sampler::new(kind, 21, 16);
        let level = sidak(1e-3, 15);
        let mut values = draws(&sampler, Dimensions::Scattering(0));
        let cells = SphereCells { rows: 10, columns: 20 };
        let cosine = sphere_chi_square(
            cells,
            COUNT as u64,
            |_| values.next().map(|[u, v, ..]| Vec3::from(warp::cosine_hemisphere([u, v]))),
            |direction: Vec3| direction.z.max(0.0) / PI,
        );
        assert!(cosine.p_value > level, "{name}, cosine: {cosine}");
        // The disk in rings and sectors of equal area; each value in 64 parts.
        let mut disk = vec![0.0; 10 * 16];
        let mut parts = [[0.0; 64]; 4];
        for values in draws(&sampler, Dimensions::Lens).take(COUNT) {
            let [x, y] = warp::disk([values[0], values[1]]);
            let ring = ((x * x + y * y) * 10.0) as usize;
            let sector = ((y.atan2(x) / PI + 1.0) * 8.0) as usize;
            disk[ring.min(9) * 16 + sector.min(15)] += 1.0;
            (0..4).for_each(|d| parts[d][(values[d] * 64.0) as usize] += 1.0);
        }
        let disk = chi_square(&disk, &[COUNT as f64 / 160.0; 160]);
        assert!(disk.p_value > level, "{name}, disk: {disk}");
        for (dimension, parts) in parts.iter().enumerate() {
            let fit = chi_square(parts, &[COUNT as f64 / 64.0; 64]);
            assert!(fit.p_value > level, "{name}, value {dimension}: {fit}");
        }
    }
}
