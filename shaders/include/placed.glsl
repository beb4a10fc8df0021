// placed: vertices, and the poses of their objects, from tables.
// The includer declares `corners` and `vertices` first, vertex indices one by one and a texel per vertex, and what pose_table.glsl needs.

#ifndef MYXO_PLACED
#define MYXO_PLACED

#include "tables.glsl"
#include "types.glsl"
#include "pose_table.glsl"

Vertex vertex_of(uint corner) {
    uvec4 words = fetch4(vertices, fetch1(corners, corner));
    return Vertex(uintBitsToFloat(words.xyz), words.w);
}

#endif
