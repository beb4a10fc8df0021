// transfer_queries: straight walks of any length that change once from the first object to the second, where they meet it,
// for `myxo query transfer`.
// Reads   triangles, halfedges, corners, vertices, poses, roots, nodes, faces, pseudonormals, dipoles.
// Writes  walkers and phases in place. A query has two walkers: the second one is for the inner side, once it has met
//         the second object. A walker that is out of attempts, or whose search has not ended, continues in the next dispatch, where it
//         stopped.
// One invocation per query; a query that has ended returns at once.
// The attempts of one dispatch are limited, so that no dispatch runs for seconds.
// Overflow: cannot happen; nothing is appended.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "index.glsl"
#include "tables.glsl"

layout(local_size_x = 64) in;

layout(constant_id = 0) const uint SIGN_RULE = 0u;

layout(push_constant) uniform Params {
    uint query_count;
    uint attempts;
    uint first_vertex_normal;  // behind those of the half-edges
} params;

READS(uvec4, 0) triangles;
READS(uvec4, 1) halfedges;
READS(uint, 2) corners;
READS(uvec4, 3) vertices;
READS(vec4, 4) poses;
layout(std430, set = 0, binding = 5) readonly buffer Roots { uint roots[]; };
READS(uvec4, 6) nodes;
READS(uvec4, 7) faces;
READS(uvec4, 8) pseudonormals;
READS(uvec4, 9) dipoles;
layout(std430, set = 0, binding = 10) buffer Phases { uint phases[]; };  // one an invocation

const bool WALK_CARRIES = true;
#include "crossing.glsl"

layout(std430, set = 0, binding = 11) buffer Walkers { Walker walkers[]; };  // one an invocation

const uint SOURCE = 0u;
const uint TARGET = 1u;

// The phase of a query's walkers.
const uint PHASE_ON_SOURCE = 0u;
const uint PHASE_ON_TARGET = 1u;
const uint PHASE_DONE = 2u;

// Walks on the source to its end, or until it meets the target.
void walk_on_source(uint i) {
    Walker w = walkers[2u * i];
    vec3 from = place_of(pose_of(TARGET), flight_of_walker(w));
    for (uint k = 0u; k < params.attempts && w.status == WALK_OUT_OF_ATTEMPTS; k += 1u) {
        // At first to the next edge; later the walk is on an edge, and goes over it to the next. Each call makes one segment.
        Walker previous = w;
        float before = w.remaining;
        walk(w, w.entered_by == NONE && k == 0u ? 0u : 1u, false);
        Flight on = flight_of_walker(w);
        vec3 to = place_of(pose_of(TARGET), on);
        Meeting meeting = meeting_between(TARGET, from, to, on, 1.0);
        if (!searches_ended()) {
            // The next dispatch examines this segment again.
            w = previous;
            break;
        }
        if (meeting.slot != NONE) {
            precise float rest = w.remaining + (1.0 - meeting.t) * (before - w.remaining);
            Walker outer = walker_from(meeting, 1.0, rest);
            Walker inner = walker_from(meeting, -1.0, rest);
            outer.status = WALK_OUT_OF_ATTEMPTS;
            inner.status = WALK_OUT_OF_ATTEMPTS;
            walkers[2u * i] = outer;
            walkers[2u * i + 1u] = inner;
            phases[i] = PHASE_ON_TARGET;
            return;
        }
        from = to;
    }
    walkers[2u * i] = w;
    if (w.status != WALK_OUT_OF_ATTEMPTS) phases[i] = PHASE_DONE;
}

// Walks both ways on the target to their ends, and takes the better one.
void walk_on_target(uint i) {
    Walker outer = walkers[2u * i];
    Walker inner = walkers[2u * i + 1u];
    if (outer.status == WALK_OUT_OF_ATTEMPTS) walk(outer, params.attempts, false);
    if (inner.status == WALK_OUT_OF_ATTEMPTS) walk(inner, params.attempts, false);
    if (outer.status != WALK_OUT_OF_ATTEMPTS && inner.status != WALK_OUT_OF_ATTEMPTS) {
        bool inner_is_taken = inner_is_better(SOURCE, outer, inner, params.first_vertex_normal);
        if (searches_ended()) {
            if (inner_is_taken) outer = inner;
            phases[i] = PHASE_DONE;
        }
    }
    walkers[2u * i] = outer;
    walkers[2u * i + 1u] = inner;
}

void main() {
    uint i = invocation_index();
    if (i >= params.query_count || phases[i] == PHASE_DONE) return;
    if (phases[i] == PHASE_ON_SOURCE) {
        walk_on_source(i);
    } else {
        walk_on_target(i);
    }
}
