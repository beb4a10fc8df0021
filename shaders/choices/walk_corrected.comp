// walk_corrected: a straight walk by the opposite method to walk_exactly: it goes the whole length in the triangle's plane. If that leaves
// the triangle, the walk is moved back onto the edge that it is farthest beyond, and continues from there.
// Reads   particles_before, motions_before, strips.
// Writes  particles, motions.
// One invocation per particle. A walk that is still outside after the last attempt is moved into the triangle; nothing is pending for the
// next dispatch. Its table has the layout of that of walk_exactly, and it too looks up only edges that it reaches; but its edges store how
// headings turn there.
// Overflow: cannot happen; nothing is appended.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "words.glsl"
#include "index.glsl"
#include "atlas.glsl"

layout(local_size_x = 64) in;

layout(push_constant) uniform Params {
    uint particle_count;
    uint attempts;  // corrections that one walk may make
    float way;      // world length
} params;

layout(set = 0, binding = 0) uniform usamplerBuffer particles_before;
layout(set = 0, binding = 1) uniform usamplerBuffer motions_before;
layout(set = 0, binding = 2) uniform usamplerBuffer strips;
layout(rgba32ui, set = 0, binding = 3) uniform writeonly uimageBuffer particles;
layout(rgba32ui, set = 0, binding = 4) uniform writeonly uimageBuffer motions;

#include "strip_table.glsl"

// The weights of where the rest of the way leads in the plane of the triangle.
vec3 aimed(uint triangle, float b, float c, vec2 heading, float remaining) {
    vec3 shape = uintBitsToFloat(shape_words(triangle).xyz);
    precise float way_c = remaining * heading.y / shape.z;
    precise float way_b = (remaining * heading.x - way_c * shape.y) / shape.x;
    precise float to_b = b + way_b;
    precise float to_c = c + way_c;
    precise float to_a = (1.0 - to_b) - to_c;
    return vec3(to_a, to_b, to_c);
}

void main() {
    uint i = invocation_index();
    if (i >= params.particle_count) return;
    Particle particle = particle_of(texelFetch(particles_before, int(i)));
    Motion motion = motion_of(texelFetch(motions_before, int(i)));
    uint triangle = particle.triangle;
    float b = particle.u;
    float c = particle.v;
    vec2 heading = vec2(motion.heading_p, motion.heading_h);
    precise float remaining = motion.pending + params.way;
    uint attempts = params.attempts;
    vec3 to = aimed(triangle, b, c, heading, remaining);
    float least = min(to.x, min(to.y, to.z));
    bool crosses = least < 0.0 && attempts > 0u;
    while (true) {
        // The loop has one path and one exit, as in walk_strip.
        if (crosses) {
            // Back to the line of the edge that lies opposite the corner of the least weight.
            precise float a = (1.0 - b) - c;
            uint corner = to.z == least ? 0u : to.x == least ? 1u : 2u;
            float before = max(corner == 0u ? c : corner == 1u ? a : b, 0.0);
            precise float part = before / (before - min(least, -1.0e-30));
            float from = corner == 0u ? b : corner == 1u ? c : a;
            float there = corner == 0u ? to.y : corner == 1u ? to.z : to.x;
            // On the line but not on the edge, where another edge was crossed first: this makes the walk too short or bends it.
            precise float on_line = from + part * (there - from);
            float along = clamp(on_line, 0.0, 1.0);
            precise float rest = 1.0 - along;

            uvec4 edge = edge_words(4u * triangle + corner);
            bool at_border = edge.x == NONE;
            uint next_corner = at_border ? corner : edge.x & 3u;
            float start = at_border ? rest : along;
            float end = at_border ? along : rest;
            b = next_corner == 1u ? start : next_corner == 0u ? end : 0.0;
            c = next_corner == 2u ? start : next_corner == 1u ? end : 0.0;
            triangle = at_border ? triangle : edge.x >> 2u;
            // At a border (cos, sin) is the direction of the edge, doubled, which mirrors the heading with its h negated.
            float mirrored = at_border ? -heading.y : heading.y;
            vec2 rotation = uintBitsToFloat(edge.yz);
            precise float turned_p = rotation.x * heading.x - rotation.y * mirrored;
            precise float turned_h = rotation.y * heading.x + rotation.x * mirrored;
            heading = vec2(turned_p, turned_h);
            precise float left = remaining - part * remaining;
            remaining = left;
            attempts -= 1u;
            to = aimed(triangle, b, c, heading, remaining);
            least = min(to.x, min(to.y, to.z));
            crosses = least < 0.0 && attempts > 0u;
        }
        if (!crosses) break;
    }
    b = clamp(to.y, 0.0, 1.0);
    precise float most = 1.0 - b;
    c = clamp(to.z, 0.0, most);
    precise float drift = heading.x * heading.x + heading.y * heading.y;
    precise float scale = 1.5 - 0.5 * drift;
    imageStore(particles, int(i), words_of(Particle(triangle, b, c, particle.id)));
    imageStore(motions, int(i), words_of(Motion(heading.x * scale, heading.y * scale, 0.0, motion.flags)));
}
