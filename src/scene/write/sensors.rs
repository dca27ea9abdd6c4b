use super::super::description::{
    AngularMap, Aperture, Crop, DistantTarget, Film, FilmContent, Lens, PixelFormat, Sensor, SensorKind,
    ShapeDescription,
};
use super::super::plugins::view::View;
use super::super::plugins::{Field, filters, media, samplers, shapes};
use super::super::read::Class;
use super::{Node, Writer};
use crate::camera::{FisheyeProjection, Shutter, ShutterKind};

/// The sensor as such. One that measures on a surface is to be put into the shape that [`surface`] gives.
pub(super) fn write(writer: &mut Writer, sensor: &Sensor) -> Node {
    let node = |plugin| Node::new(Class::Sensor, plugin, &sensor.place);
    let node = match &sensor.kind {
        SensorKind::Perspective { to_world, field_of_view, principal_point, near_clip, far_clip, lens } => {
            let node = node(if lens.is_some() { "thinlens" } else { "perspective" });
            let node = node.placement(to_world, &sensor.motion);
            let node = View.write(node, field_of_view, writer);
            let node = match lens {
                Some(lens) => self::lens(node, lens),
                None => node
                    .float("principal_point_offset_x", principal_point[0])
                    .float("principal_point_offset_y", principal_point[1]),
            };
            node.float("near_clip", *near_clip).float("far_clip", *far_clip)
        }
        SensorKind::Orthographic { to_world, near_clip, far_clip } => node("orthographic")
            .placement(to_world, &sensor.motion)
            .float("near_clip", *near_clip)
            .float("far_clip", *far_clip),
        SensorKind::Angular { to_world, map, near_clip, far_clip } => angular(node, map)
            .placement(to_world, &sensor.motion)
            .float("near_clip", *near_clip)
            .float("far_clip", *far_clip),
        SensorKind::Plane { to_world, width, stop } => node("sensorplane")
            .placement(to_world, &sensor.motion)
            .float("width", *width)
            .float("aperture_radius", stop.radius)
            .float("aperture_distance", stop.distance),
        SensorKind::RadianceMeter { origin, direction } => {
            node("radiancemeter").vector("origin", *origin).vector("direction", *direction)
        }
        SensorKind::IrradianceMeter { .. } => node("irradiancemeter"),
        SensorKind::Distant { direction, target } => {
            let node = node("distant").vector("direction", *direction);
            match target {
                DistantTarget::Scene => node.remark("looks at all of the scene"),
                DistantTarget::Point(point) => node.vector("target", *point),
                DistantTarget::Surface(surface) => node.named("target", shapes::node(surface, writer)),
            }
        }
        SensorKind::Batch(sensors) => sensors.iter().fold(node("batch"), |node, sensor| {
            let child = write(writer, sensor);
            node.child(match surface(sensor) {
                Some(surface) => shapes::node(surface, writer).child(child),
                None => child,
            })
        }),
    };
    let node = match &sensor.response {
        Some(response) => node.spectrum("srf", response),
        None => node,
    };
    let node = match &sensor.medium {
        Some(medium) => node.child(media::node(medium, writer)),
        None => node,
    };
    shutter(node, &sensor.shutter)
        .child(film(writer, &sensor.film))
        .child(samplers::node(&sensor.sampler, writer))
}

fn angular(node: impl Fn(&'static str) -> Node, map: &AngularMap) -> Node {
    match map {
        AngularMap::Fisheye { projection, fov } => {
            let name = FisheyeProjection::NAMES.iter().find(|(_, known)| known == projection);
            node("fisheye").float("fov", *fov).text("projection", name.map_or("", |(name, _)| name))
        }
        AngularMap::Panorama { fov: [across, up] } => {
            node("panorama").float("fov", *across).float("fov_y", *up)
        }
    }
}

fn shutter(node: Node, shutter: &Shutter) -> Node {
    if *shutter == Shutter::INSTANT {
        return node;
    }
    let node = node.float("shutter_open", shutter.open).float("shutter_close", shutter.close);
    match shutter.kind {
        ShutterKind::Box => node,
        ShutterKind::Triangle => node.text("shutter", "triangle"),
        ShutterKind::Strobe { flashes } => node.text("shutter", "strobe").integer("strobe_flashes", flashes),
    }
}

/// What a sensor measures on.
pub(super) fn surface(sensor: &Sensor) -> Option<&ShapeDescription> {
    match &sensor.kind {
        SensorKind::IrradianceMeter { surface } => Some(surface),
        _ => None,
    }
}

fn lens(node: Node, lens: &Lens) -> Node {
    let node = match lens.aperture {
        Aperture::Radius(radius) => node.float("aperture_radius", radius),
        Aperture::Stop(stop) => node.float("f_stop", stop),
    };
    let node = match lens.blades {
        0 => node,
        blades => node.integer("aperture_blades", blades).float("aperture_rotation", lens.rotation),
    };
    node.float("focus_distance", lens.focus_distance)
}

fn film(writer: &mut Writer, film: &Film) -> Node {
    let plugin = match film.content {
        FilmContent::Colour { .. } => "hdrfilm",
        FilmContent::Responses(_) => "specfilm",
    };
    let node = Node::new(Class::Film, plugin, &film.place)
        .integer("width", film.width)
        .integer("height", film.height);
    let node = match film.crop {
        Some(Crop { x, y, width, height }) => node
            .integer("crop_offset_x", x)
            .integer("crop_offset_y", y)
            .integer("crop_width", width)
            .integer("crop_height", height),
        None => node,
    };
    let node = match &film.content {
        FilmContent::Colour { format, alpha } => node.text(
            "pixel_format",
            match (format, alpha) {
                (PixelFormat::Rgb, false) => "rgb",
                (PixelFormat::Rgb, true) => "rgba",
                (PixelFormat::Xyz, false) => "xyz",
                (PixelFormat::Xyz, true) => "xyza",
                (PixelFormat::Luminance, false) => "luminance",
                (PixelFormat::Luminance, true) => "luminance_alpha",
            },
        ),
        FilmContent::Responses(channels) => {
            channels.iter().fold(node, |node, channel| node.spectrum(channel.name.clone(), &channel.response))
        }
    };
    node.text("component_format", "float32")
        .boolean("sample_border", film.sample_border)
        .child(filters::write(&film.filter, &film.place, writer))
}
