use super::*;

/// JSON tells the class of an object by its plugin alone, but for two names.
#[test]
fn two_names_alone_are_shared_by_classes() {
    assert_eq!(class_of("regular", ["wavelength_min", "values"].into_iter()), Some(Class::Spectrum));
    assert_eq!(class_of("regular", ["sample_count"].into_iter()), Some(Class::Sampler));
    assert_eq!(class_of("measured", ["filename"].into_iter()), Some(Class::Bsdf));
    assert_eq!(class_of("measured", ["name", "scale"].into_iter()), Some(Class::Spectrum));
    let all = || Class::ELEMENTS.iter().flat_map(|&(_, class)| plugins(class));
    for name in all().filter(|name| !["regular", "measured"].contains(name)) {
        assert_eq!(all().filter(|other| *other == name).count(), 1, "{name}");
    }
}

/// Each shape and each texture has a picture, or a word on why it has none.
#[test]
fn the_gallery_shows_every_shape_and_texture() {
    let gallery = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/gallery");
    let page = std::fs::read_to_string(gallery.join("README.md")).unwrap();
    let textures = plugins(Class::Spectrum).into_iter().filter(|name| is_texture(name));
    for name in plugins(Class::Shape).into_iter().chain(textures) {
        let shown = ["scene.xml", "picture.png"].iter().all(|file| gallery.join(name).join(file).is_file());
        assert!(shown || page.contains(&format!("`{name}`")), "scenes/gallery has no {name}");
    }
    for link in page.split(['"', '(', ')']).filter(|link| link.ends_with(".png") || link.ends_with(".xml")) {
        assert!(gallery.join(link).is_file(), "{link} is not there");
    }
}

#[test]
fn no_plugin_is_both_here_and_missing() {
    for &(_, class) in &Class::ELEMENTS {
        for plugin in mitsuba_plugins(class) {
            assert!(!plugins(class).contains(plugin), "{plugin}");
        }
    }
}
