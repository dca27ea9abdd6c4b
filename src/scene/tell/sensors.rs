use super::super::description::{Crop, FieldOfView, Film, FovAxis, PixelFormat, Sampler, Sensor};
use super::super::read::Class;
use super::Told;
use crate::film::FilterKind;
use crate::sampling::SamplerKind;

pub(super) fn tell(sensor: &Sensor) -> Told {
    let plugin = if sensor.lens.is_some() { "thinlens" } else { "perspective" };
    let told = Told::new(Class::Sensor, plugin, &sensor.place).transform("to_world", &sensor.to_world);
    let told = field_of_view(told, sensor.field_of_view);
    let told = match sensor.lens {
        Some(lens) => {
            told.float("aperture_radius", lens.aperture_radius).float("focus_distance", lens.focus_distance)
        }
        None => told
            .float("principal_point_offset_x", sensor.principal_point[0])
            .float("principal_point_offset_y", sensor.principal_point[1]),
    };
    let told = match &sensor.medium {
        Some(medium) => told.child(super::shapes::medium(medium)),
        None => told,
    };
    told.float("near_clip", sensor.near_clip)
        .float("far_clip", sensor.far_clip)
        .child(film(&sensor.film))
        .child(sampler(&sensor.sampler))
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
    let told = Told::new(Class::Film, "hdrfilm", &film.place)
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
    told.text(
        "pixel_format",
        match film.pixel_format {
            PixelFormat::Rgb => "rgb",
            PixelFormat::Xyz => "xyz",
            PixelFormat::Luminance => "luminance",
        },
    )
    .text("component_format", "float32")
    .child(filter(film))
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
    let plugin = match sampler.kind {
        SamplerKind::Sobol => "sobol",
        SamplerKind::Independent => "independent",
    };
    Told::new(Class::Sampler, plugin, &sampler.place)
        .integer("sample_count", sampler.sample_count)
        .integer("seed", sampler.seed.min(i64::MAX as u64) as i64)
}
