// surface: lights a triangle and lays the trail on it.
// Reads   trail (four texels by hand: a texel buffer has no sampler), colors, exposure.
// Writes  the pixel, in linear light; the image's format encodes sRGB.
// One invocation per pixel and triangle; edges are multisampled.
// Overflow: cannot happen; texel coordinates are clamped to the atlas.
#version 460
#include "types.glsl"
#include "shading.glsl"
#include "surface.glsl"

layout(set = 0, binding = 5) uniform samplerBuffer trail;
layout(set = 0, binding = 6) readonly buffer Colors { vec4 colors[]; };
layout(set = 0, binding = 7) readonly buffer Exposure { float brightest[]; };

// What one view of single texels does not hold is read four texels at once.
layout(constant_id = 0) const bool TEXELS_IN_QUADS = false;

#include "colormap.glsl"
#include "texels.glsl"

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) centroid in vec2 uv;
layout(location = 3) flat in vec2 atlas_origin;
layout(location = 4) flat in vec4 atlas_axes;
layout(location = 5) flat in uint chart;

layout(location = 0) out vec4 color;

float trail_of(int texel) {
    return texel_of(trail, uint(texel));
}

// The trail between its four nearest texels. Inside a triangle these are its own or gutter texels, which are filled.
float trail_at(vec2 texel) {
    vec2 q = texel - 0.5;
    vec2 corner = floor(q);
    vec2 weight = q - corner;
    ivec2 last = ivec2(int(params.size) - 1);
    ivec2 low = clamp(ivec2(corner), ivec2(0), last);
    ivec2 high = min(low + 1, last);
    int row_low = low.y * int(params.pitch);
    int row_high = high.y * int(params.pitch);
    float below = mix(trail_of(row_low + low.x), trail_of(row_low + high.x), weight.x);
    float above = mix(trail_of(row_high + low.x), trail_of(row_high + high.x), weight.x);
    return mix(below, above, weight.y);
}

// A texel position for uv that may lie a little outside of the triangle: taps stay inside, because beyond the gutter
// begins another triangle.
vec2 texel_at(vec2 inside) {
    inside = max(inside, vec2(0.0));
    inside /= max(inside.x + inside.y, 1.0);
    return atlas_origin + inside.x * atlas_axes.xy + inside.y * atlas_axes.zw;
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

void main() {
    // Where a pixel covers several texels it takes four taps on a rotated grid, so that fine trails do not sparkle.
    vec2 uv_x = dFdx(uv);
    vec2 uv_y = dFdy(uv);
    vec2 texels_x = uv_x.x * atlas_axes.xy + uv_x.y * atlas_axes.zw;
    vec2 texels_y = uv_y.x * atlas_axes.xy + uv_y.y * atlas_axes.zw;
    float footprint = max(dot(texels_x, texels_x), dot(texels_y, texels_y));
    float value;
    if (footprint > 1.5) {
        value = 0.25 * (trail_at(texel_at(uv + 0.125 * uv_x + 0.375 * uv_y))
            + trail_at(texel_at(uv - 0.125 * uv_x - 0.375 * uv_y))
            + trail_at(texel_at(uv + 0.375 * uv_x - 0.125 * uv_y))
            + trail_at(texel_at(uv - 0.375 * uv_x + 0.125 * uv_y)));
    } else {
        value = trail_at(texel_at(uv));
    }

    vec3 n = normalize(gl_FrontFacing ? normal : -normal);
    vec3 to_eye = normalize(params.eye - position);
    float brightness = params.trail_share * tone(value, brightest[0]);
    vec3 trail_color = color_of(brightness);
    vec3 bare = mix(BARE, chart_light(), params.chart_share);
    vec3 matte = bare * (1.0 - brightness) + trail_color;
    vec3 light = matte * diffuse_light(n, params.key_direction)
        + specular_light(n, to_eye, params.key_direction)
        + params.glow * trail_color;
    color = vec4(dithered(light, gl_FragCoord.xy), 1.0);
}
