// background: a quiet gradient, lighter behind the middle, and a faint ground with the shadow of what stands on it.
// Reads   shadow.
// Writes  the pixel, in linear light.
// One invocation per pixel that no object covers.
// Overflow: cannot happen; places beside the square of the shadow are clamped to its edge, where there is none.
#version 460
#include "shading.glsl"
#include "ground.glsl"

layout(push_constant) uniform Params {
    vec3 color;    // linear light
    float aspect;  // width over height
    vec3 eye;      // world space
    float ground;  // height of the ground, world units
    vec3 right;    // from the middle of the picture to its right edge, where `ahead` is 1 away
    float extent;  // half a side of the square of the shadow, world units; 0 without ground
    vec3 up;       // from the middle to the upper edge
    float middle_x;
    vec3 ahead;
    float middle_z;
} params;

layout(std430, set = 0, binding = 0) readonly buffer Shadow { float shadow[]; };

layout(location = 0) in vec2 place;

layout(location = 0) out vec4 color;

float shadow_of(uint x, uint y) {
    return shadow[y * SIDE + x];
}

float shadow_at(vec2 place_in_square) {
    vec2 cell = clamp((0.5 + 0.5 * place_in_square) * float(SIDE) - 0.5, vec2(0.0), vec2(float(SIDE) - 1.001));
    uvec2 low = uvec2(cell);
    vec2 weight = cell - vec2(low);
    return mix(mix(shadow_of(low.x, low.y), shadow_of(low.x + 1u, low.y), weight.x),
        mix(shadow_of(low.x, low.y + 1u), shadow_of(low.x + 1u, low.y + 1u), weight.x), weight.y);
}

void main() {
    vec2 from_middle = (place - vec2(0.5, 0.46)) * vec2(min(params.aspect, 1.6), 1.0);
    float vignette = exp(-2.2 * dot(from_middle, from_middle));
    float height = mix(1.12, 0.72, place.y);
    vec3 light = params.color * height * (0.5 + 1.5 * vignette);
    vec3 direction = params.ahead + (2.0 * place.x - 1.0) * params.right + (1.0 - 2.0 * place.y) * params.up;
    float far = (params.ground - params.eye.y) / min(direction.y, -1e-6);
    // Seen from below there is no ground.
    if (params.extent > 0.0 && direction.y < 0.0 && far > 0.0) {
        vec2 square = (params.eye.xz + far * direction.xz - vec2(params.middle_x, params.middle_z)) / params.extent;
        // A pool of light, which ends softly, so that there is no horizon.
        float pool = exp(-1.6 * dot(square, square));
        float seen = pool * smoothstep(0.0, 0.12, -direction.y / length(direction));
        vec3 lit_ground = params.color * (1.0 + 3.6 * pool) * (1.0 - 0.95 * smoothstep(0.0, 0.75, shadow_at(square)));
        light = mix(light, lit_ground, seen);
    }
    color = vec4(dithered(light, gl_FragCoord.xy), 1.0);
}
