//! Shading normals that vary over a surface: bump and normal maps.

use super::ShadingPoint;
use crate::geometry::{Frame, Vec3};
use crate::texture::Texture;

/// A bump or normal map, which changes the shading normal and not the shape.
#[derive(Clone, Debug)]
pub struct NormalMapping {
    /// What the normals come from.
    pub map: NormalMap,
    /// Whether a normal that faces away from the viewer is turned half around the surface's own.
    pub flip_invalid_normals: bool,
    /// Whether the shadow-terminator factor applies, which softens the edge where the light sinks below the
    /// surface.
    pub shadowing: bool,
}

/// The map of heights or normals.
#[derive(Clone, Debug)]
pub enum NormalMap {
    /// Height over the surface in scene units, times a factor.
    Height {
        /// Height by place.
        height: Texture,
        /// Factor on the height.
        scale: f64,
    },
    /// Normals in the frame of the surface, each component x stored as (x + 1)/2.
    Normals(Texture),
    /// The same one everywhere, stored likewise.
    Normal([f64; 3]),
}

/// The shadow-terminator factor of a bump or normal map, for one pair of viewer and point.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShadowTerminator {
    /// The normal of the surface and that of the map.
    smooth: Vec3,
    rough: Vec3,
    shadowing: bool,
}

impl NormalMapping {
    /// The shading frame that the map makes of the surface's `frame`, with its shadow-terminator factor.
    pub(super) fn turn(
        &self,
        frame: &Frame,
        at: &ShadingPoint,
        toward_eye: Vec3,
    ) -> (Frame, ShadowTerminator) {
        let mut local = self.normal(frame, at);
        let eye = frame.to_local(toward_eye);
        if self.flip_invalid_normals && local.dot(eye) * eye.z < 0.0 {
            local = Vec3::new(-local.x, -local.y, local.z);
        }
        let turned = Frame::with_tangent(local, Vec3::X);
        let [x, y, z] = [turned.x, turned.y, turned.z].map(|axis| frame.to_world(axis));
        let terminator = ShadowTerminator { smooth: frame.z, rough: z, shadowing: self.shadowing };
        (Frame { x, y, z }, terminator)
    }

    /// Normal in the frame of the surface.
    fn normal(&self, frame: &Frame, at: &ShadingPoint) -> Vec3 {
        match &self.map {
            NormalMap::Normals(map) => stored(map.rgb(&at.texture)),
            NormalMap::Normal(components) => stored(*components),
            NormalMap::Height { height, scale } => {
                // The tangents of the displaced surface (Blinn, "Simulation of Wrinkled Surfaces", 1978),
                // seen in the surface's plane: their parts along the normal are the height's slopes alone.
                let [du, dv] = height.gradient(&at.texture).map(|slope| slope * scale);
                // That of the surface or of the map around this one, on the front in any case.
                let normal = frame.x.cross(frame.y);
                let tangent = at.tangents[0] + normal * (du - normal.dot(at.tangents[0]));
                let bitangent = at.tangents[1] + normal * (dv - normal.dot(at.tangents[1]));
                let Some(bumped) = tangent.cross(bitangent).try_normalize() else { return Vec3::Z };
                let bumped = if bumped.dot(at.geometric_normal) < 0.0 { -bumped } else { bumped };
                // On the back of a two-sided surface the map is seen from within.
                let own = Vec3::new(frame.x.dot(bumped), frame.y.dot(bumped), normal.dot(bumped));
                own.try_normalize().unwrap_or(Vec3::Z)
            }
        }
    }
}

/// The normal whose components x are stored as (x + 1)/2.
fn stored(components: [f64; 3]) -> Vec3 {
    let [x, y, z] = components.map(|component| 2.0 * component - 1.0);
    Vec3::new(x, y, z).try_normalize().unwrap_or(Vec3::Z)
}

impl ShadowTerminator {
    /// The factor for light from a direction: 0 where only one of the two normals faces the light (Estevez,
    /// Lecocq and Stein, "A Microfacet-Based Shadowing Function to Solve the Bump Terminator Problem", Ray
    /// Tracing Gems, 2019).
    pub fn factor(&self, toward_light: Vec3) -> f64 {
        let cos = self.smooth.dot(toward_light);
        if cos * self.rough.dot(toward_light) <= 0.0 {
            return 0.0;
        }
        if !self.shadowing {
            return 1.0;
        }
        let tan_squared = |cos: f64| (1.0 - cos * cos).max(0.0) / (cos * cos);
        let alpha_squared = (0.125 * tan_squared(self.smooth.dot(self.rough))).min(1.0);
        2.0 / (1.0 + (1.0 + alpha_squared * tan_squared(cos)).sqrt())
    }
}
