// footprint: the parameters of both stages of `footprint`.

#ifndef MYXO_FOOTPRINT
#define MYXO_FOOTPRINT

layout(push_constant) uniform Params {
    vec2 middle;   // of the square: x and z, world units
    float extent;  // half its side, world units
    float ground;  // height of the ground, world units
} params;

#endif
