// move_borders: gives each object's window as many slots as the object has particles after this step's births and transfers.
// Reads   flow, windows, borders.
// Writes  windows, borders, flow, the groups of the kernels that put particles in order.
// One group: each invocation adds up a run of objects, then all add up the runs before theirs. The windows lie one after the other in a
// ring. Its beginning may move, and does so to make the mean movement of borders as small as possible.
// Overflow: cannot happen; as many come as leave.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "index.glsl"
#include "ring.glsl"
#include "transfer_groups.glsl"

layout(local_size_x = 64) in;

layout(push_constant) uniform Params {
    uint object_count;
    uint particle_count;
    uint scan_group;   // invocations in a group of defragment_scan
    uint swap_group;   // in one of defragment_swap
    uint whole;        // 1: any slot may hold a wrong particle, because particles were born
} params;

layout(std430, set = 0, binding = 0) buffer FlowBlock { Flow flow[]; };
layout(std430, set = 0, binding = 1) buffer Windows { Window windows[]; };
layout(std430, set = 0, binding = 2) buffer Borders { Border borders[]; };
layout(std430, set = 0, binding = 3) writeonly buffer Groups { DispatchGroups groups[]; };

shared uint sums[gl_WorkGroupSize.x];

// The sum of the values of all invocations before this one; `all` is the sum over all invocations.
uint added_up(uint me, uint mine, out uint all) {
    barrier();
    sums[me] = mine;
    barrier();
    uint before = 0u;
    all = 0u;
    for (uint i = 0u; i < gl_WorkGroupSize.x; i += 1u) {
        before += i < me ? sums[i] : 0u;
        all += sums[i];
    }
    return before;
}

void main() {
    uint me = invocation_index();
    if (me >= gl_WorkGroupSize.x) return;
    uint run = (params.object_count + gl_WorkGroupSize.x - 1u) / gl_WorkGroupSize.x;
    uint first = min(me * run, params.object_count);
    uint end = min(first + run, params.object_count);
    uint ring = params.particle_count;
    uint ring_start = windows[0].start;
    // It is written below, behind other barriers.
    memoryBarrierBuffer();

    // How far each border would move if the ring's beginning stayed: the number of particles that have come to the objects before it, minus
    // those that have left them. Sums wrap round, but differences are right.
    uint mine = 0u;
    for (uint o = first; o < end; o += 1u) mine += borders[o].came - borders[o].left;
    uint all;
    uint way = added_up(me, mine, all);
    uint from = way;
    // The mean way of all borders, rounded, of numbers that are not negative.
    uint whole = 0u;
    uint parts = 0u;
    for (uint o = first; o < end; o += 1u) {
        whole += (from + ring) / params.object_count;
        parts += (from + ring) % params.object_count;
        from += borders[o].came - borders[o].left;
    }
    uint whole_of_all;
    uint parts_of_all;
    added_up(me, whole, whole_of_all);
    added_up(me, parts, parts_of_all);
    uint mean = whole_of_all + (parts_of_all + params.object_count / 2u) / params.object_count;
    // How much earlier the ring begins, counted from `ring` slots before.
    uint shift = ring - mean;

    mine = 0u;
    for (uint o = first; o < end; o += 1u) mine += windows[o].count;
    uint begins = added_up(me, mine, all);

    uint gained = 0u;
    uint entries = 0u;
    for (uint o = first; o < end; o += 1u) {
        Border border = borders[o];
        uint had = windows[o].count;
        uint count = had + border.came - border.left;
        // Both runs of slots, counted from where the ring began, `ring` slots more so that no number is negative.
        uint old_start = begins + ring;
        uint new_start = begins + way + shift + ring;
        uint both_start = max(old_start, new_start);
        uint both_end = min(old_start + had, new_start + count);
        uint both = both_end > both_start ? both_end - both_start : 0u;
        border.gained = count - both;
        border.front = new_start < old_start ? min(old_start - new_start, border.gained) : 0u;
        // Slots that may hold another object's particle: no more than these.
        uint most = params.whole != 0u ? count : min(border.gained + border.left, count);
        if (border.holes != border.strays) atomicAdd(flow[0].mismatches, 1u);
        border.holes = 0u;
        border.strays = 0u;
        border.first = gained;
        border.list = entries;
        gained += border.gained;
        entries += most;
        way += border.came - border.left;
        begins += had;
        border.came = 0u;
        border.left = 0u;
        borders[o] = border;
        uint start = (ring_start + new_start) % ring;
        windows[o] = Window(start, count);
    }
    uint gained_by_all;
    uint entries_of_all;
    uint gained_before = added_up(me, gained, gained_by_all);
    uint entries_before = added_up(me, entries, entries_of_all);
    for (uint o = first; o < end; o += 1u) {
        borders[o].first += gained_before;
        borders[o].list += entries_before;
    }
    if (me == 0u) {
        flow[0].gained = gained_by_all;
        flow[0].entries = entries_of_all;
        groups[CANDIDATES] = dispatch_groups(params.whole != 0u ? ring : flow[0].leaving + gained_by_all, params.scan_group);
        groups[STRAYS] = dispatch_groups(entries_of_all, params.swap_group);
    }
}
