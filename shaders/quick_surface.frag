// quick_surface: lights a triangle and lays the trail on it.
// Reads   trail (four texels by hand: a texel buffer has no sampler), clearance, colors, exposure, distances.
// Writes  the pixel, in linear light; the image's format encodes sRGB.
// One invocation per pixel and triangle, with one sample a pixel: with several, a pixel's place may lie beside the triangle,
// and beside its chart. All pixels take the same path: CPU drivers run both sides of a branch.
// Overflow: cannot happen; texel coordinates are clamped to the atlas.
#version 460
#include "types.glsl"
#include "shading.glsl"
#include "quick_surface.glsl"

layout(set = 0, binding = 2) uniform samplerBuffer trail_texels;
layout(set = 0, binding = 3) readonly buffer Colors { vec4 colors[]; };
layout(set = 0, binding = 4) readonly buffer Exposure { float brightest[]; };
layout(set = 0, binding = 5) uniform samplerBuffer distances_texels;
const uint CLEARANCE = 255u;
// Its unit, texels.
const float CLEARANCE_UNIT = 0.5;
// Four texels per word: how many half texels far straight lines stay on the surface around.
layout(set = 0, binding = 6) uniform usamplerBuffer clearance;

// May there be other objects?
layout(constant_id = 1) const bool OTHERS = true;

#include "colormap.glsl"
#include "texels.glsl"

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 texel;
layout(location = 3) in float open_share;

layout(location = 0) out vec4 color;

#include "taps.glsl"
#include "lit.glsl"

float trail_at(vec2 at) {
    Taps taps = taps_at(at);
    vec4 values = vec4(
        texel_of(trail, taps.texels.x), texel_of(trail, taps.texels.y),
        texel_of(trail, taps.texels.z), texel_of(trail, taps.texels.w));
    return between(values, taps.weight);
}

// How far from a place the texture shows the surface around it, texels.
float clear_around(vec2 at) {
    uvec2 here = uvec2(clamp(at, vec2(0.0), vec2(float(params.size) - 1.0)));
    uint i = here.y * params.pitch + here.x;
    return CLEARANCE_UNIT * float(texelFetch(clearance, int(i >> 2u)).x >> (8u * (i & 3u)) & CLEARANCE);
}

void main() {
    // Four places of the pixel on a rotated grid, so that fine trails do not sparkle, and farther apart where a texel is larger than a
    // pixel, because heights between texels have no slope of their own; nearer to the middle where another chart begins beside this one.
    vec2 across = dFdx(texel);
    vec2 down = dFdy(texel);
    vec2 steep = 0.125 * across + 0.375 * down;
    vec2 flat_way = 0.375 * across - 0.125 * down;
    float farthest = max(sqrt(max(dot(steep, steep), dot(flat_way, flat_way))), 1e-9);
    float reach = max(1.0, min(LEAST_REACH / farthest, MOST_REACH));
    reach *= min(1.0, clear_around(texel) / (reach * farthest));
    steep *= reach;
    flat_way *= reach;
    vec4 values = vec4(trail_at(texel + steep), trail_at(texel - steep), trail_at(texel + flat_way), trail_at(texel - flat_way));
    float value = 0.25 * (values.x + values.y + values.z + values.w);
    vec3 n = normalize(normal);
    float slope = params.relief * height_slope(value, brightest[0]);
    n = raised(n, slope * changes_of(values.x - values.y, values.z - values.w, max(reach, 0.25)));
    float open = open_share;
    if (OTHERS) open *= open_beside_others(texel);
    color = lit(value, BARE, normalize(normal), n, open);
}
