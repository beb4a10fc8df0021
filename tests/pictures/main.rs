//! Pictures: what they show, where they show it, and that they look the same every time.

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/places.rs"]
mod places;

mod chart_pictures;
mod developed;
mod pictures;
mod views;
