//! The project itself: its shape, its documents, and what its build makes of shaders.

#[path = "../common/places.rs"]
mod places;
#[path = "../program/mod.rs"]
mod program;

mod guide;
mod shader_build;
mod tidy;
mod uses;
