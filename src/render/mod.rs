//! Draws what `sim` owns, and writes pictures.

mod backs;
pub mod camera;
mod canvas;
pub mod charts;
pub mod colormap;
pub mod develop;
pub mod draw_order;
pub mod exposure;
#[cfg(feature = "app")]
pub mod gui;
pub mod hues;
pub mod lens;
pub mod mean;
pub mod network_lines;
pub mod normals;
pub mod occlusion;
pub mod offscreen;
pub mod output;
pub mod pick;
mod prepared;
mod rays;
pub mod renderer;
mod shared_vertices;
pub mod view;

pub use camera::Camera;
pub use network_lines::draw_network;
pub use offscreen::Offscreen;
pub use prepared::Prepared;
pub use renderer::{Canvas, Quality, Renderer};
pub use view::View;
