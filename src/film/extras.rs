use crate::units::WavelengthRange;
use serde::{Deserialize, Serialize};

/// The channel of the filter's weights: X, Y and Z are before it.
pub(super) const WEIGHT: usize = 3;

/// What a film measures beside X, Y and Z.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Extras {
    /// The fraction of the samples that meet something.
    pub alpha: bool,
    /// The second moments of X, Y and Z over the samples.
    pub moments: bool,
    /// For each further channel of the sensor the integral of its response, nm: what is added to the channel
    /// is over it.
    pub responses: Vec<f64>,
    /// Spectral bins, if the film measures them.
    pub bins: Option<SpectralBins>,
    /// Whether light subpaths bring something, too.
    pub light_paths: bool,
}

impl Extras {
    /// Channels in all: X, Y and Z and the filter's weights included. Spectral bins are the last.
    pub fn channels(&self) -> usize {
        self.bin_channel(0) + self.bin_count()
    }

    pub(super) fn bin_count(&self) -> usize {
        self.bins.map_or(0, |bins| bins.count)
    }

    /// The channel of the weights of those samples that meet something, in a film with alpha.
    pub fn alpha_channel(&self) -> usize {
        WEIGHT + 1
    }

    /// The channel of the second moment of X, Y or Z, in a film that measures them.
    pub fn moment_channel(&self, of: usize) -> usize {
        WEIGHT + 1 + usize::from(self.alpha) + of
    }

    /// The channel of a response of the sensor, counted from 0.
    pub fn response_channel(&self, response: usize) -> usize {
        self.moment_channel(if self.moments { 3 } else { 0 }) + response
    }

    /// The channel of a spectral bin, counted from 0.
    pub fn bin_channel(&self, bin: usize) -> usize {
        self.response_channel(self.responses.len()) + bin
    }
}

/// Equal bins over a range of wavelengths, each measuring the mean spectral radiance within it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SpectralBins {
    /// The wavelengths that they cover.
    pub range: WavelengthRange,
    /// Number of bins, at least 1.
    pub count: usize,
}

impl SpectralBins {
    /// nm.
    pub fn width(&self) -> f64 {
        self.range.width() / self.count as f64
    }

    /// The middle of a bin, nm.
    pub fn centre(&self, bin: usize) -> f64 {
        self.range.min + (bin as f64 + 0.5) * self.width()
    }

    /// The bin of a wavelength; the upper end of the range belongs to the last.
    pub fn of(&self, nm: f64) -> Option<usize> {
        let bin = ((nm - self.range.min) / self.width()).floor();
        let inside = self.range.contains(nm);
        inside.then(|| (bin as usize).min(self.count - 1))
    }
}
