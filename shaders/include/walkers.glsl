// walkers: the lists of particles that another form of advance takes: those whose sensors must walk, those that are near other
// objects, and those of which both are true. The twin has no such lists: it handles each particle in one pass.
// The includer declares `walkers`, `walkers_near`, `walker_count`, `walker_groups` and `params` first, and includes append.glsl.

#ifndef MYXO_WALKERS
#define MYXO_WALKERS

#include "tables.glsl"

const uint WALKING = 0u;
const uint NEARBY = 1u;
const uint WALKING_NEARBY = 2u;

// The index in `walkers` of entry `place` of the first list, or of the second.
uint walker_slot(uint list, uint place) {
    return list == WALKING ? place : params.particle_count - 1u - place;
}

// Groups come in columns as high as the dispatch has rows.
void count_group(uint list, uint place) {
    if (place % (params.walker_rows * gl_WorkGroupSize.x) == 0u) atomicAdd(walker_groups[list].x, 1u);
}

void enlist(uint list, uint slot) {
    if (ACROSS) {
        append_to_one_of(walker_count, list, place)
        if (list == WALKING_NEARBY) {
            store1(walkers_near, place, slot);
        } else {
            store1(walkers, walker_slot(list, place), slot);
        }
        count_group(list, place);
    } else {
        // Without other objects there is only one list.
        append_to(walker_count[WALKING], place)
        store1(walkers, place, slot);
        count_group(WALKING, place);
    }
}

#endif
