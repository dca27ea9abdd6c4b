//! Scenes: what a file says ([`Description`]), and what can be traced ([`Scene`]).

mod coincident;
mod compile;
mod counting;
pub mod description;
mod features;
mod film_plan;
#[cfg(test)]
pub(crate) mod fixture;
mod flight;
mod info;
mod intersection;
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
pub use counting::{Counters, Counts, PathEnd, RayCounts, RayKind, rays_of_this_thread};
pub use description::Description;
pub use features::Features;
pub use film_plan::{CameraSample, FilmChannel, FilmPlan};
pub use flight::{Collision, Event, Flight, FlightPlan};
pub use info::{json, outline};
pub use intersection::Intersection;
pub use lanes::{Intersections, Side};
pub use limits::{Coverage, Integrator, Limits, Techniques};
pub use passage::Passage;
pub use plugins::{Declaration, Parameter, Range, Takes, Use, plugins, reference};
pub use read::{ReadOptions, read, read_str};
pub use scene::Scene;
pub use source::{Place, SceneError, SceneErrors};
