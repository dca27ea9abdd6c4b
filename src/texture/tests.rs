use super::*;
use crate::geometry::Transform;
use crate::geometry::UvTransform;
use crate::raster::{Grid, Image, luminance};
use crate::shape::{AtRest, Mesh, MeshAttribute, MeshData};

const NM: [f64; 4] = [450.0, 550.0, 600.0, 650.0];

fn at(u: f64, v: f64) -> TexturePoint<'static> {
    TexturePoint { uv: [u, v], position: Vec3::ZERO, at_rest: AtRest::NONE, mesh: None }
}

fn placing(filter: Filter, wrap: Wrap) -> Placing {
    Placing { to_uv: UvTransform::IDENTITY, filter, wrap }
}

fn bitmap(image: &Image, placing: Placing, raw: bool) -> Texture {
    Texture::Bitmap(Box::new(Bitmap::new(image, placing, raw, false)))
}

/// 2 × 2 texels in colour.
fn colours() -> Image {
    let values = vec![0.9, 0.1, 0.1, 0.1, 0.8, 0.2, 0.2, 0.3, 0.9, 0.5, 0.4, 0.3];
    Image::new(2, 2, 3, values, false)
}

/// 3 × 2 texels from 0 to 0.5.
fn greys() -> Image {
    Image::new(3, 2, 1, vec![0.0, 0.1, 0.2, 0.3, 0.4, 0.5], false)
}

fn close(found: &[f64], expected: &[f64], tolerance: f64) {
    let same = found.iter().zip(expected).all(|(a, b)| (a - b).abs() <= tolerance);
    assert!(same && found.len() == expected.len(), "{found:?}, not {expected:?}");
}

/// All numbers in this file: `eval`, `eval_1`, `eval_3`, `eval_1_grad` of Mitsuba 3.9.1, scalar_spectral.
#[test]
fn colours_are_interpolated_as_spectra() {
    let texture = bitmap(&colours(), placing(Filter::Linear, Wrap::Repeat), false);
    close(&texture.sample(&at(0.25, 0.25), &NM).0, &[0.101807, 0.117833, 0.613048, 0.965504], 2e-5);
    close(&texture.sample(&at(0.4, 0.3), &NM).0, &[0.179711, 0.313479, 0.511681, 0.657069], 2e-5);
    close(&texture.sample(&at(1.2, -0.3), &NM).0, &[0.745771, 0.275485, 0.282042, 0.40042], 2e-5);
    let nearest = bitmap(&colours(), placing(Filter::Nearest, Wrap::Repeat), false);
    close(&nearest.sample(&at(0.5, 0.5), &NM).0, &[0.308752, 0.407094, 0.457507, 0.506384], 2e-5);
}

#[test]
fn raw_images_give_numbers() {
    let texture = bitmap(&colours(), placing(Filter::Linear, Wrap::Repeat), true);
    close(&texture.rgb(&at(0.4, 0.3)), &[0.623, 0.312, 0.189], 1e-6);
    close(&[texture.value(&at(0.4, 0.3))], &[0.369264], 1e-6);
    close(&texture.gradient(&at(0.4, 0.3)), &[0.626249, -0.043611], 1e-6);
}

#[test]
fn wrap_modes_are_mitsubas() {
    let places = [
        (-0.1, 0.25),
        (-0.4, 0.25),
        (1.1, 0.25),
        (1.4, -0.3),
        (0.1, 0.6),
        (0.0, 0.0),
        (1.0, 1.0),
        (0.5, 0.5),
        (2.3, 1.7),
        (-1.3, -2.6),
    ];
    let expected = [
        (Wrap::Repeat, Filter::Nearest, [0.2, 0.1, 0.0, 0.4, 0.3, 0.0, 0.0, 0.4, 0.3, 0.2]),
        (Wrap::Repeat, Filter::Linear, [0.16, 0.13, 0.04, 0.34, 0.25, 0.25, 0.25, 0.25, 0.31, 0.25]),
        (Wrap::Mirror, Filter::Nearest, [0.0, 0.1, 0.2, 0.1, 0.3, 0.0, 0.5, 0.4, 0.0, 0.5]),
        (Wrap::Mirror, Filter::Linear, [0.0, 0.07, 0.2, 0.16, 0.21, 0.0, 0.5, 0.25, 0.07, 0.37]),
        (Wrap::Clamp, Filter::Nearest, [0.0, 0.0, 0.2, 0.2, 0.3, 0.0, 0.5, 0.4, 0.5, 0.0]),
        (Wrap::Clamp, Filter::Linear, [0.0, 0.0, 0.2, 0.2, 0.21, 0.0, 0.5, 0.25, 0.5, 0.0]),
    ];
    for (wrap, filter, values) in expected {
        let texture = bitmap(&greys(), placing(filter, wrap), true);
        let found = places.map(|(u, v)| texture.value(&at(u, v)));
        close(&found, &values, 1e-6);
    }
}

