// distance_tiles: which face of each other object is nearest to the middle of a tile of texels, so that `distance` searches only what is near.
// Reads   jobs, pairs, tiles, nodes, faces, pseudonormals, corners; for signs dipoles.
// Writes  hints: one a tile and pair.
// One invocation a tile of a job; jobs begin at multiples of a tile.
// Between a tile and another object that is beyond reach of all of it lies no surface: then its middle decides for all its texels on which side they are.
// Overflow: pairs of a job beyond hint_count have no hint, and `distance` searches them from afar.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "index.glsl"

layout(local_size_x = 64) in;

layout(constant_id = 0) const uint SIGN_RULE = 0u;

layout(push_constant) uniform Params {
    uint tile_count;           // of all jobs
    uint job_count;
    uint first_vertex_normal;  // behind those of the half-edges
    uint hint_count;           // a tile
    float reach;               // world length; distances are clamped to it
} params;

layout(std430, set = 0, binding = 0) readonly buffer Jobs { DistanceJob jobs[]; };
layout(std430, set = 0, binding = 1) readonly buffer Pairs { ObjectPair pairs[]; };
layout(std430, set = 0, binding = 2) readonly buffer Tiles { SampleTile tiles[]; };
layout(set = 0, binding = 3) uniform usamplerBuffer faces;
layout(set = 0, binding = 4) uniform usamplerBuffer pseudonormals;
layout(std430, set = 0, binding = 5) readonly buffer Corners { uint corners[]; };
layout(std430, set = 0, binding = 6) writeonly buffer Hints { uint hints[]; };
layout(set = 0, binding = 7) uniform usamplerBuffer nodes;
layout(set = 0, binding = 8) uniform usamplerBuffer dipoles;

#include "sign.glsl"
#include "distance.glsl"
#include "jobs.glsl"

void main() {
    uint i = invocation_index();
    if (i >= params.tile_count) return;
    DistanceJob job = jobs[job_of(i * TILE_SAMPLES, params.job_count)];
    uint in_job = i - job.first_thread / TILE_SAMPLES;
    if (in_job * TILE_SAMPLES >= job.sample_count) return;
    SampleTile tile = tiles[job.first_tile + in_job];
    precise float near = params.reach + tile.radius;

    for (uint p = 0u; p < min(job.pair_count, params.hint_count); p++) {
        ObjectPair pair = pairs[job.first_pair + p];
        vec3 place = place_in_other(pair, tile.center);
        bool is_closed = pair.is_closed == 1u;
        // By the other rules sides may change where there is no surface.
        bool decides = SIGN_RULE == SIGN_PSEUDONORMAL || !is_closed;
        bool may_be_inside = is_closed && is_in_box(pair.first_node, place);
        uint slot = nearest_on(pair.first_node, place, may_be_inside ? UNLIMITED : near);
        uint hint = decides ? TILE_OUTSIDE : TILE_UNKNOWN;
        if (slot != NONE) {
            vec4 point = nearest_on_face(slot, place);
            float distance = sqrt(point.z);
            float slack = slack_of_tree(pair.first_node);
            precise float beyond = near + slack;
            bool searches = distance <= beyond || !decides;
            bool inside = is_closed && !is_outside(pair.first_node, slot, place, point, params.first_vertex_normal);
            hint = searches ? slot : inside ? TILE_INSIDE : TILE_OUTSIDE;
        }
        hints[i * params.hint_count + p] = hint;
    }
}
