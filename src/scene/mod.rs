//! Scenes: what a file says ([`Description`]), and what can be traced ([`Scene`]).

pub mod description;
mod read;
pub mod source;

pub use description::Description;
pub use read::{ReadOptions, read, read_str};
pub use source::{Place, SceneError, SceneErrors};
