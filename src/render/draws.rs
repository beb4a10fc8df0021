//! The typed handles of what is drawn, as the build generates them from `shaders/*.vert` and `shaders/*.frag`.

include!(concat!(env!("OUT_DIR"), "/draws.rs"));
