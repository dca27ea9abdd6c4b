//! Versions of the format, and what Mitsuba 3 makes of names from before 2.0.0 (measured from Mitsuba 3.9.1).

use super::super::super::source::SceneError;
use super::super::attributes::Attribute;
use super::super::tree::{Class, Entry, Object, Value};
use crate::geometry::Vec3;
use glam::DMat4;

/// Whether names of a file of this version are those from before 2.0.0.
///
/// # Errors
/// For what is no version. Versions that do not exist yet are fine, as in Mitsuba 3.
pub(super) fn is_old(version: &Attribute) -> Result<bool, SceneError> {
    let numbers: Option<Vec<i32>> = version.text.trim().split('.').map(|part| part.parse().ok()).collect();
    match numbers.as_deref() {
        Some([major, _, _]) => Ok(*major < 2),
        _ => Err(SceneError::at(
            &version.place,
            format!("\"{}\" is not a version", version.text),
            "expected three numbers such as 3.0.0",
        )),
    }
}

/// `toWorld` as `to_world`, `intIOR` as `int_ior`: capitals after a small letter become small, with an
/// underscore before them.
pub(super) fn snake_case(name: &str) -> String {
    let mut result = String::with_capacity(name.len() + 4);
    let mut in_capitals = false;
    let mut before = ' ';
    for c in name.chars() {
        let begins = before.is_ascii_lowercase() && c.is_ascii_uppercase();
        in_capitals = begins || in_capitals && c.is_ascii_uppercase();
        if begins {
            result.push('_');
        }
        result.push(if in_capitals { c.to_ascii_lowercase() } else { c });
        before = c;
    }
    result
}

/// Properties that have another name or another form since 2.0.0.
pub(super) fn properties(object: &mut Object) -> Result<(), SceneError> {
    match object.class {
        Class::Bsdf if object.plugin == "diffuse" => {
            for entry in &mut object.entries {
                if entry.name.as_deref() == Some("diffuse_reflectance") {
                    entry.name = Some("reflectance".to_owned());
                }
            }
            Ok(())
        }
        Class::Spectrum => texture_coordinates(object),
        _ => Ok(()),
    }
}

/// `uscale`, `vscale`, `uoffset` and `voffset` as a transform: u becomes uscale · (u + uoffset).
fn texture_coordinates(object: &mut Object) -> Result<(), SceneError> {
    const NAMES: [&str; 4] = ["uscale", "vscale", "uoffset", "voffset"];
    let is_old = |entry: &Entry| entry.name.as_deref().is_some_and(|name| NAMES.contains(&name));
    let (old, others) = std::mem::take(&mut object.entries).into_iter().partition::<Vec<_>, _>(is_old);
    object.entries = others;
    let Some(place) = old.first().map(|entry| entry.place.clone()) else { return Ok(()) };
    if object.entries.iter().any(|entry| entry.name.as_deref() == Some("to_uv")) {
        return Err(SceneError::at(
            &place,
            "The texture coordinates are transformed twice",
            "expected either to_uv or uscale, vscale, uoffset, voffset",
        ));
    }
    let number = |name: &str, default: f64| {
        let entry = old.iter().find(|entry| entry.name.as_deref() == Some(name));
        match entry.map(|entry| (&entry.value, entry)) {
            None | Some((Value::Broken, _)) => Ok(default),
            Some((Value::Float(value), _)) => Ok(*value),
            Some((Value::Integer(value), _)) => Ok(*value as f64),
            Some((other, entry)) => {
                let problem = format!("\"{name}\" has the wrong type: {}", other.word());
                Err(SceneError::at(&entry.place, problem, "expected <float>"))
            }
        }
    };
    let scale = Vec3::new(number("uscale", 1.0)?, number("vscale", 1.0)?, 1.0);
    let offset = Vec3::new(number("uoffset", 0.0)?, number("voffset", 0.0)?, 0.0);
    let entry = Entry {
        name: Some("to_uv".to_owned()),
        name_place: place.clone(),
        value_place: place.clone(),
        place,
        value: Value::Transform(DMat4::from_scale(scale) * DMat4::from_translation(offset)),
    };
    object.entries.push(entry);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::snake_case;

    /// What Mitsuba 3.9.1 called the properties that it did not know.
    #[test]
    fn names_change_as_in_mitsuba() {
        for (old, new) in [
            ("fooBarBaz", "foo_bar_baz"),
            ("fooBAR", "foo_bar"),
            ("FooBar", "Foo_bar"),
            ("foo1Bar", "foo1Bar"),
            ("kdTreeMAX", "kd_tree_max"),
            ("aBCD", "a_bcd"),
            ("intIORValue", "int_iorvalue"),
            ("X", "X"),
            ("xY", "x_y"),
            ("hIDE_Emitters", "h_ide_Emitters"),
            ("hide_emitters", "hide_emitters"),
        ] {
            assert_eq!(snake_case(old), new);
        }
    }
}
