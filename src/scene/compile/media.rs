//! Media and phase functions that can be traced.

use super::materials::MaterialCompiler;
use super::spectra::{index, number, spectrum, texture};
use crate::geometry::Vec3;
use crate::medium::{
    Density, Diluted, Emission, Exponential, Extinction, GridExtinction, Medium, Scattering,
};
use crate::phase::mie::Population;
use crate::phase::{Mixture, Phase, PhaseTable, Sggx, air};
use crate::raster::Grid;
use crate::scene::description::{
    self, DensitySource, EmissionSource, ExponentialSource, MediumContent, MieSource, PhaseKind,
    SampledSource,
};
use crate::scene::source::{Place, SceneError};
use crate::spectrum::{Extrapolation, Spectrum};
use crate::texture::{Filter, Texture, TexturePoint, Volume, Wrap};
use crate::units::WavelengthRange;
use rayon::prelude::*;

/// An extinction that is the same everywhere, and how it scatters.
struct Uniform {
    extinction: Spectrum,
    scattering: Option<Scattering>,
}

impl MaterialCompiler {
    /// The number of a medium.
    pub fn medium(&mut self, medium: &description::Medium) -> Result<u32, SceneError> {
        let key = (medium.place.file, medium.place.span.start);
        if let Some(&known) = self.known_media.get(&key) {
            return Ok(known);
        }
        let hash = medium.hash();
        let id = match self.media_by_hash.get(&hash) {
            Some(&alike) => alike,
            None => {
                let compiled = self.compiled_medium(medium)?;
                self.media.push(Some(compiled).filter(|medium| !medium.is_clear(self.range)));
                self.media.len() as u32 - 1
            }
        };
        self.media_by_hash.insert(hash, id);
        self.known_media.insert(key, id);
        Ok(id)
    }

    fn compiled_medium(&self, medium: &description::Medium) -> Result<Medium, SceneError> {
        let emission = match &medium.emission {
            None => None,
            Some(EmissionSource::Radiance(source)) => Some(Emission::Radiance(texture(source, &self.shift)?)),
            Some(EmissionSource::Temperature(source)) => {
                Some(Emission::Thermal(number(source, &self.shift)?))
            }
        };
        let emission = emission.filter(|emission| !emission.is_zero(self.range));
        let Uniform { extinction, scattering } = match &medium.content {
            MediumContent::Suspension { particles, absorption, metres } => {
                self.suspension(&medium.place, particles, &spectrum(absorption)?, *metres)?
            }
            MediumContent::Plain { varies: true, extinction, albedo, phase } if medium.density.is_none() => {
                let place = &extinction.place;
                let extinction = match texture(extinction, &self.shift)? {
                    Texture::Uniform(spectrum) => Extinction::Homogeneous(spectrum),
                    other => Extinction::Grid(Box::new(grid(other, place)?)),
                };
                return Ok(Medium { extinction, scattering: self.scattering(albedo, phase)?, emission });
            }
            MediumContent::Plain { extinction, albedo, phase, .. } => {
                Uniform { extinction: spectrum(extinction)?, scattering: self.scattering(albedo, phase)? }
            }
        };
        let extinction = match &medium.density {
            None => Extinction::Homogeneous(extinction),
            Some(source) => {
                let density = match source {
                    DensitySource::Grid(source) => {
                        Density::Grid(grid(texture(source, &self.shift)?, &source.place)?)
                    }
                    DensitySource::Exponential(source) => Density::Exponential(self.exponential(source)),
                    DensitySource::Sampled(source) => Density::Grid(self.sampled(source)?),
                };
                Extinction::Diluted(Box::new(Diluted { density, spectrum: extinction }))
            }
        };
        Ok(Medium { extinction, scattering, emission })
    }

