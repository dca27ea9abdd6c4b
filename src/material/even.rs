//! Materials that look the same all over a surface: what groups of paths look up once.

use super::{Material, MaterialId, Materials};
use crate::bsdf::{BsdfTextures, EvenRoughMetal};
use crate::spectrum::Spectrum;

/// What is known of one side of a surface, independent of the place on it.
#[derive(Clone, Debug)]
pub enum Even<'a> {
    /// Diffuse with this reflectance.
    Diffuse(&'a Spectrum),
    /// A rough metal.
    Metal(Box<EvenRoughMetal>),
    /// Black.
    Black,
}

impl Materials {
    /// The front or the back of a material, if it is even. `None` for all others.
    pub fn even(&self, id: MaterialId, front: bool) -> Option<Even<'_>> {
        match self.get(id) {
            Material::TwoSided { front: shown, .. } if front => self.even(*shown, true),
            // The back is seen from its own front.
            Material::TwoSided { back, .. } => self.even(*back, true),
            Material::Bsdf(BsdfTextures::Diffuse { reflectance }) => {
                let spectrum = reflectance.uniform()?;
                Some(if front { Even::Diffuse(spectrum) } else { Even::Black })
            }
            Material::Bsdf(BsdfTextures::Black) => Some(Even::Black),
            Material::Bsdf(bsdf) => {
                let metal = EvenRoughMetal::of(bsdf)?;
                Some(if front { Even::Metal(Box::new(metal)) } else { Even::Black })
            }
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::microfacet::Distribution;
    use crate::bsdf::{Metal, RoughnessTextures};
    use crate::texture::Texture;

    #[test]
    fn two_sided_materials_show_each_side_from_its_front() {
        let mut materials = Materials::default();
        let mut diffuse = |value: f64| {
            let reflectance = Texture::Uniform(Spectrum::Constant(value));
            materials.add(Material::Bsdf(BsdfTextures::Diffuse { reflectance }))
        };
        let [light, dark] = [0.8, 0.1].map(&mut diffuse);
        let both = materials.add(Material::TwoSided { front: light, back: dark });
        let nothing = materials.add(Material::Bsdf(BsdfTextures::Null));
        let uniform = |value: f64| Texture::Uniform(Spectrum::Constant(value));
        let alpha = [0.3; 2].map(uniform);
        let metal = materials.add(Material::Bsdf(BsdfTextures::Conductor {
            index: Metal::Index { n: uniform(1.5), k: uniform(4.0) },
            specular_reflectance: uniform(1.0),
            roughness: Some(RoughnessTextures { distribution: Distribution::Ggx, alpha, isotropic: true }),
        }));
        let seen = |id, front| match materials.even(id, front) {
            Some(Even::Diffuse(spectrum)) => Some(spectrum.at(550.0)),
            Some(Even::Black) => Some(0.0),
            Some(Even::Metal(metal)) => Some(metal.sample(&[550.0]).facet.k.hero()),
            None => None,
        };
        assert_eq!([seen(both, true), seen(both, false)], [Some(0.8), Some(0.1)]);
        assert_eq!([seen(dark, true), seen(dark, false)], [Some(0.1), Some(0.0)]);
        assert_eq!([seen(metal, true), seen(metal, false)], [Some(4.0), Some(0.0)]);
        assert_eq!([seen(nothing, true), seen(nothing, false)], [None, None]);
    }
}
