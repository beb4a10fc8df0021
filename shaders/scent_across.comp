// scent_across: the scent that sensors read where scents cross contacts: each texel's own, and a share of that at the nearest place of
// another object, the less the farther that is away.
// Reads   samples, owners, distances, nearest, scent, triangles, corners, vertices, strips, poses.
// Writes  around, at owned texels.
// One invocation per sample.
// Overflow: cannot happen; nothing is appended.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "index.glsl"
#include "tables.glsl"

layout(local_size_x = 64) in;

layout(push_constant) uniform Params {
    uint sample_count;
    uint pitch;      // texels from one atlas row to the next
    float share;     // of a scent that crosses where the surfaces touch
    float by_reach;  // 1 / the world length at which nothing crosses any more
} params;

READS(uvec4, 0) samples;  // one an invocation
layout(std430, set = 0, binding = 1) readonly buffer Owners { uint owners[]; };  // one an invocation
READS(float, 2) distances;
READS(uint, 3) nearest;
READS(uvec4, 4) triangles;
READS(uint, 5) corners;
READS(uvec4, 6) vertices;
READS(uvec4, 7) strips;
READS(vec4, 8) poses;
READS(float, 9) scent_texels;
WRITES(float, 10) around_low;
WRITES(float, 11) around_high;

#include "texels.glsl"
#include "field.glsl"
#include "spaces.glsl"
#include "pose_table.glsl"
#include "strip_table.glsl"

FIELD(scent)

// The scent on a triangle at the point that is nearest to a place of the world.
float scent_near(uint triangle, vec3 world) {
    uvec4 shape = fetch4(triangles, triangle);
    Frame frame = frame_of(triangle);
    precise vec3 way = place_in_object(pose_of(shape.w), world) - frame.origin;
    vec2 weights = nearest_weights(uintBitsToFloat(shape.x), uintBitsToFloat(shape.y), uintBitsToFloat(shape.z),
        dot_of(way, frame.p), dot_of(way, frame.h));
    return scent_at(atlas_position(atlas_map_of(triangle), weights.x, weights.y), params.pitch);
}

void main() {
    uint i = invocation_index();
    if (i >= params.sample_count) return;
    uvec4 here = fetch4(samples, i);
    uint texel = here.w;
    uint triangle = fetch1(nearest, texel);
    float across = 0.0;
    // Beyond the reach there is none.
    if (triangle != NONE) {
        uint object = fetch4(triangles, owners[i]).w;
        float smelled = scent_near(triangle, place_in_world(pose_of(object), uintBitsToFloat(here.xyz)));
        precise float rest = 1.0 - abs(fetch1(distances, texel)) * params.by_reach;
        float near = positive(rest);
        precise float crossed = (params.share * (near * near)) * smelled;
        across = settled(crossed);
    }
    precise float sum = texel_of(scent, texel) + across;
    store_texel(around, texel, vec4(sum))
}
