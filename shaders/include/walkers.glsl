// walkers: the lists of particles that another form of advance takes: those whose sensors must walk, those that are near other
// objects, and those of which both are true. The twin has none: it takes each particle as a whole.
// The includer declares `walkers`, `walker_count`, `walker_groups` and `params` first, and includes append.glsl.

#ifndef MYXO_WALKERS
#define MYXO_WALKERS

#include "tables.glsl"
const uint WALKING = 0u;
const uint NEARBY = 1u;
const uint WALKING_NEARBY = 2u;

// Where the list of walkers has the one that is listed as number `place`.
int walker_slot(uint list, uint place) {
    if (list == WALKING) return int(place);
    return int(list == NEARBY ? params.particle_count - 1u - place : params.particle_count + place);
}

void put(uint list, uint place, uint slot) {
    store1(walkers, walker_slot(list, place), slot);
    // Groups come in columns as high as the dispatch has rows.
    if (place % (params.walker_rows * gl_WorkGroupSize.x) == 0u) atomicAdd(walker_groups[list].x, 1u);
}

// Each list has a counter of its own, so particles are appended list by list.
void enlist(uint list, uint slot) {
    if (list == WALKING) {
        append_to(walker_count[WALKING], place)
        put(WALKING, place, slot);
    } else if (list == NEARBY) {
        append_to(walker_count[NEARBY], place)
        put(NEARBY, place, slot);
    } else {
        append_to(walker_count[WALKING_NEARBY], place)
        put(WALKING_NEARBY, place, slot);
    }
}

#endif