    /// What is between the centres of cells is linear, so that optical depths are exact.
    fn sampled(&self, source: &SampledSource) -> Result<GridExtinction, SceneError> {
        let pattern = number(&source.pattern, &self.shift)?;
        let to_local = self.shift.inverse().then(&source.to_world.inverse());
        let to_scene = to_local.inverse();
        let cells = source.resolution as usize;
        let centre = |i: usize| (i as f64 + 0.5) / cells as f64;
        let at = |i: usize| {
            let place = Vec3::new(centre(i % cells), centre(i / cells % cells), centre(i / cells / cells));
            pattern.value(&TexturePoint::in_space(to_scene.point(place))).max(0.0) as f32
        };
        let values = (0..cells.pow(3)).into_par_iter().map(at).collect();
        let grid = Grid { size: [cells; 3], channels: 1, values, corners: [Vec3::ZERO, Vec3::ONE] };
        let volume = Volume::new(&grid, to_local, Filter::Linear, Wrap::Clamp, true);
        Ok(GridExtinction { volume, factor: 1.0 })
    }

    fn exponential(&self, source: &ExponentialSource) -> Exponential {
        /// Where the density is 6·10⁻⁶ of that on the ground.
        const SCALE_HEIGHTS: f64 = 12.0;
        let to_local = self.shift.inverse().then(&source.to_world.inverse());
        let top = source.top.unwrap_or(SCALE_HEIGHTS * source.scale_height);
        Exponential::new(to_local, source.radius, source.scale_height, top)
    }

    fn scattering(
        &self,
        albedo: &description::SpectrumSource,
        phase: &description::Phase,
    ) -> Result<Option<Scattering>, SceneError> {
        let albedo = texture(albedo, &self.shift)?;
        Ok(match albedo.is_zero(self.range) {
            true => None,
            false => Some(Scattering { albedo, phase: self.phase(phase)?, light_sample_probability: 1.0 }),
        })
    }

    /// The particles' coefficients add up to the host's absorption.
    fn suspension(
        &self,
        place: &Place,
        particles: &[description::Phase],
        absorption: &Spectrum,
        metres: f64,
    ) -> Result<Uniform, SceneError> {
        let mut parts = Vec::new();
        for particle in particles {
            parts.push(match &particle.kind {
                PhaseKind::Mie(source) => {
                    let optics = self.mie(&particle.place, source)?;
                    let per_unit = source.fraction.unwrap_or(0.0) * 1e6 * metres;
                    let phase = Phase::Spectral(Box::new(optics.phase));
                    (optics.extinction.scaled(per_unit), optics.scattering.scaled(per_unit), phase)
                }
                PhaseKind::Air { amount } => {
                    let (scattering, phase) = self.air(&particle.place)?;
                    let scattering = scattering.scaled(amount * metres);
                    (scattering.clone(), scattering, phase)
                }
                _ => {
                    let problem = "this phase function does not say how much its particles scatter";
                    return Err(SceneError::at(&particle.place, problem, "`mie` or `air`"));
                }
            });
        }
        let extinction = |nm: f64| absorption.at(nm) + parts.iter().map(|part| part.0.at(nm)).sum::<f64>();
        let scattered = |nm: f64| parts.iter().map(|part| part.1.at(nm)).sum::<f64>();
        let albedo = |nm: f64| match extinction(nm) {
            all if all > 0.0 => (scattered(nm) / all).min(1.0),
            _ => 0.0,
        };
        let table = |of: &dyn Fn(f64) -> f64| tabulated(self.range, place, &[absorption], of);
        let uniform = Uniform {
            extinction: table(&extinction)?,
            scattering: Some(Scattering {
                albedo: Texture::Uniform(table(&albedo)?),
                phase: Phase::Isotropic,
                light_sample_probability: 1.0,
            }),
        };
        let mut phases: Vec<(Spectrum, Phase)> = parts.into_iter().map(|part| (part.1, part.2)).collect();
        let phase = match phases.len() {
            1 => phases.remove(0).1,
            _ => Phase::Mixture(Mixture(phases)),
        };
        let scattering = uniform.scattering.map(|scattering| Scattering { phase, ..scattering });
        let scattering = scattering.filter(|scattering| !scattering.albedo.is_zero(self.range));
        Ok(Uniform { scattering, ..uniform })
    }

