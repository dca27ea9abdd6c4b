//! Pixels that have noise in common, through the film's filter or through light subpaths that a group of them
//! shares, raise no false alarm: the file says what they share.

use crate::common::folder::{Folder, of_repository};
use abbe::compare::{Options, compare};
use abbe::output::error_bars::near;
use abbe::output::exr::Channels;
use abbe::stats::{Moments, uniformity};
use std::slice::from_ref;

/// A diffuse corner under a lamp that lights most of it by way of a wall.
const SCENE: &str = r#"<scene version="3.0.0">
    <integrator type="path"><integer name="max_depth" value="5"/></integrator>
    <sensor type="perspective">
        <float name="fov" value="50"/>
        <transform name="to_world"><lookat origin="0, -4, 2.5" target="0, 0, 0.3" up="0, 0, 1"/></transform>
        <film type="hdrfilm"><integer name="width" value="24"/><integer name="height" value="24"/></film>
    </sensor>
    <shape type="rectangle"><transform name="to_world"><scale value="6"/></transform></shape>
    <shape type="rectangle">
        <transform name="to_world"><scale value="6"/><rotate x="1" angle="90"/><translate y="2"/></transform>
    </shape>
    <shape type="disk">
        <transform name="to_world"><scale value="0.5"/><translate x="-1" y="0" z="3"/></transform>
        <emitter type="area"><spectrum name="radiance" value="10"/></emitter>
    </shape>
</scene>"#;

fn scene(name: &str) -> Folder {
    let folder = Folder::new(name);
    folder.write("scene.xml", SCENE);
    folder
}

fn render(folder: &Folder, further: &[&str]) -> Channels {
    folder.ends(0, &[&["render", "scene.xml", "--quiet", "-o", "x.exr"], further].concat());
    folder.picture("x.exr")
}

/// Pairs of pictures that differ in the seed alone: at the 5 % level each test raises an alarm in 2 of 40,
/// and in more than 8 of them with a probability of 10⁻⁴. The p-values of the whole mean, of which there is
/// one in each pair, are uniform. What is shared matters: files that do not tell it raise alarms.
fn no_false_alarms(name: &str, further: &[&str]) {
    const PAIRS: u32 = 40;
    const MOST: usize = 8;
    let folder = scene(name);
    let options = Options { pixels_per_degree: 1.0, ..Options::default() };
    let (mut of_mean, mut of_tiles, mut untold) = (Vec::new(), Vec::new(), Vec::new());
    for pair in 0..PAIRS {
        let [a, b] = [0, 1].map(|side| {
            let seed = (2 * pair + side + 1).to_string();
            let arguments = ["--spp", "16", "--replicates", "8", "--seed", seed.as_str()];
            render(&folder, &[arguments.as_slice(), further].concat())
        });
        let tests = |[a, b]: [&Channels; 2]| {
            let found = compare(from_ref(a), from_ref(b), &options).expect("files that can be compared");
            let green =
                found.channels.into_iter().find(|channel| channel.name == "G").expect("a green channel");
            green.tests.expect("files with errors")
        };
        let found = tests([&a, &b]);
        of_mean.push(found.p_mean);
        of_tiles.push(found.p_tiles);
        let [a, b] = [a, b].map(|mut picture| {
            let stated = ["abbe.meanError", "abbe.tileNoise", "abbe.tileNoises"];
            picture.attributes.retain(|(name, _)| !stated.contains(&name.as_str()));
            picture
        });
        untold.push(tests([&a, &b]).p_tiles);
    }
    let alarms = |p: &[f64]| p.iter().filter(|&&p| p < 0.05).count();
    let found = [alarms(&of_mean), alarms(&of_tiles)];
    assert!(found.into_iter().all(|count| count <= MOST), "{found:?}: {of_mean:?} {of_tiles:?}");
    assert!(alarms(&untold) > MOST, "pixels that share nothing: {untold:?}");
    let uniform = uniformity(&of_mean).p_value;
    assert!(uniform > 1e-4, "p = {uniform}: {of_mean:?}");
}

