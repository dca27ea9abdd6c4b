use super::{Case, Purpose, Request, derived_seed};
use crate::film::Film;
use crate::integrator::Estimator;
use crate::output::exr::Channels;
use crate::output::{Colour, Content, Picture};
use crate::render::{Progress, Schedule, Settings, WavelengthCount, render};
use crate::sampling::{SamplerKind, digest};
use crate::spectrum::colour::rec709_to_xyz;
use crate::stats::relmse_scale;
use std::path::Path;

/// Replicates of a reference that a study makes itself: enough to tell its variance.
pub const REPLICATES: u32 = 16;

/// The picture that errors are measured against, its luminance Y.
///
/// relMSE of an image A is mean((A − B)²/(B² + 0.01·mean(B)²)) over all pixels, with the reference B, as
/// `abbe compare` has it. On average it has, beside the error of A, the variance of B in it, which is known
/// from B's replicates: that is subtracted.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Y of each pixel, by rows.
    pub y: Vec<f64>,
    /// 1/(B² + 0.01·mean(B)²).
    pub weight: Vec<f64>,
    /// What the reference's own error adds to every relMSE; `None` where it is not known.
    pub own_relmse: Option<f64>,
}

/// Why a picture is no reference.
#[derive(Clone, Debug, PartialEq)]
pub enum ReferenceError {
    /// Width and height.
    Size([usize; 2]),
    /// The names that there are.
    NoLuminance(Vec<String>),
    /// The picture is black: relMSE has no scale.
    Black,
    /// A value is infinite or not a number.
    NotFinite,
}

impl Reference {
    /// A reference of the luminances `y`, row by row, with their standard errors if they are known.
    ///
    /// # Errors
    /// Where the numbers are no picture of this width, or no reference.
    pub fn new(width: usize, y: Vec<f64>, error: Option<&[f64]>) -> Result<Self, ReferenceError> {
        let pixels = y.len().max(1) as f64;
        let mean = y.iter().sum::<f64>() / pixels;
        if !y.iter().all(|y| y.is_finite()) {
            return Err(ReferenceError::NotFinite);
        }
        if mean <= 0.0 {
            return Err(ReferenceError::Black);
        }
        let weight: Vec<f64> = y.iter().map(|&y| 1.0 / relmse_scale(y, mean)).collect();
        let own_relmse = error
            .map(|error| error.iter().zip(&weight).map(|(e, w)| e * e * w).sum::<f64>() / pixels)
            .filter(|own| own.is_finite());
        Ok(Self { width, height: y.len() / width.max(1), y, weight, own_relmse })
    }

    /// The reference of a file: its Y with `error.Y`, or the luminance of linear Rec. 709, whose error cannot
    /// be told from those of its channels.
    pub fn from_channels(file: &Channels, size: [u32; 2]) -> Result<Self, ReferenceError> {
        if [file.width, file.height] != size.map(|edge| edge as usize) {
            return Err(ReferenceError::Size([file.width, file.height]));
        }
        let find = |name: &str| -> Option<Vec<f64>> {
            Some(file.channel(name)?.iter().map(|&value| f64::from(value)).collect())
        };
        if let Some(y) = find("Y") {
            return Self::new(file.width, y, find("error.Y").as_deref());
        }
        match (find("R"), find("G"), find("B")) {
            (Some(r), Some(g), Some(b)) => {
                let luminance = |i: usize| rec709_to_xyz([r[i], g[i], b[i]]).y;
                Self::new(file.width, (0..r.len()).map(luminance).collect(), None)
            }
            _ => {
                Err(ReferenceError::NoLuminance(file.channels.iter().map(|(name, _)| name.clone()).collect()))
            }
        }
    }

    /// Hash of its values.
    pub fn hash(&self) -> u64 {
        digest(std::iter::once(self.width as u64).chain(self.y.iter().map(|y| y.to_bits())))
    }

    /// relMSE of an image, the reference's part subtracted.
    pub fn relmse(&self, image: &[f64]) -> f64 {
        let squares = image.iter().zip(&self.y).zip(&self.weight).map(|((a, b), w)| (a - b) * (a - b) * w);
        squares.sum::<f64>() / self.y.len().max(1) as f64 - self.own_relmse.unwrap_or(0.0)
    }

    /// The signed error of each pixel whose squares relMSE is the mean of.
    pub fn relative_errors(&self, image: &[f64]) -> Vec<f64> {
        image.iter().zip(&self.y).zip(&self.weight).map(|((a, b), w)| (a - b) * w.sqrt()).collect()
    }
}

/// How a study's own reference is rendered: another seed, and the sampler whose error falls fastest.
pub fn settings(request: &Request, case: usize, samples_per_pixel: u32) -> Settings {
    Settings {
        schedule: Schedule::with_replicates(samples_per_pixel, REPLICATES),
        seed: derived_seed(request.seed, Purpose::Reference, [case as u64]),
        sampler: SamplerKind::Sobol,
        wavelengths: Some(WavelengthCount::Four),
        estimator: Estimator::Shared,
        bins: None,
    }
}

/// Renders the reference of a case into an EXR file with the channels `Y` and `error.Y`.
pub fn write(path: &Path, case: &Case, settings: &Settings, progress: &dyn Progress) -> std::io::Result<()> {
    let film: Film = render(&case.scene, settings, progress);
    let picture = Picture {
        film: &film,
        content: Content::Colour(Colour::Luminance),
        moments: None,
        auxiliary: Vec::new(),
        attributes: vec![
            ("abbe.version".to_owned(), env!("CARGO_PKG_VERSION").to_owned()),
            ("abbe.sceneHash".to_owned(), case.id.scene_hash.clone()),
            ("abbe.seed".to_owned(), settings.seed.to_string()),
            ("abbe.replicates".to_owned(), settings.schedule.replicates.to_string()),
            ("abbe.samplesPerPixel".to_owned(), settings.schedule.samples().to_string()),
        ],
    };
    crate::output::exr::write(path, &picture)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn relmse_is_that_of_the_definition() {
        // Mean 2: the floor is 0.04.
        let reference = Reference::new(2, vec![1.0, 3.0], None).expect("it is lit");
        let expected = 0.5 * (0.25 / 1.04 + 1.0 / 9.04);
        assert!((reference.relmse(&[1.5, 2.0]) - expected).abs() < 1e-15);
        let errors = reference.relative_errors(&[1.5, 2.0]);
        assert!(((errors[0] * errors[0] + errors[1] * errors[1]) / 2.0 - expected).abs() < 1e-15);
        let noisy = Reference::new(2, vec![1.0, 3.0], Some(&[0.1, 0.2])).expect("it is lit");
        let own = 0.5 * (0.01 / 1.04 + 0.04 / 9.04);
        assert!((noisy.relmse(&[1.5, 2.0]) - (expected - own)).abs() < 1e-15);
    }

    #[test]
    fn what_cannot_be_a_reference_is_refused() {
        assert_eq!(Reference::new(1, vec![0.0], None), Err(ReferenceError::Black));
        assert_eq!(Reference::new(1, vec![f64::NAN], None), Err(ReferenceError::NotFinite));
        let file = Channels {
            width: 1,
            height: 1,
            channels: vec![("depth".to_owned(), vec![1.0])],
            ..Channels::default()
        };
        assert_eq!(
            Reference::from_channels(&file, [1, 1]),
            Err(ReferenceError::NoLuminance(vec!["depth".to_owned()]))
        );
        assert_eq!(Reference::from_channels(&file, [2, 1]), Err(ReferenceError::Size([1, 1])));
    }
}
