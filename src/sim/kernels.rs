//! The typed handles of the compute shaders, as the build generates them from `shaders/*.comp`.

include!(concat!(env!("OUT_DIR"), "/kernels.rs"));
