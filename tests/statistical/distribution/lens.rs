//! Thin lenses: circles of confusion (`validation/transport/circle-of-confusion` makes the claim), the focal
//! plane, polygons.

use super::{compiled, coverage, expose, pixels};
use abbe::film::Film;

/// The lens of the source's example: 50 mm, f/2, focused at 2 m. Metres.
const FOCAL_LENGTH: f64 = 0.05;
const STOP: f64 = 2.0;
const FOCUS: f64 = 2.0;
/// Width and height of the whole film in pixels.
const WHOLE: [f64; 2] = [1536.0, 1152.0];
/// Edge of the part of it that is exposed.
const PART: u32 = 36;

/// How much of a distance the width of a pixel is.
fn per_pixel() -> f64 {
    1e-3 * 36f64.hypot(24.0) * WHOLE[0] / WHOLE[0].hypot(WHOLE[1]) / WHOLE[0] / FOCAL_LENGTH
}

/// The circle of confusion on the film in metres by equation (7) of the source: |V_D − V_P| F / (n V_D), V =
/// F x / (x − F).
fn confusion(depth: f64) -> f64 {
    let image = |x: f64| FOCAL_LENGTH * x / (x - FOCAL_LENGTH);
    (image(depth) - image(FOCUS)).abs() * FOCAL_LENGTH / (STOP * image(depth))
}

/// A disk of 4 pixels' diameter at `depth`, `off` pixels to the right of the axis, in the middle of what is
/// exposed.
fn spot(depth: f64, off: f64, lens: &str) -> Film {
    let [width, height] = WHOLE;
    let corner = |whole: f64, off: f64| 0.5 * (whole - f64::from(PART)) + off;
    let scene = compiled(&format!(
        r#"<sensor type="thinlens"><string name="focal_length" value="50mm"/><float name="f_stop" value="{STOP}"/>
           <float name="focus_distance" value="{FOCUS}"/><float name="far_clip" value="1e7"/>{lens}
           <transform name="to_world"><lookat origin="0, 0, 0" target="0, 0, -1" up="0, 1, 0"/></transform>
           <film type="hdrfilm"><string name="pixel_format" value="rgba"/><rfilter type="box"/>
           <integer name="width" value="{width}"/><integer name="height" value="{height}"/>
           <integer name="crop_width" value="{PART}"/><integer name="crop_height" value="{PART}"/>
           <integer name="crop_offset_x" value="{}"/><integer name="crop_offset_y" value="{}"/></film></sensor>
           <shape type="disk"><transform name="to_world"><scale value="{}"/><translate x="{}" z="{}"/></transform></shape>"#,
        corner(width, off),
        corner(height, 0.0),
        2.0 * per_pixel() * depth,
        off * per_pixel() * depth,
        -depth,
    ));
    expose(&scene, 8, 64, 5)
}

/// Centre and variance along x and y of the picture's distribution, and all that is in it.
fn moments(film: &Film) -> ([f64; 2], [f64; 2], f64) {
    let (mut sum, mut first, mut second) = (0.0, [0.0; 2], [0.0; 2]);
    for (x, y) in pixels(film) {
        let weight = coverage(film, x, y).mean;
        let place = [x, y].map(|i| f64::from(i) + 0.5 - 0.5 * f64::from(PART));
        sum += weight;
        for axis in 0..2 {
            first[axis] += weight * place[axis];
            second[axis] += weight * place[axis] * place[axis];
        }
    }
    let centre = first.map(|c| c / sum);
    let variance = [0, 1].map(|i| second[i] / sum - centre[i] * centre[i]);
    (centre, variance, sum)
}

/// The furthest pixel from the centre that sees anything of the disk, in pixels.
fn reach(film: &Film, centre: [f64; 2]) -> f64 {
    let seen = pixels(film).filter(|&(x, y)| coverage(film, x, y).mean > 0.0);
    let distance = |(x, y): (u32, u32)| {
        let [dx, dy] =
            [(x, centre[0]), (y, centre[1])].map(|(i, c)| f64::from(i) + 0.5 - 0.5 * f64::from(PART) - c);
        dx.hypot(dy)
    };
    seen.map(distance).fold(0.0, f64::max)
}

