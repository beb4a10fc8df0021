// rng: random streams keyed by (seed, particle id, step, purpose). Twin of src/rng.rs: the same bits.
// The hash is pcg4d of Jarzynski and Olano, "Hash Functions for GPU Rendering" (JCGT 9(3), 2020).

#ifndef MYXO_RNG
#define MYXO_RNG

const uint PURPOSE_START = 0u;
const uint PURPOSE_SENSOR_NOISE = 1u;
const uint PURPOSE_RESPAWN = 2u;
const uint PURPOSE_PAINT = 3u;
const uint PURPOSE_TIE = 7u;
const uint PURPOSE_TURN = 8u;
const uint PURPOSE_REFUSED = 9u;
const uint PURPOSE_POPULATION = 11u;

uvec4 random_words(uint seed, uint id, uint time_step, uint purpose) {
    uvec4 v = uvec4(seed, id, time_step, purpose) * 1664525u + 1013904223u;
    v.x += v.y * v.w; v.y += v.z * v.x; v.z += v.x * v.y; v.w += v.y * v.z;
    v ^= v >> 16u;
    v.x += v.y * v.w; v.y += v.z * v.x; v.z += v.x * v.y; v.w += v.y * v.z;
    return v;
}

// A word as a float in [0, 1), with 24 bits.
float unit_float(uint word) {
    precise float unit = float(word >> 8) * (1.0 / 16777216.0);
    return unit;
}

#endif
