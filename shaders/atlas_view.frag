// atlas_view: the unwrapped atlas, flat: texels of triangles in colour, all others dark.
// Reads   trail, texel_owner, charts, colors, exposure.
// Writes  the pixel, in linear light.
// One invocation per pixel; where a pixel covers several texels it takes their mean.
// Overflow: cannot happen; texels outside of the atlas are not read.
#version 460
#include "types.glsl"
#include "shading.glsl"
#include "atlas_view.glsl"

layout(set = 0, binding = 0) readonly buffer Trail { float trail[]; };
layout(set = 0, binding = 1) readonly buffer TexelOwner { uint texel_owner[]; };
layout(set = 0, binding = 2) readonly buffer Charts { uint charts[]; };
layout(set = 0, binding = 3) readonly buffer Colors { vec4 colors[]; };
layout(set = 0, binding = 4) readonly buffer Exposure { float brightest[]; };

#include "colormap.glsl"

layout(location = 0) out vec4 color;

const vec3 OUTSIDE = vec3(0.0055, 0.0058, 0.0065);
const vec3 UNOWNED = vec3(0.0115, 0.0120, 0.0135);

// A light tint that neighbouring numbers do not share: hues a golden angle apart.
vec3 chart_tint(uint chart) {
    vec3 phase = 6.2831853 * (fract(float(chart & 0xffffu) * 0.61803399) + vec3(0.0, 0.33, 0.67));
    return 0.5 + 0.5 * cos(phase);
}

void main() {
    const int most_taps = 4;
    vec2 middle = params.origin + gl_FragCoord.xy * params.texels_per_pixel;
    if (any(lessThan(middle, vec2(0.0))) || any(greaterThanEqual(middle, vec2(params.size)))) {
        color = vec4(OUTSIDE, 1.0);
        return;
    }
    int taps = clamp(int(ceil(params.texels_per_pixel)), 1, most_taps);
    float apart = params.texels_per_pixel / float(taps);
    float sum = 0.0;
    float owned = 0.0;
    uint triangle = NONE;
    for (int y = 0; y < taps; y++) {
        for (int x = 0; x < taps; x++) {
            vec2 tap = middle + (vec2(x, y) - 0.5 * float(taps - 1)) * apart;
            uvec2 texel = uvec2(clamp(tap, vec2(0.0), vec2(params.size) - 0.5));
            uint place = texel.y * params.pitch + texel.x;
            uint owner = texel_owner[place];
            if (owner != NONE) {
                sum += trail[place];
                owned += 1.0;
                triangle = owner;
            }
        }
    }
    float brightness = tone(sum / max(owned, 1.0), brightest[0]);
    vec3 shown = BARE * (1.0 - brightness) + color_of(brightness);
    if (triangle != NONE && params.chart_share > 0.0) {
        shown = mix(shown, (0.12 + shown) * chart_tint(charts[triangle]), params.chart_share);
    }
    color = vec4(mix(UNOWNED, shown, owned / float(taps * taps)), 1.0);
}
