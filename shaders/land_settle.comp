// land_settle: particles whose cell on the other object is taken, or was won by another one, stay on their object, with a random heading;
// so do those that transfer_out has sent back.
// Reads   particles, bids.
// Writes  transfers and motions of those that stay; flow and flux, by atomic adds.
// One invocation per transfer.
// Overflow: cannot happen; counters stop at the largest number.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "words.glsl"
#include "index.glsl"
#include "tables.glsl"
#include "texels.glsl"
#include "counted.glsl"
#include "rng.glsl"
#include "ring.glsl"
#include "strict.glsl"
#include "claims.glsl"

layout(local_size_x = 64) in;

layout(push_constant) uniform Params {
    uint capacity;  // of the lists of transfers
    uint salt;      // of the step
    uint seed;
    uint time_step;
    uint object_count;
} params;

layout(std430, set = 0, binding = 0) buffer Transfers { Transfer transfers[]; };
layout(std430, set = 0, binding = 1) buffer FlowBlock { Flow flow[]; };
PAGED_READS(uvec4, 2) particles;
PAGED_CHANGES(uvec4, 3) motions;
READS(uint, 4) bids_texels;
layout(std430, set = 0, binding = 5) buffer Flux { uint flux[]; };

void main() {
    uint i = invocation_index();
    if (i >= params.capacity || i >= flow[0].leaving) return;
    Transfer transfer = transfers[i];
    uint slot = transfer.particle;
    uint id = fetch_paged(particles, slot).w;
    bool comes = transfer.source != transfer.target;
    if (comes && texel_of(bids, transfer.cell) == LANDING + rank_of(id, params.salt)) return;
    // It crosses nothing after all: one less, as adding the largest number does.
    if (transfer.stays == 2u) atomicAdd(flow[0].crossed, MOST_COUNTED);
    transfers[i].stays = 1u;
    if (comes) {
        transfers[i].target = transfer.source;
        atomicAdd(flux[transfer.source * params.object_count + transfer.target], 0xffffffffu);
        count_one(flux[transfer.source * params.object_count + transfer.source])
    }
    vec2 heading = turn_of(random_words(params.seed, id, params.time_step, PURPOSE_REFUSED).y);
    uint flags = load_paged(motions, slot).w & ~SELECTED;
    store_paged(motions, slot, words_of(Motion(heading.x, heading.y, 0.0, flags)));
}
