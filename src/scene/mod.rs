//! Scenes: what a file says ([`Description`]), and what can be traced ([`Scene`]).

pub mod description;
pub mod source;

pub use description::Description;
pub use source::{Place, SceneError, SceneErrors};
