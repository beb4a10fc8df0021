// painted: what the two stages of `painted` share.

#ifndef MYXO_PAINTED
#define MYXO_PAINTED

layout(push_constant) uniform Params {
    mat4 clip_from_world;
    uint size;    // side of the atlas, texels
    uint pitch;   // texels from one row of the atlas to the next
    float usual;  // a bias that is seen well, trail units
} params;

#endif
