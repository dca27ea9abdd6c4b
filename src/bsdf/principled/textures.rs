//! The textures that become the parameters of the model.

use super::{Albedo, Principled, PrincipledBase, PrincipledThin};
use crate::bsdf::Bsdf;
use crate::spectrum::colour::Observer;
use crate::spectrum::{Sampled, Spectrum};
use crate::texture::{Texture, TexturePoint};

/// What the surfaces of [`PrincipledBase`] are steered by.
#[derive(Clone, Debug)]
pub struct PrincipledBaseTextures {
    /// Colour of the base, from 0 to 1.
    pub base_color: Texture,
    /// Roughness, from 0 to 1; its square is the width α of the microfacets.
    pub roughness: Texture,
    /// Stretch of the highlight along the tangent, from 0 (round) to 1.
    pub anisotropic: Texture,
    /// Weight of specular transmission, from 0 to 1.
    pub spec_trans: Texture,
    /// Tint of the dielectric reflection toward the base's hue, from 0 to 1.
    pub spec_tint: Texture,
    /// Strength of the sheen at grazing angles, from 0 to 1.
    pub sheen: Texture,
    /// Tint of the sheen toward the base's hue, from 0 to 1.
    pub sheen_tint: Texture,
    /// Weight of the flattened diffuse lobe that stands for subsurface scattering, from 0 to 1.
    pub flatness: Texture,
}

impl PrincipledBaseTextures {
    fn sample<const C: usize>(&self, at: &TexturePoint, nm: &[f64; C]) -> PrincipledBase<C> {
        let fraction = |texture: &Texture| texture.value(at).clamp(0.0, 1.0);
        let color = self.base_color.sample(at, nm);
        let (spec_tint, sheen_tint) = (fraction(&self.spec_tint), fraction(&self.sheen_tint));
        PrincipledBase {
            color,
            tint: if spec_tint > 0.0 || sheen_tint > 0.0 { self.tint(at, nm, color) } else { Sampled::ONE },
            roughness: fraction(&self.roughness),
            anisotropic: fraction(&self.anisotropic),
            spec_trans: fraction(&self.spec_trans),
            spec_tint,
            sheen: self.sheen.value(at).max(0.0),
            sheen_tint,
            flatness: fraction(&self.flatness),
        }
    }

    /// The colour over its luminance. For luminance Mitsuba 3 takes the mean of ȳ times the colour over the
    /// four wavelengths of a path. Each of them is made from the same number, so that every wavelength has
    /// its own three companions, and its own tint: that of grey is not 1 but varies around 3.
    fn tint<const C: usize>(&self, at: &TexturePoint, nm: &[f64; C], color: Sampled<C>) -> Sampled<C> {
        Sampled::from_fn(|lane| {
            let together = companions(nm[lane]);
            let colors = self.base_color.sample(at, &together);
            let [_, weights, _] = Observer::cie1931_5nm().sample(&together);
            let luminance = (colors * weights).sum() / 4.0;
            if luminance > 0.0 { color[lane] / luminance } else { 1.0 }
        })
    }

    pub(in crate::bsdf) fn is_anisotropic(&self) -> bool {
        self.anisotropic.uniform().is_none_or(|anisotropic| *anisotropic != Spectrum::Constant(0.0))
    }

    fn all(&self) -> [&Texture; 8] {
        [
            &self.base_color,
            &self.roughness,
            &self.anisotropic,
            &self.spec_trans,
            &self.spec_tint,
            &self.sheen,
            &self.sheen_tint,
            &self.flatness,
        ]
    }
}

