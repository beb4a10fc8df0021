//! The Physarum model: particles, trail and the step, on the GPU and as CPU twins.
//!
//! Read [`step`] first: it is the whole simulation.

pub mod step;

pub(crate) mod advice;
mod direction;
mod exact;
mod moved;
mod params;
mod patience;
mod pipelines;
mod samples;
mod sensors;
mod setup;
mod simulation;
mod snapshot;
mod state;
mod surroundings;
mod texture_map;
mod turns;

pub mod areas;
pub mod brute;
pub mod carry;
pub mod checkpoint;
pub mod choices;
pub mod crossing;
pub mod depth_queries;
pub mod diffusion;
pub mod distance;
pub mod draws;
pub mod field;
pub mod food;
pub mod ground;
pub mod kernels;
pub mod memory;
pub mod movement;
pub mod network;
pub mod paint;
pub mod queries;
pub mod raster;
pub mod sorting;
pub mod start;
pub mod strip_walk;
pub mod texel_paths;
pub mod transfer_queries;
pub mod transfer_walk;
pub mod transfers;
pub mod tree_queries;
pub mod twin;
pub mod types;
pub mod walker;

pub use params::{StepConstants, StepParams, TINY_TRAIL, deposit_factor};
pub use pipelines::{FORMS_OF_ADVANCE, Kernels};
pub use setup::{Setup, atlas_options};
pub use simulation::{Areas, FoodOrder, KernelAlone, PreparedFood, Simulation, SnapshotCopy};
pub use snapshot::{Census, Distances, Snapshot};
pub use state::{PingPong, State};
pub use surroundings::{COVERED, NEAR};
pub use turns::Turn;
