//! Sensors, films and samplers, as Mitsuba 3.9.1 was seen to read them.

use super::{errors, read};
use abbe::film::FilterKind;
use abbe::geometry::Vec3;
use abbe::sampling::SamplerKind;
use abbe::scene::description::{
    Aperture, Description, DistantTarget, FieldOfView, FilmContent, FovAxis, Lens, PixelFormat, Sensor,
    SensorKind, ShapeKind,
};
use abbe::scene::{ReadOptions, read_str};
use std::path::Path;

fn with_sensor(kind: &str, content: &str) -> Result<Description, String> {
    read(&format!(r#"<scene version="3.0.0"><sensor type="{kind}">{content}</sensor></scene>"#))
}

fn sensor(kind: &str, content: &str) -> Result<Sensor, String> {
    with_sensor(kind, content).map(|scene| scene.sensor)
}

fn film(content: &str) -> Description {
    with_sensor("perspective", content).unwrap_or_else(|errors| panic!("{errors}"))
}

const PIXEL: &str =
    r#"<film type="hdrfilm"><integer name="width" value="1"/><integer name="height" value="1"/></film>"#;

#[test]
fn cameras() {
    let lens = |content: &str| match sensor("thinlens", content).unwrap().kind {
        SensorKind::Perspective { lens: Some(lens), .. } => lens,
        other => panic!("{other:?}"),
    };
    let radius = r#"<float name="aperture_radius" value="0.5"/>"#;
    let (aperture, focus_distance) = (Aperture::Radius(0.5), 10_000.0);
    assert_eq!(lens(radius), Lens { aperture, blades: 0, rotation: 0.0, focus_distance });
    let bladed = r#"<float name="f_stop" value="2.8"/><integer name="aperture_blades" value="7"/>
        <float name="aperture_rotation" value="10"/>"#;
    assert_eq!(
        lens(bladed),
        Lens { aperture: Aperture::Stop(2.8), blades: 7, rotation: 10.0, focus_distance }
    );
    let far = format!(r#"{radius}<integer name="far_clip" value="70"/>"#);
    assert_eq!(lens(&far).focus_distance, 70.0);
    assert!(sensor("thinlens", r#"<float name="principal_point_offset_x" value="0.5"/>"#).is_err());
    let fov = |content: &str| match sensor("perspective", content).unwrap().kind {
        SensorKind::Perspective { field_of_view, .. } => field_of_view,
        other => panic!("{other:?}"),
    };
    let degrees = |axis| FieldOfView::Degrees { angle: 40.0, axis };
    assert_eq!(fov(r#"<integer name="fov" value="40"/>"#), degrees(FovAxis::X));
    assert_eq!(
        fov(r#"<float name="fov" value="40"/><string name="fov_axis" value="SMALLER"/>"#),
        degrees(FovAxis::Smaller)
    );
    for text in ["35", "35mm", "35 mm"] {
        let content = format!(r#"<string name="focal_length" value="{text}"/>"#);
        assert_eq!(fov(&content), FieldOfView::FocalLength(35.0));
    }
    for bad in [
        r#"<float name="focal_length" value="35"/>"#,
        r#"<string name="focal_length" value="5cm"/>"#,
        r#"<string name="fov_axis" value="y"/>"#,
        r#"<transform name="to_world"><scale value="1.01"/></transform>"#,
        r#"<spectrum name="srf" value="400:-1, 500:1"/>"#,
    ] {
        assert!(sensor("perspective", bad).is_err(), "{bad}");
    }
    sensor("perspective", r#"<transform name="to_world"><scale x="-1"/></transform>"#).unwrap();
    sensor("orthographic", r#"<transform name="to_world"><scale x="3" y="2"/></transform>"#).unwrap();
    assert!(sensor("orthographic", r#"<float name="fov" value="40"/>"#).is_err());
    assert!(sensor("perspective", r#"<float name="srf" value="2"/>"#).unwrap().response.is_some());
}

#[test]
fn meters() {
    let radiance = |content: &str| match sensor("radiancemeter", &format!("{content}{PIXEL}"))?.kind {
        SensorKind::RadianceMeter { origin, direction } => Ok::<_, String>((origin, direction)),
        other => panic!("{other:?}"),
    };
    let origin = r#"<point name="origin" value="1 2 3"/>"#;
    let direction = r#"<vector name="direction" value="0 5 0"/>"#;
    let to_world = r#"<transform name="to_world"><translate x="7"/></transform>"#;
    let both = format!("{origin}{direction}");
    assert_eq!(radiance("").unwrap(), (Vec3::ZERO, Vec3::Z));
    assert_eq!(radiance(&both).unwrap(), (Vec3::new(1.0, 2.0, 3.0), 5.0 * Vec3::Y));
    // Together with a transform the two count for nothing.
    assert_eq!(radiance(&format!("{both}{to_world}")).unwrap(), (7.0 * Vec3::X, Vec3::Z));
    assert!(radiance(origin).unwrap_err().contains("no direction"));
    assert!(sensor("radiancemeter", &both).unwrap_err().contains("expected a single pixel"));

    let target = |content: &str| match sensor("distant", &format!("{content}{PIXEL}"))?.kind {
        SensorKind::Distant { direction, target } => Ok::<_, String>((direction, target)),
        other => panic!("{other:?}"),
    };
    assert!(matches!(target("").unwrap(), (Vec3::Z, DistantTarget::Scene)));
    let point = format!(r#"<point name="target" value="1 0 0"/>{direction}"#);
    assert!(matches!(target(&point).unwrap(), (_, DistantTarget::Point(Vec3::X))));
    let surface = target(r#"<shape type="disk" name="target"/>"#).unwrap().1;
    assert!(matches!(surface, DistantTarget::Surface(shape) if matches!(shape.kind, ShapeKind::Disk)));
    assert!(target(&format!("{direction}{to_world}")).unwrap_err().contains("given twice"));

    let meter = format!(r#"<sensor type="irradiancemeter">{PIXEL}</sensor>"#);
    let scene = format!(r#"<scene version="3.0.0"><shape type="disk">{meter}</shape></scene>"#);
    assert!(matches!(read(&scene).unwrap().sensor.kind, SensorKind::IrradianceMeter { surface }
        if matches!(surface.kind, ShapeKind::Disk)));
    assert!(read(&format!(r#"<scene version="3.0.0">{meter}</scene>"#)).unwrap_err().contains("no shape"));
    assert!(
        errors(&format!(r#"<shape type="disk">{meter}{meter}</shape>"#)).contains("more than one sensor")
    );
}

#[test]
fn batches_share_a_width_that_they_divide() {
    let two = r#"<sensor type="perspective"/><sensor type="orthographic"/>"#;
    let wide = |width: u32| format!(r#"<film type="hdrfilm"><integer name="width" value="{width}"/></film>"#);
    let kinds = sensor("batch", &format!("{two}{}", wide(6))).unwrap().kind;
    let SensorKind::Batch(sensors) = kinds else { panic!("{kinds:?}") };
    assert!(matches!(sensors[1].kind, SensorKind::Orthographic { .. }));
    assert!(sensor("batch", &format!("{two}{}", wide(5))).unwrap_err().contains("cannot be shared by 2"));
    assert!(sensor("batch", "").unwrap_err().contains("has no sensors"));
    // Under a flat sky a box from 450 to 600 nm measures 153.9 there instead of 150, other responses half of
    // theirs.
    let spectral = r#"<film type="specfilm"><spectrum name="a" value="450:1, 600:3"/></film>"#;
    assert!(sensor("batch", &format!("{two}{spectral}")).unwrap_err().contains("cannot have a specfilm"));
    assert!(
        sensor("batch", &format!(r#"{two}<shape type="disk"/>"#)).unwrap_err().contains("holds no sensor")
    );
}

#[test]
fn sensors_of_meshes_come_last() {
    // Widths of the films in the order in which Mitsuba 3.9.1 numbers the sensors: [2, 3, 4, 1].
    let film = |width: u32| {
        format!(
            r#"<film type="hdrfilm"><integer name="width" value="{width}"/><integer name="height" value="1"/></film>"#
        )
    };
    let on = |shape: &str, width| {
        format!(r#"<shape type="{shape}"><sensor type="irradiancemeter">{}</sensor></shape>"#, film(width))
    };
    let meter = |width| format!(r#"<sensor type="radiancemeter">{}</sensor>"#, film(width));
    let text = [on("rectangle", 1), meter(2), on("sphere", 3), meter(4)].concat();
    let text = format!(r#"<scene version="3.0.0">{text}</scene>"#);
    let widths = [0, 1, 2, 3].map(|sensor| {
        let options = ReadOptions { sensor, ..ReadOptions::default() };
        read_str(text.as_str(), Path::new("scene.xml"), &options).unwrap().sensor.film.width
    });
    assert_eq!(widths, [2, 3, 4, 1]);
    let options = ReadOptions { sensor: 4, ..ReadOptions::default() };
    let message = read_str(text, Path::new("scene.xml"), &options).unwrap_err().to_string();
    assert!(message.contains("4 sensors, numbers 0 to 3"), "{message}");
}

#[test]
fn films_and_filters() {
    let filter =
        |content: &str| film(&format!(r#"<film type="hdrfilm">{content}</film>"#)).sensor.film.filter;
    assert_eq!(filter(r#"<rfilter type="box"/>"#), FilterKind::Box);
    assert_eq!(filter(r#"<rfilter type="tent"/>"#), FilterKind::Tent { radius: 1.0 });
    assert_eq!(filter(r#"<rfilter type="mitchell"/>"#), FilterKind::Mitchell { b: 1.0 / 3.0, c: 1.0 / 3.0 });
    assert_eq!(filter(r#"<rfilter type="catmullrom"/>"#), FilterKind::CatmullRom);
    assert_eq!(filter(r#"<rfilter type="lanczos"/>"#), FilterKind::Lanczos { lobes: 3 });
    // A light's edge 0.3 pixels from a pixel's centre: at radius 0.5 that pixel has .802, at 0.4999 .922.
    let narrow = |radius: f64| {
        filter(&format!(r#"<rfilter type="tent"><float name="radius" value="{radius}"/></rfilter>"#))
    };
    assert_eq!(narrow(0.5), FilterKind::Box);
    assert_eq!(narrow(0.4999), FilterKind::Tent { radius: 0.4999 });
    let cropped = film(
        r#"<film type="hdrfilm"><integer name="width" value="100"/><integer name="crop_offset_x" value="10"/>
           <integer name="crop_width" value="20"/><string name="pixel_format" value="XYZ"/>
           <string name="component_format" value="float32"/><boolean name="sample_border" value="true"/></film>"#,
    );
    let crop = cropped.sensor.film.crop.unwrap();
    assert_eq!((crop.x, crop.y, crop.width, crop.height), (10, 0, 20, 576));
    assert!(cropped.sensor.film.sample_border && cropped.remarks.is_empty());
    let content = |text: &str| {
        let text = text.replace('=', r#"" value=""#);
        let text = text.replace('(', r#"<string name=""#).replace(')', r#""/>"#);
        match film(&format!(r#"<film type="hdrfilm">{text}</film>"#)).sensor.film.content {
            FilmContent::Colour { format, alpha } => (format, alpha),
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(content("(pixel_format=xyza)"), (PixelFormat::Xyz, true));
    assert_eq!(content("(pixel_format=luminance_alpha)(file_format=exr)"), (PixelFormat::Luminance, true));
    assert_eq!(content("(pixel_format=luminance)(file_format=pfm)"), (PixelFormat::Luminance, false));
    assert_eq!(content("(pixel_format=luminance)(file_format=RGBE)"), (PixelFormat::Rgb, false));
    assert_eq!(content("(pixel_format=rgba)(file_format=pfm)"), (PixelFormat::Rgb, false));
}

#[test]
fn spectral_films_have_channels_of_their_own() {
    let spectral =
        |content: &str| with_sensor("perspective", &format!(r#"<film type="specfilm">{content}</film>"#));
    let content =
        r#"<rfilter type="box"/><spectrum type="d65"/><spectrum name="blue" value="100:1, 500:0"/>"#;
    let film = spectral(content).unwrap().sensor.film;
    // Mitsuba 3.9.1 writes the channels `_arg_1` and `blue`.
    let FilmContent::Responses(channels) = &film.content else { panic!("{:?}", film.content) };
    assert_eq!([&channels[0].name, &channels[1].name], ["_arg_1", "blue"]);
    let range = film.wavelength_range();
    assert_eq!((range.min, range.max), (100.0, 830.0));
    for bad in [
        "",
        r#"<spectrum name="a" value="1"/>"#,
        r#"<spectrum name="a" value="400:-1, 500:2"/>"#,
        r#"<spectrum name="a" value="400:0, 500:0"/>"#,
        r#"<float name="a" value="2"/>"#,
        r#"<spectrum name="a" value="400:1, 500:2"/><string name="pixel_format" value="rgb"/>"#,
        r#"<spectrum name="a" value="400:1, 500:2"/><boolean name="banner" value="true"/>"#,
    ] {
        assert!(spectral(bad).is_err(), "{bad}");
    }
    let twice = r#"<spectrum name="srf" value="1"/><film type="specfilm"><spectrum name="a" value="400:1, 500:2"/></film>"#;
    assert!(sensor("perspective", twice).unwrap_err().contains("Both the sensor and its film"));
}

#[test]
fn samplers() {
    for (name, kind, remarks) in [
        ("independent", SamplerKind::Sobol, 1),
        ("stratified", SamplerKind::Sobol, 1),
        ("multijitter", SamplerKind::Sobol, 1),
        ("orthogonal", SamplerKind::Sobol, 1),
        ("ldsampler", SamplerKind::Sobol, 1),
        ("regular", SamplerKind::Regular, 0),
        ("jittered", SamplerKind::Jittered, 0),
        ("poisson", SamplerKind::Poisson, 0),
        ("sobol", SamplerKind::Sobol, 0),
        ("bluenoise", SamplerKind::BlueNoise, 0),
    ] {
        let scene = film(&format!(r#"<sampler type="{name}"/>"#));
        assert_eq!((scene.sensor.sampler.kind, scene.remarks.len()), (kind, remarks), "{name}");
    }
}
