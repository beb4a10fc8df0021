//! Tests of the window: a pointer and keys operate every control, and the scene saved at the end, or the lab's report on itself, shows that
//! each had its effect.
//!
//! Most of these tests need no display: the lab runs without a window, draws into an image, and reads input as lines. Those of `real` have
//! a window on an X display, with its pointer, its keys and its clipboard, for what can only be tested there.

mod areas;
mod back;
mod buttons;
mod gestures;
mod input;
mod lab;
mod long_steps;
mod lost;
#[cfg(target_os = "linux")]
mod many_scenes;
mod network;
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
mod tools;
mod troubles;
mod views;
mod worked;

use lab::{Lab, can_open, said, step, with_scene};

/// A small scene with one object.
const SMALL: [&str; 3] = ["cube", "--set=particles.count=3000", "--set=atlas.size=128"];
