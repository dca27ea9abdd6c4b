//! Scenes that mean harm: nothing panics, nothing takes long, nothing is allocated for a promise.

use super::read;
use crate::common::mutation::{mutated, within};
use abbe::scene::{CompileOptions, ReadOptions, read_str};
use std::path::Path;
use std::time::Duration;

const SCENE: &str = include_str!("everything.xml");

#[test]
fn mutated_files_do_not_panic() {
    assert!(read(SCENE).is_ok(), "{}", read(SCENE).unwrap_err());
    let mut state = 20_261_121;
    within(Duration::from_secs(60), "all of it", || {
        for _ in 0..4000 {
            let bytes = mutated(SCENE.as_bytes(), &mut state);
            let text = String::from_utf8_lossy(&bytes);
            within(Duration::from_secs(5), &text, || drop(read(&text)));
        }
    });
}

#[test]
fn deep_and_wide_scenes_end_quickly() {
    let deep = |element: &str, count: usize| {
        let open = format!("<{element} type=\"twosided\">").repeat(count);
        let close = format!("</{element}>").repeat(count);
        format!("<scene version=\"3.0.0\"><sensor type=\"perspective\"/>{open}{close}</scene>")
    };
    within(Duration::from_secs(5), "a deep scene", || {
        assert!(read(&deep("bsdf", 20_000)).unwrap_err().contains("nested more than"));
    });
    for (backwards, last) in [(false, 20_000), (true, 0)] {
        let link = |i| if backwards { (i + 1, i) } else { (i, i + 1) };
        let chain: String = (0..20_000)
            .map(link)
            .map(|(id, next)| format!("<bsdf type=\"twosided\" id=\"{id}\"><ref id=\"{next}\"/></bsdf>"))
            .collect();
        let chain = format!(
            "<scene version=\"3.0.0\"><sensor type=\"perspective\"/>{chain}<bsdf type=\"diffuse\" id=\"{last}\"/></scene>"
        );
        within(Duration::from_secs(20), "a chain of references", || {
            let options = ReadOptions::default();
            let errors = read_str(chain, Path::new("chain.xml"), &options).unwrap_err();
            let deep = errors.errors.iter().filter(|error| error.problem.contains("nested more than"));
            assert!(deep.count() > 0);
            assert!(errors.to_string().contains("more errors"));
        });
    }
    // Each object holds the one before twice.
    let twice = |count: usize| -> String {
        let link = |i| {
            let below = i - 1;
            format!(
                "<bsdf type=\"blendbsdf\" id=\"{i}\"><float name=\"weight\" value=\"0.5\"/><ref id=\"{below}\" name=\"a\"/><ref id=\"{below}\" name=\"b\"/></bsdf>"
            )
        };
        let links: String = (1..=count).map(link).collect();
        format!(
            "<bsdf type=\"diffuse\" id=\"0\"/>{links}<shape type=\"sphere\"><ref id=\"{count}\"/></shape>"
        )
    };
    within(Duration::from_secs(5), "objects within objects twice", || {
        let scene = super::scene(&twice(8));
        assert!(abbe::scene::outline(&scene).contains("as above"));
        let compiled = abbe::scene::compile(&scene, &CompileOptions::default()).unwrap();
        let text = abbe::scene::json(&scene, &compiled.features(), None);
        assert_eq!(super::read(&text).unwrap().hash(), scene.hash());
        assert!(super::errors(&twice(60)).contains("more than 4096 objects"));
    });
    let doubling: String =
        (0..64).map(|i| format!("<default name=\"a{}\" value=\"$a{i}$a{i}\"/>", i + 1)).collect();
    let doubling = format!(
        "<scene version=\"3.0.0\"><sensor type=\"perspective\"/><default name=\"a0\" value=\"xxxx\"/>{doubling}</scene>"
    );
    within(Duration::from_secs(5), "doubling parameters", || drop(read(&doubling)));
}

#[test]
fn tables_stay_small_whatever_their_range() {
    let bounds = r#"<float name="wavelength_min" value="400"/><float name="wavelength_max" value="1e12"/>"#;
    let scene = super::scene(&format!(
        r#"<emitter type="constant"><spectrum name="radiance" type="blackbody"><float name="temperature" value="3000"/>{bounds}</spectrum></emitter>"#
    ));
    within(Duration::from_secs(5), "a black body of any range", || {
        assert!(abbe::scene::compile(&scene, &CompileOptions::default()).is_ok());
    });
}
