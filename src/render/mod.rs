//! Draws what `sim` owns, and writes pictures.

pub mod camera;
pub mod colormap;
pub mod draws;
pub mod exposure;
pub mod normals;
pub mod output;
pub mod pick;
pub mod view;
