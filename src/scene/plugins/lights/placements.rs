//! Where lights stand, and where they shine.

use super::super::{Field, Parameter, Takes};
use crate::geometry::{Transform, Vec3};
use crate::scene::description::Animation;
use crate::scene::read::Query;
use crate::scene::source::SceneError;
use crate::scene::write::{Node, Writer};
use std::sync::Arc;

/// By how much the length of a transformed axis may differ from 1: transforms are often written with few
/// digits.
const LOOSEST_LENGTH: f64 = 1e-3;

fn to_world(takes: Takes, doc: &'static str) -> Parameter {
    Parameter { doc, ..Parameter::new("to_world", takes) }
}

/// `to_world` of light from beyond the scene, which has no place and no size.
pub fn rotation(query: &Query<'_>) -> Transform {
    let to_world = query.transform("to_world");
    if !to_world.is_rigid(LOOSEST_LENGTH) {
        query.error(
            SceneError::at(
                &query.place("to_world"),
                "The transform of light from all around scales",
                "expected a transform that only rotates",
            )
            .with_remedy(
                "leave out <scale>, which would not make the surroundings larger, only distort them; a rotation \
                 axis must have length 1",
            ),
        );
        return Transform::IDENTITY;
    }
    to_world
}

/// `to_world` of light from all around.
pub struct Turned;

impl Field for Turned {
    type Value = Transform;

    fn parameters(&self) -> Vec<Parameter> {
        vec![to_world(Takes::Transform, "how it is turned")]
    }

    fn read(&self, query: &Query<'_>) -> Option<Transform> {
        Some(rotation(query))
    }

    fn write(&self, node: Node, to_world: &Transform, _: &mut Writer) -> Node {
        node.transform("to_world", to_world)
    }
}

/// What moves a light, if anything does.
pub type Motion = Option<Arc<Animation>>;

/// `to_world` of a light that shines in some directions more than in others.
pub struct Rigid;

impl Field for Rigid {
    type Value = (Transform, Motion);

    fn parameters(&self) -> Vec<Parameter> {
        vec![to_world(Takes::Placement, "where it stands and how it is turned")]
    }

    fn read(&self, query: &Query<'_>) -> Option<Self::Value> {
        let (to_world, motion) = query.placement();
        if let Some(motion) = &motion
            && motion.keys.iter().any(|(_, to_world)| !to_world.is_rigid(LOOSEST_LENGTH))
        {
            let problem = "The light is scaled while it moves";
            let error =
                SceneError::at(&motion.place, problem, "expected keyframes that only rotate and move");
            query.error(error.with_remedy(
                "leave out <scale>, which would change what the light's angles mean; a rotation axis must have \
                 length 1",
            ));
        }
        Some((to_world, motion))
    }

    fn write(&self, node: Node, (to_world, motion): &Self::Value, _: &mut Writer) -> Node {
        node.placement(to_world, motion)
    }
}

/// Where a point light is.
pub struct Position;

impl Field for Position {
    type Value = (Vec3, Motion);

    fn parameters(&self) -> Vec<Parameter> {
        let position = Parameter::new("position", Takes::Vector);
        vec![
            Parameter { default: "(0, 0, 0)".to_owned(), doc: "where it stands", ..position },
            to_world(Takes::Placement, "instead of `position`"),
        ]
    }

    fn read(&self, query: &Query<'_>) -> Option<Self::Value> {
        let (to_world, motion) = query.placement();
        let position = query.vector("position");
        if position.is_some() && query.has("to_world") {
            query.error(SceneError::at(
                &query.place("position"),
                "The position is given twice",
                "expected either position or to_world",
            ));
        }
        Some((position.unwrap_or_else(|| to_world.point(Vec3::ZERO)), motion))
    }

    fn write(&self, node: Node, (position, motion): &Self::Value, _: &mut Writer) -> Node {
        match motion {
            None => node.vector("position", *position),
            Some(_) => node.placement(&Transform::IDENTITY, motion),
        }
    }
}

/// Where directional light goes.
pub struct Travel;

impl Field for Travel {
    type Value = (Vec3, Motion);

    fn parameters(&self) -> Vec<Parameter> {
        let direction = Parameter::new("direction", Takes::Vector);
        vec![
            Parameter { default: "(0, 0, 1)".to_owned(), doc: "where it goes", ..direction },
            to_world(Takes::Placement, "instead of `direction`: where it takes +z"),
        ]
    }

    fn read(&self, query: &Query<'_>) -> Option<Self::Value> {
        let (to_world, motion) = Rigid.read(query)?;
        let direction = query.vector("direction");
        if direction.is_some() && query.has("to_world") {
            query.error(SceneError::at(
                &query.place("direction"),
                "The direction is given twice",
                "expected either direction or to_world",
            ));
        }
        let along = to_world.vector(Vec3::Z);
        if direction.is_none() && (along.length() - 1.0).abs() > LOOSEST_LENGTH {
            query.error(
                SceneError::at(
                    &query.place("to_world"),
                    "The directional light's transform scales",
                    "expected a transform that keeps the length of the z axis",
                )
                .with_remedy(
                    "Mitsuba 3 would take the length for a part of the angle at which surfaces are lit; scale the irradiance instead",
                ),
            );
        }
        let travels = direction.unwrap_or(along);
        if travels.try_normalize().is_none() {
            query.error(SceneError::at(
                &query.place("direction"),
                "The light travels nowhere: its direction has no length",
                "expected a direction such as 0 0 -1",
            ));
            return None;
        }
        Some((travels, motion))
    }

    fn write(&self, node: Node, (travels, motion): &Self::Value, _: &mut Writer) -> Node {
        match motion {
            None => node.vector("direction", *travels),
            Some(_) => node.placement(&Transform::IDENTITY, motion),
        }
    }
}
