use super::colours::Lit;
use crate::scene::description::{
    BitmapSource, CheckerboardSource, ProceduralSource, RgbRole, SpectrumKind, SpectrumSource,
};
use crate::spectrum::DispersionFormula;
use std::sync::Arc;

/// A spectrum as its plugin has it.
pub enum Plugin {
    Uniform(f64),
    Regular { min_nm: f64, max_nm: f64, values: Vec<f64> },
    Irregular { nm: Vec<f64>, values: Vec<f64> },
    D65 { lit: Lit, scale: f64 },
    Blackbody { kelvin: f64, min_nm: f64, max_nm: f64 },
    Rgb([f64; 3]),
    Srgb { rgb: [f64; 3], unbounded: bool },
    RawConstant(SpectrumKind),
    Bitmap(BitmapSource),
    Checkerboard(CheckerboardSource),
    MeshAttribute { name: String, scale: f64 },
    Volume(SpectrumKind),
    Procedural(ProceduralSource),
    Measured { name: String, scale: f64 },
    Sellmeier(DispersionFormula),
    Cauchy(DispersionFormula),
}

impl Plugin {
    /// The plugin that stands for a spectrum.
    pub fn of(source: &SpectrumSource) -> Self {
        let SpectrumSource { kind, scale, .. } = source;
        let scale = *scale;
        let scaled = |values: &[f64]| values.iter().map(|value| value * scale).collect::<Vec<_>>();
        match kind {
            SpectrumKind::Constant(value) => Self::Uniform(value * scale),
            SpectrumKind::Irregular { nm, values, .. } => {
                Self::Irregular { nm: nm.clone(), values: scaled(values) }
            }
            SpectrumKind::Regular { min_nm, max_nm, values } => {
                Self::Regular { min_nm: *min_nm, max_nm: *max_nm, values: scaled(values) }
            }
            SpectrumKind::D65 => Self::D65 { lit: Lit::Nothing, scale },
            SpectrumKind::Rgb { rgb, role: RgbRole::Illuminant } => {
                Self::D65 { lit: Lit::Colour(*rgb), scale }
            }
            SpectrumKind::Daylit(nested) => Self::D65 { lit: Lit::Texture(nested.clone()), scale },
            SpectrumKind::Blackbody { kelvin, min_nm, max_nm } => {
                Self::Blackbody { kelvin: *kelvin, min_nm: *min_nm, max_nm: *max_nm }
            }
            SpectrumKind::Rgb { rgb, role } => Self::Srgb { rgb: *rgb, unbounded: *role == RgbRole::Clipped },
            SpectrumKind::Vector(_) => Self::RawConstant(kind.clone()),
            SpectrumKind::Bitmap(source) => Self::Bitmap((**source).clone()),
            SpectrumKind::Checkerboard(source) => Self::Checkerboard((**source).clone()),
            SpectrumKind::MeshAttribute { name } => Self::MeshAttribute { name: name.clone(), scale },
            SpectrumKind::Volume(_) => Self::Volume(kind.clone()),
            SpectrumKind::Procedural(source) => Self::Procedural((**source).clone()),
            SpectrumKind::Named(name) => Self::Measured { name: name.clone(), scale },
        }
    }

    /// The spectrum with a factor on it; `None` for a formula of an index.
    pub fn spectrum(self) -> Option<(SpectrumKind, f64)> {
        let kind = match self {
            Self::Uniform(value) => SpectrumKind::Constant(value),
            Self::Regular { min_nm, max_nm, values } => SpectrumKind::Regular { min_nm, max_nm, values },
            Self::Irregular { nm, values } => SpectrumKind::Irregular { nm, values, file: None },
            Self::D65 { lit, scale } => {
                let kind = match lit {
                    Lit::Nothing => SpectrumKind::D65,
                    Lit::Colour(rgb) => SpectrumKind::Rgb { rgb, role: RgbRole::Illuminant },
                    Lit::Texture(nested) => SpectrumKind::Daylit(nested),
                };
                return Some((kind, scale));
            }
            Self::Blackbody { kelvin, min_nm, max_nm } => SpectrumKind::Blackbody { kelvin, min_nm, max_nm },
            Self::Rgb(rgb) => SpectrumKind::Rgb { rgb, role: RgbRole::Reflectance },
            Self::Srgb { rgb, unbounded } => {
                let role = if unbounded { RgbRole::Clipped } else { RgbRole::Reflectance };
                SpectrumKind::Rgb { rgb, role }
            }
            Self::RawConstant(kind) | Self::Volume(kind) => kind,
            Self::Bitmap(source) => SpectrumKind::Bitmap(Arc::new(source)),
            Self::Checkerboard(source) => SpectrumKind::Checkerboard(Arc::new(source)),
            Self::MeshAttribute { name, scale } => {
                return Some((SpectrumKind::MeshAttribute { name }, scale));
            }
            Self::Procedural(source) => SpectrumKind::Procedural(Arc::new(source)),
            Self::Measured { name, scale } => return Some((SpectrumKind::Named(name), scale)),
            Self::Sellmeier(_) | Self::Cauchy(_) => return None,
        };
        Some((kind, 1.0))
    }
}
