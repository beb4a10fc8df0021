//! Pictures: what they show, where they show it, and that they look the same every time.

#[path = "../common/mod.rs"]
mod common;

mod chart_pictures;
mod pictures;
mod views;
