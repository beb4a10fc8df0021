//! Meshes without Vulkan: theorems about them, and the files that they come from; and all that is read from files, by the
//! corpus of the fuzz targets.

mod corpus;
mod mesh;
mod mesh_files;
