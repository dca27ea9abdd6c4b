use super::Vec3;
use crate::lanes::{Real, Vector};

/// A right-handed orthonormal basis whose z axis is a given normal.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// First axis, in the coordinates around the frame.
    pub x: Vec3,
    /// Second axis.
    pub y: Vec3,
    /// Third axis: the normal, for frames of surfaces.
    pub z: Vec3,
}

impl Frame {
    /// Any frame around the unit vector `normal`; see [`axes_around`].
    pub fn around(normal: Vec3) -> Self {
        let [x, y] = axes_around(Vector::of(normal)).map(Vec3::from);
        Self { x, y, z: normal }
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

    /// A vector of the world in this frame.
    pub fn to_local(&self, world: Vec3) -> Vec3 {
        Vec3::new(self.x.dot(world), self.y.dot(world), self.z.dot(world))
    }

    /// A vector of this frame in the world.
    pub fn to_world(&self, local: Vec3) -> Vec3 {
        self.x * local.x + self.y * local.y + self.z * local.z
    }
}

/// Two axes that make a right-handed orthonormal basis with the unit vector `normal` as the third
/// (Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017).
#[inline(always)]
pub fn axes_around<R: Real>(normal: Vector<R>) -> [Vector<R>; 2] {
    let one = R::of(1.0);
    let sign = one.copysign(normal.z);
    let a = -one / (sign + normal.z);
    let b = normal.x * normal.y * a;
    [
        Vector::new(one + sign * normal.x * normal.x * a, sign * b, -sign * normal.x),
        Vector::new(b, sign + normal.y * normal.y * a, -normal.y),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_orthonormal(frame: &Frame) -> bool {
        let Frame { x, y, z } = *frame;
        let unit = [x, y, z].iter().all(|v| (v.length() - 1.0).abs() < 1e-14);
        unit && (x.cross(y) - z).length() < 1e-14
    }

    #[test]
    fn frames_are_right_handed_around_any_normal() {
        for normal in [
            Vec3::Z,
            -Vec3::Z,
            Vec3::new(0.0, -0.0, -0.0) - Vec3::Z,
            Vec3::new(1e-9, -1e-9, -1.0).normalize(),
            Vec3::new(0.36, 0.48, -0.8),
            Vec3::Y,
        ] {
            let frame = Frame::around(normal);
            assert!(is_orthonormal(&frame) && frame.z == normal, "{frame:?}");
            let world = Vec3::new(0.3, -2.0, 0.7);
            assert!((frame.to_world(frame.to_local(world)) - world).length() < 1e-14);
            for tangent in [Vec3::X, normal, Vec3::ZERO, Vec3::new(3.0, -1e-3, 7.0)] {
                assert!(is_orthonormal(&Frame::with_tangent(normal, tangent)), "{normal} {tangent}");
            }
        }
        let frame = Frame::with_tangent(Vec3::Z, Vec3::new(2.0, 0.0, 5.0));
        assert_eq!((frame.x, frame.y), (Vec3::X, Vec3::Y));
    }
}
