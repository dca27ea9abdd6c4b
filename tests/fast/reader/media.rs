//! Media whose particles are computed, that emit, or that thin out.

use super::{errors, shape};
use abbe::phase::mie::Sizes;
use abbe::scene::description::{
    DensitySource, EmissionSource, Medium, MediumContent, PhaseKind, SpectrumKind,
};

fn within(medium: &str) -> String {
    format!(r#"<shape type="sphere"><bsdf type="null"/>{medium}</shape>"#)
}

fn medium(plugin: &str, content: &str) -> Medium {
    let medium = format!(r#"<medium name="interior" type="{plugin}">{content}</medium>"#);
    shape(&within(&medium)).interior.unwrap()
}

fn wrong(plugin: &str, content: &str) -> String {
    errors(&within(&format!(r#"<medium name="interior" type="{plugin}">{content}</medium>"#)))
}

#[test]
fn a_suspension_holds_particles() {
    let drops = r#"<phase type="mie"><string name="distribution" value="gamma"/><float name="radius" value="8"/>
                   <float name="fraction" value="1e-7"/></phase>"#;
    let found =
        medium("suspension", &format!(r#"{drops}<phase type="air"/><float name="metres" value="0.01"/>"#));
    let MediumContent::Suspension { particles, metres, .. } = found.content else { panic!("{found:?}") };
    assert_eq!(metres, 0.01);
    let [drops, air] = &particles[..] else { panic!("{particles:?}") };
    let PhaseKind::Mie(drops) = &drops.kind else { panic!("{drops:?}") };
    assert_eq!(drops.sizes, Sizes::Gamma { effective: 8.0, variance: 0.1 });
    assert_eq!(drops.fraction, Some(1e-7));
    assert!(matches!(air.kind, PhaseKind::Air { amount: 1.0 }));
}

#[test]
fn a_medium_emits_and_thins_out() {
    let found = medium(
        "heterogeneous",
        r#"<float name="temperature" value="1800"/>
           <volume name="density" type="exponential"><float name="scale_height" value="3"/></volume>"#,
    );
    assert!(matches!(found.emission, Some(EmissionSource::Temperature(_))), "{found:?}");
    let Some(DensitySource::Exponential(air)) = &found.density else { panic!("{found:?}") };
    assert!(air.scale_height == 3.0 && air.radius.is_none() && air.top.is_none(), "{air:?}");
    let found = medium(
        "heterogeneous",
        r#"<volume name="density" type="texturevolume"><texture name="texture" type="marble"/>
           <integer name="resolution" value="16"/></volume>"#,
    );
    let Some(DensitySource::Sampled(pattern)) = &found.density else { panic!("{found:?}") };
    assert_eq!(pattern.resolution, 16);
    let found = medium("homogeneous", r#"<spectrum name="emission" value="400:1, 700:2"/>"#);
    assert!(matches!(found.emission, Some(EmissionSource::Radiance(_))), "{found:?}");
}

#[test]
fn albedos_of_homogeneous_media_may_be_grids() {
    let volume = |name: &str| {
        let file = "tests/scenes/agreement/smoke_coloured.vol";
        format!(
            r#"<volume name="{name}" type="gridvolume"><string name="filename" value="{file}"/></volume>"#
        )
    };
    let found = medium("homogeneous", &volume("albedo"));
    let MediumContent::Plain { varies: false, albedo, .. } = found.content else { panic!("{found:?}") };
    assert!(matches!(albedo.kind, SpectrumKind::Volume(_)), "{albedo:?}");
    assert!(wrong("homogeneous", &volume("sigma_t")).contains("use a `heterogeneous` medium"));
    let text = wrong("homogeneous", r#"<texture name="albedo" type="checkerboard"/>"#);
    assert!(text.contains("it may be a <volume type=\"gridvolume\">"), "{text}");
}

#[test]
fn what_is_no_medium_is_refused_with_what_is_wrong() {
    let cases = [
        ("suspension", "", "holds no particles"),
        ("suspension", r#"<phase type="mie"/>"#, "how many spheres"),
        ("suspension", r#"<phase type="hg"/>"#, "does not say how much its particles scatter"),
        (
            "suspension",
            r#"<phase type="mie"><float name="fraction" value="1e-6"/><float name="spread" value="2"/></phase>"#,
            "says nothing of this distribution",
        ),
        (
            "homogeneous",
            r#"<phase type="mie"><float name="radius" value="-1"/></phase>"#,
            "expected a number above 0",
        ),
        (
            "homogeneous",
            r#"<phase type="blendphase"><texture name="weight" type="checkerboard"/><phase type="isotropic"/>
               <phase type="rayleigh"/></phase>"#,
            "expected a number or a <volume>",
        ),
        (
            "suspension",
            r#"<phase type="mie"><volume name="k" type="gridvolume">
               <string name="filename" value="tests/scenes/agreement/smoke.vol"/></volume></phase>"#,
            "\"k\" of phase \"mie\" has the wrong type",
        ),
        ("homogeneous", r#"<phase type="sggx"/>"#, "S"),
        ("homogeneous", r#"<phase type="sggx"><string name="S" value="1, 1, 1"/></phase>"#, "no six numbers"),
        (
            "homogeneous",
            r#"<phase type="sggx"><string name="S" value="1, 1, 1, 2, 0, 0"/></phase>"#,
            "positive definite",
        ),
        (
            "homogeneous",
            r#"<spectrum name="emission" value="1"/><float name="temperature" value="900"/>"#,
            "an emission and a temperature",
        ),
        ("homogeneous", r#"<float name="temperature" value="-1"/>"#, "at least 0"),
        ("heterogeneous", r#"<volume name="sigma_t" type="exponential"/>"#, "is a density alone"),
        ("heterogeneous", r#"<volume name="density" type="constvolume"/>"#, "no grid of numbers"),
        ("heterogeneous", r#"<volume name="density" type="texturevolume"/>"#, "texture"),
        (
            "heterogeneous",
            r#"<volume name="density" type="texturevolume"><float name="texture" value="1"/></volume>"#,
            "no pattern in space",
        ),
        (
            "heterogeneous",
            r#"<volume name="density" type="texturevolume"><texture name="texture" type="wood">
               <string name="space" value="uv"/></texture></volume>"#,
            "no pattern in space",
        ),
        (
            "heterogeneous",
            r#"<volume name="density" type="exponential"><transform name="to_world"><scale value="2"/></transform></volume>"#,
            "changes lengths",
        ),
    ];
    for (plugin, content, expected) in cases {
        let text = wrong(plugin, content);
        assert!(text.contains(expected), "{plugin}, {content}: {text}");
    }
}
