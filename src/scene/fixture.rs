//! Scenes for unit tests, made without a file. Whatever needs files is tested through the public interface:
//! else the reader would be compiled once more for the unit tests.

use super::description::{
    Bsdf, BsdfKind, Description, FieldOfView, Film, FilmContent, FovAxis, IndexKind, IndexSource, Integrator,
    IntegratorKind, Medium, MediumContent, Phase, PhaseKind, PixelFormat, Roughness, Sampler, Sensor,
    SensorKind, ShapeDescription, ShapeKind, SpectrumKind, SpectrumSource,
};
use super::source::{Place, Sources};
use super::{CompileOptions, Scene, Techniques, compile};
use crate::camera::{Shutter, ShutterKind};
use crate::film::FilterKind;
use crate::geometry::{Transform, Vec3};
use crate::sampling::SamplerKind;
use crate::units::WavelengthRange;
use glam::DMat4;
use std::collections::BTreeSet;
use std::sync::Arc;

pub(crate) const PLACE: Place = Place { file: 0, span: 0..0 };

pub(crate) fn constant(value: f64) -> SpectrumSource {
    SpectrumSource { place: PLACE, kind: SpectrumKind::Constant(value), scale: 1.0 }
}

/// A line from the short to the long end of what is visible.
pub(crate) fn sloped(ends: [f64; 2]) -> SpectrumSource {
    let WavelengthRange { min, max } = WavelengthRange::VISIBLE;
    let kind = SpectrumKind::Irregular { nm: vec![min, max], values: ends.to_vec(), file: None };
    SpectrumSource { place: PLACE, kind, scale: 1.0 }
}

pub(crate) fn bsdf(kind: BsdfKind) -> Arc<Bsdf> {
    Arc::new(Bsdf { place: PLACE, id: None, kind })
}

pub(crate) fn diffuse(reflectance: SpectrumSource) -> Arc<Bsdf> {
    bsdf(BsdfKind::Diffuse { reflectance })
}

pub(crate) fn glass(index: f64, roughness: Option<Roughness>) -> Arc<Bsdf> {
    bsdf(BsdfKind::Dielectric {
        interior: IndexSource { place: PLACE, kind: IndexKind::Constant(index) },
        exterior: None,
        specular_reflectance: constant(1.0),
        specular_transmittance: constant(1.0),
        roughness,
    })
}

/// The same everywhere; scatters evenly.
pub(crate) fn medium(extinction: SpectrumSource, albedo: f64) -> Medium {
    let phase = Phase { place: PLACE, kind: PhaseKind::Isotropic };
    let content = MediumContent::Plain { varies: false, extinction, albedo: constant(albedo), phase };
    Medium { place: PLACE, id: None, content, emission: None, density: None }
}

pub(crate) fn transform(matrix: DMat4) -> Transform {
    Transform::new(matrix).expect("an invertible matrix")
}

pub(crate) fn shape(kind: ShapeKind, to_world: DMat4, bsdf: Arc<Bsdf>) -> ShapeDescription {
    ShapeDescription {
        place: PLACE,
        id: None,
        kind,
        to_world: transform(to_world),
        motion: None,
        flip_normals: false,
        bsdf,
        emission: None,
        interior: None,
        exterior: None,
        priority: None,
    }
}

/// Shapes before a camera of 45° that looks from one place to another; 16 × 16 pixels.
pub(crate) fn described(shapes: Vec<ShapeDescription>, from: Vec3, to: Vec3) -> Description {
    let ahead = (to - from).normalize();
    let left = Vec3::Y.cross(ahead).normalize();
    let axes = [left, ahead.cross(left), ahead].map(|axis| axis.extend(0.0));
    let to_world = DMat4::from_cols(axes[0], axes[1], axes[2], from.extend(1.0));
    let film = Film {
        place: PLACE,
        width: 16,
        height: 16,
        crop: None,
        filter: FilterKind::Box,
        sample_border: false,
        content: FilmContent::Colour { format: PixelFormat::Xyz, alpha: false },
    };
    let kind = SensorKind::Perspective {
        to_world: transform(to_world),
        field_of_view: FieldOfView::Degrees { angle: 45.0, axis: FovAxis::X },
        principal_point: [0.0; 2],
        near_clip: 1e-2,
        far_clip: 1e4,
        lens: None,
    };
    let sampler =
        Sampler { place: PLACE, kind: SamplerKind::Sobol, forced: false, sample_count: 16, seed: 0 };
    let sensor = Sensor {
        place: PLACE,
        kind,
        response: None,
        medium: None,
        film,
        sampler,
        motion: None,
        shutter: Shutter { open: 0.0, close: 0.0, kind: ShutterKind::Box },
    };
    let integrator = Integrator {
        place: PLACE,
        kind: IntegratorKind::Path,
        max_depth: Some(5),
        rr_depth: 5,
        hide_emitters: false,
        techniques: Techniques::Both,
        aovs: Vec::new(),
        moments: None,
    };
    Description {
        sources: Sources::default(),
        files: BTreeSet::new(),
        integrator,
        sensor,
        shapes,
        solids: Vec::new(),
        instances: Vec::new(),
        lights: Vec::new(),
        extensions: Vec::new(),
        assumptions: Vec::new(),
        remarks: Vec::new(),
    }
}

pub(crate) fn compiled(description: &Description) -> Scene {
    compile(description, &CompileOptions::default()).unwrap_or_else(|errors| panic!("{errors}"))
}
