//! The Physarum model: particles, trail and the step, on the GPU and as CPU twins.
//!
//! Read [`step`] first: it is the whole simulation.

pub mod step;

pub(crate) mod advice;
mod counts;
mod direction;
mod exact;
mod kept;
mod moved;
mod patience;
mod samples;
mod sensors;
mod setup;
mod simulation;
mod snapshot;
mod state;
mod surroundings;
mod texture_map;

pub mod areas;
pub mod arithmetic;
pub mod arranged;
pub mod arrays;
pub mod behaviour;
pub mod beside;
pub mod brute;
pub mod buffers;
pub mod carry;
pub mod cells;
pub mod checkpoint;
pub mod claims;
pub mod course;
pub mod crossing;
pub mod depth;
pub mod depth_queries;
pub mod diffusion;
pub mod distance;
pub mod draws;
pub mod field;
pub mod food;
pub mod graph;
pub mod ground;
pub mod kernels;
pub mod looks;
pub mod loops;
pub mod memory;
pub mod movement;
pub mod network;
pub mod paint;
pub mod physarum;
pub mod pipelines;
pub mod plan;
pub mod pulse;
pub mod queries;
pub mod raster;
pub mod restarts;
pub mod roles;
pub mod sorting;
pub mod spread;
mod spread_length;
pub mod start;
pub mod strip_walk;
pub mod texel_paths;
pub mod texture;
pub mod transfer_queries;
pub mod transfer_walk;
pub mod transfers;
pub mod tree_queries;
pub mod twin;
pub mod types;
pub mod walker;
pub mod work;
pub mod yardstick;

pub use behaviour::{deposit_factor, mean_deposit, mean_trail};
pub use plan::{Means, Plan};
pub use setup::{FixedSetup, LOOKING, STARTING, Setup, atlas_options};
pub use simulation::{
    Areas, FoodOrder, KernelAlone, KernelOrder, PreparedFood, Simulation, SnapshotCopy, StateAside,
    TrailCopy,
};
pub use snapshot::{Census, Distances, Snapshot};
pub use spread::TINY_TRAIL;
pub use state::State;
pub use step::advance::FORMS_OF_ADVANCE;
pub use surroundings::{COVERED, NEAR};
pub use texture::{PingPong, Texture};
