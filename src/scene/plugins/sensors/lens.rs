//! The lens of a camera.

use super::super::{Field, Parameter, Range, Takes};
use super::cameras::Clips;
use crate::scene::description::{Aperture, Lens};
use crate::scene::read::Query;
use crate::scene::source::SceneError;
use crate::scene::write::{Node, Writer};

/// Most blades of an aperture.
const MOST_BLADES: i64 = 1000;

/// A thin lens, and the distances between which its camera sees: it focuses on the farther one by default.
pub struct LensAndClips;

impl Field for LensAndClips {
    type Value = (Lens, f64, f64);

    fn parameters(&self) -> Vec<Parameter> {
        let radius = Parameter::new("aperture_radius", Takes::Float(Range::NOT_NEGATIVE));
        let stop = Parameter::new("f_stop", Takes::Float(Range::POSITIVE));
        let blades = Parameter::new("aperture_blades", Takes::Integer(0, MOST_BLADES));
        let rotation = Parameter::new("aperture_rotation", Takes::Float(Range::ALL));
        let focus = Parameter::new("focus_distance", Takes::Float(Range::POSITIVE));
        let of_stop = "in place of `aperture_radius`, focal length over diameter";
        let of_blades = "straight blades that bound the aperture, 3 or more; 0 for a round one";
        let of_rotation = "by how much the blades are turned, counter-clockwise from behind the camera";
        let zero = || "0".to_owned();
        let of_lens = vec![
            Parameter { is_required: true, doc: "radius of the lens; not with `f_stop`", ..radius },
            Parameter { is_extension: true, doc: of_stop, ..stop },
            Parameter { is_extension: true, default: zero(), doc: of_blades, ..blades },
            Parameter { is_extension: true, default: zero(), unit: "degrees", doc: of_rotation, ..rotation },
            Parameter { doc: "distance that is in focus; otherwise `far_clip`", ..focus },
        ];
        [of_lens, Clips.parameters()].concat()
    }

    fn read(&self, query: &Query<'_>) -> Option<Self::Value> {
        let (near_clip, far_clip) = Clips.read(query)?;
        let focus_distance = query.positive("focus_distance", far_clip);
        let (blades, rotation) = blades(query);
        let aperture = aperture(query);
        Some((Lens { aperture, blades, rotation, focus_distance }, near_clip, far_clip))
    }

    fn write(&self, node: Node, (lens, near_clip, far_clip): &Self::Value, writer: &mut Writer) -> Node {
        let node = match lens.aperture {
            Aperture::Radius(radius) => node.float("aperture_radius", radius),
            Aperture::Stop(stop) => node.float("f_stop", stop),
        };
        let node = match lens.blades {
            0 => node,
            blades => node.integer("aperture_blades", blades).float("aperture_rotation", lens.rotation),
        };
        Clips.write(node.float("focus_distance", lens.focus_distance), &(*near_clip, *far_clip), writer)
    }
}

/// A pinhole where it is wrong or missing, which is reported.
fn aperture(query: &Query<'_>) -> Aperture {
    if query.has("f_stop") {
        let stop = query.positive("f_stop", 1.0);
        if query.has("aperture_radius") {
            query.float("aperture_radius");
            query.error(
                SceneError::at(
                    &query.place("f_stop"),
                    "The aperture is given twice",
                    "expected either aperture_radius or f_stop",
                )
                .with_remedy(
                    "the radius that an f_stop stands for is the focal length / (2 f_stop), in metres",
                ),
            );
        }
        query.reader.extension(&query.place("f_stop"), format!("f_stop: the aperture is f/{stop}"));
        return Aperture::Stop(stop);
    }
    let radius = query.required("aperture_radius", query.float("aperture_radius")).unwrap_or(0.0);
    if radius < 0.0 {
        let problem = format!("The aperture has a radius of {radius}");
        query.error(SceneError::at(&query.place("aperture_radius"), problem, "expected at least 0"));
    }
    Aperture::Radius(radius)
}

/// The number of an aperture's blades, 0 where it is round, and by how many degrees they are turned.
fn blades(query: &Query<'_>) -> (u32, f64) {
    let (name, turned) = ("aperture_blades", "aperture_rotation");
    let rotation = query.float(turned);
    let blades = query.integer(name, 0, MOST_BLADES).unwrap_or(0);
    if (1..3).contains(&blades) {
        query.error(SceneError::at(
            &query.place(name),
            format!("The aperture has {blades} {}", if blades == 1 { "blade" } else { "blades" }),
            format!("expected 0 for a round aperture, or an integer from 3 to {MOST_BLADES}"),
        ));
    } else if blades > 0 {
        query.reader.extension(&query.place(name), format!("{name}: the aperture is a regular polygon"));
    } else if rotation.is_some() && !query.has(name) {
        query.error(
            SceneError::at(
                &query.place(turned),
                "A round aperture is not turned",
                "expected aperture_blades beside aperture_rotation",
            )
            .with_remedy("say how many blades there are, 3 or more"),
        );
    }
    // Nothing is left of the angle where it changes nothing.
    (blades as u32, rotation.filter(|_| blades > 0).unwrap_or(0.0))
}
