//! `--frames`: the pictures of an animation, each what it is alone, and what a break leaves of them.

use crate::common::folder::Folder;

/// A ball that crosses 20 pixels in a second.
const BALL: &str = r#"<scene version="3.0.0">
<default name="open" value="0"/><default name="close" value="0.05"/>
<integrator type="path"/>
<sensor type="orthographic">
  <float name="shutter_open" value="$open"/><float name="shutter_close" value="$close"/>
  <transform name="to_world"><scale x="1" y="0.5"/><lookat origin="0, 0, 5" target="0, 0, 0" up="0, 1, 0"/></transform>
  <film type="hdrfilm"><integer name="width" value="20"/><integer name="height" value="10"/><rfilter type="box"/></film>
  <sampler type="independent"><integer name="sample_count" value="4"/></sampler></sensor>
<shape type="sphere"><animation name="to_world">
  <transform time="0"><scale value="0.2"/><translate x="1"/></transform>
  <transform time="1"><scale value="0.2"/><translate x="-1"/></transform></animation>
  <emitter type="area"><spectrum name="radiance" value="1"/></emitter></shape>
</scene>"#;

fn render<'a>(more: &[&'a str]) -> Vec<&'a str> {
    [&["render", "ball.xml", "--frames=2..5", "--fps=10", "-q"], more].concat()
}

#[test]
fn frames_are_what_they_are_alone_and_go_on_where_they_stopped() {
    let folder = Folder::new("frames");
    folder.write("ball.xml", BALL);
    folder.ends(0, &render(&["-o", "f-%03d.exr", "--seed=7"]));
    let all = ["ball.xml", "f-002.exr", "f-002.png", "f-003.exr", "f-003.png", "f-004.exr", "f-004.png"];
    assert_eq!(folder.files(), all, "no checkpoint of a complete frame stays");
    let bytes = |name: &str| folder.bytes(name);
    let before = [bytes("f-002.exr"), bytes("f-003.exr"), bytes("f-004.exr")];
    // By itself, with the shutter and the seed of frame 3.
    let alone =
        ["render", "ball.xml", "-q", "-D", "open=0.3", "-D", "close=0.35", "--seed=10", "-o", "alone.exr"];
    folder.ends(0, &alone);
    let channels = |name: &str| folder.picture(name).channels;
    assert_eq!(channels("alone.exr"), channels("f-003.exr"));
    assert!(channels("f-002.exr") != channels("f-003.exr"), "nothing moves");
    // The ball's light moves with it: two pixels a frame, from x = 0.6 on.
    let middle = |name: &str| {
        let picture = folder.picture(name);
        let (_, green) = picture.channels.iter().find(|(name, _)| name == "G").expect("a channel").clone();
        let sum: f64 = green.iter().map(|&value| f64::from(value)).sum();
        let moment: f64 = green.iter().enumerate().map(|(i, &v)| (i % 20) as f64 * f64::from(v)).sum();
        moment / sum
    };
    let [second, fourth] = ["f-002.exr", "f-004.exr"].map(middle);
    assert!(((fourth - second).abs() - 4.0).abs() < 0.4, "{second}, {fourth}");

    // A frame that is missing is made again, and the others are left alone.
    std::fs::remove_file(folder.path("f-003.exr")).expect("it is there");
    folder.write("f-004.png", "not touched");
    let resume =
        ["render", "ball.xml", "--frames=2..5", "--fps=10", "-o", "f-%03d.exr", "--seed=7", "--resume"];
    let told = folder.ends(0, &resume);
    assert!(told.contains("f-002.exr is complete") && told.contains("f-004.exr is complete"), "{told}");
    assert!(!told.contains("f-003.exr is complete"), "{told}");
    assert_eq!([bytes("f-002.exr"), bytes("f-003.exr"), bytes("f-004.exr")], before);
    assert_eq!(folder.text("f-004.png"), "not touched");
    // What is there is of another seed.
    let told = folder.ends(2, &render(&["-o", "f-%03d.exr", "--seed=8", "--resume"]));
    assert!(told.contains("abbe.seed") && told.contains("f-002.exr"), "{told}");
    let told = folder.ends(2, &render(&["-o", "f-%03d.exr", "--seed=7", "--spp=64", "--resume"]));
    assert!(told.contains("the number of samples per pixel is 4 there and 64 here"), "{told}");
    folder.write("f-002.exr", "cut");
    let told = folder.ends(2, &resume);
    assert!(told.contains("cannot read f-002.exr") && told.contains("help: remove it"), "{told}");
}

