//! What the host does about Mesa's CPU driver, lavapipe, leaving the loops of an invocation after so many rounds; how, and what
//! kernels do, is in `shaders/include/loops.glsl`.

/// Rounds of its loops that an invocation surely has. lavapipe has 65,535; the rest is for what a kernel does beside the
/// loops that are counted.
pub const ROUNDS: u32 = 60_000;

/// How many dispatches take so many rounds, if each goes on where the one before has stopped.
#[must_use]
pub fn dispatches_of(rounds: u64) -> u32 {
    rounds.div_ceil(ROUNDS.into()) as u32
}
