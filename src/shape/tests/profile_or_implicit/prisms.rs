//! Polygons and extrusions.

use super::{double, kinds, letter, new_shape};
use crate::geometry::{Ray, Transform, Vec3};
use crate::shape::tests::doubled::{Doubled, Polynomial};
use crate::shape::tests::oracle::{Exact, Line, SURE_FROM, Tally, check_against, near};
use crate::shape::tests::{close, direction, placement};
use crate::shape::{FillRule, ProfileOrImplicitKind};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg as Random;

/// Where a line's projection crosses the boundary, and whether it enters; with how near it passes a corner.
fn across_outline(line: &Line, contours: &[Vec<[f64; 2]>], rule: FillRule) -> (Vec<(Doubled, bool)>, f64) {
    let Line([x, y, _]) = line;
    let across = [x.0[1], y.0[1]];
    let length = (across[0] * across[0] + across[1] * across[1]).sqrt();
    let side = |corner: [f64; 2]| {
        let away = [double(corner[0]) - x.0[0], double(corner[1]) - y.0[0]];
        across[0] * away[1] - across[1] * away[0]
    };
    let mut doubt = f64::INFINITY;
    let mut all: Vec<(Doubled, i32)> = Vec::new();
    for contour in contours {
        for (i, &from) in contour.iter().enumerate() {
            let to = contour[(i + 1) % contour.len()];
            let (a, b) = (side(from), side(to));
            doubt = doubt.min((a / length).high.abs());
            if (a.high > 0.0) == (b.high > 0.0) {
                continue;
            }
            let at = a / (a - b);
            let place = [0, 1].map(|k| double(from[k]) + (double(to[k]) - double(from[k])) * at);
            let t = ((place[0] - x.0[0]) * across[0] + (place[1] - y.0[0]) * across[1]) / (length * length);
            all.push((t, if b.high > a.high { 1 } else { -1 }));
        }
    }
    all.sort_by(|a, b| (a.0 - b.0).high.total_cmp(&0.0));
    let (mut winding, mut inside) = (0, false);
    let mut found = Vec::new();
    for (t, turn) in all {
        winding += turn;
        let now = if rule == FillRule::EvenOdd { winding & 1 != 0 } else { winding != 0 };
        if now != inside {
            inside = now;
            found.push((t, now));
        }
    }
    (found, doubt)
}

/// Whether a point is over the inside, by a line through it, and how near that passes a corner or the point
/// an edge.
fn over_inside(point: [Doubled; 2], contours: &[Vec<[f64; 2]>], rule: FillRule) -> (bool, f64) {
    let coordinate = |k: usize, slope: f64| Polynomial(vec![point[k], double(slope)]);
    let line = Line([coordinate(0, 0.8), coordinate(1, 0.6), Polynomial::constant(0.0)]);
    let (walls, doubt) = across_outline(&line, contours, rule);
    let behind = walls.iter().filter(|(t, _)| t.high < 0.0).count();
    (behind % 2 == 1, walls.iter().fold(doubt, |doubt, (t, _)| doubt.min(t.high.abs())))
}

/// By intervals: where the line is over the inside, and where between the planes.
fn prism(line: &Line, kind: &ProfileOrImplicitKind) -> (Vec<(Doubled, bool)>, f64) {
    let Line([x, y, z]) = line;
    let upright = x.0[1].high == 0.0 && y.0[1].high == 0.0;
    match kind {
        ProfileOrImplicitKind::Polygon { contours, rule } => {
            let t = -z.0[0] / z.0[1];
            let (inside, doubt) = over_inside([x.at(t), y.at(t)], contours, *rule);
            let there = inside && z.0[1].high != 0.0;
            (if there { vec![(t, z.0[1].high < 0.0)] } else { Vec::new() }, doubt)
        }
        ProfileOrImplicitKind::Extrusion { contours, rule, heights, capped } => {
            let (walls, mut doubt) = across_outline(line, contours, *rule);
            let mut planes = heights.map(|height| (double(height) - z.0[0]) / z.0[1]);
            if z.0[1].high < 0.0 {
                planes.swap(0, 1);
            } else if z.0[1].high == 0.0 {
                let [below, above] = heights.map(|height| (double(height) - z.0[0]).high);
                planes = if below < 0.0 && above > 0.0 {
                    [double(-1e30), double(1e30)]
                } else {
                    [double(1e30); 2]
                };
                doubt = doubt.min(below.abs()).min(above.abs());
            }
            for (wall, _) in &walls {
                for plane in planes {
                    doubt = doubt.min(((*wall - plane) * z.0[1]).high.abs());
                }
            }
            let [enter, leave] = planes;
            let mut found = Vec::new();
            if upright {
                let (inside, doubt) = over_inside([x.0[0], y.0[0]], contours, *rule);
                let ends = if inside && *capped { vec![(enter, true), (leave, false)] } else { Vec::new() };
                return (ends, doubt);
            }
            if !capped {
                found.extend(
                    walls.into_iter().filter(|(t, _)| (*t - enter).high > 0.0 && (leave - *t).high > 0.0),
                );
                return (found, doubt);
            }
            for pair in walls.chunks(2) {
                let later = if (pair[0].0 - enter).high > 0.0 { pair[0].0 } else { enter };
                let sooner = if (pair[1].0 - leave).high > 0.0 { leave } else { pair[1].0 };
                if (sooner - later).high > 0.0 {
                    found.extend([(later, true), (sooner, false)]);
                }
            }
            (found, doubt)
        }
        _ => unreachable!(),
    }
}

