//! Which properties of an element make attributes, by Mitsuba 3's rules.
//!
//! `r g b` or `red green blue` are `color`. Of the others those count that end in an underscore and a letter:
//! `t_x t_y t_z` or `t_0 t_1 t_2` (or `t_1 t_2 t_3`) are `t`, `t_r t_g t_b` are `t_color`. An attribute has
//! one number or three. Other properties are passed over, as there.

use super::super::meshes::MeshError;
use super::{Element, Scalar};
use crate::shape::MeshAttribute;

/// The last letters of the names of an attribute's numbers.
const POSTFIXES: [&[u8; 4]; 4] = [b"xyzw", b"rgba", b"0123", b"1234"];

/// An attribute that is being read, and the columns that it comes from.
pub(super) struct Columns {
    columns: Vec<(usize, Scalar)>,
    pub attribute: MeshAttribute,
}

impl Columns {
    /// The attributes of an element beside the columns `taken`.
    pub fn of(element: &Element, taken: &[usize], per_face: bool) -> Result<Vec<Self>, MeshError> {
        let mut found: Vec<Self> = Vec::new();
        let mut add = |name: &[u8], columns: &[usize]| {
            let prefix = if per_face { "face" } else { "vertex" };
            let name = format!("{prefix}_{}", String::from_utf8_lossy(name));
            if found.iter().any(|other| other.attribute.name == name) {
                let problem = format!("The file has the attribute \"{name}\" twice");
                return Err(MeshError::new(problem, "expected names that give different attributes"));
            }
            let attribute = MeshAttribute { name, per_face, channels: columns.len(), values: Vec::new() };
            let columns = columns.iter().map(|&at| (at, element.properties[at].scalar)).collect();
            found.push(Self { columns, attribute });
            Ok(())
        };
        let with_alpha = element.find(&[b"a", b"alpha"]);
        let colour = element
            .find_all([&[b"r"], &[b"g"], &[b"b"]])
            .or_else(|| element.find_all([&[b"red"], &[b"green"], &[b"blue"]]));
        // With an alpha it has four numbers, which Mitsuba's textures refuse.
        if let (Some(colour), None) = (colour, with_alpha) {
            add(b"color", &colour)?;
        }
        let used = |at: usize| taken.contains(&at) || colour.is_some_and(|colour| colour.contains(&at));
        let others = element.properties.iter().enumerate();
        let others = others.filter(|(at, property)| property.list.is_none() && !used(*at));
        let named: Vec<_> = others.filter_map(|(at, p)| Some((at, split(&p.name)?))).collect();
        let mut known: Vec<&[u8]> = Vec::new();
        let mut rest = &named[..];
        while let [(_, (prefix, first)), ..] = rest {
            let sequence = POSTFIXES.iter().find(|sequence| sequence[0] == *first);
            let (Some(sequence), false) = (sequence, known.contains(prefix)) else {
                rest = &rest[1..];
                continue;
            };
            let run = rest.iter().take_while(|(_, (other, _))| other == prefix).count();
            let (own, later) = rest.split_at(run);
            rest = later;
            known.push(prefix);
            let in_order = own.iter().map(|(_, (_, postfix))| postfix).eq(sequence.iter().take(run));
            if in_order && matches!(run, 1 | 3) {
                let columns: Vec<usize> = own.iter().map(|(at, _)| *at).collect();
                let suffix: &[u8] = if sequence[0] == b'r' { b"_color" } else { b"" };
                add(&[*prefix, suffix].concat(), &columns)?;
            }
        }
        Ok(found)
    }

    /// Takes the value out of a row. `false` where it is not finite.
    pub fn push(&mut self, row: &[f64]) -> bool {
        let start = self.attribute.values.len();
        let values = self.columns.iter().map(|&(at, scalar)| scalar.attribute_value(row[at]) as f32);
        self.attribute.values.extend(values);
        self.attribute.values[start..].iter().all(|value| value.is_finite())
    }
}

impl Scalar {
    /// What Mitsuba 3 makes of a number in an attribute: integers are fractions of the largest, stored with
    /// the sRGB curve (IEC 61966-2-1). But a byte is taken as it is.
    fn attribute_value(self, value: f64) -> f64 {
        let largest = match self {
            Self::U8 | Self::F32 | Self::F64 => return value,
            Self::I8 => f64::from(i8::MAX),
            Self::I16 => f64::from(i16::MAX),
            Self::U16 => f64::from(u16::MAX),
            Self::I32 => f64::from(i32::MAX),
            Self::U32 => f64::from(u32::MAX),
        };
        let share = value / largest;
        if share <= 0.04045 { share / 12.92 } else { ((share + 0.055) / 1.055).powf(2.4) }
    }
}

