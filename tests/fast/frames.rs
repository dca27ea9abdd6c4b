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

#[test]
fn wrong_frames_are_2() {
    let folder = Folder::new("frames-wrong");
    folder.write("ball.xml", BALL);
    for (arguments, expected) in [
        (vec!["--frames=0..2", "-o", "f.exr"], "%04d"),
        (vec!["--frames=0..2", "-o", "f-%04d.checkpoint"], "%04d"),
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