#[test]
fn the_blur_of_a_point_has_the_diameter_of_equation_7() {
    // At V_P a pixel is this wide on the film.
    let pixel = per_pixel() * FOCAL_LENGTH * FOCUS / (FOCUS - FOCAL_LENGTH);
    for (depth, millimetres) in [(4.0, 0.3205128205), (1.0, 0.6410256410), (1e6, 0.6410256410)] {
        assert!((1e3 * confusion(depth) - millimetres).abs() < 1e-5, "{}", confusion(depth));
        for off in [0.0, 600.0] {
            let film = spot(depth, off, "");
            let (centre, variance, sum) = moments(&film);
            // An evenly lit disk of radius R has the variance R²/4 along each axis. The source's own and a
            // pixel's come on top.
            let own = 0.5 * (variance[0] + variance[1]) - 1.0 / 12.0 - 2.0 * 2.0 / 4.0;
            let diameter = 4.0 * own.sqrt() * pixel;
            let deviation = diameter / confusion(depth) - 1.0;
            println!("{depth} m, {off} pixels off: {:.4} mm, {:+.2} %", 1e3 * diameter, 100.0 * deviation);
            assert!(deviation.abs() < 0.02, "at {depth} m the blur is {diameter} m wide");
            // In the right place, and nothing lost.
            assert!(centre.iter().all(|c| c.abs() < 0.3), "{centre:?}");
            let area = std::f64::consts::PI * 4.0;
            assert!((sum / area - 1.0).abs() < 0.05, "{sum} of {area}");
            // Evenly lit up to a rim, and nothing beyond.
            let rim = 0.5 * confusion(depth) / pixel + 2.0;
            let reach = reach(&film, centre);
            assert!((reach - rim).abs() < 1.0, "the blur reaches {reach} pixels of {rim}");
        }
    }
}

#[test]
fn the_focal_surface_is_a_plane() {
    for off in [0.0, 740.0] {
        let film = spot(FOCUS, off, "");
        let (_, variance, _) = moments(&film);
        let reach = reach(&film, [0.0; 2]);
        println!("{off} pixels off, in the plane: variance {variance:?}, reach {reach}");
        // No more than the disk itself of radius 2, and half of a pixel's diagonal.
        assert!(reach < 2.0 + 0.75, "{off} pixels off the axis a point in the plane is blurred: {reach}");
        // As far away from the lens as the plane is on the axis.
        let slant = off * per_pixel();
        let depth = FOCUS / slant.hypot(1.0);
        let wide = 0.5 * confusion(depth) / per_pixel() / FOCAL_LENGTH;
        let (_, variance, _) = moments(&spot(depth, off, ""));
        println!("{off} pixels off, on the sphere: variance {variance:?}, expected blur radius {wide:.2}");
        let expected = 1.0 + 1.0 / 12.0 + wide * wide / 4.0;
        assert!((0.5 * (variance[0] + variance[1]) / expected - 1.0).abs() < 0.05, "{variance:?} {expected}");
    }
}

#[test]
fn blades_show_in_the_blur() {
    // Beyond the focal plane the picture of the aperture is upright: its corner on top for rotation 0.
    let film = |angle: f64| {
        let lens = format!(
            r#"<integer name="aperture_blades" value="3"/><float name="aperture_rotation" value="{angle}"/>"#
        );
        spot(1e6, 0.0, &lens)
    };
    let upper = |film: &Film| {
        let rows = |from: u32, to: u32| -> f64 {
            (from..to)
                .flat_map(|y| (0..PART).map(move |x| (x, y)))
                .map(|(x, y)| coverage(film, x, y).mean)
                .sum()
        };
        rows(0, PART / 2) / rows(0, PART)
    };
    // 5/9 of a triangle lie on the base's side of its middle: 1 − (1 − 1/3)² = 5/9.
    let films = [film(0.0), film(60.0)];
    let shares = films.each_ref().map(upper);
    println!("shares of the upper half: {shares:?}");
    assert!(shares[0] < 0.46 && shares[1] > 0.54, "{shares:?}");
    // A triangle in a circle of radius R has the variance R²/8 along each axis.
    let radius = 0.5 * confusion(1e6) / (per_pixel() * FOCAL_LENGTH * FOCUS / (FOCUS - FOCAL_LENGTH));
    let (_, variance, _) = moments(&films[0]);
    let expected = 1.0 + 1.0 / 12.0 + radius * radius / 8.0;
    assert!((0.5 * (variance[0] + variance[1]) / expected - 1.0).abs() < 0.04, "{variance:?} {expected}");
}
