//! Parts of a picture are what they are in the whole: `--crop` bit by bit, a film's own crop window away from
//! its border.

use crate::common::folder::{Folder, stderr};
use std::process::Output;

/// Width and height of the whole pictures.
const SIZE: [usize; 2] = [40, 30];

/// x, y, width and height of four parts that cover the whole and whose borders are those of no tile.
const PARTS: [[usize; 4]; 4] = [[0, 0, 17, 13], [17, 0, 23, 13], [0, 13, 17, 17], [17, 13, 23, 17]];

fn run(folder: &Folder, scene: &str, arguments: &[&str]) -> Output {
    folder.write("made.xml", scene);
    folder.run(&[&["render", "made.xml", "--quiet", "-o", "x.exr"], arguments].concat())
}

fn render(folder: &Folder, scene: &str, arguments: &[&str]) -> Picture {
    let output = run(folder, scene, arguments);
    assert!(output.status.success(), "{}", stderr(&output));
    let file = folder.picture("x.exr");
    Picture { size: [file.width, file.height], channels: file.channels }
}

struct Picture {
    size: [usize; 2],
    channels: Vec<(String, Vec<f32>)>,
}

impl Picture {
    /// The bits of each channel in a part of the picture.
    fn part(&self, [x, y, width, height]: [usize; 4]) -> Vec<(&str, Vec<u32>)> {
        let rows = |values: &[f32]| {
            let row =
                |row: usize| values[row * self.size[0] + x..][..width].iter().map(|value| value.to_bits());
            (y..y + height).flat_map(row).collect()
        };
        self.channels.iter().map(|(name, values)| (name.as_str(), rows(values))).collect()
    }

    fn all(&self) -> Vec<(&str, Vec<u32>)> {
        self.part([0, 0, self.size[0], self.size[1]])
    }

    fn channel(&self, name: &str) -> &[f32] {
        let found = self.channels.iter().find(|(known, _)| known == name);
        &found.unwrap_or_else(|| panic!("{name} is missing")).1
    }
}

/// A lens of glass over a floor, which casts a caustic, and a lamp; the rest of the picture sees nothing.
/// `film` is what the film holds, `bsdf` makes the lens.
fn scene(film: &str, bsdf: &str) -> String {
    format!(
        r#"<scene version="3.0.0"><integrator type="path"/>
        <sensor type="perspective"><float name="fov" value="40"/>
            <transform name="to_world"><lookat origin="0 -5 2.5" target="0 0 0.4" up="0 0 1"/></transform>
            <film type="hdrfilm"><integer name="width" value="{}"/><integer name="height" value="{}"/>{film}</film>
        </sensor>
        <shape type="rectangle"><bsdf type="diffuse"/></shape>
        <shape type="sphere"><point name="center" x="0" y="0" z="0.6"/><float name="radius" value="0.4"/>{bsdf}</shape>
        <shape type="rectangle"><transform name="to_world"><scale value="0.3"/><rotate x="1" angle="180"/>
            <translate x="0.6" z="2"/></transform>
            <emitter type="area"><spectrum name="radiance" value="400:1, 700:3"/></emitter></shape></scene>"#,
        SIZE[0], SIZE[1]
    )
}

/// A lamp out of focus and one of less than a pixel.
fn lamps() -> String {
    let lamp = |x: f64, y: f64, z: f64| {
        format!(
            r#"<shape type="sphere"><point name="center" x="{x}" y="{y}" z="{z}"/>
            <float name="radius" value="0.02"/><emitter type="area"><rgb name="radiance" value="90"/></emitter></shape>"#
        )
    };
    format!(
        r#"<scene version="3.0.0"><integrator type="path"/>
        <sensor type="thinlens"><float name="fov" value="40"/><float name="aperture_radius" value="0.3"/>
            <float name="focus_distance" value="5"/>
            <transform name="to_world"><lookat origin="0 -5 0" target="0 0 0" up="0 0 1"/></transform>
            <film type="hdrfilm"><integer name="width" value="{}"/><integer name="height" value="{}"/></film>
        </sensor>{}{}</scene>"#,
        SIZE[0],
        SIZE[1],
        lamp(-0.2, -3.0, 0.1),
        lamp(0.9, 0.0, -0.4)
    )
}

