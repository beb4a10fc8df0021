// tree_queries: nearest points and crossings on one object, for `myxo query sdf`.
// Reads   nodes, dipoles, faces, pseudonormals, corners.
// Writes  queries in place: the result, after the question; and whether the search has ended.
// One invocation per query.
// Overflow: cannot happen; nothing is appended.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "index.glsl"
#include "tables.glsl"

layout(local_size_x = 64) in;

layout(constant_id = 0) const bool CROSSINGS = false;
layout(constant_id = 1) const uint SIGN_RULE = 0u;

layout(push_constant) uniform Params {
    uint query_count;
    uint root;                 // the object's first node
    uint first_vertex_normal;  // behind those of the half-edges
} params;

READS(uvec4, 0) nodes;
READS(uvec4, 1) dipoles;
READS(uvec4, 2) faces;
READS(uvec4, 3) pseudonormals;
READS(uint, 4) corners;
layout(std430, set = 0, binding = 5) buffer Queries { TreeQuery queries[]; };  // one an invocation

#include "sign.glsl"

void main() {
    uint i = invocation_index();
    if (i >= params.query_count) return;
    TreeQuery query = queries[i];
    if (CROSSINGS) {
        Crossing crossing = first_crossing(params.root, query.place, query.end);
        query.slot = crossing.slot;
        query.result = crossing.t;
        query.u = crossing.u;
        query.v = crossing.v;
    } else {
        query.slot = nearest_on(params.root, query.place, UNLIMITED);
        vec4 point = nearest_on_face(query.slot, query.place);
        bool outside = is_outside(params.root, query.slot, query.place, point, params.first_vertex_normal);
        float distance = root(point.z);
        query.result = outside ? distance : -distance;
        query.u = point.x;
        query.v = point.y;
    }
    query.ended = searches_ended() ? 1u : 0u;
    queries[i] = query;
}
