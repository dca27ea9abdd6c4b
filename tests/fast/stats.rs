//! `--stats`: what a render did, exactly where that is known, and the same picture.

use crate::common::folder::{Folder, of_repository, stderr, stdout};
use abbe::output::exr::Channels;
use serde_json::Value;

/// A unit sphere under a uniform sky, of which 4 × 4 pixels see nothing but the sphere.
const SPHERE: &str = r#"<scene version="3.0.0">
<integrator type="path"><integer name="max_depth" value="5"/></integrator>
<sensor type="perspective"><float name="fov" value="5"/>
  <transform name="to_world"><lookat origin="0, 0, 9" target="0, 0, 0" up="0, 1, 0"/></transform>
  <film type="hdrfilm"><integer name="width" value="4"/><integer name="height" value="4"/><rfilter type="box"/></film>
  <sampler type="independent"><integer name="sample_count" value="4"/></sampler></sensor>
LIGHT
<shape type="sphere"><bsdf type="diffuse"><spectrum name="reflectance" value="0.5"/></bsdf></shape>
</scene>"#;

const SKY: &str = r#"<emitter type="constant"><spectrum name="radiance" value="1"/></emitter>"#;
const LAMP: &str = r#"<emitter type="point"><point name="position" x="0" y="0" z="9"/></emitter>"#;

