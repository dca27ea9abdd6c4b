use super::super::description::{
    AngularMap, Aperture, Crop, DistantTarget, FieldOfView, Film, FilmContent, FovAxis, Lens, PixelFormat,
    Sampler, Sensor, SensorKind, Shape,
};
use super::super::read::Class;
use super::{Teller, Told, media, shapes};
use crate::camera::{FisheyeProjection, Shutter, ShutterKind};
use crate::film::FilterKind;

/// The sensor as such. One that measures on a surface is to be put into the shape that [`surface`] gives.
pub(super) fn tell(teller: &mut Teller, sensor: &Sensor) -> Told {
    let told = |plugin| Told::new(Class::Sensor, plugin, &sensor.place);
    let told = match &sensor.kind {
        SensorKind::Perspective { to_world, field_of_view, principal_point, near_clip, far_clip, lens } => {
            let told = told(if lens.is_some() { "thinlens" } else { "perspective" });
            let told = told.placement(to_world, &sensor.motion);
            let told = self::field_of_view(told, *field_of_view);
            let told = match lens {
                Some(lens) => self::lens(told, lens),
                None => told
                    .float("principal_point_offset_x", principal_point[0])
                    .float("principal_point_offset_y", principal_point[1]),
            };
            told.float("near_clip", *near_clip).float("far_clip", *far_clip)
        }
        SensorKind::Orthographic { to_world, near_clip, far_clip } => told("orthographic")
            .placement(to_world, &sensor.motion)
            .float("near_clip", *near_clip)
            .float("far_clip", *far_clip),
        SensorKind::Angular { to_world, map, near_clip, far_clip } => angular(told, map)
            .placement(to_world, &sensor.motion)
            .float("near_clip", *near_clip)
            .float("far_clip", *far_clip),
        SensorKind::Plane { to_world, width, stop } => told("sensorplane")
            .placement(to_world, &sensor.motion)
            .float("width", *width)
            .float("aperture_radius", stop.radius)
            .float("aperture_distance", stop.distance),
        SensorKind::RadianceMeter { origin, direction } => {
            told("radiancemeter").vector("origin", *origin).vector("direction", *direction)
        }
        SensorKind::IrradianceMeter { .. } => told("irradiancemeter"),
        SensorKind::Distant { direction, target } => {
            let told = told("distant").vector("direction", *direction);
            match target {
                DistantTarget::Scene => told.remark("looks at all of the scene"),
                DistantTarget::Point(point) => told.vector("target", *point),
                DistantTarget::Surface(surface) => told.named("target", shapes::tell(teller, surface)),
            }
        }
        SensorKind::Batch(sensors) => sensors.iter().fold(told("batch"), |told, sensor| {
            let child = tell(teller, sensor);
            told.child(match surface(sensor) {
                Some(surface) => shapes::tell(teller, surface).child(child),
                None => child,
            })
        }),
    };
    let told = match &sensor.response {
        Some(response) => told.spectrum("srf", response),
        None => told,
    };
    let told = match &sensor.medium {
        Some(medium) => told.child(media::tell(medium)),
        None => told,
    };
    shutter(told, &sensor.shutter).child(film(&sensor.film)).child(sampler(&sensor.sampler))
}

fn angular(told: impl Fn(&'static str) -> Told, map: &AngularMap) -> Told {
    match map {
        AngularMap::Fisheye { projection, fov } => {
            let name = FisheyeProjection::NAMES.iter().find(|(_, known)| known == projection);
            told("fisheye").float("fov", *fov).text("projection", name.map_or("", |(name, _)| name))
        }
        AngularMap::Panorama { fov: [across, up] } => {
            told("panorama").float("fov", *across).float("fov_y", *up)
        }
    }
}

fn shutter(told: Told, shutter: &Shutter) -> Told {
    if *shutter == Shutter::INSTANT {
        return told;
    }
    let told = told.float("shutter_open", shutter.open).float("shutter_close", shutter.close);
    match shutter.kind {
        ShutterKind::Box => told,
        ShutterKind::Triangle => told.text("shutter", "triangle"),
        ShutterKind::Strobe { flashes } => told.text("shutter", "strobe").integer("strobe_flashes", flashes),
    }
}

/// What a sensor measures on.
pub(super) fn surface(sensor: &Sensor) -> Option<&Shape> {
    match &sensor.kind {
        SensorKind::IrradianceMeter { surface } => Some(surface),
        _ => None,
    }
}

fn lens(told: Told, lens: &Lens) -> Told {
    let told = match lens.aperture {
        Aperture::Radius(radius) => told.float("aperture_radius", radius),
        Aperture::Stop(stop) => told.float("f_stop", stop),
    };
    let told = match lens.blades {
        0 => told,
        blades => told.integer("aperture_blades", blades).float("aperture_rotation", lens.rotation),
    };
    told.float("focus_distance", lens.focus_distance)
}

pub(super) fn field_of_view(told: Told, field_of_view: FieldOfView) -> Told {
    match field_of_view {
        FieldOfView::Degrees { angle, axis } => told.float("fov", angle).text("fov_axis", axis_name(axis)),
        FieldOfView::FocalLength(mm) => told.text("focal_length", format!("{mm}mm")),
    }
}

fn axis_name(axis: FovAxis) -> &'static str {
    match axis {
        FovAxis::X => "x",
        FovAxis::Y => "y",
        FovAxis::Diagonal => "diagonal",
        FovAxis::Smaller => "smaller",
        FovAxis::Larger => "larger",
    }
}

fn film(film: &Film) -> Told {
    let plugin = match film.content {
        FilmContent::Colour { .. } => "hdrfilm",
        FilmContent::Responses(_) => "specfilm",
    };
    let told = Told::new(Class::Film, plugin, &film.place)
        .integer("width", film.width)
        .integer("height", film.height);
    let told = match film.crop {
        Some(Crop { x, y, width, height }) => told
            .integer("crop_offset_x", x)
            .integer("crop_offset_y", y)
            .integer("crop_width", width)
            .integer("crop_height", height),
        None => told,
    };
    let told = match &film.content {
        FilmContent::Colour { format, alpha } => told.text(
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
            channels.iter().fold(told, |told, channel| told.spectrum(channel.name.clone(), &channel.response))
        }
    };
    told.text("component_format", "float32").boolean("sample_border", film.sample_border).child(filter(film))
}

fn filter(film: &Film) -> Told {
    let told = |plugin| Told::new(Class::Filter, plugin, &film.place);
    match film.filter {
        FilterKind::Box => told("box"),
        FilterKind::Tent { radius } => told("tent").float("radius", radius),
        FilterKind::Gaussian { stddev } => told("gaussian").float("stddev", stddev),
        FilterKind::Mitchell { b, c } => told("mitchell").float("B", b).float("C", c),
        FilterKind::CatmullRom => told("catmullrom"),
        FilterKind::Lanczos { lobes } => told("lanczos").integer("lobes", lobes),
    }
}

fn sampler(sampler: &Sampler) -> Told {
    // Any of Mitsuba's stands for the best that there is here.
    let name = if sampler.forced { sampler.kind.name() } else { "independent" };
    Told::new(Class::Sampler, name, &sampler.place)
        .integer("sample_count", sampler.sample_count)
        .integer("seed", sampler.seed.min(i64::MAX as u64) as i64)
}
