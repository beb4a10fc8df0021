// depth_queries: the depths of distances, by one of the mappings of `distance_raster`.
// Reads   distances.
// Writes  depths.
// One invocation per query.
// Overflow: cannot happen; nothing is appended.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "index.glsl"
#include "depth.glsl"

layout(local_size_x = 64) in;

layout(constant_id = 0) const uint DEPTH = 0u;

layout(push_constant) uniform Params {
    uint query_count;
    float reach;       // world length
    float near_plane;  // world length
    float scale;       // world length
} params;

layout(std430, set = 0, binding = 0) readonly buffer Distances { float distances[]; };  // one an invocation
layout(std430, set = 0, binding = 1) writeonly buffer Depths { float depths[]; };  // one an invocation

void main() {
    uint i = invocation_index();
    if (i >= params.query_count) return;
    depths[i] = depth_of(DEPTH, distances[i], params.reach, params.near_plane, params.scale);
}
