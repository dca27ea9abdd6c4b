//! The renderer leaves out the features that a scene does not ask for (`Features`). These kernels switch them
//! on all the same: the difference to "nothing more" is what leaving each of them out is worth.
//!
//! The loop does not branch on the other features: what does not disperse, is not rough or does not move is
//! another kind of material, spectrum or transform.

use super::Kernel;
use super::paths::{compiled, picture};
use abbe::scene::Features;

/// Features on which the loop branches, with those that they rely on, and those without a branch.
const FORCED: [(&str, Features); 9] = {
    let none = Features {
        dispersion: false,
        absorption: false,
        scattering: false,
        medium_stack: false,
        precedence: false,
        contact: false,
        sensor_within: false,
        lens: false,
        motion: false,
        light_samples: false,
        rough_surfaces: false,
        choices: false,
        transparent_shadows: false,
        textures: false,
        caustics: false,
        visible_lamps: false,
    };
    [
        ("nothing more", none),
        ("medium stack", Features { medium_stack: true, ..none }),
        ("absorption", Features { absorption: true, medium_stack: true, ..none }),
        ("precedence", Features { precedence: true, medium_stack: true, ..none }),
        ("surfaces in contact", Features { contact: true, medium_stack: true, ..none }),
        ("sensor within a body", Features { sensor_within: true, medium_stack: true, ..none }),
        ("lens", Features { lens: true, ..none }),
        ("mixed materials", Features { choices: true, ..none }),
        ("transparent shadows", Features { transparent_shadows: true, ..none }),
    ]
};

pub fn kernels() -> Vec<Kernel> {
    let of = |scene: &'static str| {
        FORCED.into_iter().map(move |(name, features)| {
            picture(format!("{scene}, {name}"), compiled(scene).with_features(features))
        })
    };
    ["cornell", "caustic"].into_iter().flat_map(of).collect()
}
