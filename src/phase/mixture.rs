//! Several kinds of particles, of which each scatters another fraction of each wavelength.

use super::Phase;
use crate::spectrum::{Sampled, Spectrum};

/// What each kind scatters per unit of length, up to a factor that all have in common, and how.
#[derive(Clone, Debug)]
pub struct Mixture(pub Vec<(Spectrum, Phase)>);

impl Mixture {
    /// The fraction of each kind, of sum 1 at each wavelength.
    pub fn fractions<'a, const C: usize>(
        &'a self,
        nm: &'a [f64; C],
    ) -> impl Iterator<Item = (Sampled<C>, &'a Phase)> + 'a {
        let all = self.0.iter().fold(Sampled::ZERO, |all, (part, _)| all + part.sample(nm));
        // Where nothing scatters, nothing is asked for: all are alike there.
        let even = 1.0 / self.0.len() as f64;
        self.0.iter().map(move |(part, phase)| {
            let own = part.sample(nm);
            (own.zip(all, |own, all| if all > 0.0 { own / all } else { even }), phase)
        })
    }
}