#[test]
fn slopes_turn_before_they_scale() {
    let image = greys();
    let slope = |to_uv, u, v| {
        bitmap(&image, Placing { to_uv, ..placing(Filter::Linear, Wrap::Repeat) }, true).gradient(&at(u, v))
    };
    close(&slope(UvTransform::IDENTITY, 0.2, 0.3), &[0.3, 0.6], 1e-6);
    close(&slope(UvTransform([[2.0, 0.0, 0.0], [0.0, 3.0, 0.0]]), 0.1, 0.1), &[0.6, 1.8], 1e-6);
    close(&slope(UvTransform([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0]]), 0.1, 0.3), &[-0.9, -0.2], 1e-6);
    let nearest = bitmap(&image, placing(Filter::Nearest, Wrap::Repeat), true);
    assert_eq!(nearest.gradient(&at(0.2, 0.3)), [0.0; 2]);
}

#[test]
fn coordinates_that_are_no_numbers_do_no_harm() {
    let texture = bitmap(&colours(), placing(Filter::Linear, Wrap::Mirror), false);
    for u in [f64::NAN, f64::INFINITY, -1e300, 1e18] {
        let value = texture.sample(&at(u, -u), &NM).0;
        assert!(value.iter().all(|value| (0.0..=1.0).contains(value)), "{u}: {value:?}");
    }
}

#[test]
fn boards_change_sides_for_numbers() {
    let grey = Image::new(2, 2, 1, vec![0.2, 0.4, 0.6, 0.8], false);
    let board = |colours, to_uv| Texture::Checkerboard(Box::new(Checkerboard { colours, to_uv }));
    let constant = |value| Texture::Uniform(Spectrum::Constant(value));
    let plain = board([constant(0.4), constant(0.2)], UvTransform::IDENTITY);
    for (u, v, value) in [
        (0.25, 0.25, 0.4),
        (0.75, 0.25, 0.2),
        (0.25, 0.75, 0.2),
        (0.75, 0.75, 0.4),
        (1.25, 0.25, 0.4),
        (-0.25, 0.25, 0.2),
        (0.5, 0.25, 0.4),
        (0.25, 0.5, 0.4),
    ] {
        assert_eq!(plain.sample(&at(u, v), &NM), Sampled::splat(value), "{u} {v}");
        assert!((plain.value(&at(u, v)) - (0.6 - value)).abs() < 1e-12, "{u} {v}");
    }
    let doubled = UvTransform([[2.0, 0.0, 0.0], [0.0, 2.0, 0.0]]);
    let nested = board([bitmap(&grey, placing(Filter::Linear, Wrap::Repeat), true), plain], doubled);
    for (u, v, value) in [(0.1, 0.1, 0.38), (0.2, 0.1, 0.34), (0.1, 0.3, 0.4), (0.7, 0.7, 0.74)] {
        close(&nested.sample(&at(u, v), &NM).0, &[value; 4], 1e-6);
    }
}

#[test]
fn a_colour_as_a_number_is_its_mean() {
    let red = Texture::Uniform(Spectrum::Sigmoid { shape: upsample([0.9, 0.1, 0.1]), factor: 1.0 });
    close(&[red.value(&at(0.0, 0.0))], &[0.631762], 1e-5);
}

#[test]
fn grids_are_looked_up_in_space() {
    let volume = |grid: &Grid, to_local, raw| {
        Texture::Volume(Box::new(Volume::new(grid, to_local, Filter::Linear, Wrap::Clamp, raw)))
    };
    let place = |x, y, z| TexturePoint { position: Vec3::new(x, y, z), ..at(0.0, 0.0) };
    let values = (0..8).map(|i| 0.1 * i as f32).collect();
    let corners = [Vec3::new(-2.0, -1.0, 0.0), Vec3::new(2.0, 3.0, 4.0)];
    let grid = Grid { size: [2; 3], channels: 1, values, corners };
    let texture = volume(&grid, Transform::IDENTITY, false);
    for (x, y, z, value) in
        [(0.75, 0.25, 0.25, 0.1), (0.4, 0.3, 0.6, 0.33), (1.2, 0.5, 0.5, 0.4), (2.0, 2.0, 2.0, 0.7)]
    {
        close(&[texture.value(&place(x, y, z))], &[value], 1e-6);
    }
    let boxed = volume(&grid, from_box(corners).unwrap(), false);
    close(&[boxed.value(&place(0.4, 0.3, 0.6)), boxed.value(&place(0.3, 0.2, 2.1))], &[0.1, 0.305], 1e-6);

    let values = vec![0.9, 0.1, 0.1, 0.1, 0.8, 0.2, 0.2, 0.3, 0.9, 0.5, 0.4, 2.0];
    let grid = Grid { size: [2, 2, 1], channels: 3, values, corners };
    let texture = volume(&grid, Transform::IDENTITY, false);
    close(&texture.sample(&place(0.4, 0.3, 0.6), &NM).0, &[0.21376, 0.35864, 0.39237, 0.99064], 5e-5);
    close(&volume(&grid, Transform::IDENTITY, true).rgb(&place(0.4, 0.3, 0.6)), &[0.623, 0.312, 0.24], 1e-6);
}

