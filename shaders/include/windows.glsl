// windows: which slots a window has gained when the borders moved. Twin of src/sim/step/windows.rs.
// The includer declares `windows`, `borders` and `params` with `particle_count` and `object_count` first.
//
// A window's slots before and after are two runs. The slots that it gains lie in front of their common part
// (`front` slots), or behind it.

#ifndef MYXO_WINDOWS
#define MYXO_WINDOWS

#include "ring.glsl"

// Slot number i of those that a window has gained.
uint gained_slot(uint object, uint i) {
    Window window = windows[object];
    Border border = borders[object];
    uint offset = i < border.front ? i : window.count - (border.gained - i);
    return ring_slot(window.start, offset, params.particle_count);
}

// Did a slot belong to a window before, and does it still?
bool has_kept(uint object, uint slot) {
    Window window = windows[object];
    Border border = borders[object];
    uint offset = ring_offset(window.start, slot, params.particle_count);
    return offset >= border.front && offset < window.count - (border.gained - border.front);
}

// The window that has gained slot number i of all gained slots, or whose part of the lists has entry i.
uint window_of(uint i, bool of_lists) {
    uint low = 0u;
    uint high = params.object_count;
    while (high - low > 1u) {
        uint middle = (low + high) / 2u;
        uint begins = of_lists ? borders[middle].list : borders[middle].first;
        if (begins <= i) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

#endif
