// land_claim: particles that come over from another object claim the cells that they would land on.
// Reads   flow, particles, strips, homes, goals, bids, triangles, corners, vertices, poses.
// Writes  transfers: the cell of each; bids, by atomic minima, so that no order shows. A cell is free if it was empty or has been left, and
//         if no particle of its object claims it. One that such a particle claims, but would win in a later round than the last, counts
//         as taken: it is rare, and its bid has no room for another one.
// One invocation per transfer.
// Overflow: cannot happen; nothing is appended.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "words.glsl"
#include "index.glsl"
#include "tables.glsl"
#include "texels.glsl"

layout(local_size_x = 64) in;

layout(push_constant) uniform Params {
    uint capacity;  // of the lists of transfers
    uint salt;      // of the step
    uint pitch;     // texels from one atlas row to the next
    uint rounds;    // in which cells are won
} params;

layout(std430, set = 0, binding = 0) buffer Transfers { Transfer transfers[]; };
layout(std430, set = 0, binding = 1) readonly buffer FlowBlock { Flow flow[]; };
PAGED_READS(uvec4, 2) particles;
READS(uvec4, 3) strips;
READS(uint, 4) homes_texels;
READS(uint, 6) goals_texels;
layout(std430, set = 0, binding = 7) buffer Bids { uint bids_block[]; };
CHANGES(uint, 8) bids_low;
CHANGES(uint, 9) bids_high;
READS(uvec4, 10) triangles;
READS(uint, 11) corners;
READS(uvec4, 12) vertices;
READS(vec4, 13) poses;

#include "strip_table.glsl"
#include "atlas.glsl"
#include "transfer.glsl"

// Other invocations lower bids meanwhile, but only to values from LANDING on, which are above any other claim. So neither whether a bid
// is below LANDING, nor whether it is some claim, depends on whether it is read before or after that.
uint bid_of(uint cell) {
    read_texel(bids, cell, bid)
    return bid;
}

#include "rows.glsl"

// May a particle that comes over have a cell?
bool is_open(uint cell) {
    // A particle's bid is lower than any of a landing, and would remain in any case.
    if (bid_of(cell) < LANDING) return false;
    uint word = texel_of(goals, cell);
    if (word == FREE) return true;
    return word != SHARED && won_in(cell, goal_of(word), params.salt, params.rounds) != 0u;
}

void main() {
    uint i = invocation_index();
    if (i >= params.capacity || i >= flow[0].leaving) return;
    Transfer transfer = transfers[i];
    // What stays on its object keeps its cell.
    if (transfer.source == transfer.target) return;
    Landing landing = landing_on(transfer.triangle, Flight(transfer.position, transfer.heading, transfer.normal));
    vec2 position = atlas_position(atlas_map_of(transfer.triangle), landing.u, landing.v);
    uint cell = texel_of(homes, texel_at(position, params.pitch));
    transfers[i].cell = cell;
    if (!is_open(cell)) return;
    uint rank = rank_of(fetch_paged(particles, transfer.particle).w, params.salt);
    lower_texel(bids, cell, LANDING + rank, before)
}
