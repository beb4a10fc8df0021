// background: a quiet gradient, lighter behind the middle, darker towards the corners.
// Reads   nothing.
// Writes  the pixel, in linear light.
// One invocation per pixel that no object covers.
// Overflow: cannot happen.
#version 460
#include "shading.glsl"

layout(push_constant) uniform Params {
    vec3 color;    // linear light
    float aspect;  // width over height
} params;

layout(location = 0) in vec2 place;

layout(location = 0) out vec4 color;

void main() {
    vec2 from_middle = (place - vec2(0.5, 0.46)) * vec2(min(params.aspect, 1.6), 1.0);
    float vignette = exp(-2.2 * dot(from_middle, from_middle));
    float height = mix(1.12, 0.72, place.y);
    vec3 light = params.color * height * (0.5 + 1.5 * vignette);
    color = vec4(dithered(light, gl_FragCoord.xy), 1.0);
}
