// distance_raster: the distance from a texel's surface point to one triangle of another object, as a depth.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"

layout(constant_id = 0) const uint DEPTH = 0u;

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

layout(set = 0, binding = 4) uniform usamplerBuffer places;
layout(set = 0, binding = 5) uniform usamplerBuffer faces;

layout(location = 0) flat in uint triangle;
layout(location = 1) flat in uint slot;
layout(location = 0) out uint winner;

#include "nearest.glsl"
#include "distance.glsl"
#include "depth.glsl"

void main() {
    uint texel = uint(gl_FragCoord.y) * params.pitch + uint(gl_FragCoord.x);
    // Outlines reach a little beyond the texels that the triangle owns.
    uvec4 here = texelFetch(places, int(texel));
    if (here.w != triangle) discard;
    vec3 own = uintBitsToFloat(here.xyz);
    vec3 place = vec3(along(params.x, own), along(params.y, own), along(params.z, own));
    float distance = sqrt(nearest_on_face(slot, place).z);
    if (distance > params.farthest) discard;
    gl_FragDepth = depth_of(DEPTH, distance, params.farthest, params.near_plane, params.scale);
    winner = slot + 1u;
}
