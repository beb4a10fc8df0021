// transfer_out: particles that were selected leave in world space, towards the triangle that their texel is nearest to.
// Reads   particle_indices, particles, motions, nearest, atlas_maps, triangles, corners, vertices, poses.
// Writes  departing, behind the transfers that were copied on; flux, by atomic adds.
// One invocation an entry of the lists; the first were copied on and return at once.
// One that finds no triangle near flies back to where it is.
// Overflow: cannot happen; selection has taken a place in the lists for each.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "index.glsl"

layout(local_size_x = 64) in;

layout(push_constant) uniform Params {
    uint capacity;      // of the lists of transfers
    uint pitch;         // texels from one atlas row to the next
    uint object_count;
} params;

layout(std430, set = 0, binding = 0) readonly buffer FlowBlock { Flow flow[]; };
layout(std430, set = 0, binding = 1) readonly buffer ParticleIndices { uint particle_indices[]; };
layout(std430, set = 0, binding = 2) readonly buffer Particles { Particle particles[]; };
layout(std430, set = 0, binding = 3) readonly buffer Motions { Motion motions[]; };
layout(std430, set = 0, binding = 4) readonly buffer Nearest { uint nearest[]; };
layout(std430, set = 0, binding = 5) readonly buffer AtlasMaps { AtlasMap atlas_maps[]; };
layout(std430, set = 0, binding = 6) writeonly buffer Departing { Transfer departing[]; };
// From each object (rows) to each.
layout(std430, set = 0, binding = 7) buffer Flux { uint flux[]; };
layout(set = 0, binding = 8) uniform usamplerBuffer triangles;
layout(std430, set = 0, binding = 9) readonly buffer Corners { uint corners[]; };
layout(std430, set = 0, binding = 10) readonly buffer Vertices { Vertex vertices[]; };
layout(std430, set = 0, binding = 11) readonly buffer Poses { Pose poses[]; };

#include "transfer.glsl"
#include "atlas.glsl"

// What the texel with the largest weight of the four around says, of those that know a triangle. Gutter texels know
// none, and a point near a seam may lie in one.
uint nearest_triangle(vec2 position) {
    precise vec2 corner = position - 0.5;
    vec2 low = floor(corner);
    precise vec2 f = corner - low;
    precise vec2 rest = 1.0 - f;
    uint texel = uint(low.y) * params.pitch + uint(low.x);
    uint found = NONE;
    float most = -1.0;
    for (uint k = 0u; k < 4u; k += 1u) {
        bool right = (k & 1u) != 0u;
        bool below = (k & 2u) != 0u;
        uint near = nearest[texel + (right ? 1u : 0u) + (below ? params.pitch : 0u)];
        precise float weight = (right ? f.x : rest.x) * (below ? f.y : rest.y);
        bool better = near != NONE && weight > most;
        found = better ? near : found;
        most = better ? weight : most;
    }
    return found;
}

void main() {
    uint i = invocation_index();
    if (i >= params.capacity || i >= flow[0].leaving || i < flow[0].carried) return;
    uint slot = particle_indices[i];
    Particle particle = particles[slot];
    uint source = texelFetch(triangles, int(particle.triangle)).w;
    uint near = nearest_triangle(atlas_position(atlas_maps[particle.triangle], particle.u, particle.v));
    uint triangle = near == NONE ? particle.triangle : near;
    uint target = texelFetch(triangles, int(triangle)).w;
    Flight flight = flight_of(particle, motions[slot]);
    departing[i] = Transfer(flight.position, slot, flight.heading, source, flight.normal, target, triangle, 0u, 0u, 0u);
    atomicAdd(flux[source * params.object_count + target], 1u);
}
