//! Roughness that may vary over a surface.

use crate::bsdf::{Microfacets, microfacet};
use crate::texture::{Texture, TexturePoint};

/// The roughness of a surface made of small facets.
#[derive(Clone, Debug)]
pub struct Facets {
    pub shape: microfacet::Shape,
    /// Along the tangent and the bitangent.
    pub alpha: [Texture; 2],
    /// Whether the two are one texture.
    pub isotropic: bool,
}

impl Facets {
    pub(super) fn microfacets(&self, at: &TexturePoint) -> Microfacets {
        let [u, v] = &self.alpha;
        let along = u.value(at);
        let across = if self.isotropic { along } else { v.value(at) };
        Microfacets::new(self.shape, along, across)
    }

    /// Whether it matters which way the surface's coordinates run.
    pub(super) fn is_anisotropic(&self) -> bool {
        !self.isotropic
    }

    pub(super) fn textures(&self) -> impl Iterator<Item = &Texture> {
        self.alpha.iter()
    }
}
