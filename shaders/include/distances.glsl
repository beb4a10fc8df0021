// distances: reading signed distances between texel centres, as `trail.glsl` reads the trail. Twin of
// src/sim/twin/trail.rs.
// The includer declares `distances` (float[]) first.

#ifndef MYXO_DISTANCES
#define MYXO_DISTANCES

// Bilinear over the four texels around, gutter texels among them.
float distance_at(vec2 position, uint pitch) {
    precise vec2 corner = position - 0.5;
    vec2 low = floor(corner);
    precise vec2 f = corner - low;
    uint texel = uint(low.y) * pitch + uint(low.x);
    precise float top = distances[texel] + f.x * (distances[texel + 1u] - distances[texel]);
    precise float bottom = distances[texel + pitch] + f.x * (distances[texel + pitch + 1u] - distances[texel + pitch]);
    precise float value = top + f.y * (bottom - top);
    return value;
}

#endif
