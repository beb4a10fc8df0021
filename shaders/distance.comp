// distance: signed distance from an object's texels to the nearest other object, and which triangle of it is nearest.
// Reads   jobs, pairs, samples, hints, nodes, faces, pseudonormals, corners; for signs dipoles.
// Writes  owned texels of distances and nearest, of the objects that have a job.
// One invocation a sample of a job; jobs begin at multiples of the group size.
// Overflow: cannot happen; nothing is appended, and no tree is deeper than a search has room for.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "index.glsl"

layout(local_size_x = 64) in;

layout(constant_id = 0) const uint SIGN_RULE = 0u;

layout(push_constant) uniform Params {
    uint thread_count;
    uint job_count;
    uint first_vertex_normal;  // behind those of the half-edges
    uint hint_count;           // a tile
    float reach;               // world length; distances are clamped to it
} params;

layout(std430, set = 0, binding = 0) readonly buffer Jobs { DistanceJob jobs[]; };
layout(std430, set = 0, binding = 1) readonly buffer Pairs { ObjectPair pairs[]; };
layout(std430, set = 0, binding = 2) readonly buffer Samples { SurfaceSample samples[]; };
layout(set = 0, binding = 3) uniform usamplerBuffer faces;
layout(set = 0, binding = 4) uniform usamplerBuffer pseudonormals;
layout(std430, set = 0, binding = 5) readonly buffer Corners { uint corners[]; };
layout(std430, set = 0, binding = 6) writeonly buffer Distances { float distances[]; };
layout(std430, set = 0, binding = 7) writeonly buffer Nearest { uint nearest[]; };
layout(set = 0, binding = 8) uniform usamplerBuffer nodes;
layout(set = 0, binding = 9) uniform usamplerBuffer dipoles;
layout(std430, set = 0, binding = 10) readonly buffer Hints { uint hints[]; };

#include "candidate.glsl"
#include "jobs.glsl"

void main() {
    uint i = invocation_index();
    if (i >= params.thread_count) return;
    DistanceJob job = jobs[job_of(i, params.job_count)];
    if (i - job.first_thread >= job.sample_count) return;
    SurfaceSample here = samples[job.first_sample + (i - job.first_thread)];

    float least = params.reach;
    uint triangle = NONE;
    uint first_hint = i / TILE_SAMPLES * params.hint_count;
    for (uint p = 0u; p < job.pair_count; p++) {
        uint hint = p < params.hint_count ? hints[first_hint + p] : TILE_UNKNOWN;
        if (hint == TILE_OUTSIDE) continue;
        if (hint == TILE_INSIDE) {
            bool is_least = -params.reach < least;
            least = is_least ? -params.reach : least;
            triangle = is_least ? NONE : triangle;
            continue;
        }
        ObjectPair pair = pairs[job.first_pair + p];
        vec3 place = place_in_other(pair, here.position);
        // What lies in a closed object may be inside, however deep.
        bool may_be_inside = pair.is_closed == 1u && is_in_box(pair.first_node, place);
        float bound = may_be_inside ? UNLIMITED : params.reach;
        if (hint != TILE_UNKNOWN) bound = min(bound, sqrt(nearest_on_face(hint, place).z));
        uint slot = nearest_on(pair.first_node, place, bound);
        if (slot == NONE) continue;
        uint found = triangle_of(slot);
        vec4 point = nearest_on_face(slot, place);
        float distance = sqrt(point.z);
        float candidate = candidate_distance(pair, slot, place, point, params.reach, params.first_vertex_normal);
        if (candidate < least) {
            least = candidate;
            triangle = distance < params.reach ? found : NONE;
        }
    }
    distances[here.texel] = least;
    nearest[here.texel] = triangle;
}
