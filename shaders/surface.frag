// surface: lights a triangle and lays the trail on it, flat or as a relief.
// Reads   trail (four texels by hand: a texel buffer has no sampler), colors, exposure, distances, looks; for the relief the
//         triangle's corners and pose.
// Writes  the pixel, in linear light; the image's format encodes sRGB.
// One invocation per pixel and triangle; edges are multisampled.
// Overflow: cannot happen; texel coordinates are clamped to the atlas.
#version 460
#include "types.glsl"
#include "shading.glsl"
#include "surface.glsl"

layout(set = 0, binding = 0) uniform usamplerBuffer corners;
layout(set = 0, binding = 1) uniform usamplerBuffer vertices;
layout(set = 0, binding = 4) uniform samplerBuffer poses;
layout(set = 0, binding = 5) uniform samplerBuffer trail_texels;
layout(set = 0, binding = 6) readonly buffer Colors { vec4 colors[]; };
layout(set = 0, binding = 7) readonly buffer Exposure { float brightest[]; };
layout(set = 0, binding = 10) uniform samplerBuffer distances_texels;
layout(set = 0, binding = 11) uniform samplerBuffer looks_texels;

// May there be a relief, or charts, and other objects? CPU drivers run both sides of a branch.
layout(constant_id = 1) const bool EXTRAS = true;
layout(constant_id = 2) const bool OTHERS = true;
// Is it the second look, in its own colours, laid over the first by the weight at each place?
layout(constant_id = 3) const bool LOOKS = false;

#include "colormap.glsl"
#include "texels.glsl"

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) centroid in vec2 uv;
layout(location = 3) flat in vec2 atlas_origin;
layout(location = 4) flat in vec4 atlas_axes;
layout(location = 5) flat in uint triangle;
layout(location = 6) in float open_share;
layout(location = 7) flat in uint chart;

#include "taps.glsl"
#include "triangle_texel.glsl"
#include "frame.glsl"
#include "placed.glsl"
#include "lit.glsl"

layout(location = 0) out vec4 color;

vec4 trails_of(uvec4 texels) {
    return vec4(texel_of(trail, texels.x), texel_of(trail, texels.y), texel_of(trail, texels.z), texel_of(trail, texels.w));
}

float trail_at(vec2 texel) {
    Taps taps = taps_at(texel);
    return between(trails_of(taps.texels), taps.weight);
}

vec2 trail_growth_at(vec2 texel) {
    Taps taps = taps_at(texel);
    return growth(trails_of(taps.texels), taps.weight);
}

// The chart's colour; light where the pixel lies on a seam. Edge k of the triangle is one if bit 24 + k is set.
vec3 chart_light() {
    vec3 light = light_of(unpackUnorm4x8(chart).rgb);
    vec3 weights = vec3(uv.y, 1.0 - uv.x - uv.y, uv.x);
    vec3 in_pixels = weights / max(fwidth(weights), vec3(1e-9));
    float line = 0.0;
    for (uint k = 0u; k < 3u; k++) {
        if ((chart >> (24u + k) & 1u) != 0u) {
            line = max(line, clamp(1.5 - in_pixels[k], 0.0, 1.0));
        }
    }
    return mix(light, vec3(0.9), line);
}

// The normal as if the trail stood up from the surface. The mean of four places half a texel off, or of the four that the
// pixel covers, because the trail is linear between texels and would show facets.
// The bent normal is that of Blinn, "Simulation of Wrinkled Surfaces" (1978).
vec3 bent(vec3 n, float value, vec2 uv_x, vec2 uv_y, bool is_far) {
    float area = atlas_axes.x * atlas_axes.w - atlas_axes.y * atlas_axes.z;
    if (area == 0.0) return n;
    if (!is_far) {
        uv_x = vec2(atlas_axes.w, -atlas_axes.y) * (1.3 / area);
        uv_y = vec2(-atlas_axes.z, atlas_axes.x) * (1.3 / area);
    }
    vec2 grows = 0.25 * (trail_growth_at(texel_at(uv + 0.125 * uv_x + 0.375 * uv_y))
        + trail_growth_at(texel_at(uv - 0.125 * uv_x - 0.375 * uv_y))
        + trail_growth_at(texel_at(uv + 0.375 * uv_x - 0.125 * uv_y))
        + trail_growth_at(texel_at(uv - 0.375 * uv_x + 0.125 * uv_y)));
    float slope = params.relief * tone_slope(value, brightest[0]);
    float along_b = slope * dot(grows, atlas_axes.xy);
    float along_c = slope * dot(grows, atlas_axes.zw);

    Pose pose = pose_of(vertex_of(3u * triangle).object);
    vec3 a = corner_position(triangle, 0u);
    vec3 to_b = turn_to_world(pose, corner_position(triangle, 1u) - a);
    vec3 to_c = turn_to_world(pose, corner_position(triangle, 2u) - a);
    vec3 face = cross(to_b, to_c);
    vec3 steepest = (along_b * cross(to_c, face) + along_c * cross(face, to_b)) / dot(face, face);
    float steepness = length(steepest);
    // Limits the slope, so that the walls of a vein are not vertical.
    return normalize(n - steepest / max(1.0, steepness / 1.6));
}

void main() {
    // Four places of the pixel on a rotated grid, so that fine trails do not sparkle, and farther apart where a texel is larger than a
    // pixel, because heights between texels have no slope of their own.
    vec2 uv_x = dFdx(uv);
    vec2 uv_y = dFdy(uv);
    vec2 texels_x = uv_x.x * atlas_axes.xy + uv_x.y * atlas_axes.zw;
    vec2 texels_y = uv_y.x * atlas_axes.xy + uv_y.y * atlas_axes.zw;
    float farthest = max(0.4 * sqrt(max(dot(texels_x, texels_x), dot(texels_y, texels_y))), 1e-9);
    float reach = max(1.0, min(LEAST_REACH / farthest, MOST_REACH));
    vec2 steep = reach * (0.125 * uv_x + 0.375 * uv_y);
    vec2 level = reach * (0.375 * uv_x - 0.125 * uv_y);
    vec4 values = vec4(trail_at(texel_at(uv + steep)), trail_at(texel_at(uv - steep)),
        trail_at(texel_at(uv + level)), trail_at(texel_at(uv - level)));
    float value = 0.25 * (values.x + values.y + values.z + values.w);

    vec3 n = normalize(normal);
    vec3 bare = BARE;
    if (EXTRAS) {
        if (params.relief > 0.0) {
            bool is_far = max(dot(texels_x, texels_x), dot(texels_y, texels_y)) > 1.5;
            n = bent(n, value, uv_x, uv_y, is_far);
            bare = CLAY;
        }
        bare = mix(bare, chart_light(), params.chart_share);
        shine = 1.0 - params.chart_share;
    } else {
        float slope = params.relief * height_slope(value, brightest[0]);
        n = raised(n, slope * changes_of(values.x - values.y, values.z - values.w, reach));
    }
    float open = open_share;
    if (OTHERS) open *= open_beside_others(texel_at(uv));
    float weight = 1.0;
    if (LOOKS) {
        Taps taps = taps_at(texel_at(uv));
        weight = between(vec4(texel_of(looks, taps.texels.x), texel_of(looks, taps.texels.y),
            texel_of(looks, taps.texels.z), texel_of(looks, taps.texels.w)), taps.weight);
        if (weight <= 0.0) discard;
    }
    color = lit(value, bare, normalize(normal), n, open);
    if (LOOKS) color.a *= weight;
}