fn octaves() -> Octaves {
    Octaves { count: 3, gain: 0.5, seed: 0 }
}

fn patterns() -> [Pattern; 5] {
    let veins = Veins { octaves: octaves(), strength: 1.5 };
    [
        Pattern::Noise(octaves()),
        Pattern::Turbulence(octaves()),
        Pattern::Marble(veins),
        Pattern::Wood(veins),
        Pattern::Bands,
    ]
}

fn procedural(pattern: Pattern, ground: Ground, colours: Vec<Texture>, mixed: bool) -> Procedural {
    Procedural { pattern, ground, colours, range: [0.0, 1.0], mixed }
}

const PLAIN: Ground = Ground::Uv(UvTransform::IDENTITY);

/// Measured spectra are selected and mixed as they are, wavelength by wavelength.
#[test]
fn patterns_select_and_mix_spectra() {
    let measured = ["colorchecker/red", "colorchecker/blue", "colorchecker/green"]
        .map(|name| crate::spectrum::catalogue::reflectance(name).unwrap());
    let [red, blue, green] = measured.each_ref().map(|spectrum| spectrum.sample(&NM));
    let colours: Vec<Texture> = measured.into_iter().map(Texture::Uniform).collect();
    let stripes = Texture::Procedural(Box::new(procedural(Pattern::Bands, PLAIN, colours.clone(), false)));
    for (u, expected) in [(0.1, red), (0.3, red), (0.4, blue), (0.7, green), (1.2, red), (-0.1, green)] {
        assert_eq!(stripes.sample(&at(u, 0.3), &NM), expected, "{u}");
    }
    let waves = Texture::Procedural(Box::new(procedural(Pattern::Bands, PLAIN, colours, true)));
    assert_eq!(waves.sample(&at(0.0, 0.0), &NM), red);
    assert_eq!(waves.sample(&at(0.5, 0.0), &NM), green);
    // A third of the way up the wave, from the first colour to the second.
    let third = (1.0f64 / 3.0).acos() / std::f64::consts::TAU;
    let expected = red * (1.0 / 3.0) + blue * (2.0 / 3.0);
    close(&waves.sample(&at(third, 0.0), &NM).0, &expected.0, 1e-12);
}

#[test]
fn colours_begin_and_end_where_the_range_does() {
    let colours = vec![Texture::Uniform(Spectrum::Constant(0.2)), Texture::Uniform(Spectrum::Constant(0.6))];
    let mut texture = procedural(Pattern::Bands, PLAIN, colours, true);
    texture.range = [0.25, 0.75];
    for (u, value) in [(0.0, 0.2), (1.0 / 6.0, 0.2), (0.25, 0.4), (1.0 / 3.0, 0.6), (0.5, 0.6)] {
        assert!((texture.value(&at(u, 0.0)) - value).abs() < 1e-12, "{u}");
    }
}

/// Slopes by u and v are those of the values: of patterns on u and v, of patterns in space on a slanted
/// surface, and of textures within them.
#[test]
fn slopes_of_patterns_are_those_of_their_values() {
    let to_pattern = UvTransform([[3.0, -1.0, 0.2], [0.5, 2.0, -0.4]]);
    let to_space = Transform::scale(1.7).then(&Transform::translation(Vec3::new(0.3, 0.1, -2.0)));
    let tangents = [Vec3::new(0.4, -0.2, 0.9), Vec3::new(-0.1, 0.8, 0.3)];
    let place = |u: f64, v: f64| {
        let position = Vec3::new(5.0, 3.0, 1.0) + tangents[0] * u + tangents[1] * v;
        TexturePoint { at_rest: AtRest { position, tangents }, ..at(u, v) }
    };
    let board = Image::new(3, 2, 1, vec![0.1, 0.7, 0.3, 0.9, 0.5, 0.2], false);
    let step = 1e-6;
    for pattern in patterns() {
        for ground in [Ground::Uv(to_pattern), Ground::Solid(glam::DAffine3::from_mat4(to_space.matrix()))] {
            let plain = Placing { filter: Filter::Linear, ..placing(Filter::Linear, Wrap::Repeat) };
            let colours = vec![
                Texture::Uniform(Spectrum::Constant(0.1)),
                bitmap(&board, plain, true),
                Texture::Uniform(Spectrum::Constant(0.9)),
            ];
            let texture = procedural(pattern, ground, colours, true);
            let mut creases = 0;
            for i in 0..400 {
                let (u, v) = (0.037_137 * f64::from(i), 0.021_319 * f64::from(i));
                let difference = |du: f64, dv: f64| {
                    texture.value(&place(u + du, v + dv)) - texture.value(&place(u - du, v - dv))
                };
                let expected = [difference(step, 0.0), difference(0.0, step)].map(|d| d / (2.0 * step));
                let found = texture.gradient(&place(u, v));
                // Where a texel, a crease of the turbulence or the end of a ring lies in between.
                let same = found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-4 * (1.0 + b.abs()));
                creases += u32::from(!same);
            }
            assert!(creases <= 4, "{pattern:?} {ground:?}: {creases} of 400");
        }
    }
}

