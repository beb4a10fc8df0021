//! Random streams, keyed by their purpose and never by a place in memory.
//! The twin of `shaders/include/rng.glsl`: both give the same bits.

/// The purpose of a random number; separates the streams of one particle and step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Purpose {
    /// The initial place and heading.
    Start = 0,
    /// Noise added to the three sensors.
    SensorNoise = 1,
    /// The place and heading of a particle that restarts.
    Respawn = 2,
    /// The choice of particles that a dab of the teleporting brush moves, and their places.
    Paint = 3,
    /// The places of scattered food; used on the host only.
    Food = 4,
    /// The choice of particles that leave if more are selected than the lists hold; used on the host only.
    Limit = 5,
    /// The points of a sample of parameters; used on the host only.
    Sample = 6,
    /// The side that a particle turns to where both sides are better than the middle.
    Tie = 7,
    /// Whether a particle turns to any direction, and to which.
    Turn = 8,
    /// The heading of a particle that was refused a cell.
    Refused = 9,
    /// The ranks of cells, and of those that land or are born, in a step; used on the host only.
    Claim = 10,
    /// Whether a particle divides or dies, the side where it divides, and the heading of a particle that is born.
    Population = 11,
}

/// Four random words for one (seed, particle, step, purpose).
///
/// The hash is pcg4d of Jarzynski and Olano, "Hash Functions for GPU Rendering" (JCGT 9(3), 2020).
#[must_use]
pub fn random(seed: u32, id: u32, step: u32, purpose: Purpose) -> [u32; 4] {
    let mut v = [seed, id, step, purpose as u32]
        .map(|x| x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    fn mix(v: &mut [u32; 4]) {
        v[0] = v[0].wrapping_add(v[1].wrapping_mul(v[3]));
        v[1] = v[1].wrapping_add(v[2].wrapping_mul(v[0]));
        v[2] = v[2].wrapping_add(v[0].wrapping_mul(v[1]));
        v[3] = v[3].wrapping_add(v[1].wrapping_mul(v[2]));
    }
    mix(&mut v);
    v = v.map(|x| x ^ (x >> 16));
    mix(&mut v);
    v
}

/// The word that keys the random streams of a seed.
#[must_use]
pub fn seed_word(seed: u64) -> u32 {
    (seed ^ (seed >> 32)) as u32
}

/// A word as a float in `[0, 1)`, with 24 bits.
#[must_use]
pub fn unit(word: u32) -> f32 {
    (word >> 8) as f32 * (1.0 / 16_777_216.0)
}
