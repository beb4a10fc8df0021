//! The host's workaround for Mesa's CPU driver, lavapipe, which ends the loops of an invocation after a number of rounds. Details,
//! and the kernels' part, are in `shaders/include/loops.glsl`.

/// Loop rounds that every invocation has. lavapipe has 65,535; the rest is for other loops of a kernel than those that are counted.
pub const ROUNDS: u32 = 60_000;
