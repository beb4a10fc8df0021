//! The typed handles of what is drawn, as the build generates them from `shaders/*.vert` and `shaders/*.frag`: pictures,
//! and what the step lets the graphics pipeline do.

#![allow(
    clippy::identity_op,
    clippy::derivable_impls,
    reason = "generated: offsets may be 0, and defaults those of the type"
)]

include!(concat!(env!("OUT_DIR"), "/draws.rs"));
