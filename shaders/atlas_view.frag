// atlas_view: the unwrapped atlas, flat: texels of triangles in colour, all others dark; charts coloured as in pictures of the layout,
// under the trail. The second look is drawn a second time, over the first, by its weight.
// Reads   trail, charts (src/render/charts.rs makes them), colors, exposure, looks.
// Writes  the pixel, in linear light.
// One invocation per pixel; a pixel that covers several texels takes their mean.
// Overflow: cannot happen; texels outside of the atlas are not read.
#version 460
#include "types.glsl"
#include "shading.glsl"
#include "atlas_view.glsl"

layout(set = 0, binding = 0) uniform samplerBuffer trail_texels;
layout(set = 0, binding = 1) uniform usamplerBuffer charts_texels;
layout(set = 0, binding = 2) readonly buffer Colors { vec4 colors[]; };
layout(set = 0, binding = 3) readonly buffer Exposure { float brightest[]; };
layout(set = 0, binding = 4) uniform samplerBuffer looks_texels;

// Is it the second look, in its own colours, laid over the first by the weight at each place?
layout(constant_id = 3) const bool LOOKS = false;

#include "colormap.glsl"
#include "texels.glsl"

layout(location = 0) out vec4 color;

const vec3 OUTSIDE = vec3(0.0055, 0.0058, 0.0065);
const vec3 UNOWNED = vec3(0.0115, 0.0120, 0.0135);

void main() {
    const int most_taps = 4;
    vec2 middle = params.origin + gl_FragCoord.xy * params.texels_per_pixel;
    if (any(lessThan(middle, vec2(0.0))) || any(greaterThanEqual(middle, vec2(params.size)))) {
        color = vec4(OUTSIDE, 1.0);
        if (LOOKS) color.a = 0.0;
        return;
    }
    int taps = clamp(int(ceil(params.texels_per_pixel)), 1, most_taps);
    float apart = params.texels_per_pixel / float(taps);
    float sum = 0.0;
    float owned = 0.0;
    float weight = 0.0;
    vec3 owned_chart = vec3(0.0);
    vec3 other_chart = vec3(0.0);
    for (int y = 0; y < taps; y++) {
        for (int x = 0; x < taps; x++) {
            vec2 tap = middle + (vec2(x, y) - 0.5 * float(taps - 1)) * apart;
            uvec2 texel = uvec2(clamp(tap, vec2(0.0), vec2(params.size) - 0.5));
            uint place = texel.y * params.pitch + texel.x;
            vec4 chart = unpackUnorm4x8(texel_of(charts, place));
            if (chart.a > 0.75) {
                sum += texel_of(trail, place);
                owned += 1.0;
                if (LOOKS) weight += texel_of(looks, place);
                owned_chart += light_of(chart.rgb);
            } else {
                other_chart += light_of(chart.rgb);
            }
        }
    }
    float all = float(taps * taps);
    float brightness = params.trail_share * tone(sum / max(owned, 1.0), brightest[0]);
    vec3 matte = mix(BARE, owned_chart / max(owned, 1.0), params.chart_share);
    vec3 beside = mix(UNOWNED, other_chart / max(all - owned, 1.0), params.chart_share);
    vec4 trail_color = color_of(brightness);
    vec3 shown = matte * (1.0 - trail_color.a) + params.trail_share * trail_color.rgb;
    color = vec4(mix(beside, shown, owned / all), 1.0);
    if (LOOKS) color.a = weight / max(owned, 1.0);
}
