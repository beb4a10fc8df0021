// placed: vertices, and how their objects stand, out of texel buffers: CPU drivers gather from storage buffers scalar by scalar.
// The includer declares `corners`, `vertices` and `poses` first: vertex indices one by one, a texel a vertex, three a pose.

#ifndef MYXO_PLACED
#define MYXO_PLACED

#include "types.glsl"
#include "pose_table.glsl"

Vertex vertex_of(uint corner) {
    uvec4 words = texelFetch(vertices, int(texelFetch(corners, int(corner)).x));
    return Vertex(uintBitsToFloat(words.xyz), words.w);
}

#endif
