//! Meshes without Vulkan: theorems about them, and the files that they come from.

mod mesh;
mod mesh_files;
