//! What has one right answer, or a render so small that its noise hardly counts: the program and its files,
//! the reading of scenes, bits that do not change, bodies and their surfaces, the documents.

mod aovs;
mod bodies;
mod cameras;
mod colour;
mod command_line;
#[path = "../common/mod.rs"]
mod common;
mod compare;
mod contact;
mod crop;
mod determinism;
mod docs;
mod explain;
mod film;
mod frames;
mod groups;
mod images;
mod json;
mod lamps;
mod lenses;
mod long;
mod models;
mod moving;
mod photons;
mod pilots;
mod reader;
mod rooms;
mod scene_errors;
mod skips;
mod solids;
mod stats;
mod stopped;
mod study;
mod surfaces;
mod view;
mod worked_examples;
