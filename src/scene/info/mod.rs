//! What a description says, for people (an indented outline), for programs (JSON) and as a hash; all from
//! what [`super::write`] makes of it.

mod hash;
mod json;
mod outline;

pub(super) use hash::{hash_of_bytes, hash_of_curves, hash_of_mesh, hash_of_patches, hash_of_values};
pub use json::json;
pub use outline::outline;
pub(super) use outline::text_of;