fn json(folder: &Folder, arguments: &[&str]) -> Value {
    let output =
        folder.run(&[&["render"], arguments, &["--stats", "--json", "--quiet", "-o", "x.exr"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    serde_json::from_str(&stdout(&output)).expect("valid JSON")
}

fn count(stats: &Value, path: &str) -> u64 {
    stats.pointer(path).and_then(Value::as_u64).unwrap_or_else(|| panic!("{path} in {stats:#}"))
}

/// 64 camera rays, each of which meets the sphere; 64 that leave it, of which none can meet it again.
#[test]
fn the_counts_of_a_single_sphere_are_exact() {
    let folder = Folder::new("stats-sphere");
    folder.write("sky.xml", SPHERE.replace("LIGHT", SKY));
    folder.write("lamp.xml", SPHERE.replace("LIGHT", LAMP));
    for estimator in ["plain", "shared"] {
        let stats = json(&folder, &["sky.xml", "--estimator", estimator]);
        assert_eq!([count(&stats, "/samples"), count(&stats, "/pixels")], [64, 16]);
        let camera = |what: &str| count(&stats, &format!("/rays/camera/{what}"));
        assert_eq!(["rays", "queries", "hits"].map(camera), [64; 3], "{estimator}");
        // One node with one box around the one surface, which each of these rays is tested against.
        assert_eq!(["nodes", "boxes_entered", "leaves", "surfaces"].map(camera), [64; 4], "{estimator}");
        assert_eq!(["boxes_missed", "boxes_empty", "packets"].map(camera), [0; 3], "{estimator}");
        assert_eq!(count(&stats, "/rays/scattered/rays"), 64, "{estimator}");
        assert_eq!(count(&stats, "/rays/scattered/hits"), 0, "{estimator}");
        assert_eq!(count(&stats, "/paths/number"), 64, "{estimator}");
        assert_eq!(count(&stats, "/paths/ends/escaped"), 64, "{estimator}");
        assert_eq!(stats["paths"]["mean_segments"], 2.0, "{estimator}");
    }
    let stats = json(&folder, &["lamp.xml", "--estimator", "plain"]);
    assert_eq!(count(&stats, "/rays/shadow/rays"), 64);
    assert_eq!(count(&stats, "/rays/shadow/hits"), 0, "the lamp is where the camera is");
    assert_eq!(count(&stats, "/all_rays"), 3 * 64);
}

/// A camera in fog, whose box has a boundary that is none, sees a wall through it, and a ball of glass. Paths
/// split at and behind the glass alone.
#[test]
fn null_boundaries_and_media_split_no_path() {
    let folder = Folder::new("stats-null");
    let scene = |ball: &str| {
        format!(
            r#"<scene version="3.0.0"><integrator type="volpath"/>
<medium type="homogeneous" id="fog"><float name="sigma_t" value="0.2"/><float name="albedo" value="0.9"/></medium>
<sensor type="perspective"><float name="fov" value="40"/>
  <film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="8"/><rfilter type="box"/></film>
  <sampler type="independent"><integer name="sample_count" value="16"/></sampler><ref id="fog"/></sensor>
<shape type="cube"><bsdf type="null"/><ref name="interior" id="fog"/></shape>
<shape type="cube"><transform name="to_world"><scale value="2"/></transform>
  <bsdf type="twosided"><bsdf type="diffuse"/></bsdf></shape>{ball}
<emitter type="point"><point name="position" x="0" y="1.5" z="0"/></emitter></scene>"#
        )
    };
    folder.write("fog.xml", scene(""));
    folder.write(
        "glass.xml",
        scene(r#"<shape type="sphere"><point name="center" x="0" y="0" z="0.7"/><float name="radius" value="0.2"/><bsdf type="dielectric"/></shape>"#),
    );
    let paths = |name: &str| {
        let stats = json(&folder, &[name]);
        [count(&stats, "/paths/number"), count(&stats, "/samples")]
    };
    let [number, samples] = paths("fog.xml");
    assert_eq!(number, samples);
    let [number, samples] = paths("glass.xml");
    assert!(number > samples, "{number}");
}

/// Channels, and all attributes but those of statistics; these by themselves.
fn picture(folder: &Folder, name: &str) -> (Channels, Vec<(String, Value)>) {
    let mut picture = folder.picture(name);
    let is_told = |name: &str| name.starts_with("abbe.stats");
    let json = |text: &str| serde_json::from_str(text).expect("valid JSON");
    let told = picture.attributes.iter().filter(|(name, _)| is_told(name));
    let told = told.map(|(name, text)| (name.clone(), json(text))).collect();
    picture.attributes.retain(|(name, _)| !is_told(name));
    (picture, told)
}

/// Scenes with light tracing, media, contact, and neither.
#[test]
fn the_picture_is_the_same_and_kinds_add_up() {
    let folder = Folder::new("stats-same");
    for scene in ["scenes/box/scene.xml", "scenes/mug/scene.xml", "tests/scenes/agreement/contact.xml"] {
        let scene = of_repository(scene);
        for estimator in ["plain", "shared"] {
            let render = |more: &[&str]| {
                let common = [&scene, "--spp=16", "--size=24x16", "--estimator", estimator];
                [&common[..], more].concat().iter().map(|word| (*word).to_owned()).collect::<Vec<_>>()
            };
            let words = render(&["--threads", "2"]);
            let stats = json(&folder, &words.iter().map(String::as_str).collect::<Vec<_>>());
            let (counted, told) = picture(&folder, "x.exr");
            // The file has what is printed: what is the same for equal renders, and by itself what is not.
            let names: Vec<&str> = told.iter().map(|(name, _)| name.as_str()).collect();
            assert_eq!(names, ["abbe.stats", "abbe.stats.run"]);
            let attributes = told.iter().flat_map(|(_, value)| value.as_object().expect("an object").clone());
            assert_eq!(Value::Object(attributes.collect()), stats, "{scene} {estimator}");
            for (name, place) in [("abbe.stats", "/rays/camera"), ("abbe.stats.run", "/memory/film")] {
                let (_, value) = told.iter().find(|(told, _)| told == name).expect("it is there");
                assert!(value.pointer(place).is_some(), "{place}: {value:#}");
            }
            let words = render(&["--threads", "1"]);
            let again = json(&folder, &words.iter().map(String::as_str).collect::<Vec<_>>());
            let mut plain = vec!["render", "--quiet", "-o", "y.exr"];
            plain.extend(words.iter().map(String::as_str));
            folder.ends(0, &plain);
            let (uncounted, told) = picture(&folder, "y.exr");
            assert!(told.is_empty(), "{told:?}");
            assert!(counted == uncounted, "{scene} {estimator}: another picture where rays are counted");
            for exact in ["rays", "paths", "all_rays", "rays_of_pilots", "plan"] {
                assert_eq!(stats[exact], again[exact], "{scene} {estimator}: threads change the counts");
            }
            let rays = stats["rays"].as_object().expect("kinds");
            let sum: u64 = rays.values().map(|kind| kind["rays"].as_u64().unwrap_or(0)).sum();
            assert_eq!(sum, count(&stats, "/all_rays"), "{scene} {estimator}");
            let ends = stats["paths"]["ends"].as_object().expect("ends");
            let sum: u64 = ends.values().filter_map(Value::as_u64).sum();
            assert_eq!(sum, count(&stats, "/paths/number"), "{scene} {estimator}");
            // Each camera ray begins a path; branches make more of them.
            assert!(sum >= count(&stats, "/samples"), "{scene} {estimator}: {sum} paths");
            for kind in rays.values() {
                let of = |what: &str| kind[what].as_u64().expect("a number");
                assert!(of("queries") >= of("rays") && of("hits") <= of("queries"), "{kind:#}");
            }
            let share = stats["share_of_ray_queries"].as_f64().expect("a share");
            assert!(share > 0.02 && share <= 1.0, "{scene} {estimator}: {share} of the time");
            assert_times_are_of_this_render(&stats);
        }
    }
}

/// Times are of this render, and the parts of them fit into the whole.
#[track_caller]
fn assert_times_are_of_this_render(stats: &Value) {
    let number = |path: &str| stats.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("{path}"));
    let passes = stats["seconds"]["passes"].as_array().expect("passes");
    let first_pass = passes[0]["seconds"].as_f64().expect("a time");
    let first = number("/seconds/first_samples");
    assert!(first > 0.0 && first <= first_pass, "first samples after {first} s of {first_pass} s");
    // Two threads at most; what counting takes is deducted.
    let processor = number("/processor_seconds");
    let all: f64 = passes.iter().map(|pass| pass["seconds"].as_f64().expect("a time")).sum();
    assert!(processor > 0.0 && processor <= 2.0 * all, "{processor} s of two threads in {all} s");
    let of_a_ray = 1e6 * processor / number("/all_rays");
    assert!((number("/microseconds_per_ray") / of_a_ray - 1.0).abs() < 1e-9, "{of_a_ray}");
    let share: f64 = stats["rays"]
        .as_object()
        .expect("kinds")
        .values()
        .map(|kind| kind["share"].as_f64())
        .sum::<Option<f64>>()
        .expect("shares");
    assert!((share - 1.0).abs() < 1e-9, "shares of kinds sum to {share}");
    let paths = number("/paths/number") / number("/samples");
    assert!((number("/paths/per_sample") / paths - 1.0).abs() < 1e-9, "{paths}");
}

#[test]
fn the_text_has_what_the_json_has() {
    let folder = Folder::new("stats-text");
    folder.write("sky.xml", SPHERE.replace("LIGHT", SKY));
    let output = folder.run(&["render", "sky.xml", "--stats", "--quiet", "-o", "x.exr"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let told = stdout(&output);
    for part in [
        "camera",
        "scattered",
        "of all",
        "per pixel",
        "1.000 a sample, of 2.00 segments",
        "escaped 100.0%",
        "processor time",
        "a ray",
        "bad values",
        "memory",
        "read",
        "pilots",
        "wavelengths a path 4, pixels a suffix",
        "first samples",
    ] {
        assert!(told.contains(part), "{part}: {told}");
    }
    assert!(folder.ends(2, &["render", "sky.xml", "--json"]).contains("--stats"));
}

/// What paths from a pixel take.
#[test]
fn the_cost_of_a_pixel_is_what_its_paths_take() {
    let folder = Folder::new("stats-cost");
    let near = SPHERE.replace("LIGHT", SKY);
    folder.write("near.xml", &near);
    folder.write("wide.xml", near.replace(r#"name="fov" value="5""#, r#"name="fov" value="60""#));
    let cost = |scene: &str, threads: &str| {
        folder.ends(0, &["render", scene, "--aov=cost", "--threads", threads, "-q", "-o", "x.exr"]);
        let picture = folder.picture("x.exr");
        let values = |wanted: &str| {
            let found = picture.channels.iter().find(|(name, _)| name == wanted);
            found.unwrap_or_else(|| panic!("no {wanted}")).1.clone()
        };
        assert!(values("error.cost.T").iter().all(|error| error.is_finite()));
        values("cost.T")
    };
    let near = cost("near.xml", "1");
    assert_eq!(near, cost("near.xml", "3"));
    // A node and a surface on the way there; a ray that leaves the box from within may visit both again.
    assert!(near.iter().all(|cost| (2.0..=4.0).contains(cost)), "{near:?}");
    // A ray that misses the box around everything visits nothing.
    let wide = cost("wide.xml", "1");
    assert!(wide[0] == 0.0 && wide[5] > 0.0, "{wide:?}");
}
