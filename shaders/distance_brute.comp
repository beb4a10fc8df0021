// distance_brute: signed distance to other objects by looking at all their triangles; the reference for `distance`.
// Reads   jobs, pairs, samples, faces, pseudonormals, corners; for signs nodes, dipoles.
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
} params;

layout(std430, set = 0, binding = 0) readonly buffer Jobs { DistanceJob jobs[]; };
layout(std430, set = 0, binding = 1) readonly buffer Pairs { ObjectPair pairs[]; };
layout(std430, set = 0, binding = 2) readonly buffer Samples { SurfaceSample samples[]; };
READS(uvec4, 3) faces;
READS(uvec4, 4) pseudonormals;
READS(uint, 5) corners;
layout(std430, set = 0, binding = 6) writeonly buffer Distances { float distances[]; };
layout(std430, set = 0, binding = 7) writeonly buffer Nearest { uint nearest[]; };
READS(uvec4, 8) nodes;
READS(uvec4, 9) dipoles;

#include "candidate.glsl"
#include "jobs.glsl"

// The nearest of the faces looked at so far.
struct Best {
    float square;
    uint triangle;
    uint slot;
};

void look_at(uint slot, vec3 place, inout Best best) {
    float square = nearest_on_face(slot, place).z;
    uint triangle = triangle_of(slot);
    bool nearer = is_nearer(square, triangle, best.square, best.triangle);
    best.square = nearer ? square : best.square;
    best.triangle = nearer ? triangle : best.triangle;
    best.slot = nearer ? slot : best.slot;
}

void main() {
    uint i = invocation_index();
    if (i >= params.thread_count) return;
    DistanceJob job = jobs[job_of(i, params.job_count)];
    if (i - job.first_thread >= job.sample_count) return;
    SurfaceSample here = samples[job.first_sample + (i - job.first_thread)];

    float least = params.reach;
    uint triangle = NONE;
    for (uint p = job.first_pair; p < job.first_pair + job.pair_count; p++) {
        ObjectPair pair = pairs[p];
        vec3 place = place_in_other(pair, here.position);
        Best best = Best(3.4e38, NONE, pair.first_face);
        // Four a round, for more faces before rounds run out (loops.glsl); src/sim/brute.rs refuses scenes that take more.
        // The last face may come more than once, which changes nothing.
        uint last = pair.first_face + pair.face_count - 1u;
        for (uint k = pair.first_face; k <= last; k += 4u) {
            look_at(k, place, best);
            look_at(min(k + 1u, last), place, best);
            look_at(min(k + 2u, last), place, best);
            look_at(min(k + 3u, last), place, best);
        }
        vec4 point = nearest_on_face(best.slot, place);
        float distance = root(point.z);
        float candidate = candidate_distance(pair, best.slot, place, point, params.reach, params.first_vertex_normal);
        if (candidate < least) {
            least = candidate;
            triangle = distance < params.reach ? best.triangle : NONE;
        }
    }
    distances[here.texel] = settled(least);
    nearest[here.texel] = triangle;
}
