//! Draws what `sim` owns, and writes pictures.

pub mod camera;
pub mod colormap;
