// painted: tints places that attract, repel or may not be entered, over the surface.
// Reads   bias.
// Writes  the tint, which covers by its alpha: green attracts, violet repels, red stripes are no-go.
// One invocation per pixel and triangle; pixels without any bias are not changed.
// Overflow: cannot happen; texel coordinates are clamped to the atlas.
#version 460
#include "types.glsl"
#include "painted.glsl"

layout(set = 0, binding = 4) uniform samplerBuffer bias_texels;


#include "texels.glsl"

layout(location = 0) centroid in vec2 texel;

layout(location = 0) out vec4 color;

const float NO_GO = -5.0e8;
// Beyond the area that repels most, -1e6. A texel of a gutter with a smaller part of a no-go area may be entered, and is not tinted.
const float STRONGEST = -1.1e6;
// Of nearly one luminance, so that both stand out as much from what lies below: over dark and mean trail of the map `myxo` their
// contrasts differ by 5 %, and their differences in OKLab by 6 %. Eyes without red, green or blue cones see them apart, too.
const vec3 ATTRACTS = vec3(0.0, 0.78, 0.10);
const vec3 REPELS = vec3(0.84, 0.40, 0.94);

void main() {
    uvec2 at = uvec2(clamp(texel, vec2(0.0), vec2(float(params.size) - 1.0)));
    float value = texel_of(bias, at.y * params.pitch + at.x);
    if (value == 0.0 || (value >= NO_GO && value < STRONGEST)) discard;
    float strength = 1.0 - exp(-abs(value) / params.usual);
    vec3 tint = value > 0.0 ? ATTRACTS : REPELS;
    float alpha = 0.55 * strength;
    if (value < NO_GO) {
        float stripe = step(0.5, fract((gl_FragCoord.x + gl_FragCoord.y) / 12.0));
        tint = mix(vec3(0.75, 0.02, 0.04), vec3(0.05, 0.0, 0.0), stripe);
        alpha = 0.65;
    }
    color = vec4(tint, alpha);
}
