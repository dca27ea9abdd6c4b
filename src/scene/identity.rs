//! What tells two scenes apart.

use super::description::{Description, ShapeKind};
use std::fmt::Write;

/// A number that two descriptions share only if they are the same scene: all that they say, places in files left out of
/// account only as far as the texts agree.
pub fn identity(description: &Description) -> u64 {
    let mut hash = Fnv(0xcbf2_9ce4_8422_2325);
    // Formatting is as complete as the types themselves: nothing that a scene says can be forgotten here.
    let said = (&description.integrator, &description.sensor, &description.lights);
    write!(hash, "{said:?}").expect("writing into a hash never fails");
    for shape in &description.shapes {
        if let ShapeKind::Mesh { mesh, .. } = &shape.kind {
            let data = mesh.data();
            data.positions.iter().flatten().for_each(|x| hash.bytes(&x.to_bits().to_le_bytes()));
            data.indices.iter().flatten().for_each(|i| hash.bytes(&i.to_le_bytes()));
            data.normals.iter().flatten().flatten().for_each(|x| hash.bytes(&x.to_bits().to_le_bytes()));
            data.uvs.iter().flatten().flatten().for_each(|x| hash.bytes(&x.to_bits().to_le_bytes()));
        } else {
            write!(hash, "{:?}", shape.kind).expect("writing into a hash never fails");
        }
        let said = (&shape.to_world, shape.flip_normals, &shape.bsdf, &shape.emission, &shape.interior);
        write!(hash, "{said:?}").expect("writing into a hash never fails");
    }
    hash.0
}

/// The hash of Fowler, Noll and Vo, FNV-1a, 64 bits.
struct Fnv(u64);

impl Fnv {
    fn bytes(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }
}

impl Write for Fnv {
    fn write_str(&mut self, text: &str) -> std::fmt::Result {
        self.bytes(text.as_bytes());
        Ok(())
    }
}