/// A frame that was stopped has a checkpoint beside its picture: it is not complete.
#[test]
fn a_frame_that_was_stopped_goes_on() {
    let folder = Folder::new("frames-stopped");
    folder.write("ball.xml", BALL);
    let with = |more: &[&'static str]| render(&[&["-o", "f-%d.exr", "--no-png"], more].concat());
    folder.ends(0, &with(&[]));
    let whole = folder.bytes("f-2.exr");
    // As a stop leaves it: part of the samples in the picture, all that is done in the checkpoint.
    let part = ["render", "ball.xml", "-q", "-D", "open=0.2", "-D", "close=0.25", "--seed=2", "--no-png"];
    folder.ends(0, &[&part[..], &["--checkpoint", "-o", "g.exr"]].concat());
    std::fs::rename(folder.path("g.checkpoint"), folder.path("f-2.checkpoint")).expect("it is there");
    folder.write("f-2.exr", "half of a picture");
    let told = folder.ends(2, &with(&[]));
    assert!(told.contains("f-2.checkpoint is there already"), "{told}");
    folder.ends(0, &with(&["--resume"]));
    assert!(folder.bytes("f-2.exr") == whole, "another picture after a break");
    assert!(!folder.exists("f-2.checkpoint"));
}

/// H33: a wheel with one spoke of light, at five turns a second and six frames a second, turns backwards by
/// 60° a frame where the shutter is open for an instant, and smears over 300° where it is open all the time.
#[test]
fn a_wheel_at_five_turns_a_second_turns_backwards_in_the_film() {
    let folder = Folder::new("frames-wheel");
    // A keyframe for each quarter of a turn, a twentieth of a second, and for a second more.
    let keys: String = (0..=40)
        .map(|quarter| {
            format!(
                r#"<transform time="{}"><rotate z="1" angle="{}"/></transform>"#,
                f64::from(quarter) / 20.0,
                90 * quarter
            )
        })
        .collect();
    folder.write(
        "wheel.xml",
        format!(
            r#"<scene version="3.0.0"><default name="close" value="0"/><integrator type="path"/>
            <sensor type="orthographic"><float name="shutter_close" value="$close"/>
            <transform name="to_world"><lookat origin="0, 0, 5" target="0, 0, 0" up="0, 1, 0"/></transform>
            <film type="hdrfilm"><integer name="width" value="24"/><integer name="height" value="24"/>
            <rfilter type="box"/></film></sensor>
            <shape type="sphere"><point name="center" x="0.7" y="0" z="0"/><float name="radius" value="0.1"/>
            <animation name="to_world">{keys}</animation><emitter type="area"><spectrum name="radiance" value="1"/></emitter></shape></scene>"#
        ),
    );
    let render = |more: &[&str]| {
        let common = ["render", "wheel.xml", "--frames=0..6", "--spp=64", "--no-png", "-q"];
        folder.ends(0, &[&common[..], &["--estimator=plain"], more].concat());
    };
    // What is lit, as angles around the axis.
    let lit = |name: &str| -> Vec<(f64, f64)> {
        let green = folder.picture(name).channel("G").expect("a channel").to_vec();
        let at = |i: usize| ((i % 24) as f64 - 11.5, 11.5 - (i / 24) as f64);
        (0..green.len())
            .filter(|&i| green[i] > 0.0)
            .map(|i| (at(i).1.atan2(at(i).0).to_degrees(), f64::from(green[i])))
            .collect()
    };
    // By how much the spoke seems to turn from frame to frame, the shorter way.
    let steps = |fps: &str| -> Vec<f64> {
        render(&[fps, "-o", "at-%d.exr"]);
        let spoke = |frame: u32| {
            let sum = lit(&format!("at-{frame}.exr")).iter().fold([0.0; 2], |[x, y], (degrees, light)| {
                let (sin, cos) = degrees.to_radians().sin_cos();
                [x + light * cos, y + light * sin]
            });
            sum[1].atan2(sum[0]).to_degrees()
        };
        let shorter = |step: f64| (step + 540.0).rem_euclid(360.0) - 180.0;
        (0..5).map(|frame| shorter(spoke(frame + 1) - spoke(frame))).collect()
    };
    // 30° a frame is the way that it turns.
    let (fast, slow) = (steps("--fps=60"), steps("--fps=6"));
    let forward = fast[0].signum();
    assert!(fast.iter().all(|step| (forward * step - 30.0).abs() < 3.0), "{fast:?}");
    assert!(slow.iter().all(|step| (forward * step + 60.0).abs() < 3.0), "{slow:?}, and {fast:?}");
    // A sixth of a second is five sixths of a turn: of each sixth of the circle, all but one is lit.
    render(&["--fps=6", "-D", "close=0.1666666667", "-o", "all-%d.exr"]);
    for frame in 0..6 {
        let lit = lit(&format!("all-{frame}.exr"));
        // In steps of 5°: the ball itself is 16° wide.
        let dark = (0..72).filter(|step| {
            let middle = 5.0 * f64::from(*step) - 180.0;
            lit.iter().all(|(degrees, _)| ((degrees - middle + 540.0).rem_euclid(360.0) - 180.0).abs() > 5.0)
        });
        let dark = 5 * dark.count();
        assert!((30..=60).contains(&dark), "frame {frame}: {dark}° are dark");
    }
}

#[test]
fn wrong_frames_are_2() {
    let folder = Folder::new("frames-wrong");
    folder.write("ball.xml", BALL);
    for (arguments, expected) in [
        (vec!["--frames=0..2", "-o", "f.exr"], "%04d"),
        (vec!["--frames=0..2", "-o", "f-%04d.checkpoint"], "frames are EXR files"),
        (vec!["--frames=0..2", "-o", "f-%d-%d.exr"], "in the name once"),
        (vec!["--frames=0..2", "-o", "dir%d/f.exr"], "not of its folder"),
        (vec!["--frames=2..2", "-o", "f-%d.exr"], "A..B"),
        (vec!["--frames=0..2"], "--output"),
        (vec!["--fps=3", "-o", "f.exr"], "--frames"),
        (vec!["--frames=0..2", "--fps=0", "-o", "f-%d.exr"], "above 0"),
        (vec!["--frames=0..2", "--samples=0..2", "-o", "f-%d.exr"], "--samples"),
    ] {
        let told = folder.ends(2, &[&["render", "ball.xml"], &arguments[..]].concat());
        assert!(told.contains(expected), "{arguments:?}: {told}");
    }
    assert_eq!(folder.files(), ["ball.xml"]);
}
