//! The project itself: its shape, its documents, and what its build makes of shaders.

#[path = "../program/mod.rs"]
mod program;

mod guide;
mod shader_build;
mod tidy;
mod uses;
