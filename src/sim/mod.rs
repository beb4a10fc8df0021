//! The Physarum model: particles, trail and the step, on the GPU and as CPU twins.

pub mod kernels;
pub mod twin;
pub mod types;
