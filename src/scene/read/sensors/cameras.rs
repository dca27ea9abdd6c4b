//! Cameras: where they stand, how wide they see, and their lens.

use super::super::query::Query;
use super::Motion;
use crate::camera::{FisheyeProjection, Stop};
use crate::geometry::Transform;
use crate::scene::description::{AngularMap, Aperture, Lens, SensorKind};
use crate::scene::plugins::{Field, view::View};
use crate::scene::source::SceneError;

/// How far a camera's axes may be from orthonormal, as matrices written with few digits are.
const LOOSEST_FRAME: f64 = 1e-3;

pub(super) fn perspective(query: &Query<'_>, thin_lens: bool, motion: &mut Motion) -> Option<SensorKind> {
    let to_world;
    (to_world, *motion) = camera_to_world(query);
    let [near_clip, far_clip] = clips(query);
    let principal_point = if thin_lens {
        [0.0; 2]
    } else {
        ["principal_point_offset_x", "principal_point_offset_y"].map(|name| query.float(name).unwrap_or(0.0))
    };
    let lens = if thin_lens { lens(query, far_clip) } else { None };
    if !thin_lens {
        without_focus(query);
    }
    Some(SensorKind::Perspective {
        to_world,
        field_of_view: View.read(query)?,
        principal_point,
        near_clip,
        far_clip,
        lens,
    })
}

pub(super) fn orthographic(query: &Query<'_>, motion: &mut Motion) -> SensorKind {
    let to_world;
    (to_world, *motion) = query.placement();
    let [near_clip, far_clip] = clips(query);
    without_focus(query);
    SensorKind::Orthographic { to_world, near_clip, far_clip }
}

pub(super) fn fisheye(query: &Query<'_>, motion: &mut Motion) -> SensorKind {
    let text = "fisheye: a camera that sees a cone of any width on a circle";
    query.reader.extension(&query.object.place, text.to_owned());
    let projection = query.choice("projection", &FisheyeProjection::NAMES, false);
    let projection = projection.unwrap_or(FisheyeProjection::Equidistant);
    let (limit, included) = projection.limit();
    let most = (2.0 * limit).to_degrees();
    let fov = angle(query, "fov", 180.0, most, included);
    angular(query, AngularMap::Fisheye { projection, fov }, motion)
}

pub(super) fn panorama(query: &Query<'_>, motion: &mut Motion) -> SensorKind {
    let text = "panorama: a camera that sees all around, longitude across and latitude up";
    query.reader.extension(&query.object.place, text.to_owned());
    let fov = [angle(query, "fov", 360.0, 360.0, true), angle(query, "fov_y", 180.0, 180.0, true)];
    angular(query, AngularMap::Panorama { fov }, motion)
}

fn angular(query: &Query<'_>, map: AngularMap, motion: &mut Motion) -> SensorKind {
    let to_world;
    (to_world, *motion) = camera_to_world(query);
    let [near_clip, far_clip] = clips(query);
    SensorKind::Angular { to_world, map, near_clip, far_clip }
}

pub(super) fn plane(query: &Query<'_>, motion: &mut Motion) -> SensorKind {
    let text = "sensorplane: a film in the scene, which measures the irradiance through a stop";
    query.reader.extension(&query.object.place, text.to_owned());
    let to_world;
    (to_world, *motion) = camera_to_world(query);
    let stop = Stop {
        radius: query.positive("aperture_radius", 1.0),
        distance: query.positive("aperture_distance", 1.0),
    };
    SensorKind::Plane { to_world, width: query.positive("width", 1.0), stop }
}

/// Degrees above 0 and up to the most that can be shown.
fn angle(query: &Query<'_>, name: &'static str, default: f64, most: f64, included: bool) -> f64 {
    let angle = query.float(name).unwrap_or(default);
    if angle > 0.0 && (angle < most || included && angle == most) {
        return angle;
    }
    let expected = match included {
        true => format!("expected an angle above 0 and up to {most} degrees"),
        false => format!("expected an angle between 0 and {most} degrees"),
    };
    query.error(SceneError::at(
        &query.place(name),
        format!("The field of view is {angle} degrees"),
        expected,
    ));
    default
}

/// Mitsuba 3 reads and ignores where a camera without a lens focuses.
fn without_focus(query: &Query<'_>) {
    if query.float("focus_distance").is_some() {
        let text = "focus_distance changes nothing: there is no lens".to_owned();
        query.reader.remark(&query.place("focus_distance"), text);
    }
}

fn clips(query: &Query<'_>) -> [f64; 2] {
    let near_clip = query.positive("near_clip", 1e-2);
    let far_clip = query.positive("far_clip", 1e4);
    if near_clip >= far_clip {
        let problem = format!("The near plane ({near_clip}) is not before the far plane ({far_clip})");
        let place = query.place(if query.has("near_clip") { "near_clip" } else { "far_clip" });
        query.error(SceneError::at(&place, problem, "expected near_clip below far_clip"));
    }
    [near_clip, far_clip]
}

fn camera_to_world(query: &Query<'_>) -> (Transform, Motion) {
    let (to_world, motion) = query.placement();
    let keys = motion.iter().flat_map(|motion| &motion.keys).map(|(_, to_world)| to_world);
    if keys.chain([&to_world]).any(|to_world| !to_world.is_rigid(LOOSEST_FRAME)) {
        query.error(
            SceneError::at(
                &query.place("to_world"),
                "The camera's transform scales",
                "expected a transform that only rotates and moves",
            )
            .with_remedy("leave out <scale>; a rotation axis must have length 1"),
        );
        return (Transform::IDENTITY, None);
    }
    (to_world, motion)
}

fn lens(query: &Query<'_>, far_clip: f64) -> Option<Lens> {
    let focus_distance = query.positive("focus_distance", far_clip);
    let (blades, rotation) = blades(query);
    let aperture = aperture(query)?;
    Some(Lens { aperture, blades, rotation, focus_distance })
}

fn aperture(query: &Query<'_>) -> Option<Aperture> {
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
        return Some(Aperture::Stop(stop));
    }
    let radius = query.required("aperture_radius", query.float("aperture_radius"))?;
    if radius < 0.0 {
        let problem = format!("The aperture has a radius of {radius}");
        query.error(SceneError::at(&query.place("aperture_radius"), problem, "expected at least 0"));
    }
    Some(Aperture::Radius(radius))
}

/// The number of an aperture's blades, 0 where it is round, and by how many degrees they are turned.
fn blades(query: &Query<'_>) -> (u32, f64) {
    const MOST: i64 = 1000;
    let (name, turned) = ("aperture_blades", "aperture_rotation");
    let rotation = query.float(turned);
    let blades = query.integer(name, 0, MOST).unwrap_or(0);
    if (1..3).contains(&blades) {
        query.error(SceneError::at(
            &query.place(name),
            format!("The aperture has {blades} {}", if blades == 1 { "blade" } else { "blades" }),
            format!("expected 0 for a round aperture, or an integer from 3 to {MOST}"),
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
