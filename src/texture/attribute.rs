//! What the vertices or faces of a mesh carry.

use super::TexturePoint;
use crate::raster::luminance;
use crate::shape::{Mesh, MeshAttribute};
use crate::spectrum::{Sampled, upsample};

/// What the vertices or faces of a mesh carry.
#[derive(Clone, Debug)]
pub struct Attribute {
    /// Name with the prefix `vertex_` or `face_`.
    pub name: String,
    /// Factor on what the mesh carries.
    pub scale: f64,
}

impl Attribute {
    /// Colours are made into spectra at the vertices, and those are interpolated. Zero on what has no such
    /// attribute.
    pub fn sample<const C: usize>(&self, at: &TexturePoint, nm: &[f64; C]) -> Sampled<C> {
        let Some((mesh, index)) = self.find(at) else { return Sampled::ZERO };
        let Some(place) = at.mesh else { return Sampled::ZERO };
        let attribute = &mesh.data().attributes[index];
        if attribute.channels != 3 {
            return Sampled::splat(self.value(at));
        }
        let spectrum = |index: u32| {
            let sigmoid = upsample(colour(attribute, index));
            Sampled::from_fn(|lane| self.scale * sigmoid.at(nm[lane]))
        };
        if attribute.per_face {
            return spectrum(place.triangle);
        }
        let [a, b, c] = mesh.data().indices[place.triangle as usize].map(spectrum);
        let [v, w] = place.barycentric;
        a * (1.0 - v - w) + b * v + c * w
    }

    /// One number for all wavelengths: of a colour, the luminance.
    pub fn value(&self, at: &TexturePoint) -> f64 {
        let rgb = self.rgb(at);
        let is_colour =
            self.find(at).is_some_and(|(mesh, index)| mesh.data().attributes[index].channels == 3);
        if is_colour { luminance(rgb) } else { rgb[0] }
    }

    /// The three numbers at a point as they are.
    pub fn rgb(&self, at: &TexturePoint) -> [f64; 3] {
        let (Some((mesh, index)), Some(place)) = (self.find(at), at.mesh) else { return [0.0; 3] };
        mesh.attribute_at(index, place.triangle, place.barycentric).map(|value| value * self.scale)
    }

    fn find<'a>(&self, at: &TexturePoint<'a>) -> Option<(&'a Mesh, usize)> {
        let mesh = at.mesh?.mesh;
        mesh.attribute(&self.name).map(|index| (mesh, index))
    }
}

fn colour(attribute: &MeshAttribute, index: u32) -> [f64; 3] {
    [0, 1, 2].map(|channel| f64::from(attribute.values[3 * index as usize + channel]))
}
