// distance_merge: signed distance to the faces that `distance_raster` has found, if it is less than that to earlier objects.
// Reads   jobs, pairs, samples, winners, faces, pseudonormals, corners; for signs nodes, dipoles.
// Writes  owned texels of distances and nearest, of the objects that have a job.
// One invocation per sample of a job; jobs begin at multiples of the group size.
// Overflow: cannot happen; nothing is appended.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "index.glsl"
#include "tables.glsl"

layout(local_size_x = 64) in;

layout(constant_id = 0) const uint SIGN_RULE = 0u;

layout(push_constant) uniform Params {
    uint thread_count;
    uint job_count;
    uint first_vertex_normal;  // behind those of the half-edges
    float reach;               // world length; distances are clamped to it
    uint round;                // which of each job's pairs
} params;

layout(std430, set = 0, binding = 0) readonly buffer Jobs { DistanceJob jobs[]; };
layout(std430, set = 0, binding = 1) readonly buffer Pairs { ObjectPair pairs[]; };
layout(std430, set = 0, binding = 2) readonly buffer Samples { SurfaceSample samples[]; };
READS(uvec4, 3) faces;
READS(uvec4, 4) pseudonormals;
READS(uint, 5) corners;
layout(std430, set = 0, binding = 6) buffer Distances { float distances[]; };
layout(std430, set = 0, binding = 7) buffer Nearest { uint nearest[]; };
READS(uvec4, 8) nodes;
READS(uvec4, 9) dipoles;
layout(std430, set = 0, binding = 10) readonly buffer Winners { uint winners[]; };

#include "candidate.glsl"
#include "jobs.glsl"

void main() {
    uint i = invocation_index();
    if (i >= params.thread_count) return;
    DistanceJob job = jobs[job_of(i, params.job_count)];
    if (i - job.first_thread >= job.sample_count) return;
    SurfaceSample here = samples[job.first_sample + (i - job.first_thread)];

    float least = params.round == 0u ? params.reach : distances[here.texel];
    uint triangle = params.round == 0u ? NONE : nearest[here.texel];
    uint winner = params.round < job.pair_count ? winners[here.texel] : 0u;
    if (winner != 0u) {
        ObjectPair pair = pairs[job.first_pair + params.round];
        vec3 place = place_in_other(pair, here.position);
        uint slot = winner - 1u;
        vec4 point = nearest_on_face(slot, place);
        float distance = root(point.z);
        float candidate = candidate_distance(pair, slot, place, point, params.reach, params.first_vertex_normal);
        if (candidate < least) {
            least = candidate;
            triangle = distance < params.reach ? triangle_of(slot) : NONE;
        }
    }
    distances[here.texel] = settled(least);
    nearest[here.texel] = triangle;
}
