//! Scenes: what a file says ([`Description`]), and what can be traced ([`Scene`]).

mod compile;
pub mod description;
mod flight;
mod info;
mod meeting;
mod passage;
mod read;
pub mod source;
mod tell;
mod traceable;

pub use compile::{CompileOptions, Part, compile};
pub use description::Description;
pub use flight::{Collision, Event, Flight};
pub use info::{json, outline};
pub use passage::Passage;
pub use read::{ReadOptions, read, read_str};
pub use source::{Place, SceneError, SceneErrors};
pub use traceable::{CameraSample, FilmChannel, FilmPlan, Intersection, Needs, Scene};
