// painted: the parameters of both stages of `painted`.

#ifndef MYXO_PAINTED
#define MYXO_PAINTED

layout(push_constant) uniform Params {
    mat4 clip_from_world;
    uint size;    // side of the atlas, texels
    uint pitch;   // texels from one row of the atlas to the next
    float usual;  // a bias that is shown clearly, trail units
} params;

#endif
