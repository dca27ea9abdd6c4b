use super::super::description::{Light, LightKind};
use super::super::read::Class;
use super::Told;

pub(super) fn tell(light: &Light) -> Told {
    let told = |plugin| Told::new(Class::Emitter, plugin, &light.place);
    match &light.kind {
        LightKind::Point { position, intensity } => {
            told("point").vector("position", *position).spectrum("intensity", intensity)
        }
        LightKind::Directional { travels, irradiance } => {
            told("directional").vector("direction", *travels).spectrum("irradiance", irradiance)
        }
        LightKind::Constant { radiance } => told("constant").spectrum("radiance", radiance),
    }
}
