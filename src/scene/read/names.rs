//! Names: which was probably meant, and which exist in Mitsuba 3 but not here.

use super::tree::Class;

/// The known name that a mistyped one is most like, if any is like it.
pub(super) fn nearest<'a>(wrong: &str, known: &[&'a str]) -> Option<&'a str> {
    let lower = wrong.to_lowercase();
    let best = known
        .iter()
        .map(|&name| (strsim::jaro_winkler(&lower, &name.to_lowercase()), name))
        // The first of equals, so that the answer does not depend on anything else.
        .fold((0.0, ""), |best, next| if next.0 > best.0 { next } else { best });
    let edits = strsim::damerau_levenshtein(&lower, &best.1.to_lowercase());
    let plausible = best.0 > 0.84 || edits <= 1 + wrong.chars().count() / 5;
    (plausible && !best.1.is_empty()).then_some(best.1)
}

/// Names in a row, the first dozen of them.
pub(super) fn listing(names: &[&str]) -> String {
    const MOST: usize = 12;
    let mut text = names.iter().take(MOST).copied().collect::<Vec<_>>().join(", ");
    if names.len() > MOST {
        text.push_str(&format!(" and {} more", names.len() - MOST));
    }
    text
}

/// "a, b or c".
pub(super) fn either(names: &[&str]) -> String {
    match names {
        [] => String::new(),
        [only] => (*only).to_owned(),
        [first @ .., last] => format!("{} or {last}", first.join(", ")),
    }
}

/// The plugins that can be read, by class.
pub(super) fn plugins(class: Class) -> &'static [&'static str] {
    match class {
        Class::Integrator => &["path", "direct", "volpath", "volpathmis", "walk"],
        Class::Sensor => &["perspective", "thinlens"],
        Class::Film => &["hdrfilm"],
        Class::Sampler => &["independent", "stratified", "multijitter", "orthogonal", "ldsampler", "sobol"],
        Class::Filter => &["box", "tent", "gaussian", "mitchell", "catmullrom", "lanczos"],
        Class::Shape => &[
            "sphere",
            "rectangle",
            "disk",
            "cube",
            "cylinder",
            "obj",
            "ply",
            "serialized",
            "merge",
            "shapegroup",
            "instance",
        ],
        Class::Bsdf => &[
            "diffuse",
            "conductor",
            "roughconductor",
            "dielectric",
            "roughdielectric",
            "twosided",
            "mask",
            "blendbsdf",
            "bumpmap",
            "normalmap",
            "null",
            "diffusetransmitter",
        ],
        Class::Emitter => &["area", "point", "directional", "constant"],
        Class::Medium => &["homogeneous"],
        Class::Spectrum => {
            &["uniform", "regular", "irregular", "d65", "blackbody", "measured", "sellmeier", "cauchy"]
        }
        Class::Phase => &["isotropic", "hg"],
        Class::Scene | Class::Volume => &[],
    }
}

/// Plugins of Mitsuba 3.9 that are not here.
pub(super) fn mitsuba_plugins(class: Class) -> &'static [&'static str] {
    match class {
        Class::Integrator => &[
            "aov",
            "depth",
            "moment",
            "prb",
            "prb_basic",
            "prb_projective",
            "prbvolpath",
            "direct_projective",
            "ptracer",
            "stokes",
            "time_gated_path",
        ],
        Class::Sensor => &["batch", "distant", "irradiancemeter", "orthographic", "radiancemeter"],
        Class::Film => &["specfilm"],
        Class::Shape => {
            &["bsplinecurve", "ellipsoids", "ellipsoidsmesh", "linearcurve", "sdfgrid", "blender"]
        }
        Class::Bsdf => &[
            "circular",
            "hair",
            "measured",
            "measured_polarized",
            "plastic",
            "polarizer",
            "pplastic",
            "principled",
            "principledthin",
            "retarder",
            "roughplastic",
            "thindielectric",
        ],
        Class::Emitter => {
            &["directionalarea", "envmap", "projector", "sky", "spot", "sun", "sunsky", "timed_sunsky"]
        }
        Class::Medium => &["heterogeneous"],
        Class::Phase => &["blendphase", "rayleigh", "sggx", "tabphase"],
        Class::Spectrum => &[
            "bitmap",
            "checkerboard",
            "mesh_attribute",
            "rawconstant",
            "rgb",
            "srgb",
            "volume",
            "vertexattribute",
        ],
        Class::Volume => &["constvolume", "gridvolume"],
        Class::Scene | Class::Sampler | Class::Filter => &[],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_name_is_found_or_none() {
        let known = ["radius", "center", "to_world", "flip_normals"];
        assert_eq!(nearest("raduis", &known), Some("radius"));
        assert_eq!(nearest("toWorld", &known), Some("to_world"));
        assert_eq!(nearest("CENTRE", &known), Some("center"));
        assert_eq!(nearest("banana", &known), None);
        assert_eq!(nearest("x", &[]), None);
    }

    #[test]
    fn lists_read_well() {
        assert_eq!(either(&["a", "b", "c"]), "a, b or c");
        assert_eq!(either(&["a"]), "a");
        let many: Vec<&str> = vec!["n"; 14];
        assert!(listing(&many).ends_with("n and 2 more"));
    }
}
