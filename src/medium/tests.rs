//! What is integrated exactly against what is summed up finely.

use super::{FreeFlight, GridExtinction};
use crate::geometry::{Ray, Transform, Vec3};
use crate::raster::Grid;
use crate::texture::{Filter, Volume, Wrap};
use glam::DMat4;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

const NM: [f64; 3] = [450.0, 550.0, 650.0];

fn grids() -> Vec<(String, GridExtinction)> {
    let mut random = Pcg64Mcg::seed_from_u64(3);
    let mut found = Vec::new();
    for channels in [1, 3] {
        for filter in [Filter::Linear, Filter::Nearest] {
            for wrap in [Wrap::Clamp, Wrap::Repeat, Wrap::Mirror] {
                for size in [[1, 1, 1], [4, 3, 2], [5, 1, 7]] {
                    let count = size.iter().product::<usize>() * channels;
                    let values = (0..count).map(|_| random.random::<f32>()).collect();
                    let grid = Grid { size, channels, values, corners: [Vec3::ZERO, Vec3::ONE] };
                    // Turned, stretched and moved.
                    let turn = DMat4::from_axis_angle(Vec3::new(1.0, 2.0, -1.0).normalize(), 0.7);
                    let stretch = DMat4::from_scale(Vec3::new(0.7, 1.1, 0.9));
                    let offset = DMat4::from_translation(Vec3::new(0.3, 0.4, 0.6));
                    let to_local = Transform::new(offset * turn * stretch).unwrap();
                    let volume = Volume::new(&grid, to_local, filter, wrap, false);
                    found.push((
                        format!("{channels} channels, {filter:?}, {wrap:?}, {size:?}"),
                        GridExtinction { volume, factor: 2.5 },
                    ));
                }
            }
        }
    }
    found
}

fn rays() -> Vec<Ray> {
    let mut random = Pcg64Mcg::seed_from_u64(4);
    let mut point =
        |scale: f64| Vec3::from_array(std::array::from_fn(|_| scale * (random.random::<f64>() - 0.5)));
    (0..12)
        .map(|i| {
            let (from, to) = (point(6.0), point(1.0));
            let t_max = if i % 3 == 0 { (to - from).length() } else { f64::INFINITY };
            Ray { t_max, ..Ray::new(from, (to - from).normalize()) }
        })
        .collect()
}

#[test]
fn optical_depths_are_those_of_a_fine_sum() {
    const CELLS: u32 = 40_000;
    for (name, grid) in grids() {
        for ray in rays() {
            let exact = grid.optical_depths(&ray, &NM);
            let end = ray.t_max.min(12.0);
            let step = end / f64::from(CELLS);
            let mut sum = crate::spectrum::Sampled::ZERO;
            for i in 0..CELLS {
                sum += grid.at(ray.at((f64::from(i) + 0.5) * step), &NM) * step;
            }
            for lane in 0..3 {
                let (exact, sum) = (exact[lane], sum[lane]);
                // Where values jump the sum is wrong by up to a cell for each.
                assert!((exact - sum).abs() < 2e-3, "{name}: {exact}, summed up {sum}");
            }
        }
    }
}

/// Up to the place where a flight ends lies the optical depth that it was given.
#[test]
fn flights_end_where_the_depth_is_reached() {
    let mut ended = 0;
    for (name, grid) in grids() {
        for ray in rays() {
            let whole = grid.optical_depths(&ray, &NM);
            for fraction in [1e-9, 0.1, 0.5, 0.999, 1.001] {
                let target = fraction * whole.hero();
                match grid.fly(&ray, target, &NM) {
                    FreeFlight::Ended { distance, depths, extinction } => {
                        ended += 1;
                        assert!(fraction < 1.0, "{name}: ended beyond the end");
                        let up_to = grid.optical_depths(&Ray { t_max: distance, ..ray }, &NM);
                        assert!((depths.hero() - target).abs() < 1e-9, "{name}: {depths:?} for {target}");
                        for lane in 0..3 {
                            assert!(
                                (up_to[lane] - depths[lane]).abs() < 1e-9,
                                "{name}: {up_to:?} {depths:?}"
                            );
                        }
                        let there = grid.at(ray.at(distance), &NM);
                        let near = |lane: usize| (there[lane] - extinction[lane]).abs() < 1e-6;
                        assert!(near(0) && near(1) && near(2), "{name}: {there:?} {extinction:?}");
                    }
                    FreeFlight::Passed { depths } => {
                        assert!(
                            fraction > 1.0 || whole.hero() == 0.0,
                            "{name}: passed at {fraction} of the depth"
                        );
                        assert!((depths.hero() - whole.hero()).abs() < 1e-12, "{name}");
                    }
                }
            }
        }
    }
    assert!(ended > 500, "{ended} flights ended");
}
