//! The same scene and seed give the same file, bit for bit, whatever the number of threads.

use std::path::{Path, PathBuf};
use std::process::Command;

fn render(folder: &Path, name: &str, arguments: &[&str]) -> Vec<u8> {
    let output: PathBuf = folder.join(name);
    let run = Command::new(env!("CARGO_BIN_EXE_abbe"))
        .args([
            "render",
            "tests/scenes/agreement/dispersion.xml",
            "--quiet",
            "--spp",
            "16",
            "--spectral",
            "10",
        ])
        .args(["--aov", "albedo,sh_normal,depth,position,shape_index", "--size", "50x40", "-o"])
        .arg(&output)
        .args(arguments)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("the program starts");
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    std::fs::read(output).expect("the program wrote its file")
}

#[test]
fn threads_leave_no_trace_in_the_file() {
    let folder = std::env::temp_dir().join(format!("abbe-determinism-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder for temporary files");
    let one = render(&folder, "one.exr", &["--threads", "1"]);
    for threads in ["2", "7"] {
        let other = render(&folder, &format!("{threads}.exr"), &["--threads", threads]);
        assert!(one == other, "{threads} threads give another file than one");
    }
    let again = render(&folder, "again.exr", &["--threads", "1"]);
    assert!(one == again, "a second run gives another file");
    let reseeded = render(&folder, "seed.exr", &["--seed", "5"]);
    assert!(one != reseeded, "another seed gives the same file: the comparison cannot fail");
    std::fs::remove_dir_all(&folder).expect("the temporary files can be removed");
}

#[test]
fn every_sampler_leaves_threads_no_trace() {
    let folder = std::env::temp_dir().join(format!("abbe-samplers-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder for temporary files");
    let mut files = Vec::new();
    for (sampler, _) in abbe::sampling::SamplerKind::NAMES {
        let with = |threads: &str| {
            let arguments = ["--sampler", sampler, "--threads", threads];
            render(&folder, &format!("{sampler}.exr"), &arguments)
        };
        let one = with("1");
        assert!(one == with("5"), "{sampler}: five threads give another file than one");
        assert!(!files.contains(&one), "{sampler} gives the file of another sampler");
        files.push(one);
    }
    std::fs::remove_dir_all(&folder).expect("the temporary files can be removed");
}
