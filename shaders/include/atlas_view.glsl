// atlas_view: the parameters of both stages of `atlas_view`.

#ifndef MYXO_ATLAS_VIEW
#define MYXO_ATLAS_VIEW

layout(push_constant) uniform Params {
    vec2 origin;             // texel position at the picture's top left corner
    float texels_per_pixel;  // below 1 magnifies
    float trail_share;       // how much of the trail is shown, 0 to 1
    float chart_share;       // how much of the charts' colours is shown under the trail, 0 to 1
    uint size;               // side of the atlas, texels
    uint pitch;              // texels from one row of the atlas to the next
} params;

#endif
