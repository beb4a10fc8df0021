// shared_vertex: equal corners of triangles, joined to one vertex. src/render/shared_vertices.rs finds them.
// The includer declares `shared_vertices` first: a table of twice four words per vertex.

#ifndef MYXO_SHARED_VERTEX
#define MYXO_SHARED_VERTEX

#include "tables.glsl"

struct SharedVertex {
    vec3 position;  // object space
    uint object;
    vec2 texel;     // position in the atlas
    uint normal;    // packed, object space
    float openness; // share of the sky that is visible from it
};

SharedVertex shared_vertex(uint i) {
    uvec4 place = fetch4(shared_vertices, 2u * i);
    uvec4 look = fetch4(shared_vertices, 2u * i + 1u);
    return SharedVertex(uintBitsToFloat(place.xyz), place.w, uintBitsToFloat(look.xy), look.z, uintBitsToFloat(look.w));
}

#endif
