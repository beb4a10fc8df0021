// particles: a point of light for each particle, on the surface.
// Reads   particles, corners, vertices, poses, colors.
// Writes  the point's place, size and light.
// One invocation per drawn particle: every stride-th.
// Overflow: cannot happen; the draw has no more points than there are particles.
#version 460
#include "types.glsl"
#include "words.glsl"
#include "shading.glsl"

layout(set = 0, binding = 0) uniform usamplerBuffer particles;
layout(set = 0, binding = 1) readonly buffer Corners { uint corners[]; };
layout(set = 0, binding = 2) readonly buffer Vertices { Vertex vertices[]; };
layout(set = 0, binding = 3) readonly buffer Poses { Pose poses[]; };
layout(set = 0, binding = 4) readonly buffer Colors { vec4 colors[]; };

#include "colormap.glsl"
#include "particles.glsl"

layout(location = 0) flat out vec3 light;

void main() {
    Particle particle = particle_of(texelFetch(particles, gl_VertexIndex * int(params.stride)));
    uint first = 3u * particle.triangle;
    Vertex a = vertices[corners[first]];
    vec3 b = vertices[corners[first + 1u]].position;
    vec3 c = vertices[corners[first + 2u]].position;
    vec3 on_surface = a.position + particle.u * (b - a.position) + particle.v * (c - a.position);
    vec3 position = place_in_world(poses[a.object], on_surface);

    // A little towards the eye, so that the surface does not swallow half of the point.
    position += params.lift * normalize(params.eye - position);
    // Particles differ a little, so that a crowd has grain.
    float shade = 0.72 + 0.28 * float((particle.id * 2654435769u) >> 24) / 255.0;
    light = color_of(0.92 * shade) * params.strength;
    gl_Position = params.clip_from_world * vec4(position, 1.0);
    gl_PointSize = params.diameter;
}
