//! The typed handles of what is drawn, as the build generates them from `shaders/*.vert` and `shaders/*.frag`: pictures, and the draws of a
//! step.

#![allow(
    clippy::identity_op,
    clippy::derivable_impls,
    reason = "generated: offsets may be 0, and defaults those of the type"
)]

include!(concat!(env!("OUT_DIR"), "/draws.rs"));
