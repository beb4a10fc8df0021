// walk_corrected: straight on by a length the other way round: it goes the whole length in the triangle's plane, and where
// that has left the triangle, is corrected: back to the edge that it is farthest behind, onto it, and on from there.
// Reads   particles_before, motions_before, triangles, halfedges.
// Writes  particles, motions.
// One invocation a particle.
// What is still outside after the last attempt is moved into the triangle; nothing is left for the next dispatch.
// Overflow: cannot happen; nothing is appended.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "words.glsl"
#include "index.glsl"

layout(local_size_x = 64) in;

layout(push_constant) uniform Params {
    uint particle_count;
    uint attempts;  // corrections that one walk may make
    float way;      // world length
} params;

layout(set = 0, binding = 0) uniform usamplerBuffer particles_before;
layout(set = 0, binding = 1) uniform usamplerBuffer motions_before;
layout(set = 0, binding = 2) uniform usamplerBuffer triangles;
layout(set = 0, binding = 3) uniform usamplerBuffer halfedges;
layout(rgba32ui, set = 0, binding = 4) uniform writeonly uimageBuffer particles;
layout(rgba32ui, set = 0, binding = 5) uniform writeonly uimageBuffer motions;

void main() {
    uint i = invocation_index();
    if (i >= params.particle_count) return;
    Particle particle = particle_of(texelFetch(particles_before, int(i)));
    Motion motion = motion_of(texelFetch(motions_before, int(i)));
    uint triangle = particle.triangle;
    float b = particle.u;
    float c = particle.v;
    float p = motion.heading_p;
    float h = motion.heading_h;
    precise float remaining = motion.pending + params.way;
    uint attempts = params.attempts;
    bool crosses = true;
    while (crosses) {
        vec3 shape = uintBitsToFloat(texelFetch(triangles, int(triangle)).xyz);
        precise float a = (1.0 - b) - c;
        precise float way_c = remaining * h / shape.z;
        precise float way_b = (remaining * p - way_c * shape.y) / shape.x;
        precise float to_b = b + way_b;
        precise float to_c = c + way_c;
        precise float to_a = (1.0 - to_b) - to_c;
        float least = min(to_a, min(to_b, to_c));
        crosses = least < 0.0 && attempts > 0u;

        // Back to the line of the edge that lies opposite the corner of the least weight.
        uint corner = to_c == least ? 0u : to_a == least ? 1u : 2u;
        float before = max(corner == 0u ? c : corner == 1u ? a : b, 0.0);
        precise float part = before / (before - min(least, -1.0e-30));
        float from = corner == 0u ? b : corner == 1u ? c : a;
        float to = corner == 0u ? to_b : corner == 1u ? to_c : to_a;
        // On the line but not on the edge, where another edge was crossed first: this is where way gets lost or bent.
        precise float on_line = from + part * (to - from);
        float along = clamp(on_line, 0.0, 1.0);
        precise float rest = 1.0 - along;

        uvec4 edge = texelFetch(halfedges, int(3u * triangle + corner));
        bool at_border = edge.x == NONE;
        uint next_corner = at_border ? corner : edge.x % 3u;
        float start = at_border ? rest : along;
        float end = at_border ? along : rest;
        b = !crosses ? to_b : next_corner == 1u ? start : next_corner == 0u ? end : 0.0;
        c = !crosses ? to_c : next_corner == 2u ? start : next_corner == 1u ? end : 0.0;
        triangle = !crosses || at_border ? triangle : edge.x / 3u;
        // At a border (cos, sin) is the direction of the edge, doubled, which mirrors the heading with its h negated.
        float mirrored = at_border ? -h : h;
        vec2 rotation = uintBitsToFloat(edge.yz);
        precise float turned_p = rotation.x * p - rotation.y * mirrored;
        precise float turned_h = rotation.y * p + rotation.x * mirrored;
        p = crosses ? turned_p : p;
        h = crosses ? turned_h : h;
        precise float left = remaining - part * remaining;
        remaining = left;
        attempts -= 1u;
    }
    b = clamp(b, 0.0, 1.0);
    precise float most = 1.0 - b;
    c = clamp(c, 0.0, most);
    precise float drift = p * p + h * h;
    precise float scale = 1.5 - 0.5 * drift;
    imageStore(particles, int(i), words_of(Particle(triangle, b, c, particle.id)));
    imageStore(motions, int(i), words_of(Motion(p * scale, h * scale, 0.0, motion.flags)));
}
