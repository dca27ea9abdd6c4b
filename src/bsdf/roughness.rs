//! The microfacet distribution and roughness of a surface, which may vary over it.

use super::{Microfacets, microfacet};
use crate::texture::{Texture, TexturePoint};

/// The microfacet distribution of a rough surface and the textures of its roughness.
#[derive(Clone, Debug)]
pub struct RoughnessTextures {
    /// Distribution of the microfacets' normals.
    pub distribution: microfacet::Distribution,
    /// Along the tangent and the bitangent.
    pub alpha: [Texture; 2],
    /// Whether the two are one texture.
    pub isotropic: bool,
}

impl RoughnessTextures {
    pub(super) fn microfacets(&self, at: &TexturePoint) -> Microfacets {
        let [u, v] = &self.alpha;
        let along = u.value(at);
        let across = if self.isotropic { along } else { v.value(at) };
        Microfacets::new(self.distribution, along, across)
    }

    /// Those of a surface on which they are the same everywhere and in all directions.
    pub(super) fn even(&self) -> Option<Microfacets> {
        let alpha = self.alpha[0].uniform_value().filter(|_| self.isotropic)?;
        Some(Microfacets::new(self.distribution, alpha, alpha))
    }

    /// Whether it is the same everywhere, and at most so large in each direction.
    pub(super) fn is_at_most(&self, largest: f64) -> bool {
        let is_below = |alpha: &Texture| alpha.uniform_value().is_some_and(|alpha| alpha <= largest);
        self.alpha.iter().all(is_below)
    }

    /// Whether it matters which way the surface's coordinates run.
    pub(super) fn is_anisotropic(&self) -> bool {
        !self.isotropic
    }

    pub(super) fn textures(&self) -> impl Iterator<Item = &Texture> {
        self.alpha.iter()
    }
}