const GLASS: &str = r#"<bsdf type="dielectric"/>"#;
const DIFFUSE: &str = r#"<bsdf type="diffuse"/>"#;

fn is_each_part_of_the_whole(name: &str, scene: &str, arguments: &[&str]) {
    let folder = Folder::new(name);
    let whole = render(&folder, scene, arguments);
    assert_eq!(whole.size, SIZE);
    for [x, y, width, height] in PARTS.into_iter().chain([[20, 10, 1, 1]]) {
        let crop = format!("--crop={x},{y},{width},{height}");
        let part = render(&folder, scene, &[arguments, &[&crop]].concat());
        assert_eq!(part.size, [width, height]);
        for (found, expected) in part.all().into_iter().zip(whole.part([x, y, width, height])) {
            assert!(found == expected, "{name}: {} of {crop} differs from the whole's", expected.0);
        }
    }
}

#[test]
fn a_part_holds_the_bits_of_the_whole() {
    let film = |filter: &str, more: &str| format!(r#"<rfilter type="{filter}"/>{more}"#);
    let alpha = r#"<string name="pixel_format" value="rgba"/>"#;
    let window = r#"<integer name="crop_offset_x" value="0"/><integer name="crop_width" value="40"/>
        <integer name="crop_offset_y" value="0"/><integer name="crop_height" value="30"/>
        <boolean name="sample_border" value="true"/>"#;
    for (name, film, bsdf, arguments) in [
        ("box", film("box", ""), DIFFUSE, &["--spp=16", "--aov=albedo,sh_normal,depth"][..]),
        ("gaussian", film("gaussian", ""), DIFFUSE, &["--spp=16", "--sampler=bluenoise"]),
        ("caustic", film("gaussian", ""), GLASS, &["--spp=32", "--spectral=4"]),
        ("alpha", film("mitchell", alpha), DIFFUSE, &["--spp=12", "--sampler=jittered"]),
        ("border", film("lanczos", window), GLASS, &["--spp=8", "--sampler=independent", "--seed=3"]),
        // Enough samples for a pilot, which must find the same in each part.
        ("pilot", film("box", ""), DIFFUSE, &["--spp=512"]),
        ("poisson", film("tent", ""), GLASS, &["--spp=8", "--sampler=poisson", "--wavelengths=1"]),
    ] {
        is_each_part_of_the_whole(name, &scene(&film, bsdf), arguments);
    }
    is_each_part_of_the_whole("lamps", &lamps(), &["--spp=32"]);
}

const WINDOW: [usize; 4] = [11, 7, 21, 18];

/// A film that exposes that window.
fn windowed(filter: &str) -> String {
    let [x, y, width, height] = WINDOW;
    format!(
        r#"<rfilter type="{filter}"/>
        <integer name="crop_offset_x" value="{x}"/><integer name="crop_offset_y" value="{y}"/>
        <integer name="crop_width" value="{width}"/><integer name="crop_height" value="{height}"/>"#
    )
}

/// Within the film's own window a pixel at the border sees what the window holds; the others are the whole's.
#[test]
fn a_crop_window_is_the_whole_away_from_its_border() {
    let [x, y, width, height] = WINDOW;
    // How far a filter reaches beyond its own pixel. Error bars look farther: at squares of pixels.
    for (filter, reach) in [("box", 0), ("gaussian", 2)] {
        let folder = Folder::new(&format!("window-{filter}"));
        let whole = render(&folder, &scene(&format!(r#"<rfilter type="{filter}"/>"#), GLASS), &["--spp=16"]);
        let window = render(&folder, &scene(&windowed(filter), GLASS), &["--spp=16"]);
        let inner = [reach, reach, width - 2 * reach, height - 2 * reach];
        let same = [x + reach, y + reach, inner[2], inner[3]];
        for (found, expected) in window.part(inner).into_iter().zip(whole.part(same)) {
            let is_error = found.0.starts_with("error.");
            assert!(is_error || found == expected, "{filter}: {} of the window is another", found.0);
        }
        let border = |picture: &Picture, x, y| {
            let strip = picture.part([x, y, 1, 18]);
            strip.into_iter().find(|(name, _)| *name == "G").map(|(_, bits)| bits)
        };
        let is_cut = border(&window, 0, 0) != border(&whole, x, y);
        assert_eq!(is_cut, filter != "box", "{filter}: Mitsuba's rule at the border");
    }
}

#[test]
fn a_part_of_a_crop_window_is_counted_from_the_films_corner() {
    let folder = Folder::new("within");
    let [x, y, width, height] = WINDOW;
    let scene = scene(&windowed("gaussian"), GLASS);
    let window = render(&folder, &scene, &["--spp=8"]);
    let part = render(&folder, &scene, &["--spp=8", "--crop=11,9,5,16"]);
    assert!(part.all() == window.part([0, 2, 5, 16]));
    let beyond = [
        format!("--crop={},{y},{width},{height}", x - 1),
        format!("--crop={x},{y},{width},{}", height + 1),
        "--crop=0,0,40,30".to_owned(),
        "--crop=4294967295,0,4294967295,1".to_owned(),
        "--crop=11,9,0,3".to_owned(),
        "--crop=11,9,3".to_owned(),
    ];
    for crop in &beyond {
        let output = run(&folder, &scene, &[crop]);
        let told = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{crop}: {told}");
        assert!(told.contains("help") || told.contains("--crop"), "{crop}: {told}");
    }
}

/// The noise of neighbouring parts is that of different pixels, whether they come by `--crop` or by crop
/// windows.
#[test]
fn parts_of_one_film_do_not_share_their_noise() {
    let folder = Folder::new("noise");
    let window = |x: usize| {
        format!(
            r#"<rfilter type="box"/><integer name="crop_offset_x" value="{x}"/>
            <integer name="crop_width" value="20"/>"#
        )
    };
    // No smooth surface and the same light everywhere: what differs is noise.
    let even = |film: &str| {
        scene(film, DIFFUSE)
            .replace("<float name=\"fov\" value=\"40\"/>", "<float name=\"fov\" value=\"0.01\"/>")
    };
    let residuals = |scene: &str| {
        let picture = render(&folder, scene, &["--spp=4", "--wavelengths=1"]);
        let values = picture.channel("G").to_vec();
        let mean = values.iter().sum::<f32>() / values.len() as f32;
        assert!(mean > 0.0);
        values.into_iter().map(|value| f64::from(value - mean)).collect::<Vec<_>>()
    };
    let (left, right) = (residuals(&even(&window(0))), residuals(&even(&window(20))));
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let correlation = product(&left, &right) / (product(&left, &left) * product(&right, &right)).sqrt();
    // Its standard error is 1/√n for n independent pairs.
    let bound = 4.5 / (left.len() as f64).sqrt();
    assert!(correlation.abs() < bound, "{correlation} against {bound}");
}

#[test]
fn the_longest_path_is_that_of_the_command_line() {
    let folder = Folder::new("depth");
    let path = |integrator: &str| {
        scene("", DIFFUSE)
            .replace("<integrator type=\"path\"/>", &format!("<integrator type={integrator}</integrator>"))
    };
    let deep = path("\"path\">");
    let written = render(&folder, &path("\"path\"><integer name=\"max_depth\" value=\"2\"/>"), &["--spp=8"]);
    let asked = render(&folder, &deep, &["--spp=8", "--max-depth=2"]);
    assert!(written.all() == asked.all());
    assert!(render(&folder, &deep, &["--spp=8"]).all() != asked.all(), "longer paths bring nothing");
}

/// Where the file says that its pixels are.
#[test]
fn the_file_says_which_part_it_is() {
    let folder = Folder::new("windows");
    render(&folder, &scene("", DIFFUSE), &["--spp=1", "--crop=17,13,23,17"]);
    let bytes = folder.bytes("x.exr");
    let window = |name: &str| -> [i32; 4] {
        let name = format!("{name}\0box2i\0");
        let at = bytes.windows(name.len()).position(|part| part == name.as_bytes()).expect("an attribute");
        let value = &bytes[at + name.len() + 4..][..16];
        std::array::from_fn(|i| i32::from_le_bytes(value[4 * i..][..4].try_into().expect("four bytes")))
    };
    assert_eq!(window("dataWindow"), [17, 13, 39, 29]);
    assert_eq!(window("displayWindow"), [0, 0, 39, 29]);
}
