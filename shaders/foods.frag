// foods: lights the domes of food and markers.
// Reads   the outputs of the vertex stage.
// Writes  the light.
// One invocation per pixel that a dome covers.
// Overflow: cannot happen; nothing is appended.
#version 460
#include "types.glsl"
#include "shading.glsl"
#include "foods.glsl"

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) flat in vec3 albedo;

layout(location = 0) out vec4 color;

void main() {
    vec3 n = normalize(normal);
    vec3 to_eye = normalize(params.eye - position);
    vec3 light = params.lamp * (albedo * diffuse_light(n, params.key_direction, 1.0)
            + specular_light(n, to_eye, params.key_direction, 0.5))
        + params.glow * albedo;
    color = exposed(light, gl_FragCoord.xy);
}
