use super::super::description::{Light, LightKind};
use super::super::read::Class;
use super::{Told, sensors};

pub(super) fn tell(light: &Light) -> Told {
    let told = |plugin| Told::new(Class::Emitter, plugin, &light.place);
    match &light.kind {
        LightKind::Point { position, intensity } => {
            told("point").vector("position", *position).spectrum("intensity", intensity)
        }
        LightKind::Spot { to_world, intensity, cutoff_angle, beam_width, texture } => {
            let told = told("spot")
                .transform("to_world", to_world)
                .spectrum("intensity", intensity)
                .float("cutoff_angle", *cutoff_angle)
                .float("beam_width", *beam_width);
            match texture {
                Some(texture) => told.spectrum("texture", texture),
                None => told,
            }
        }
        LightKind::Projector { to_world, irradiance, scale, field_of_view } => {
            let told = told("projector")
                .transform("to_world", to_world)
                .spectrum("irradiance", irradiance)
                .float("scale", *scale);
            sensors::field_of_view(told, *field_of_view)
        }
        LightKind::Directional { travels, irradiance } => {
            told("directional").vector("direction", *travels).spectrum("irradiance", irradiance)
        }
        LightKind::Constant { radiance } => told("constant").spectrum("radiance", radiance),
    }
}
