//! Media and phase functions that can be traced.

use super::materials::MaterialCompiler;
use super::spectra::{spectrum, texture};
use crate::medium::{Extinction, GridExtinction, Medium, Scattering};
use crate::phase::{Phase, PhaseTable};
use crate::scene::description::{self, PhaseKind};
use crate::scene::source::SceneError;
use crate::texture::Texture;

impl MaterialCompiler {
    /// The number of a medium.
    pub fn medium(&mut self, medium: &description::Medium) -> Result<u32, SceneError> {
        let key = (medium.place.file, medium.place.span.start);
        if let Some(&known) = self.known_media.get(&key) {
            return Ok(known);
        }
        let compiled = self.compiled_medium(medium)?;
        self.media.push(Some(compiled).filter(|medium| !medium.is_clear(self.range)));
        let id = self.media.len() as u32 - 1;
        self.known_media.insert(key, id);
        Ok(id)
    }

    fn compiled_medium(&self, medium: &description::Medium) -> Result<Medium, SceneError> {
        let shift = self.shift;
        let extinction = if medium.varies {
            match texture(&medium.extinction, &shift)? {
                Texture::Uniform(spectrum) => Extinction::Homogeneous(spectrum),
                Texture::Volume(volume) => grid(*volume, 1.0),
                Texture::Filtered { texture: nested, by } => match *nested {
                    Texture::Volume(volume) => grid(*volume, by.at(550.0)),
                    _ => return Err(no_grid(medium)),
                },
                _ => return Err(no_grid(medium)),
            }
        } else {
            Extinction::Homogeneous(spectrum(&medium.extinction)?)
        };
        let albedo = texture(&medium.albedo, &shift)?;
        let scattering = match albedo.is_zero(self.range) {
            true => None,
            false => Some(Scattering { albedo, phase: self.phase(&medium.phase)? }),
        };
        Ok(Medium { extinction, scattering })
    }

    fn phase(&self, phase: &description::Phase) -> Result<Phase, SceneError> {
        Ok(match &phase.kind {
            PhaseKind::Isotropic => Phase::Isotropic,
            PhaseKind::HenyeyGreenstein { g } => Phase::HenyeyGreenstein(*g),
            PhaseKind::Rayleigh => Phase::Rayleigh,
            PhaseKind::Tabulated { values } => {
                let table = PhaseTable::new(values).ok_or_else(|| {
                    let expected = "values of at least 0, two or more and not all 0";
                    SceneError::at(&phase.place, "this table is no phase function", expected)
                })?;
                Phase::Table(Box::new(table))
            }
            PhaseKind::Blend { weight, nested } => {
                let [first, second] = &**nested;
                Phase::Blend {
                    weight: texture(weight, &self.shift)?,
                    nested: Box::new([self.phase(first)?, self.phase(second)?]),
                }
            }
        })
    }
}

fn grid(volume: crate::texture::Volume, factor: f64) -> Extinction {
    Extinction::Grid(Box::new(GridExtinction { volume, factor }))
}

fn no_grid(medium: &description::Medium) -> SceneError {
    SceneError::at(
        &medium.extinction.place,
        "the extinction of this medium is no grid",
        "a number, a spectrum or a `gridvolume`",
    )
}
