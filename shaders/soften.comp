// soften: blurs the shadow on the ground along one axis of its square.
// Reads   footprint, or shadow.
// Writes  softened.
// One invocation per cell.
// Overflow: cannot happen; beyond its edges the square is without shadow.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "index.glsl"
#include "tables.glsl"
#include "ground.glsl"

layout(local_size_x = 64) in;

// Is the footprint read, as words whose lowest byte is red?
layout(constant_id = 0) const bool IS_FIRST = true;

layout(push_constant) uniform Params {
    uint cell_count;
    uint is_down;   // 0: along rows, 1: along columns
    uint apart;     // cells from one that is read to the next
} params;

READS(uint, 0) footprint;
layout(std430, set = 0, binding = 1) readonly buffer Shadow { float shadow[]; };
layout(std430, set = 0, binding = 2) writeonly buffer Softened { float softened[]; };

// Of six cells on each side and the middle: a bell with a width of 2.5 cells.
const float WEIGHTS[7] = float[](0.160834, 0.148467, 0.116788, 0.078288, 0.044720, 0.021768, 0.009029);

float shadow_at(uint cell) {
    if (IS_FIRST) {
        precise float share = float(fetch1(footprint, cell) & 255u) * (1.0 / 255.0);
        return share;
    }
    return shadow[cell];
}

void main() {
    uint i = invocation_index();
    if (i >= params.cell_count) return;
    int place = int(params.is_down == 1u ? i / SIDE : i % SIDE);
    int pace = params.is_down == 1u ? int(SIDE) : 1;
    precise float sum = shadow_at(i) * WEIGHTS[0];
    for (int k = 1; k < 7; k++) {
        int steps = k * int(params.apart);
        float before = place >= steps ? shadow_at(uint(int(i) - steps * pace)) : 0.0;
        float after = place + steps < int(SIDE) ? shadow_at(uint(int(i) + steps * pace)) : 0.0;
        precise float both = before + after;
        precise float weighted = both * WEIGHTS[k];
        precise float more = sum + weighted;
        sum = more;
    }
    softened[i] = sum;
}