#[test]
fn samples_splatted_onto_several_pixels_raise_no_false_alarms() {
    no_false_alarms("splatted", &["--estimator", "plain"]);
}

#[test]
fn pixels_that_share_light_paths_raise_no_false_alarms() {
    no_false_alarms("shared", &["--estimator", "shared"]);
}

/// A clean scene with sharp edges, under a filter that smears none of them. The red ball before the wall has
/// hardly any contrast in some channels.
fn edges(name: &str) -> Folder {
    let folder = Folder::new(name);
    folder.write(
        "scene.xml",
        r#"<scene version="3.0.0"><integrator type="path"/>
           <sensor type="perspective"><float name="fov" value="35"/>
           <transform name="to_world"><lookat origin="0, -6, 3" target="0, 0, 0.8" up="0, 0, 1"/></transform>
           <film type="hdrfilm"><integer name="width" value="96"/><integer name="height" value="72"/>
           <rfilter type="box"/></film></sensor>
           <shape type="rectangle"><transform name="to_world"><scale value="5"/></transform></shape>
           <shape type="sphere"><point name="center" x="0" y="0" z="1"/>
           <bsdf type="diffuse"><rgb name="reflectance" value="0.7, 0.15, 0.1"/></bsdf></shape>
           <shape type="rectangle"><transform name="to_world">
           <rotate x="1" angle="180"/><translate x="-1.5" y="-1" z="4"/></transform>
           <emitter type="area"><spectrum name="radiance" value="6"/></emitter></shape>
           <emitter type="constant"><spectrum name="radiance" value="0.2"/></emitter></scene>"#,
    );
    folder
}

/// Pairs of pictures as they are made by default. Runs of a net complete each other in most pixels, and
/// hardly on an edge: error bars that know no difference raise an alarm in nine of ten pairs, and such as
/// tell edges by their noise alone in eight of 20 with 64 samples. At the 5 % level one of 20 is due, and
/// more than 5 come with a probability of 3·10⁻⁴.
#[test]
fn sharp_edges_raise_no_false_alarms() {
    const PAIRS: u32 = 20;
    let folder = edges("edges");
    let options = Options { pixels_per_degree: 1.0, ..Options::default() };
    for samples in ["16", "64"] {
        let p = |pair: u32| -> [f64; 4] {
            let [a, b] = [1, 2]
                .map(|side| render(&folder, &["--spp", samples, "--seed", &(2 * pair + side).to_string()]));
            let found = compare(from_ref(&a), from_ref(&b), &options).expect("files that can be compared");
            let verdict = found.verdict().expect("files with errors");
            [verdict.p, verdict.p_mean, verdict.p_tiles, verdict.p_pixels]
        };
        let found: Vec<[f64; 4]> = (0..PAIRS).map(p).collect();
        for test in 0..4 {
            let alarms = found.iter().filter(|p| p[test] < 0.05).count();
            assert!(alarms <= 5, "{samples} samples: {alarms} alarms of test {test}: {found:?}");
        }
    }
}

