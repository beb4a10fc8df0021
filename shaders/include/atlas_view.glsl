// atlas_view: what the two stages of `atlas_view` share.

#ifndef MYXO_ATLAS_VIEW
#define MYXO_ATLAS_VIEW

layout(push_constant) uniform Params {
    vec2 origin;             // texel position at the picture's top left corner
    float texels_per_pixel;  // below 1 magnifies
    float chart_share;       // how strongly charts are told apart by a tint, 0 to 1
    uint size;               // side of the atlas, texels
    uint pitch;              // texels from one row of the atlas to the next
} params;

#endif