fn check_prisms(rays: u32) {
    let mut tally = Tally::default();
    let flat = |kind: &ProfileOrImplicitKind| {
        matches!(kind, ProfileOrImplicitKind::Polygon { .. } | ProfileOrImplicitKind::Extrusion { .. })
    };
    for (i, (name, kind)) in kinds().into_iter().filter(|kind| flat(&kind.1)).enumerate() {
        for (j, (scale, distance)) in
            [(0.0, 0.0), (1.0, 0.0), (1e-6, 1e-3), (1e6, 1e8)].into_iter().enumerate()
        {
            let to_world = match scale {
                0.0 => Transform::IDENTITY,
                _ => placement(Vec3::new(0.9, 0.5, 0.3) * scale)
                    .then(&Transform::translation(Vec3::new(0.6, -0.8, 0.2) * distance)),
            };
            let shape = new_shape(&to_world, &kind);
            // The place of the line's parameter 0 moves with the shape.
            let exact = |ray: &Ray| {
                let (found, _) = prism(&Line::new(ray, &to_world), &kind);
                found.into_iter().map(|(t, enters)| Exact { t: t + near(ray).into(), enters }).collect()
            };
            let doubt = |ray: &Ray| {
                let origin = to_world.inverse().point(ray.origin).length();
                let there = distance / if scale == 0.0 { 1.0 } else { scale };
                prism(&Line::new(ray, &to_world), &kind).1 / (1.0 + origin + 10.0 * there)
                    * (1.0 + ray.origin.length())
            };
            tally += check_against(name, &shape, exact, doubt, rays, (10 * i + j) as u64);
        }
    }
    tally.tell("prisms", SURE_FROM);
}

#[test]
fn prisms_are_crossed_where_the_oracle_says() {
    check_prisms(crate::stress::count(4_000, 250_000));
}

/// A ray meets exactly one of polygons that share an edge, whatever their sizes and wherever they are placed.
#[test]
fn neighbours_leave_no_gap_and_no_overlap() {
    let mut random = Random::seed_from_u64(4);
    for _ in 0..200 {
        let mut any = || [random.random_range(-1.0..1.0), random.random_range(-1.0..1.0)];
        let (a, b) = (any(), any());
        let place = placement(Vec3::new(0.9, 0.5, 0.3) * 10f64.powf(random.random_range(-6.0..6.0)));
        let polygon = |far: [f64; 2]| {
            let contours = vec![vec![a, far, b]];
            new_shape(&place, &ProfileOrImplicitKind::Polygon { contours, rule: FillRule::EvenOdd })
        };
        // Far corners on both sides of the edge, one of them ten times as far away.
        let across = [a[1] - b[1], b[0] - a[0]];
        let corner = |side: f64| [0, 1].map(|k| 0.5 * (a[k] + b[k]) + side * across[k]);
        let sides = [polygon(corner(1.0)), polygon(corner(-10.0))];
        for _ in 0..500 {
            let at: f64 = random.random_range(0.01..0.99);
            let on_edge = [0, 1].map(|k| a[k] + at * (b[k] - a[k]));
            let target = place.point(Vec3::new(on_edge[0], on_edge[1], 0.0));
            let toward = direction(&mut random);
            let ray = Ray::new(target - toward * place.vector(Vec3::X).length(), toward);
            let met = sides.iter().filter(|side| side.intersect(&ray).is_some()).count();
            assert_eq!(met, 1, "{ray:?}");
        }
    }
}

/// Areas of the letter by the shoelace formula, of walls by their lengths.
#[test]
fn areas_are_those_of_closed_forms() {
    let shoelace = |contour: &[[f64; 2]]| -> f64 {
        let twice = |(i, a): (usize, &[f64; 2])| {
            let b = contour[(i + 1) % contour.len()];
            a[0] * b[1] - a[1] * b[0]
        };
        0.5 * contour.iter().enumerate().map(twice).sum::<f64>().abs()
    };
    let length = |contour: &[[f64; 2]]| -> f64 {
        let side = |(i, a): (usize, &[f64; 2])| {
            let b = contour[(i + 1) % contour.len()];
            (a[0] - b[0]).hypot(a[1] - b[1])
        };
        contour.iter().enumerate().map(side).sum()
    };
    let (inside, around) =
        (shoelace(&letter()[0]) - shoelace(&letter()[1]), length(&letter()[0]) + length(&letter()[1]));
    let made = |name: &str| kinds().into_iter().find(|kind| kind.0 == name).unwrap().1;
    let area = |name: &str| new_shape(&Transform::scale(3.0), &made(name)).area() / 9.0;
    assert!(close(area("polygon"), inside, 1e-14));
    assert!(close(area("open prism"), around * 0.75, 1e-14));
    assert!(close(area("prism"), 2.0 * inside + around * 0.75, 1e-14));
}
