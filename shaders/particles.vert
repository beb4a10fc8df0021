// particles: a point of light for each particle, on the surface.
// Reads   order, particles, corners, vertices, poses, colors; motions where hues show headings, or particles may be dead.
// Writes  the point's place, size and light.
// One invocation per drawn particle: those that draw_order lists.
// Overflow: cannot happen; the draw has no more points than there are particles.
#version 460
#include "types.glsl"
#include "words.glsl"
#include "ring.glsl"
#include "shading.glsl"
#include "tables.glsl"

PAGED_READS(uvec4, 0) particles;
layout(set = 0, binding = 1) uniform usamplerBuffer corners;
layout(set = 0, binding = 2) uniform usamplerBuffer vertices;
layout(set = 0, binding = 3) uniform samplerBuffer poses;
layout(set = 0, binding = 4) readonly buffer Colors { vec4 colors[]; };

PAGED_READS(uvec4, 5) motions;
layout(set = 0, binding = 6) readonly buffer Order { uint order[]; };

#include "colormap.glsl"
#include "particles.glsl"
#include "frame.glsl"
#include "placed.glsl"

layout(location = 0) flat out vec3 light;

// Direction of a heading on the surface, in turns from red, which is to the right as seen from in front of the surface, counterclockwise: a
// quarter is upwards. On a floor or a ceiling, upwards is away from the front.
float turn_of(Frame frame, vec2 heading, Pose pose) {
    vec3 normal = turn_to_world(pose, frame.normal);
    vec3 direction = turn_to_world(pose, heading.x * frame.p + heading.y * frame.h);
    vec3 sky = abs(normal.y) > 0.999 ? vec3(0.0, 0.0, -1.0) : vec3(0.0, 1.0, 0.0);
    vec3 up = normalize(sky - dot(sky, normal) * normal);
    vec3 right = cross(up, normal);
    return fract(atan(dot(direction, up), dot(direction, right)) / 6.28318531);
}

void main() {
    int slot = int(order[gl_VertexIndex]);
    Particle particle = particle_of(fetch_paged(particles, slot));
    uint first = 3u * particle.triangle;
    Vertex a = vertex_of(first);
    vec3 b = vertex_of(first + 1u).position;
    vec3 c = vertex_of(first + 2u).position;
    Pose pose = pose_of(a.object);
    vec3 on_surface = a.position + particle.u * (b - a.position) + particle.v * (c - a.position);
    vec3 position = place_in_world(pose, on_surface);

    // Moved a little towards the eye, so that the surface does not hide half of the point.
    position += params.lift * normalize(params.eye - position);
    // Particles differ a little, so that a crowd has texture.
    float shade = 0.72 + 0.28 * float((particle.id * 2654435769u) >> 24) / 255.0;
    if (params.hued != 0u) {
        vec2 heading = uintBitsToFloat(fetch_paged(motions, slot).xy);
        light = hue_light(turn_of(frame_of(particle.triangle), heading, pose)) * shade;
    } else {
        light = color_of(mix(params.ground, 1.0, 0.92 * shade)).rgb * params.strength;
    }
    gl_Position = params.clip_from_world * vec4(position, 1.0);
    // Beyond the picture.
    if (params.mortal != 0u && (fetch_paged(motions, slot).w & DEAD) != 0u) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    gl_PointSize = params.diameter;
}
