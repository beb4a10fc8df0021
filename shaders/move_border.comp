// move_border: ends an object's turn: fixes how many transfers leave it, and gives as many slots at the end of its window to the next object's.
// Reads   flow.
// Writes  flow, windows, the groups of the dispatches that follow.
// One invocation; sizes made on the device stay there.
// Without windows only the lists are closed.
// Overflow: entries beyond the capacity were never written. They are counted as refused, and the capacity that would have done is kept.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "index.glsl"
#include "ring.glsl"
#include "counted.glsl"

layout(local_size_x = 1) in;

layout(constant_id = 0) const bool WINDOWS = false;

layout(push_constant) uniform Params {
    uint object;            // whose turn it is
    uint object_count;
    uint particle_count;
    uint capacity;          // of the lists of transfers
    uint transfer_group;    // invocations in a group of the kernels that work on transfers
    uint particle_group;    // the same for those that work on particles
} params;

layout(std430, set = 0, binding = 0) buffer FlowBlock { Flow flow[]; };
layout(std430, set = 0, binding = 1) buffer Windows { Window windows[]; };
// First those of transfers that leave, then those of the next window's particles.
layout(std430, set = 0, binding = 2) writeonly buffer Groups { DispatchGroups groups[]; };

void main() {
    if (invocation_index() > 0u || params.object >= params.object_count) return;
    Flow now = flow[0];
    uint leaving = min(now.wanted, params.capacity);
    now.leaving = leaving;
    now.carried = now.passing;
    now.selected = counted(now.selected, now.wanted - now.passing);
    now.refused = counted(now.refused, now.wanted - leaving);
    if (params.object == 0u) {
        now.asked_before = now.asking;
        now.asking = 0u;
    }
    now.asking += now.wanted - now.passing;
    now.most_wanted = max(now.most_wanted, max(now.wanted, now.refused > 0u ? now.asking + now.asked_before : 0u));
    // Those of the turn before, which no kernel needs any more.
    now.mismatches += uint(now.stayers != now.outside);
    now.wanted = 0u;
    now.passing = 0u;
    now.stayers = 0u;
    now.outside = 0u;
    flow[0] = now;
    groups[0] = dispatch_groups(leaving, params.transfer_group);
    if (WINDOWS) {
        uint next = params.object + 1u == params.object_count ? 0u : params.object + 1u;
        windows[params.object].count -= leaving;
        Window window = windows[next];
        window.start = ring_slot(window.start, params.particle_count - leaving, params.particle_count);
        window.count += leaving;
        windows[next] = window;
        groups[1] = dispatch_groups(window.count, params.particle_group);
    }
}
