//! Each default, as `print` shows it in Mitsuba 3.9.1 (validation/mitsuba/FACTS.md).

use super::{errors, scene, shape};
use abbe::bsdf::microfacet::Distribution;
use abbe::film::FilterKind;
use abbe::geometry::{Transform, Vec3};
use abbe::sampling::SamplerKind;
use abbe::scene::description::{
    Alpha, Bsdf, BsdfKind, ConductorIndex, FieldOfView, FilmContent, IndexKind, IntegratorKind, LightKind,
    MediumContent, MetalAssumption, PhaseKind, PixelFormat, Roughness, SensorKind, ShapeKind, SpectrumKind,
    SpectrumSource,
};

fn bsdf(content: &str) -> Bsdf {
    (*shape(&format!(r#"<shape type="sphere">{content}</shape>"#)).bsdf).clone()
}

fn is_constant(source: &SpectrumSource, value: f64) -> bool {
    matches!(source.kind, SpectrumKind::Constant(found) if found * source.scale == value)
}

#[test]
fn a_bare_scene_is_seen_as_in_mitsuba() {
    let scene = scene("");
    assert_eq!(scene.integrator.kind, IntegratorKind::Path);
    assert_eq!((scene.integrator.max_depth, scene.integrator.rr_depth), (None, 5));
    assert!(!scene.integrator.hide_emitters);
    let sensor = &scene.sensor;
    let SensorKind::Perspective { to_world, field_of_view, principal_point, near_clip, far_clip, lens: None } =
        sensor.kind
    else {
        panic!("{:?}", sensor.kind)
    };
    assert_eq!((near_clip, far_clip), (0.01, 10_000.0));
    assert_eq!(field_of_view, FieldOfView::FocalLength(50.0));
    assert_eq!((to_world, principal_point), (Transform::IDENTITY, [0.0; 2]));
    assert!(sensor.response.is_none() && sensor.medium.is_none());
    let film = &sensor.film;
    assert_eq!((film.width, film.height, film.crop, film.sample_border), (768, 576, None, false));
    assert_eq!(film.filter, FilterKind::Gaussian { stddev: 0.5 });
    assert!(matches!(film.content, FilmContent::Colour { format: PixelFormat::Rgb, alpha: false }));
    assert_eq!((sensor.sampler.kind, sensor.sampler.sample_count), (SamplerKind::Sobol, 4));
    assert_eq!(sensor.sampler.seed, 0);
}

#[test]
fn integrators() {
    let integrator = |text: &str| scene(text).integrator;
    let path =
        integrator(r#"<integrator type="volpath"><integer name="max_depth" value="-1"/></integrator>"#);
    assert_eq!((path.kind, path.max_depth, path.rr_depth), (IntegratorKind::VolPath, None, 5));
    let black = integrator(r#"<integrator type="path"><integer name="max_depth" value="0"/></integrator>"#);
    assert_eq!(black.max_depth, Some(0));
    assert_eq!(integrator(r#"<integrator type="direct"/>"#).max_depth, Some(2));
    assert_eq!(integrator(r#"<integrator type="walk"/>"#).kind, IntegratorKind::Walk);
    errors(r#"<integrator type="direct"><integer name="max_depth" value="3"/></integrator>"#);
    errors(r#"<integrator type="path"><boolean name="strict_normals" value="true"/></integrator>"#);
}

#[test]
fn shapes() {
    let sphere = shape(r#"<shape type="sphere"/>"#);
    assert!(matches!(sphere.kind, ShapeKind::Sphere { centre: Vec3::ZERO, radius: 1.0 }));
    assert!(!sphere.flip_normals && sphere.interior.is_none() && sphere.emission.is_none());
    assert!(matches!(&sphere.bsdf.kind, BsdfKind::Diffuse { reflectance } if is_constant(reflectance, 0.5)));
    let light = shape(r#"<shape type="sphere"><emitter type="area"/></shape>"#);
    assert!(matches!(&light.bsdf.kind, BsdfKind::Diffuse { reflectance } if is_constant(reflectance, 0.0)));
    let emission = light.emission.unwrap();
    assert!(matches!(emission.kind, SpectrumKind::D65) && emission.scale == 1.0);
    let cylinder = shape(r#"<shape type="cylinder"/>"#);
    assert!(matches!(cylinder.kind, ShapeKind::Cylinder { from: Vec3::ZERO, to: Vec3::Z, radius: 1.0 }));
    let vector = shape(r#"<shape type="sphere"><vector name="center" value="2"/></shape>"#);
    assert!(matches!(vector.kind, ShapeKind::Sphere { centre, .. } if centre == Vec3::splat(2.0)));
    errors(r#"<shape type="disk"><float name="radius" value="2"/></shape>"#);
}

#[test]
fn a_bare_number_in_an_emitter_is_d65_and_a_spectrum_is_flat() {
    let radiance = |spectrum: &str| {
        let scene = scene(&format!(r#"<emitter type="constant">{spectrum}</emitter>"#));
        match &scene.lights[0].kind {
            LightKind::Constant { radiance } => radiance.clone(),
            _ => panic!("not constant"),
        }
    };
    for number in [r#"<float name="radiance" value="3"/>"#, r#"<integer name="radiance" value="3"/>"#] {
        let radiance = radiance(number);
        assert!(matches!(radiance.kind, SpectrumKind::D65) && radiance.scale == 3.0, "{number}");
    }
    assert!(is_constant(&radiance(r#"<spectrum name="radiance" value="3"/>"#), 3.0));
    let d65 = r#"<spectrum name="radiance" type="d65"><float name="scale" value="2"/></spectrum>"#;
    assert!(matches!(radiance(d65), SpectrumSource { kind: SpectrumKind::D65, scale: 2.0, .. }));
    let hot = radiance(
        r#"<spectrum name="radiance" type="blackbody"><integer name="temperature" value="3000"/></spectrum>"#,
    );
    assert!(matches!(hot.kind, SpectrumKind::Blackbody { kelvin: 3000.0, min_nm: 360.0, max_nm: 830.0 }));
}

#[test]
fn lights() {
    let light = |text: &str| scene(text).lights.remove(0).kind;
    assert!(matches!(light(r#"<emitter type="point"/>"#), LightKind::Point { position: Vec3::ZERO, .. }));
    let moved =
        r#"<emitter type="point"><transform name="to_world"><translate y="3"/></transform></emitter>"#;
    assert!(matches!(light(moved), LightKind::Point { position, .. } if position == Vec3::Y * 3.0));
    assert!(matches!(
        light(r#"<emitter type="directional"/>"#),
        LightKind::Directional { travels: Vec3::Z, .. }
    ));
    let down = r#"<emitter type="directional"><vector name="direction" value="0 -7 0"/></emitter>"#;
    assert!(matches!(light(down), LightKind::Directional { travels, .. } if travels == Vec3::NEG_Y * 7.0));
    assert!(matches!(
        light(r#"<emitter type="spot"/>"#),
        LightKind::Spot { cutoff_angle: 20.0, beam_width: 15.0, texture: None, .. }
    ));
    assert!(matches!(
        light(r#"<emitter type="projector"/>"#),
        LightKind::Projector { scale: 1.0, field_of_view: FieldOfView::FocalLength(50.0), .. }
    ));
}

#[test]
fn the_sun_is_where_it_is_said_to_be() {
    let sun = |content: &str| match scene(&format!(r#"<emitter type="sunsky">{content}</emitter>"#))
        .lights
        .remove(0)
        .kind
    {
        LightKind::SunSky { sun_direction, turbidity, sun_aperture, .. } => {
            assert_eq!((turbidity, sun_aperture), (3.0, 0.5358));
            sun_direction
        }
        other => panic!("{other:?}"),
    };
    // Mitsuba 3.9.1: the middle of the sun's disc, found to 0.001°.
    let tokyo = sun("");
    assert!((tokyo.z.acos().to_degrees() - 43.920).abs() < 2e-3, "{tokyo}");
    assert!((tokyo.y.atan2(tokyo.x).to_degrees() - 85.752).abs() < 2e-3, "{tokyo}");
    let turn = r#"<transform name="to_world"><rotate z="1" angle="90"/></transform>"#;
    assert!((sun(turn) - Vec3::new(-tokyo.y, tokyo.x, tokyo.z)).length() < 1e-12);
    let given = r#"<vector name="sun_direction" value="1 2 3"/>"#;
    assert_eq!(sun(&format!("{given}{turn}")), Vec3::new(1.0, 2.0, 3.0));
}

#[test]
fn conductors() {
    let index = |content: &str| match bsdf(&format!(r#"<bsdf type="conductor">{content}</bsdf>"#)).kind {
        BsdfKind::Conductor { index, specular_reflectance, roughness: None } => {
            assert!(is_constant(&specular_reflectance, 1.0));
            index
        }
        other => panic!("{other:?}"),
    };
    assert!(matches!(index(""), ConductorIndex::Mirror));
    assert!(matches!(index(r#"<string name="material" value="none"/>"#), ConductorIndex::Mirror));
    assert!(matches!(index(r#"<string name="material" value="Au"/>"#), ConductorIndex::Named { .. }));
    let eta = index(r#"<float name="eta" value="2"/>"#);
    assert!(matches!(eta, ConductorIndex::Complex { n, k } if is_constant(&n, 2.0) && is_constant(&k, 1.0)));
    let k = index(r#"<spectrum name="k" value="3"/>"#);
    assert!(matches!(k, ConductorIndex::Complex { n, k } if is_constant(&n, 0.0) && is_constant(&k, 3.0)));
    let assumption =
        |content: &str| match index(&format!(r#"<float name="normal_reflectance" value="0.8"/>{content}"#)) {
            ConductorIndex::NormalReflectance { assumption, .. } => assumption,
            other => panic!("{other:?}"),
        };
    assert!(matches!(assumption(""), MetalAssumption::NoAbsorption));
    assert!(matches!(assumption(r#"<string name="assume" value="k=0"/>"#), MetalAssumption::NoAbsorption));
    assert!(matches!(assumption(r#"<string name="assume" value="n=1"/>"#), MetalAssumption::UnitIndex));
    assert!(matches!(assumption(r#"<float name="eta" value="0.2"/>"#), MetalAssumption::KnownIndex(_)));
}

#[test]
fn dielectrics() {
    let indices = |content: &str| match bsdf(&format!(r#"<bsdf type="dielectric">{content}</bsdf>"#)).kind {
        BsdfKind::Dielectric { interior, exterior, .. } => (interior.kind, exterior.map(|index| index.kind)),
        other => panic!("{other:?}"),
    };
    assert!(matches!(indices(""), (IndexKind::Constant(1.5046), None)));
    let both = r#"<string name="int_ior" value="Water"/><float name="ext_ior" value="1.1"/>"#;
    assert!(matches!(indices(both), (IndexKind::Constant(1.333), Some(IndexKind::Constant(1.1)))));
    let sellmeier = r#"<spectrum name="int_ior" type="sellmeier"><string name="b" value="1.03961212, 0.231792344, 1.01046945"/>
        <string name="c" value="0.00600069867, 0.0200179144, 103.560653"/></spectrum>"#;
    let (IndexKind::Formula(formula), None) = indices(sellmeier) else { panic!("no formula") };
    // The catalogue's n_d of BK7.
    assert!((formula.index(587.5618) - 1.5168).abs() < 1e-5);
    let cauchy = r#"<spectrum name="ext_ior" type="cauchy"><string name="coefficients" value="1.5, 0.004"/></spectrum>"#;
    let (_, Some(IndexKind::Formula(formula))) = indices(cauchy) else { panic!("no formula") };
    assert!((formula.index(500.0) - 1.516).abs() < 1e-12);
    let table = r#"<spectrum name="int_ior" value="400:1.53, 700:1.51"/>"#;
    assert!(matches!(indices(table), (IndexKind::Tabulated(_), None)));
    let named = r#"<spectrum name="int_ior" type="measured"><string name="name" value="N-SF11"/></spectrum>"#;
    assert!(matches!(indices(named), (IndexKind::Named(name), None) if name == "N-SF11"));
    let normal = r#"<float name="normal_reflectance" value="0.04"/>"#;
    assert!(matches!(indices(normal), (IndexKind::NormalReflectance { slab: false, .. }, None)));
}

#[test]
fn roughness() {
    let rough = |content: &str| match bsdf(&format!(r#"<bsdf type="roughdielectric">{content}</bsdf>"#)).kind
    {
        BsdfKind::Dielectric { roughness: Some(roughness), .. } => roughness,
        other => panic!("{other:?}"),
    };
    let alpha = |roughness: &Roughness| match &roughness.alpha {
        Alpha::Isotropic(alpha) => [alpha.constant(); 2],
        Alpha::Anisotropic([u, v]) => [u.constant(), v.constant()],
    };
    let one = rough("");
    assert_eq!((one.distribution, alpha(&one)), (Distribution::Beckmann, [Some(0.1); 2]));
    let both = rough(
        r#"<float name="alpha_u" value="0.2"/><float name="alpha_v" value="0.3"/><string name="distribution" value="GGX"/>"#,
    );
    assert_eq!((both.distribution, alpha(&both)), (Distribution::Ggx, [Some(0.2), Some(0.3)]));
}

/// As `print` and `eval` show them in Mitsuba 3.9.1. An index that has to be there for
/// light to be transmitted is put there.
#[test]
fn layered_surfaces() {
    let plastic = |content: &str| match bsdf(&format!(r#"<bsdf type="plastic">{content}</bsdf>"#)).kind {
        BsdfKind::Plastic { interior, diffuse_reflectance, nonlinear, coat: None, .. } => {
            let IndexKind::Constant(index) = interior.kind else { panic!("{interior:?}") };
            (index, diffuse_reflectance.constant(), nonlinear)
        }
        other => panic!("{other:?}"),
    };
    assert_eq!(plastic(""), (1.49, Some(0.5), false));
    assert_eq!(plastic(r#"<string name="int_ior" value="pet"/>"#), (1.575, Some(0.5), false));
    let index = |content: &str| match bsdf(&format!(r#"<bsdf type="principled">{content}</bsdf>"#)).kind {
        BsdfKind::Principled { eta, base, .. } => (eta, base.roughness.constant()),
        other => panic!("{other:?}"),
    };
    let (eta, roughness) = index("");
    assert!((eta - 1.5).abs() < 1e-12 && roughness == Some(0.5));
    assert_eq!(index(r#"<float name="specular" value="0"/>"#).0, 1.0);
    let glass = r#"<float name="spec_trans" value="0.5"/>"#;
    assert!((index(&format!(r#"{glass}<float name="specular" value="0"/>"#)).0 - 1.01805).abs() < 1e-5);
    assert_eq!(index(&format!(r#"{glass}<float name="eta" value="1"/>"#)).0, 1.001);
}

#[test]
fn media() {
    let medium = |content: &str| {
        shape(&format!(
            r#"<shape type="sphere"><bsdf type="dielectric"/><medium type="homogeneous" name="interior">
               {content}</medium></shape>"#
        ))
        .interior
        .unwrap()
    };
    let plain = |content: &str| match medium(content).content {
        MediumContent::Plain { varies: false, extinction, albedo, phase } => (extinction, albedo, phase.kind),
        other => panic!("{other:?}"),
    };
    let (extinction, albedo, phase) = plain("");
    assert!(is_constant(&extinction, 1.0) && is_constant(&albedo, 0.75));
    assert!(matches!(phase, PhaseKind::Isotropic));
    let phase = |content: &str| plain(content).2;
    assert!(matches!(phase(r#"<phase type="hg"/>"#), PhaseKind::HenyeyGreenstein { g: 0.8 }));
    let (scaled, ..) = plain(r#"<spectrum name="sigma_t" value="2"/><float name="scale" value="3"/>"#);
    assert!(is_constant(&scaled, 6.0));
}

#[test]
fn both_sides() {
    let sides = |content: &str| match bsdf(&format!(r#"<bsdf type="twosided">{content}</bsdf>"#)).kind {
        BsdfKind::TwoSided { back, .. } => back.is_some(),
        other => panic!("{other:?}"),
    };
    assert!(!sides(r#"<bsdf type="diffuse"/>"#));
    assert!(sides(r#"<bsdf type="diffuse"/><bsdf type="conductor"/>"#));
    // Either side is seen from its front, so within another both show that of the inner one.
    let inner = r#"<bsdf type="twosided"><bsdf type="conductor"/><bsdf type="diffuse"/></bsdf>"#;
    assert!(!sides(inner));
    match bsdf(&format!(r#"<bsdf type="twosided"><bsdf type="diffuse"/>{inner}</bsdf>"#)).kind {
        BsdfKind::TwoSided { back: Some(back), .. } => {
            assert!(matches!(back.kind, BsdfKind::Conductor { .. }), "{back:?}");
        }
        other => panic!("{other:?}"),
    }
    let leaf = bsdf(r#"<bsdf type="diffusetransmitter"/>"#).kind;
    assert!(matches!(leaf, BsdfKind::DiffuseTransmitter { reflectance, transmittance }
        if is_constant(&reflectance, 0.25) && is_constant(&transmittance, 0.25)));
    bsdf(
        r#"<bsdf type="diffusetransmitter"><float name="reflectance" value="0.7"/><float name="transmittance" value="0.3"/></bsdf>"#,
    );
}
