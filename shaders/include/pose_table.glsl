// pose_table: how objects stand, out of a texel buffer: CPU drivers gather from storage buffers scalar by scalar.
// The includer declares `poses` first: three texels a pose.

#ifndef MYXO_POSE_TABLE
#define MYXO_POSE_TABLE

#include "types.glsl"

Pose pose_of(uint object) {
    int first = int(3u * object);
    return Pose(texelFetch(poses, first), texelFetch(poses, first + 1), texelFetch(poses, first + 2));
}

#endif
