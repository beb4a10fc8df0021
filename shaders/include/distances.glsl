// distances: reading signed distances between texel centres, as `trail.glsl` reads the trail. Twin of
// src/sim/twin/trail.rs.
// The includer declares `distances` first, a texel buffer of one float.

#ifndef MYXO_DISTANCES
#define MYXO_DISTANCES

float distances_of(uint texel) {
    return texelFetch(distances, int(texel)).x;
}

// Bilinear over the four texels around, gutter texels among them.
float distance_at(vec2 position, uint pitch) {
    precise vec2 corner = position - 0.5;
    vec2 low = floor(corner);
    precise vec2 f = corner - low;
    uint texel = uint(low.y) * pitch + uint(low.x);
    precise float top = distances_of(texel) + f.x * (distances_of(texel + 1u) - distances_of(texel));
    precise float bottom = distances_of(texel + pitch) + f.x * (distances_of(texel + pitch + 1u) - distances_of(texel + pitch));
    precise float value = top + f.y * (bottom - top);
    return value;
}

#endif