    fn mie(&self, place: &Place, source: &MieSource) -> Result<crate::phase::mie::Optics, SceneError> {
        let population = Population {
            sizes: source.sizes,
            index: [index(&source.index, self.range)?, spectrum(&source.k)?],
            host: index(&source.host, self.range)?,
        };
        population.optics(self.range).map_err(|error| {
            let expected = "spheres of some dozens of micrometres at most, with an index at all wavelengths";
            SceneError::at(place, format!("these spheres cannot be computed: {error}"), expected)
                .with_remedy("use smaller spheres, or a `tabphase` with values of its own")
        })
    }

    fn air(&self, place: &Place) -> Result<(Spectrum, Phase), SceneError> {
        air::optics(self.range).map_err(|error| {
            SceneError::at(place, error.to_string(), "a range of wavelengths that has a width")
        })
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
                    weight: number(weight, &self.shift)?,
                    nested: Box::new([self.phase(first)?, self.phase(second)?]),
                }
            }
            PhaseKind::Sggx { matrix } => {
                Phase::Sggx(Box::new(Sggx::new(matrix.elements).ok_or_else(|| {
                    SceneError::at(&phase.place, "this matrix is no ellipsoid", "a positive definite matrix")
                })?))
            }
            PhaseKind::Mie(source) => Phase::Spectral(Box::new(self.mie(&phase.place, source)?.phase)),
            PhaseKind::Air { .. } => self.air(&phase.place)?.1,
        })
    }
}

/// A function as a table that is fine enough for spectra from a file, and for what changes slowly with the
/// wavelength.
pub(super) fn tabulated(
    range: WavelengthRange,
    place: &Place,
    of: &[&Spectrum],
    at: &dyn Fn(f64) -> f64,
) -> Result<Spectrum, SceneError> {
    const STEP: f64 = 1.0;
    Spectrum::tabulated(range, STEP, of, Extrapolation::Hold, at)
        .map_err(|error| SceneError::at(place, error.to_string(), "finite coefficients"))
}

/// A grid and the factor on it.
fn grid(texture: Texture, place: &Place) -> Result<GridExtinction, SceneError> {
    let of = |volume: Volume, factor: f64| GridExtinction { volume, factor };
    match texture {
        Texture::Volume(volume) => Ok(of(*volume, 1.0)),
        Texture::Filtered { texture, by } => match *texture {
            Texture::Volume(volume) => Ok(of(*volume, by.at(550.0))),
            _ => Err(no_grid(place)),
        },
        _ => Err(no_grid(place)),
    }
}

fn no_grid(place: &Place) -> SceneError {
    SceneError::at(place, "what varies here is no grid", "a number, a spectrum or a `gridvolume`")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Transform;
    use crate::scene::fixture::PLACE;

    /// Air that absorbs from 589.2 to 589.8 nm, and in a line on whose flanks absorption and scattering are
    /// alike somewhere.
    #[test]
    fn a_suspension_absorbs_between_steps() {
        let compiler = MaterialCompiler::new(WavelengthRange::VISIBLE, Transform::IDENTITY);
        let air = description::Phase { place: PLACE, kind: PhaseKind::Air { amount: 1e4 } };
        let scattered = compiler.air(&PLACE).unwrap().0.scaled(1e4);
        let absorptions = [
            Spectrum::irregular(&[589.2, 589.8], &[1.0, 1.0], Extrapolation::Zero),
            Spectrum::irregular(&[589.2, 589.5, 589.8], &[0.0, 3.0, 0.0], Extrapolation::Zero),
        ];
        for absorption in absorptions.map(Result::unwrap) {
            let Uniform { extinction, scattering } =
                compiler.suspension(&PLACE, std::slice::from_ref(&air), &absorption, 1.0).unwrap();
            let albedo = scattering.unwrap().albedo;
            let albedo = albedo.uniform().unwrap();
            for nm in [589.1, 589.19, 589.21, 589.3, 589.5, 589.7, 589.79, 589.81] {
                let exact = absorption.at(nm) + scattered.at(nm);
                assert!((extinction.at(nm) / exact - 1.0).abs() < 1e-6, "{nm} nm: {}", extinction.at(nm));
                let [found, exact] = [albedo.at(nm) * extinction.at(nm), scattered.at(nm)];
                assert!((found / exact - 1.0).abs() < 0.01, "{nm} nm: scatters {found}, not {exact}");
            }
        }
    }
}
