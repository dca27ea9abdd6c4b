//! What a scene does not need is left out (`Needs`): here it is done all the same. Against "nothing more" that tells what leaving it
//! out is worth.
//!
//! Of the others on the list of needs nothing is asked in the loop: what does not disperse, is not rough or does not move is
//! another kind of material, spectrum or transform.

use super::Kernel;
use super::paths::{compiled, picture};
use abbe::scene::Needs;

/// Needs that a question in the loop stands for, with those that they bring along, and those without any.
const FORCED: [(&str, Needs); 9] = {
    let none = Needs {
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
        clear_shadows: false,
        textures: false,
        light_paths: false,
    };
    [
        ("nothing more", none),
        ("medium stack", Needs { medium_stack: true, ..none }),
        ("absorption", Needs { absorption: true, medium_stack: true, ..none }),
        ("precedence", Needs { precedence: true, medium_stack: true, ..none }),
        ("surfaces in contact", Needs { contact: true, medium_stack: true, ..none }),
        ("sensor within a body", Needs { sensor_within: true, medium_stack: true, ..none }),
        ("lens", Needs { lens: true, ..none }),
        ("mixed materials", Needs { choices: true, ..none }),
        ("transparent shadows", Needs { clear_shadows: true, ..none }),
    ]
};

pub fn kernels() -> Vec<Kernel> {
    let of = |scene: &'static str| {
        FORCED
            .into_iter()
            .map(move |(name, needs)| picture(format!("{scene}, {name}"), compiled(scene).with_needs(needs)))
    };
    ["cornell", "caustic"].into_iter().flat_map(of).collect()
}
