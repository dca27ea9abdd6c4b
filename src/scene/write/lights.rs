use super::super::description::{Light, LightKind};
use super::super::read::Class;
use super::{Node, sensors, spectra};
use crate::geometry::Transform;

pub(super) fn write(light: &Light) -> Node {
    let node = |plugin| Node::new(Class::Emitter, plugin, &light.place);
    match &light.kind {
        LightKind::Point { position, intensity } => match &light.motion {
            None => node("point").vector("position", *position),
            Some(_) => node("point").placement(&Transform::IDENTITY, &light.motion),
        }
        .spectrum("intensity", intensity),
        LightKind::Spot { to_world, intensity, cutoff_angle, beam_width, texture } => {
            let node = node("spot")
                .placement(to_world, &light.motion)
                .spectrum("intensity", intensity)
                .float("cutoff_angle", *cutoff_angle)
                .float("beam_width", *beam_width);
            match texture {
                Some(texture) => node.spectrum("texture", texture),
                None => node,
            }
        }
        LightKind::Projector { to_world, irradiance, scale, field_of_view } => {
            let node = node("projector")
                .placement(to_world, &light.motion)
                .spectrum("irradiance", irradiance)
                .float("scale", *scale);
            sensors::field_of_view(node, *field_of_view)
        }
        LightKind::Directional { travels, irradiance } => match &light.motion {
            None => node("directional").vector("direction", *travels),
            Some(_) => node("directional").placement(&Transform::IDENTITY, &light.motion),
        }
        .spectrum("irradiance", irradiance),
        LightKind::EnvironmentMap { to_world, file, image, scale } => node("envmap")
            .transform("to_world", to_world)
            .with("filename", spectra::picture(file, image))
            .float("scale", *scale),
        LightKind::SunSky {
            to_world,
            turbidity,
            albedo,
            sun_direction,
            sky_scale,
            sun_scale,
            sun_aperture,
            complex_sun,
        } => node("sunsky")
            .transform("to_world", to_world)
            .float("turbidity", *turbidity)
            .spectrum("albedo", albedo)
            .vector("sun_direction", *sun_direction)
            .float("sky_scale", *sky_scale)
            .float("sun_scale", *sun_scale)
            .float("sun_aperture", *sun_aperture)
            .boolean("complex_sun", *complex_sun),
        LightKind::Constant { radiance } => node("constant").spectrum("radiance", radiance),
    }
}
