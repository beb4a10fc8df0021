// placed: vertices, and how their objects stand, out of tables.
// The includer declares `corners` and `vertices` first, vertex indices one by one and a texel a vertex, and what pose_table.glsl
// asks for.

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
