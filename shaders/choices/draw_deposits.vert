// draw_deposits: counts particles in texels by drawing: each is a point of one pixel, and pixels add up.
// Reads   particles, strips.
// Writes  the place of the point: the middle of its texel.
// One invocation per particle.
// Overflow: floats count exactly up to 2^24 particles in a texel.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "words.glsl"
#include "atlas.glsl"

layout(push_constant) uniform Params {
    vec2 pixel;  // of a texel, in clip space
} params;

layout(set = 0, binding = 0) uniform usamplerBuffer particles;
layout(set = 0, binding = 1) uniform usamplerBuffer strips;

#include "strip.glsl"

void main() {
    Particle particle = particle_of(texelFetch(particles, gl_VertexIndex));
    vec2 position = atlas_position(atlas_map_of(particle.triangle), particle.u, particle.v);
    vec2 middle = floor(position) + 0.5;
    gl_Position = vec4(middle * params.pixel - 1.0, 0.5, 1.0);
    gl_PointSize = 1.0;
}
