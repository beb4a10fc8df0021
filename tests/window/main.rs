//! Hands on the lab: a pointer and keys operate every control, and the scene that is saved at the end, or what the lab tells of
//! itself, shows that each had its effect.
//!
//! Most of these tests need no display: the lab runs without a window, draws into an image, and is told line by line what the hand
//! does. Those of `real` have a window on an X display, with its pointer, its keys and its clipboard, for what only these show.

mod areas;
mod back;
mod buttons;
mod gestures;
mod hand;
mod hands;
mod lab;
mod long_steps;
mod lost;
#[cfg(target_os = "linux")]
mod many_scenes;
mod objects;
mod opening;
mod out;
mod parameters;
#[path = "../common/places.rs"]
mod places;
mod presets;
#[path = "../program/mod.rs"]
mod program;
mod real;
mod troubles;
mod views;
mod worked;

use lab::{Lab, can_open, said};

/// Small, on one object that is seen from all sides.
const SMALL: [&str; 3] = ["cube", "--set=particles.count=3000", "--set=atlas.size=128"];
