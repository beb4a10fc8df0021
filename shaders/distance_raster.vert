// distance_raster: lays the triangles of an object out in atlas space once for each triangle of another object; the depth
// test keeps, for each texel, the triangle of the other that is nearest.
// Reads   outlines, bounds, slots, nodes; places and faces for the texels.
// Writes  the target: for each owned texel, the slot of the nearest face plus 1, or 0 where no face is near.
// One instance per triangle of the other object, three vertices for each triangle that owns texels.
// Overflow: none.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"

layout(push_constant) uniform Params {
    vec4 x;              // takes places to the other object's space: the row of its X
    vec4 y;              // the row of its Y
    vec4 z;              // the row of its Z
    vec2 pixel;          // of a texel, in clip space
    uint first_outline;
    uint first_face;     // the other's
    uint first_node;     // the root of the other's tree
    uint pitch;
    float reach;         // world length; triangles nearer than this matter everywhere
    float farthest;      // world length; triangles nearer than this matter inside the other's box
    float near_plane;    // world length; from the eye of a projection
    float scale;         // world length; what the curves take as 1
} params;

layout(set = 0, binding = 0) uniform usamplerBuffer outlines;
layout(set = 0, binding = 1) uniform usamplerBuffer bounds;
layout(std430, set = 0, binding = 2) readonly buffer Slots { uint slots[]; };
layout(set = 0, binding = 3) uniform usamplerBuffer nodes;
layout(set = 0, binding = 5) uniform usamplerBuffer faces;

layout(location = 0) flat out uint triangle;
layout(location = 1) flat out uint slot;

#include "bvh.glsl"
#include "distance.glsl"
#include "meets.glsl"

void main() {
    uint outline = params.first_outline + uint(gl_VertexIndex) / 3u;
    uint corner = uint(gl_VertexIndex) % 3u;
    uint other = params.first_face + uint(gl_InstanceIndex);
    uvec4 first = texelFetch(outlines, int(2u * outline));
    uvec4 second = texelFetch(outlines, int(2u * outline + 1u));
    triangle = second.z;
    slot = slots[other];

    vec4 own_bound = uintBitsToFloat(texelFetch(bounds, int(triangle)));
    vec4 other_bound = uintBitsToFloat(texelFetch(bounds, int(other)));
    vec3 centre = vec3(along(params.x, own_bound.xyz), along(params.y, own_bound.xyz), along(params.z, own_bound.xyz));
    bool meets = meet(params.first_node, centre, own_bound.w, other_bound, params.reach, params.farthest);
    vec2 position = uintBitsToFloat(corner == 0u ? first.xy : corner == 1u ? first.zw : second.xy);
    gl_Position = meets ? vec4(position * params.pixel - 1.0, 0.5, 1.0) : vec4(-2.0, -2.0, 0.5, 1.0);
}
