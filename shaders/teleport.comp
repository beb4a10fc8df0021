// teleport: moves randomly chosen particles of an object to places on it that a brush has touched.
// Reads   places, place_ranges, triangles.
// Writes  particles and motions in place.
// One invocation per particle; those whose object the brush has not touched return.
// Overflow: cannot happen; nothing is appended.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "words.glsl"
#include "index.glsl"
#include "tables.glsl"
#include "rng.glsl"
#include "strict.glsl"

layout(local_size_x = 64) in;

layout(push_constant) uniform Params {
    uint particle_count;
    uint seed;
    uint dab;     // number of the dab; keys the choice of particles
    float share;  // share of an object's particles that are moved
} params;

// The destinations, object by object; the ids are not used.
layout(std430, set = 0, binding = 0) readonly buffer Places { Particle places[]; };
// One per object: its first place, and its number of places.
layout(std430, set = 0, binding = 1) readonly buffer PlaceRanges { uvec2 place_ranges[]; };
READS(uvec4, 2) triangles;
PAGED_CHANGES(uvec4, 3) particles;  // one an invocation
PAGED_CHANGES(uvec4, 4) motions;  // one an invocation

void main() {
    uint i = invocation_index();
    if (i >= params.particle_count) return;
    int slot = int(i);
    Particle particle = particle_of(load_paged(particles, slot));
    uint flags = load_paged(motions, slot).w;
    uvec2 range = place_ranges[fetch4(triangles, particle.triangle).w];
    uvec4 words = random_words(params.seed, particle.id, params.dab, PURPOSE_PAINT);
    if (range.y == 0u || unit_float(words.x) >= params.share) return;
    Particle place = places[range.x + words.y % range.y];
    vec2 heading = turn_of(words.z);
    store_paged(particles, slot, words_of(Particle(place.triangle, place.u, place.v, particle.id)));
    store_paged(motions, slot, words_of(Motion(heading.x, heading.y, 0.0, flags)));
}
