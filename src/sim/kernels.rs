//! The typed handles of the compute shaders, as the build generates them from `shaders/*.comp`.

#![allow(
    clippy::identity_op,
    clippy::derivable_impls,
    reason = "generated: offsets may be 0, and defaults those of the type"
)]

include!(concat!(env!("OUT_DIR"), "/kernels.rs"));
