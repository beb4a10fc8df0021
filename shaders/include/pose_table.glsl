// pose_table: how objects stand, out of a texel buffer: CPU drivers gather from storage buffers scalar by scalar.
// The includer declares `poses` first: three texels a pose.

#ifndef MYXO_POSE_TABLE
#define MYXO_POSE_TABLE

#include "types.glsl"

Pose pose_in(samplerBuffer table, uint object) {
    int first = int(3u * object);
    return Pose(texelFetch(table, first), texelFetch(table, first + 1), texelFetch(table, first + 2));
}

Pose pose_of(uint object) {
    return pose_in(poses, object);
}

#endif