/// No value is below the least or above the greatest of the colours, and the mean that lights are chosen by
/// is about the mean.
#[test]
fn patterns_keep_to_their_colours() {
    let range = WavelengthRange::VISIBLE;
    let constant = |value| Texture::Uniform(Spectrum::Constant(value));
    for pattern in patterns() {
        for mixed in [true, false] {
            let colours = vec![constant(0.2), constant(0.9), constant(0.4)];
            let ground = Ground::Uv(UvTransform([[37.0, 5.0, 0.0], [-11.0, 23.0, 0.0]]));
            let texture = Texture::Procedural(Box::new(procedural(pattern, ground, colours, mixed)));
            let (mut sum, count) = (0.0, 10_000);
            for i in 0..count {
                let value = texture.value(&at((0.618_034 * f64::from(i)).fract(), f64::from(i) / 1e4));
                assert!((0.2..=texture.max_bound(range)).contains(&value), "{pattern:?}: {value}");
                sum += value / f64::from(count);
            }
            let mean = texture.mean_spectrum(range).at(550.0);
            assert!((mean / sum - 1.0).abs() < 0.1, "{pattern:?}: {mean}, not {sum}");
        }
    }
}

/// Two lines between whole nanometres.
#[test]
fn means_keep_narrow_lines() {
    let range = WavelengthRange::VISIBLE;
    let line = |nm: f64, peak| {
        Spectrum::irregular(&[nm - 0.4, nm, nm + 0.4], &[0.0, peak, 0.0], Extrapolation::Zero).unwrap()
    };
    let (yellow, violet) = (line(589.5, 100.0), line(404.5, 20.0));
    let colours = || [&yellow, &violet].map(|line| Texture::Uniform(line.clone()));
    let board =
        || Texture::Checkerboard(Box::new(Checkerboard { colours: colours(), to_uv: UvTransform::IDENTITY }));
    let bands = Texture::Procedural(Box::new(procedural(Pattern::Bands, PLAIN, colours().into(), true)));
    let halved = Texture::Filtered { texture: Box::new(board()), by: Spectrum::Constant(0.5) };
    let of_one = |texture: &Texture, nm: f64| {
        texture.mean_spectrum(range).integral(WavelengthRange { min: nm - 1.0, max: nm + 1.0 })
    };
    for (texture, share, tolerance) in [(board(), 0.5, 1e-9), (halved, 0.25, 1e-9), (bands, 0.5, 0.1)] {
        for (nm, line) in [(589.5, &yellow), (404.5, &violet)] {
            let (found, exact) = (of_one(&texture, nm), share * line.integral(range));
            assert!((found / exact - 1.0).abs() <= tolerance, "{texture:?}: {found}, not {exact}");
            assert!(texture.mean_spectrum(range).at(nm) > 0.0, "{texture:?} at {nm} nm");
        }
    }
}

/// Where a number is asked for, a colour of a mesh is its luminance, as that of an image is.
#[test]
fn a_colour_of_a_mesh_is_a_number_by_its_luminance() {
    let attribute = |name: &str, channels: usize, values: [f32; 3]| MeshAttribute {
        name: name.to_owned(),
        per_face: true,
        channels,
        values: values[..channels].to_vec(),
    };
    let colour = [0.2, 0.6, 0.4];
    let data = MeshData {
        positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        indices: vec![[0, 1, 2]],
        attributes: vec![attribute("face_color", 3, colour), attribute("face_weight", 1, [0.3; 3])],
        ..MeshData::default()
    };
    let mesh = Mesh::new(data).unwrap();
    let place = MeshPoint { mesh: &mesh, triangle: 0, barycentric: [0.2, 0.3] };
    let at = TexturePoint { mesh: Some(place), ..at(0.0, 0.0) };
    let value = |name: &str| Texture::Attribute(Attribute { name: name.to_owned(), scale: 2.0 }).value(&at);
    close(&[value("face_color")], &[2.0 * luminance(colour.map(f64::from))], 1e-12);
    close(&[value("face_weight")], &[2.0 * f64::from(0.3f32)], 1e-12);
}
