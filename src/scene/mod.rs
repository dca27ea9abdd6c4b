//! Scenes: what a file says ([`Description`]), and what can be traced ([`Scene`]).

mod coincident;
mod compile;
mod counting;
pub mod description;
mod flight;
mod info;
mod lanes;
mod limits;
mod passage;
mod plugins;
mod read;
#[expect(clippy::module_inception, reason = "it holds the type that the room is named after")]
mod scene;
pub mod source;
mod write;

pub use compile::{CompileOptions, Crop, compile};
pub use counting::{Counters, Counts, PathEnd, RayCounts, RayKind};
pub use description::Description;
pub use flight::{Collision, Event, Flight, FlightPlan};
pub use info::{json, outline};
pub use lanes::{Intersections, Side};
pub use limits::{Coverage, Integrator, Limits, Techniques};
pub use passage::Passage;
pub use plugins::{Declaration, Parameter, Range, Takes, Use, plugins, reference};
pub use read::{ReadOptions, read, read_str};
pub use scene::{CameraSample, Features, FilmChannel, FilmPlan, Intersection, Scene};
pub use source::{Place, SceneError, SceneErrors};
