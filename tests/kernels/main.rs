//! The kernels of a step and those beside it: each against its twin, and what can be worked out of them without a GPU.

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/places.rs"]
mod places;

// What the build generates names `crate::gpu`.
use myxo::gpu;

mod alone;
mod arithmetic;
mod bits;
mod choices;
mod crossing;
mod developing;
mod distances;
mod kernels;
mod landing;
mod limit;
mod picture_kernels;
mod sorting;
mod strips;
mod ties;
mod trail_kernels;
mod walk;
mod windows;
mod yardstick;
