//! The same scene and seed give the same file, bit for bit, whatever the number of threads.

use crate::common::folder::{Folder, of_repository};

fn render(folder: &Folder, arguments: &[&str]) -> Vec<u8> {
    let scene = of_repository("tests/scenes/agreement/dispersion.xml");
    let common = ["render", &scene, "--quiet", "--spp=16", "--spectral=10", "--size=35x20", "-o", "x.exr"];
    let images = ["--aov", "albedo,sh_normal,depth,position,shape_index"];
    folder.ends(0, &[&common, &images[..], arguments].concat());
    folder.bytes("x.exr")
}

#[test]
fn threads_leave_no_trace_in_the_file() {
    let folder = Folder::new("determinism");
    let one = render(&folder, &["--threads", "1"]);
    for threads in ["2", "7"] {
        let other = render(&folder, &["--threads", threads]);
        assert!(one == other, "{threads} threads give another file than one");
    }
    let again = render(&folder, &["--threads", "1"]);
    assert!(one == again, "a second run gives another file");
    let reseeded = render(&folder, &["--seed", "5"]);
    assert!(one != reseeded, "another seed gives the same file: the comparison cannot fail");
}

#[test]
fn every_sampler_leaves_threads_no_trace() {
    let folder = Folder::new("samplers");
    let mut files = Vec::new();
    for (sampler, _) in abbe::sampling::SamplerKind::NAMES {
        let with = |threads: &str| render(&folder, &["--sampler", sampler, "--threads", threads]);
        let one = with("1");
        assert!(one == with("5"), "{sampler}: five threads give another file than one");
        assert!(!files.contains(&one), "{sampler} gives the file of another sampler");
        files.push(one);
    }
}
