// groups: lists whose entries the kernel of an indirect dispatch works on. The first of `groups` is the dispatch, the second
// counts entries.
// The includer declares `groups` first, in a storage block, and includes append.glsl.

#ifndef MYXO_GROUPS
#define MYXO_GROUPS

// Groups of an indirect dispatch along its first axis, at the most.
const uint GROUPS_A_ROW = 65535u;

// The place of one more entry in the list, of which a group takes `in_group`.
uint appended(uint in_group) {
    append_to(groups[1].x, place)
    if (place % in_group == 0u) {
        uint group = place / in_group;
        atomicMax(groups[0].x, min(group + 1u, GROUPS_A_ROW));
        atomicMax(groups[0].y, group / GROUPS_A_ROW + 1u);
    }
    return place;
}

#endif
