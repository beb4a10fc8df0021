// pose_table: the poses of objects.
// The includer declares `poses` first, a table of vec4: three a pose.

#ifndef MYXO_POSE_TABLE
#define MYXO_POSE_TABLE

#include "tables.glsl"
#include "types.glsl"

#define pose_in(table, object) \
    Pose(fetch4(table, 3u * (object)), fetch4(table, 3u * (object) + 1u), fetch4(table, 3u * (object) + 2u))

Pose pose_of(uint object) {
    return pose_in(poses, object);
}

#endif
