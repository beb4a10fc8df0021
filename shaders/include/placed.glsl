// placed: vertices, and how their objects stand, out of texel buffers.
// The includer declares `corners` and `vertices` first, vertex indices one by one and a texel a vertex, and what pose_table.glsl
// asks for.

#ifndef MYXO_PLACED
#define MYXO_PLACED

#include "types.glsl"
#include "pose_table.glsl"

Vertex vertex_of(uint corner) {
    uvec4 words = texelFetch(vertices, int(texelFetch(corners, int(corner)).x));
    return Vertex(uintBitsToFloat(words.xyz), words.w);
}

#endif
