use super::Vec3;

/// A right-handed orthonormal basis whose z axis is a given normal.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    pub x: Vec3,
    pub y: Vec3,
    pub z: Vec3,
}

impl Frame {
    /// Any frame around the unit vector `normal`
    /// (Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017).
    pub fn around(normal: Vec3) -> Self {
        let sign = 1f64.copysign(normal.z);
        let a = -1.0 / (sign + normal.z);
        let b = normal.x * normal.y * a;
        Self {
            x: Vec3::new(1.0 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x),
            y: Vec3::new(b, sign + normal.y * normal.y * a, -normal.y),
            z: normal,
        }
    }

    /// The frame around `normal` whose x axis lies along `tangent` projected into the surface;
    /// any frame where the tangent vanishes or is parallel to the normal.
    pub fn with_tangent(normal: Vec3, tangent: Vec3) -> Self {
        let across = tangent - normal * normal.dot(tangent);
        match across.try_normalize() {
            Some(x) => Self { x, y: normal.cross(x), z: normal },
            None => Self::around(normal),
        }
    }

    pub fn to_local(&self, world: Vec3) -> Vec3 {
        Vec3::new(self.x.dot(world), self.y.dot(world), self.z.dot(world))
    }

    pub fn to_world(&self, local: Vec3) -> Vec3 {
        self.x * local.x + self.y * local.y + self.z * local.z
    }
}
