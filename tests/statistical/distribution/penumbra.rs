//! The penumbra behind a straight edge, against the integral over the part of the lamp that is seen from each
//! place; `validation/transport/penumbra` makes the claim.

use super::{assert_agree, compiled, expose, film, radiance};
use abbe::stats::Estimate;
use std::f64::consts::PI;

/// Heights of the lamp and of the edge above the floor.
const LAMP: f64 = 4.0;
const EDGE: f64 = 1.5;
const REFLECTANCE: f64 = 0.6;

#[derive(Clone, Copy)]
enum Lamp {
    Disk {
        radius: f64,
    },
    /// Half the extents across and along the edge.
    Rectangle {
        half: [f64; 2],
    },
}

impl Lamp {
    /// Half its extents across the edge, and along it at the place `x`.
    fn half(self) -> (f64, impl Fn(f64) -> f64) {
        let across = match self {
            Self::Disk { radius } => radius,
            Self::Rectangle { half } => half[0],
        };
        let along = move |x: f64| match self {
            Self::Disk { radius } => (radius * radius - x * x).max(0.0).sqrt(),
            Self::Rectangle { half } => half[1],
        };
        (across, along)
    }

    fn shape(self) -> String {
        let light = r#"<emitter type="area"><spectrum name="radiance" value="1"/></emitter>"#;
        // Turned to look down.
        let (shape, scale) = match self {
            Self::Disk { radius } => ("disk", format!(r#"<scale value="{radius}"/>"#)),
            Self::Rectangle { half: [x, y] } => ("rectangle", format!(r#"<scale x="{x}" y="{y}"/>"#)),
        };
        format!(
            r#"<shape type="{shape}"><transform name="to_world">{scale}<rotate x="1" angle="180"/>
               <translate z="{LAMP}"/></transform>{light}</shape>"#
        )
    }
}

/// What the floor at x returns where all X < 0 at the height of the edge is covered, for a lamp of radiance
/// 1: ρ/π ∫ cos² / r² dA over what is seen, by the midpoint rule.
fn expected(lamp: Lamp, x: f64, y: f64) -> f64 {
    const STEPS: usize = 160;
    let (across, along) = lamp.half();
    // The line from (x, 0) to a place q of the lamp passes the edge's height at x + (q − x) EDGE/LAMP.
    let from = (x - x * LAMP / EDGE).max(-across);
    if from >= across {
        return 0.0;
    }
    // Denser towards both ends, where the disk's edge is steep.
    let mut sum = 0.0;
    for i in 0..STEPS {
        let angle = PI * (i as f64 + 0.5) / STEPS as f64;
        let middle = 0.5 * (from + across);
        let (q, width) = (
            middle - 0.5 * (across - from) * angle.cos(),
            0.5 * (across - from) * angle.sin() * PI / STEPS as f64,
        );
        let half = along(q);
        for j in 0..STEPS {
            let s = half * (2.0 * (j as f64 + 0.5) / STEPS as f64 - 1.0);
            let squared = (q - x).powi(2) + (s - y).powi(2) + LAMP * LAMP;
            // Both cosines are LAMP / r.
            sum += LAMP * LAMP / (squared * squared) * width * 2.0 * half / STEPS as f64;
        }
    }
    REFLECTANCE / PI * sum
}

const WIDTH: u32 = 60;
/// Half of what the film sees of the floor across the edge.
const HALF: f64 = 1.5;

fn check(name: &str, lamp: Lamp) {
    // The camera looks from the side that is open, so that nothing covers the floor: along the edge two
    // pixels.
    let scene = compiled(&format!(
        r#"<integrator type="path"><integer name="max_depth" value="2"/></integrator>
           <sensor type="orthographic"><transform name="to_world"><scale x="{HALF}" y="{HALF}"/>
           <matrix value="-1 0 -1 20  0 1 0 0  0 0 -1 20  0 0 0 1"/></transform>{}</sensor>
           <shape type="rectangle"><transform name="to_world"><scale value="50"/></transform>
           <bsdf type="diffuse"><spectrum name="reflectance" value="{REFLECTANCE}"/></bsdf></shape>
           <shape type="rectangle"><transform name="to_world"><scale value="10"/>
           <translate x="-10" z="{EDGE}"/></transform></shape>{}"#,
        film(WIDTH, 2),
        lamp.shape(),
    ));
    let film = expose(&scene, 16, 256, 3);
    let pixel = 2.0 * HALF / f64::from(WIDTH);
    let pairs = (0..WIDTH).flat_map(|i| (0..2).map(move |j| (i, j))).map(|(i, j)| {
        let centre = (f64::from(i) + 0.5) * pixel - HALF;
        let y = (0.5 - f64::from(j)) * pixel;
        let parts = 8;
        let at = |k: u32| expected(lamp, centre + pixel * ((f64::from(k) + 0.5) / f64::from(parts) - 0.5), y);
        let expected = (0..parts).map(at).sum::<f64>() / f64::from(parts);
        (radiance(&film, i, j), Estimate::exact(expected))
    });
    let pairs: Vec<_> = pairs.collect();
    let full = REFLECTANCE / PI * PI / (LAMP * LAMP);
    assert!(pairs.iter().any(|p| p.1.mean == 0.0) && pairs.iter().any(|p| p.1.mean > 0.2 * full));
    // Where the lamp is seen by less than one path in hundreds, means are not normal.
    let judged = pairs.into_iter().filter(|(found, expected)| {
        assert!(expected.mean > 0.0 || found.mean == 0.0, "light in the umbra: {found:?}");
        expected.mean == 0.0 || expected.mean > 0.01 * full
    });
    assert_agree(name, judged);
}

#[test]
fn the_penumbra_of_a_disk_behind_an_edge() {
    check("disk", Lamp::Disk { radius: 1.0 });
}

#[test]
fn the_penumbra_of_a_rectangle_behind_an_edge() {
    check("rectangle", Lamp::Rectangle { half: [0.8, 0.4] });
}