/// The four wavelengths of the path in Mitsuba 3 that has one of them: a quarter of the distribution
/// `∝ sech²(0.0072 (λ − 538))` over 360–830 nm apart, nm.
fn companions(nm: f64) -> [f64; 4] {
    const CENTRE: f64 = 538.0;
    const SCALE: f64 = 0.0072;
    let tanh = |nm: f64| (SCALE * (nm - CENTRE)).tanh();
    let (low, high) = (tanh(360.0), tanh(830.0));
    let place = ((tanh(nm) - low) / (high - low)).clamp(0.0, 1.0);
    std::array::from_fn(|i| {
        if i == 0 {
            return nm;
        }
        let place = (place + 0.25 * i as f64).fract();
        CENTRE + (low + (high - low) * place).atanh() / SCALE
    })
}

/// Metal, diffuse base and glass under sheen and clear coat.
#[derive(Clone, Debug)]
pub struct PrincipledTextures {
    /// What it has in common with the one for thin sheets.
    pub base: PrincipledBaseTextures,
    /// Weight of the metallic lobe, from 0 (dielectric) to 1 (metal).
    pub metallic: Texture,
    /// Strength of the clear coat, from 0 to 1.
    pub clearcoat: Texture,
    /// Gloss of the clear coat, from 0 (satin) to 1 (glossy).
    pub clearcoat_gloss: Texture,
    /// Index below over that above; not 1 where light is transmitted.
    pub eta: f64,
    /// Whether light may be transmitted anywhere.
    pub glass: bool,
    /// Table that keeps the surface from making energy.
    pub albedo: Option<&'static Albedo>,
}

impl PrincipledTextures {
    pub(in crate::bsdf) fn bsdf<const C: usize>(&self, at: &TexturePoint, nm: &[f64; C]) -> Bsdf<C> {
        Bsdf::Principled(Principled {
            base: self.base.sample(at, nm),
            metallic: self.metallic.value(at).clamp(0.0, 1.0),
            clearcoat: self.clearcoat.value(at).max(0.0),
            clearcoat_gloss: self.clearcoat_gloss.value(at).clamp(0.0, 1.0),
            eta: self.eta,
            albedo: self.albedo,
        })
    }

    pub(in crate::bsdf) fn all_textures(&self) -> Vec<&Texture> {
        let own = [&self.metallic, &self.clearcoat, &self.clearcoat_gloss];
        self.base.all().into_iter().chain(own).collect()
    }
}

/// Below, a texture holds no index.
pub(crate) const LEAST_INDEX: f64 = 1e-3;

/// A thin sheet of the same.
#[derive(Clone, Debug)]
pub struct PrincipledThinTextures {
    /// What it has in common with the one for solids.
    pub base: PrincipledBaseTextures,
    /// Diffuse transmission, from 0 (none) to 2 (all that is diffuse is transmitted).
    pub diff_trans: Texture,
    /// Refractive index over that of air.
    pub eta: Texture,
    /// Table that keeps the surface from making energy.
    pub albedo: Option<&'static Albedo>,
}

impl PrincipledThinTextures {
    pub(in crate::bsdf) fn bsdf<const C: usize>(&self, at: &TexturePoint, nm: &[f64; C]) -> Bsdf<C> {
        Bsdf::PrincipledThin(PrincipledThin {
            base: self.base.sample(at, nm),
            diff_trans: self.diff_trans.value(at).clamp(0.0, 2.0),
            eta: self.eta.value(at).max(LEAST_INDEX),
            albedo: self.albedo,
        })
    }

    pub(in crate::bsdf) fn all_textures(&self) -> Vec<&Texture> {
        self.base.all().into_iter().chain([&self.diff_trans, &self.eta]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The wavelengths of Mitsuba's camera ray for the wavelength sample 0.1 (`sensor.sample_ray`).
    #[test]
    fn companions_are_mitsubas() {
        let path = [424.343, 507.333, 571.936, 657.501];
        for turn in 0..4 {
            for (i, nm) in companions(path[turn]).into_iter().enumerate() {
                let expected = path[(turn + i) % 4];
                assert!((nm - expected).abs() < 2e-3, "{nm}, not {expected}");
            }
        }
    }
}
