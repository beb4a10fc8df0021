// walk_queries: straight walks of any length, for `myxo query geodesic`.
// Reads   triangles, halfedges.
// Writes  walkers in place: one that is out of attempts continues in the next dispatch, where it stopped.
// One invocation a walk; a walker that has ended returns at once.
// The attempts of one dispatch are limited, so that no dispatch runs for seconds.
// Overflow: cannot happen; nothing is appended.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "index.glsl"
#include "tables.glsl"

layout(local_size_x = 64) in;

layout(constant_id = 0) const bool BORDER_REFLECTS = false;

layout(push_constant) uniform Params {
    uint walk_count;
    uint attempts;
} params;

READS(uvec4, 0) triangles;
READS(uvec4, 1) halfedges;

const bool WALK_CARRIES = true;
#include "walk.glsl"

layout(std430, set = 0, binding = 2) buffer Walkers { Walker walkers[]; };  // one an invocation

void main() {
    uint i = invocation_index();
    if (i >= params.walk_count) return;
    Walker w = walkers[i];
    if (w.status != WALK_OUT_OF_ATTEMPTS) return;
    walk(w, params.attempts, BORDER_REFLECTS);
    walkers[i] = w;
}
