// land_claim: particles that come over from another object claim the cells that they would land on.
// Reads   flow, particles, strips, homes, triangles, corners, vertices, poses.
// Writes  transfers: the cell of each; cells, by atomic minima, so that no order shows.
// One invocation per transfer.
// Overflow: cannot happen; nothing is appended.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "words.glsl"
#include "index.glsl"
#include "tables.glsl"
#include "texels.glsl"
#include "claims.glsl"

layout(local_size_x = 64) in;

layout(push_constant) uniform Params {
    uint capacity;  // of the lists of transfers
    uint salt;      // of the step
    uint pitch;     // texels from one atlas row to the next
} params;

layout(std430, set = 0, binding = 0) buffer Transfers { Transfer transfers[]; };
layout(std430, set = 0, binding = 1) readonly buffer FlowBlock { Flow flow[]; };
PAGED_READS(uvec4, 2) particles;
READS(uvec4, 3) strips;
READS(uint, 4) homes_texels;
layout(std430, set = 0, binding = 5) buffer Cells { uint cells_block[]; };
CHANGES(uint, 6) cells_low;
CHANGES(uint, 7) cells_high;
READS(uvec4, 8) triangles;
READS(uint, 9) corners;
READS(uvec4, 10) vertices;
READS(vec4, 11) poses;

#include "strip_table.glsl"
#include "atlas.glsl"
#include "transfer.glsl"

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
    uint rank = rank_of(fetch_paged(particles, transfer.particle).w, params.salt);
    lower_texel(cells, cell, claim_of(rank, LANDING), before)
}
