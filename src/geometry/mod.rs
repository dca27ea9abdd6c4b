//! Vectors, frames, transforms, rays and error-bounded offsets. Knows nothing of light.
//!
//! Everything here is `f64`. Meshes and boxes are stored in `f32` by the rooms that own them.

pub mod angle;
pub mod bernstein;
mod bounds;
mod frame;
mod motion;
mod orientation;
mod points;
mod pose;
mod ray;
pub mod roots;
mod transform;
mod uv;

pub use bounds::Bounds;
pub use frame::{Frame, axes_around};
pub use glam::DVec3 as Vec3;
pub use motion::{Motion, MotionError, Placed};
pub use orientation::orientation;
pub use points::{Points, Segments};
pub use pose::Pose;
pub use ray::{Ray, SurfacePoint};
pub use transform::Transform;
pub use uv::UvTransform;
