// respawn: selected particles restart on their own object, at a random place (uniform by area) with a random heading, or where particles
// of the object began.
// Reads   flow, particle_indices, triangles, area_shares, object_triangles, restarts, restart_ranges.
// Writes  particles and motions in place.
// One invocation per entry of the list.
// Overflow: cannot happen; nothing is appended.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "words.glsl"
#include "index.glsl"
#include "tables.glsl"
#include "counted.glsl"
#include "rng.glsl"
#include "ring.glsl"
#include "strict.glsl"

layout(local_size_x = 64) in;

// Do they restart where particles began?
layout(constant_id = 0) const bool FROM_START = false;

layout(push_constant) uniform Params {
    uint capacity;
    uint seed;
    uint time_step;
} params;

layout(std430, set = 0, binding = 0) buffer FlowBlock { Flow flow[]; };
layout(std430, set = 0, binding = 1) readonly buffer ParticleIndices { uint particle_indices[]; };
PAGED_CHANGES(uvec4, 2) particles;
PAGED_CHANGES(uvec4, 3) motions;
READS(uvec4, 4) triangles;
// One per triangle: its cumulative share of its object's area, those before it included, in units of 2^-32.
layout(std430, set = 0, binding = 5) readonly buffer AreaShares { uint area_shares[]; };
// One per object: its first triangle, and the one behind its last.
layout(std430, set = 0, binding = 6) readonly buffer ObjectTriangles { uvec2 object_triangles[]; };
// Two per place: the triangle and the bits of u and v; the bits of the heading.
layout(std430, set = 0, binding = 7) readonly buffer Restarts { uvec4 restarts[]; };
// One per object: its first place, and the one behind its last.
layout(std430, set = 0, binding = 8) readonly buffer RestartRanges { uvec2 restart_ranges[]; };

// Where a particle of the object began. A function of its own: inside of main() shaderc looks without end for what `precise` reaches.
void restart_at(int slot, uint place, uint id, uint flags) {
    store_paged(particles, slot, uvec4(restarts[place].xyz, id));
    store_paged(motions, slot, uvec4(restarts[place + 1u].xy, 0u, flags));
}

void main() {
    uint i = invocation_index();
    if (i >= params.capacity || i >= flow[0].leaving) return;
    count_one(flow[0].arrived)
    int slot = int(particle_indices[i]);
    Particle particle = particle_of(load_paged(particles, slot));
    uvec4 words = random_words(params.seed, particle.id, params.time_step, PURPOSE_RESPAWN);
    uint object = fetch4(triangles, particle.triangle).w;
    uint flags = load_paged(motions, slot).w & ~SELECTED;
    if (FROM_START) {
        uvec2 places = restart_ranges[object];
        if (places.x < places.y) {
            uint place = 2u * (places.x + words.x % (places.y - places.x));
            restart_at(slot, place, particle.id, flags);
            return;
        }
    }
    uvec2 range = object_triangles[object];
    // The first triangle whose cumulative share is above the word; that of the last one is 1.
    uint low = range.x;
    uint high = range.y - 1u;
    while (low < high) {
        uint middle = (low + high) / 2u;
        if (area_shares[middle] > words.x) {
            high = middle;
        } else {
            low = middle + 1u;
        }
    }
    float u = unit_float(words.y);
    float v = unit_float(words.z);
    precise float sum = u + v;
    precise float mirrored_u = 1.0 - u;
    precise float mirrored_v = 1.0 - v;
    bool beyond = sum > 1.0;
    store_paged(particles, slot, words_of(Particle(low, beyond ? mirrored_u : u, beyond ? mirrored_v : v, particle.id)));
    vec2 heading = turn_of(words.w);
    store_paged(motions, slot, words_of(Motion(heading.x, heading.y, 0.0, flags)));
}