/// Error bars on edges are as wide as the noise there: over the pixels whose surroundings differ by more than
/// 30 % the root mean square of the error is 1.03 to 1.08 times what is stated. If edges were told by their
/// noise alone, it would be 1.6 times in red.
#[test]
fn edges_err_as_the_file_states() {
    const SEEDS: u32 = 24;
    let folder = edges("edge-errors");
    let pictures: Vec<Channels> =
        (1..=SEEDS).map(|seed| render(&folder, &["--spp", "64", "--seed", &seed.to_string()])).collect();
    let (width, height) = (pictures[0].width, pictures[0].height);
    for name in ["R", "G", "B"] {
        let pixel = |name: &str, at: usize| -> Moments {
            let mut moments = Moments::default();
            let values = pictures.iter().map(|picture| picture.channel(name).expect("a channel")[at]);
            values.for_each(|value| moments.push(f64::from(value)));
            moments
        };
        let found: Vec<Moments> = (0..width * height).map(|at| pixel(name, at)).collect();
        let (mut noise, mut stated, mut edges) = (0.0, 0.0, 0);
        for (x, y) in (1..height - 1).flat_map(|y| (1..width - 1).map(move |x| (x, y))) {
            let [least, most] = near([width, height], [x, y])
                .fold([f64::INFINITY, 0.0], |[least, most]: [f64; 2], at| {
                    [least.min(found[at].mean()), most.max(found[at].mean())]
                });
            let at = y * width + x;
            if most - least > 0.3 * found[at].mean() {
                let error = pixel(&format!("error.{name}"), at);
                noise += found[at].variance();
                stated += error.mean().powi(2) + error.variance();
                edges += 1;
            }
        }
        let times = (noise / stated).sqrt();
        println!("{name}: {edges} pixels on edges err {times:.3} times as they state");
        assert!(edges > 500 && (0.8..1.25).contains(&times), "{name}: {times} on {edges} pixels");
    }
}

/// The error of the mean that files state is that of the mean, where the edge of a lamp has nearly all the
/// noise. The spread of 64 means is known to 9 %.
#[test]
fn the_mean_errs_as_the_file_states() {
    const SEEDS: u32 = 64;
    let folder = Folder::new("mean-error");
    let box_scene = of_repository("scenes/box/scene.xml");
    let (mut means, mut stated) = (Moments::default(), Moments::default());
    for seed in 1..=SEEDS {
        let arguments = ["render", &box_scene, "--size", "24x24", "--spp", "16", "--seed", &seed.to_string()];
        folder.ends(0, &[&arguments[..], &["--quiet", "-o", "x.exr"]].concat());
        let picture = folder.picture("x.exr");
        let green = picture.channel("G").expect("a green channel");
        means.push(green.iter().map(|&value| f64::from(value)).sum::<f64>() / green.len() as f64);
        stated.push(picture.mean_error("G").expect("it is stated").powi(2));
    }
    let times = (stated.mean() / means.variance()).sqrt();
    assert!((0.8..1.45).contains(&times), "{times}");
}

/// What the file says of the noise that pixels share: nothing without replicates, and the same with any
/// number of threads.
#[test]
fn files_state_what_pixels_share() {
    let folder = scene("stated");
    let arguments = ["--spp", "64", "--spectral", "2", "--estimator", "plain", "--threads"];
    let [one, three] =
        ["1", "3"].map(|threads| render(&folder, &[&arguments, [threads].as_slice()].concat()));
    assert_eq!(one, three);
    for channel in ["R", "G", "B", "S0.477,500000nm"] {
        let of_tiles = one.tile_noise(channel).expect("it is stated");
        // A Gaussian of half a pixel weighs a sample by exp(−2 d²): in independent samples the mean over a
        // tile has about 3 times the variance of independent pixels, in stratified ones less.
        assert!(of_tiles > 1.2 && of_tiles < 5.0, "{channel}: {of_tiles}");
        let errors = one.channel(&format!("error.{channel}")).expect("a channel of errors");
        let independent = errors.iter().map(|error| f64::from(*error).powi(2)).sum::<f64>().sqrt() / 576.0;
        let error = one.mean_error(channel).expect("it is stated");
        assert!(error > 0.3 * independent && error < 6.0 * independent, "{channel}: {error} {independent}");
    }
    assert_eq!((one.tile_noise("samples"), one.mean_error("depth")), (None, None));
    let single = render(&folder, &["--spp", "4", "--replicates", "1"]);
    assert_eq!((single.tile_noise("G"), single.attribute("abbe.meanError")), (None, None));
}
