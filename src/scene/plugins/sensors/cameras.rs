//! Where cameras stand, how wide those with a map of directions see, and between which planes.

use super::super::fields::{Choices, Float};
use super::super::{Field, Ignored, Parameter, Range, Simple, Takes, choice, float, ignored};
use super::Motion;
use crate::camera::FisheyeProjection;
use crate::geometry::Transform;
use crate::scene::read::Query;
use crate::scene::source::SceneError;
use crate::scene::write::{Node, Writer};

/// How far a camera's axes may be from orthonormal, as matrices written with few digits are.
const LOOSEST_FRAME: f64 = 1e-3;

/// Mitsuba 3 reads and ignores where a camera without a lens focuses.
pub const NO_FOCUS: Ignored =
    ignored("focus_distance", Takes::Float(Range::ALL), "there is no lens").listed();

pub const ANGLE_ACROSS: Simple<Float> = angle("fov", 360.0, "angle across the picture")
    .said("The field of view is {} degrees", "expected an angle above 0 and up to 360 degrees");

pub const ANGLE_UP: Simple<Float> = angle("fov_y", 180.0, "angle up the picture")
    .said("The field of view is {} degrees", "expected an angle above 0 and up to 180 degrees");

/// An angle above 0 and up to `most`, which is the default.
const fn angle(name: &'static str, most: f64, doc: &'static str) -> Simple<Float> {
    let range = Range { low: 0.0, with_low: false, high: most, with_high: true };
    float(name, most, doc).within(range).unit("degrees")
}

fn placement() -> Vec<Parameter> {
    let doc = "where it stands; it looks along its local +z, +y is up";
    vec![Parameter { doc, ..Parameter::new("to_world", Takes::Placement) }]
}

/// `to_world` of a camera.
pub struct Placed;

impl Field for Placed {
    type Value = (Transform, Motion);

    fn parameters(&self) -> Vec<Parameter> {
        placement()
    }

    fn read(&self, query: &Query<'_>) -> Option<Self::Value> {
        Some(query.placement())
    }

    fn write(&self, node: Node, (to_world, motion): &Self::Value, _: &mut Writer) -> Node {
        node.placement(to_world, motion)
    }
}

/// `to_world` of a camera that nothing may scale.
pub struct Rigid;

impl Field for Rigid {
    type Value = (Transform, Motion);

    fn parameters(&self) -> Vec<Parameter> {
        placement()
    }

    fn read(&self, query: &Query<'_>) -> Option<Self::Value> {
        let (to_world, motion) = query.placement();
        let keys = motion.iter().flat_map(|motion| &motion.keys).map(|(_, to_world)| to_world);
        if keys.chain([&to_world]).all(|to_world| to_world.is_rigid(LOOSEST_FRAME)) {
            return Some((to_world, motion));
        }
        query.error(
            SceneError::at(
                &query.place("to_world"),
                "The camera's transform scales",
                "expected a transform that only rotates and moves",
            )
            .with_remedy("leave out <scale>; a rotation axis must have length 1"),
        );
        Some((Transform::IDENTITY, None))
    }

    fn write(&self, node: Node, value: &Self::Value, writer: &mut Writer) -> Node {
        Placed.write(node, value, writer)
    }
}

/// Distances between which a camera sees.
pub struct Clips;

impl Clips {
    const NEAR: Simple<Float> = float("near_clip", 1e-2, "nothing nearer is seen").positive();
    const FAR: Simple<Float> = float("far_clip", 1e4, "nothing farther is seen").positive();
}

impl Field for Clips {
    type Value = (f64, f64);

    fn parameters(&self) -> Vec<Parameter> {
        [Self::NEAR.parameters(), Self::FAR.parameters()].concat()
    }

    fn read(&self, query: &Query<'_>) -> Option<(f64, f64)> {
        let (near, far) = (Self::NEAR.read(query)?, Self::FAR.read(query)?);
        if near >= far {
            let problem = format!("The near plane ({near}) is not before the far plane ({far})");
            let place = query.place(if query.has("near_clip") { "near_clip" } else { "far_clip" });
            query.error(SceneError::at(&place, problem, "expected near_clip below far_clip"));
        }
        Some((near, far))
    }

    fn write(&self, node: Node, (near, far): &(f64, f64), writer: &mut Writer) -> Node {
        Self::FAR.write(Self::NEAR.write(node, near, writer), far, writer)
    }
}

/// How a fisheye shows its cone, and the angle across it in degrees.
pub struct Circle;

impl Circle {
    const PROJECTION: Simple<Choices<FisheyeProjection>> = choice(
        "projection",
        FisheyeProjection::Equidistant,
        &FisheyeProjection::NAMES,
        "how angles from the axis become distances on the film",
    );
}

impl Field for Circle {
    type Value = (FisheyeProjection, f64);

    fn parameters(&self) -> Vec<Parameter> {
        let range = Range { low: 0.0, with_low: false, high: 360.0, with_high: true };
        let fov = Parameter::new("fov", Takes::Float(range));
        let doc = "angle across the largest circle on the film; `orthographic` shows 180 at most, \
                   `stereographic` less than 360";
        let fov = Parameter { default: "180".to_owned(), unit: "degrees", doc, ..fov };
        [vec![fov], Self::PROJECTION.parameters()].concat()
    }

    fn read(&self, query: &Query<'_>) -> Option<Self::Value> {
        const DEFAULT: f64 = 180.0;
        let projection = Self::PROJECTION.read(query)?;
        let (limit, included) = projection.limit();
        let most = (2.0 * limit).to_degrees();
        let fov = query.float("fov").unwrap_or(DEFAULT);
        if fov > 0.0 && (fov < most || included && fov == most) {
            return Some((projection, fov));
        }
        let expected = match included {
            true => format!("expected an angle above 0 and up to {most} degrees"),
            false => format!("expected an angle between 0 and {most} degrees"),
        };
        let problem = format!("The field of view is {fov} degrees");
        query.error(SceneError::at(&query.place("fov"), problem, expected));
        Some((projection, DEFAULT))
    }

    fn write(&self, node: Node, (projection, fov): &Self::Value, writer: &mut Writer) -> Node {
        Self::PROJECTION.write(node.float("fov", *fov), projection, writer)
    }
}
