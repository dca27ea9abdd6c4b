use super::*;

/// JSON tells the class of an object by its plugin alone, but for the regular spectrum and the regular
/// sampler.
#[test]
fn no_two_classes_share_a_plugin() {
    assert_eq!(class_of("regular", ["wavelength_min", "values"].into_iter()), Some(Class::Spectrum));
    assert_eq!(class_of("regular", ["sample_count"].into_iter()), Some(Class::Sampler));
    let all = || Class::ELEMENTS.iter().flat_map(|&(_, class)| plugins(class));
    for name in all().filter(|name| *name != "regular") {
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

/// What reading a scene with one object of a plugin says about it. Where the object is meant to stand is
/// seen to; that it lacks what it cannot be without is no matter.
pub(in crate::scene::read) fn said_of(class: Class, plugin: &str) -> String {
    let word = class.word();
    let object = format!("<{word} type=\"{plugin}\"/>");
    let film = |content: &str| format!("<film type=\"hdrfilm\">{content}</film>");
    let sensor = |content: &str| format!("<sensor type=\"perspective\">{content}</sensor>");
    let within = |content: &str| format!("{}<shape type=\"sphere\">{content}</shape>", sensor(""));
    let scene = match class {
        Class::Sensor if plugin == "irradiancemeter" => {
            format!("<shape type=\"sphere\">{object}</shape>")
        }
        Class::Sensor => object,
        Class::Film | Class::Sampler => sensor(&object),
        Class::Filter => sensor(&film(&object)),
        Class::Emitter if plugin.ends_with("area") => within(&object),
        Class::Medium => within(&format!("<medium name=\"interior\" type=\"{plugin}\"/>")),
        Class::Phase => within(&format!("<medium name=\"interior\" type=\"homogeneous\">{object}</medium>")),
        _ => sensor("") + &object,
    };
    let scene = format!("<scene version=\"3.0.0\">{scene}</scene>");
    let read = crate::scene::read_str(scene, std::path::Path::new("scene.xml"), &Default::default());
    read.map_or_else(|errors| errors.to_string(), |_| String::new())
}

/// Whether a message says that there is no such plugin.
fn refuses(message: &str, class: Class, plugin: &str) -> bool {
    let word = format!("{} \"{plugin}\"", class.word());
    message.to_lowercase().contains(&format!("{word} is not supported"))
        || message.contains(&format!("There is no {word}"))
}

/// The lists are what hints are made of. One that lags behind the reader tells nobody of what there is.
#[test]
fn the_reader_accepts_what_is_listed_and_nothing_that_is_said_to_be_missing() {
    let mut wrong = Vec::new();
    for &(_, class) in &Class::ELEMENTS {
        for plugin in plugins(class) {
            if refuses(&said_of(class, plugin), class, plugin) {
                wrong.push(format!("{plugin} is listed and not read"));
            }
        }
        for plugin in mitsuba_plugins(class) {
            if !refuses(&said_of(class, plugin), class, plugin) {
                wrong.push(format!("{plugin} is said to be missing and is read"));
            }
            if plugins(class).contains(plugin) {
                wrong.push(format!("{plugin} is in both lists"));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
