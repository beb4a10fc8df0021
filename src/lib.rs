//! Physarum on the surfaces of several moving 3D objects, on explicit Vulkan.

pub mod error;
pub mod rng;
pub mod whole_file;

pub mod gpu;
pub mod mesh;

pub mod scene;

pub mod sim;

pub mod render;

pub use error::{Error, Result};