/// What stands before the last underscore, and the one letter behind it.
fn split(name: &[u8]) -> Option<(&[u8], u8)> {
    match name {
        [prefix @ .., b'_', postfix] => Some((prefix, *postfix)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::super::{MeshOptions, read};
    use crate::shape::MeshAttribute;

    /// The attributes of a triangle whose vertices i have 10 i, 10 i + 1, ... in these properties, and whose
    /// face 100, 101, ...
    fn attributes(vertex: &[&str], face: &[&str]) -> Vec<MeshAttribute> {
        let property = |name: &&str| match name.split_once(' ') {
            Some(_) => format!("property {name}\n"),
            None => format!("property float {name}\n"),
        };
        let row = |start: usize, count: usize| {
            (start..start + count).map(|x| format!(" {x}")).collect::<String>() + "\n"
        };
        let header: String = vertex.iter().map(property).collect();
        let faces: String = face.iter().map(property).collect();
        let rows: String = (0..3).map(|i| format!("{i} {} 0{}", i * i, row(10 * i, vertex.len()))).collect();
        let text = format!(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n{header}\
             element face 1\nproperty list uchar int vertex_indices\n{faces}end_header\n{rows}3 0 1 2{}",
            row(100, face.len())
        );
        let options = MeshOptions { face_normals: false, flip_tex_coords: false };
        read(text.as_bytes(), options).unwrap().mesh.attributes
    }

    fn names(vertex: &[&str]) -> Vec<String> {
        attributes(vertex, &[]).into_iter().map(|attribute| attribute.name).collect()
    }

    #[test]
    fn attributes_are_those_that_mitsuba_finds() {
        // Seen in Mitsuba 3.9.1 by listing the attributes of such files.
        let cases: [(&[&str], &[&str]); 16] = [
            (&["r", "g", "b"], &["vertex_color"]),
            (&["blue", "green", "red", "foo_0"], &["vertex_color", "vertex_foo"]),
            (&["r", "g"], &[]),
            (&["r", "g", "b", "a"], &[]),
            (&["vertex_color_r", "vertex_color_g", "vertex_color_b"], &["vertex_vertex_color_color"]),
            (&["density", "vertex_color", "foo_12"], &[]),
            (&["foo_x", "foo_y", "foo_z"], &["vertex_foo"]),
            (&["foo_1", "foo_2", "foo_3"], &["vertex_foo"]),
            (&["foo_0", "foo_1"], &[]),
            (&["foo_0", "foo_2", "foo_1"], &[]),
            (&["foo_z", "foo_y", "foo_x"], &["vertex_foo"]),
            (&["foo_0", "bar_0", "foo_1"], &["vertex_foo", "vertex_bar"]),
            (&["foo_0", "foo_1", "foo_2", "foo_r", "foo_g", "foo_b"], &[]),
            (&["foo_r"], &["vertex_foo_color"]),
            (&["u", "v", "s", "t", "_0"], &["vertex_"]),
            (&["texture_u", "texture_v", "face_foo_0"], &["vertex_face_foo"]),
        ];
        for (properties, expected) in cases {
            assert_eq!(names(properties), expected, "{properties:?}");
        }
    }

    #[test]
    fn values_go_by_name_and_type() {
        let [colour] = &attributes(&["b", "foo", "r", "g"], &[])[..] else { panic!() };
        assert_eq!((colour.per_face, colour.channels), (false, 3));
        assert_eq!(colour.values, [2.0, 3.0, 0.0, 12.0, 13.0, 10.0, 22.0, 23.0, 20.0]);
        let [face] = &attributes(&[], &["a_0", "r", "g", "b"])[1..] else { panic!() };
        assert_eq!((face.name.as_str(), face.per_face, &face.values[..]), ("face_a", true, &[100.0][..]));
        // Mitsuba 3.9.1 makes this of 100 as a char, a short and a uchar.
        for (name, expected) in [("char q_0", 0.5826935), ("short q_0", 2.3621137e-4), ("uchar q_0", 100.0)] {
            let found = attributes(&[], &[name])[0].values[0];
            assert!((found / expected - 1.0).abs() < 1e-6, "{name}: {found}");
        }
    }
}
