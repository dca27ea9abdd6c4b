use abbe::film::FilterKind;
use abbe::geometry::*;
use abbe::render::*;
use abbe::sampling::SamplerKind;
use abbe::scene::description::*;
use abbe::scene::{source::*, *};
use std::sync::Arc;
fn pl() -> Place {
    Place { file: 0, span: 0..0 }
}
fn c(v: f64) -> SpectrumSource {
    SpectrumSource { place: pl(), kind: SpectrumKind::Constant(v), scale: 1.0 }
}
fn b(k: BsdfKind) -> Arc<Bsdf> {
    Arc::new(Bsdf { place: pl(), id: None, kind: k })
}
fn sh(kind: ShapeKind, m: glam::DMat4, bsdf: Arc<Bsdf>, e: Option<SpectrumSource>) -> Shape {
    Shape {
        place: pl(),
        id: None,
        kind,
        to_world: Transform::new(m).unwrap(),
        flip_normals: false,
        bsdf,
        emission: e,
        interior: None,
    }
}
fn main() {
    use glam::*;
    let lin = |a: f64, z: f64| SpectrumSource {
        place: pl(),
        kind: SpectrumKind::Regular { min_nm: 360., max_nm: 830., values: vec![a, z] },
        scale: 1.0,
    };
    let white = b(BsdfKind::Diffuse { reflectance: c(0.7) });
    let red = b(BsdfKind::Diffuse { reflectance: lin(0.05, 0.8) });
    let blue = b(BsdfKind::Diffuse { reflectance: lin(0.8, 0.05) });
    let black = b(BsdfKind::Diffuse { reflectance: c(0.0) });
    let glass = b(BsdfKind::Dielectric {
        interior: IndexSource { place: pl(), kind: IndexKind::Tabulated(lin(1.6, 1.5)) },
        exterior: Some(IndexSource { place: pl(), kind: IndexKind::Constant(1.0) }),
        specular_reflectance: c(1.0),
        specular_transmittance: c(1.0),
        roughness: None,
    });
    let metal = b(BsdfKind::Conductor {
        index: ConductorIndex::Complex { n: c(0.2), k: c(3.0) },
        specular_reflectance: c(1.0),
        roughness: Some(Roughness { distribution: Distribution::Ggx, alpha: [0.2, 0.2] }),
    });
    let t = |x: f64, y: f64, z: f64| DMat4::from_translation(dvec3(x, y, z));
    let rx = DMat4::from_rotation_x;
    let ry = DMat4::from_rotation_y;
    let d = std::f64::consts::FRAC_PI_2;
    let shapes = vec![
        sh(ShapeKind::Rectangle, t(0., -1., 0.) * rx(-d), white.clone(), None),
        sh(ShapeKind::Rectangle, t(0., 1., 0.) * rx(d), white.clone(), None),
        sh(ShapeKind::Rectangle, t(0., 0., -1.), white.clone(), None),
        sh(ShapeKind::Rectangle, t(-1., 0., 0.) * ry(d), red, None),
        sh(ShapeKind::Rectangle, t(1., 0., 0.) * ry(-d), blue, None),
        sh(
            ShapeKind::Rectangle,
            t(0., 0.99, 0.) * rx(d) * DMat4::from_scale(dvec3(0.3, 0.3, 1.0)),
            black,
            Some(c(10.0)),
        ),
        sh(ShapeKind::Sphere { centre: dvec3(-0.4, -0.6, -0.2), radius: 0.4 }, DMat4::IDENTITY, metal, None),
        sh(ShapeKind::Sphere { centre: dvec3(0.4, -0.65, 0.3), radius: 0.35 }, DMat4::IDENTITY, glass, None),
    ];
    let mut description = Description {
        sources: Sources::default(),
        integrator: Integrator {
            place: pl(),
            kind: IntegratorKind::Path,
            max_depth: Some(8),
            rr_depth: 5,
            hide_emitters: false,
        },
        sensor: Sensor {
            place: pl(),
            to_world: Transform::new(t(0., 0., 3.9) * ry(2. * d)).unwrap(),
            field_of_view: FieldOfView::Degrees { angle: 39.3, axis: FovAxis::X },
            principal_point: [0.; 2],
            near_clip: 0.01,
            far_clip: 1e4,
            lens: None,
            film: Film {
                place: pl(),
                width: 256,
                height: 256,
                crop: None,
                filter: FilterKind::Box,
                pixel_format: PixelFormat::Rgb,
            },
            sampler: Sampler { place: pl(), kind: SamplerKind::Sobol, sample_count: 64, seed: 0 },
        },
        shapes,
        lights: vec![],
        extensions: vec![],
        assumptions: vec![],
    };
    for (kind, count) in [
        (IntegratorKind::Path, WavelengthCount::One),
        (IntegratorKind::Path, WavelengthCount::Four),
        (IntegratorKind::Path, WavelengthCount::Eight),
        (IntegratorKind::Walk, WavelengthCount::One),
    ] {
        description.integrator.kind = kind;
        let scene = compile(&description, &CompileOptions::default()).unwrap();
        let s = Settings {
            schedule: Schedule::new(64),
            seed: 1,
            sampler: SamplerKind::Sobol,
            wavelengths: count,
            bins: None,
        };
        let start = std::time::Instant::now();
        let film = render(&scene, &s, &Unwatched::new());
        let dt = start.elapsed().as_secs_f64();
        let mut m = [0.0; 3];
        let mut v = [0.0; 3];
        for y in 0..256 {
            for x in 0..256 {
                for k in 0..3 {
                    let mut w = [0.0; 3];
                    w[k] = 1.0;
                    let q = film.combined(x, y, w);
                    m[k] += q.mean / 65536.;
                    v[k] += q.error * q.error / 65536. / 65536.;
                }
            }
        }
        println!(
            "{kind:?} {count:?} {:?} +- {:?} rel {:?} {:.2} s {:.2} M/s bad {:?}",
            m,
            v.map(f64::sqrt),
            film.relative_error(),
            dt,
            film.total_samples() as f64 / dt / 1e6,
            film.bad
        );
        if count == WavelengthCount::Four {
            let p = abbe::output::Picture {
                film: &film,
                colour: abbe::output::Colour::Rec709,
                full_size: [256, 256],
                offset: [0, 0],
                auxiliary: vec![],
                attributes: vec![],
            };
            abbe::output::png::write("/tmp/smoke.png".as_ref(), &p).unwrap();
            abbe::output::exr::write("/tmp/smoke.exr".as_ref(), &p).unwrap();
        }
    }
    println!(
        "{:?}",
        abbe::output::exr::read("/tmp/smoke.exr".as_ref())
            .unwrap()
            .0
            .iter()
            .map(|c| c.0.clone())
            .collect::<Vec<_>>()
    );
}
