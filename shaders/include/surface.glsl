// surface: the parameters of both stages of `surface`.

#ifndef MYXO_SURFACE
#define MYXO_SURFACE

layout(push_constant) uniform Params {
    mat4 clip_from_world;
    vec3 eye;            // world space
    float trail_share;   // how much of the trail is shown, 0 to 1
    vec3 key_direction;  // unit vector towards the key light, world space
    float glow;          // light that the trail sends out itself, as a share of its colour
    uint size;           // side of the atlas, texels
    uint pitch;          // texels from one row of the atlas to the next
    float chart_share;   // how much of the charts' colours is shown under the trail, 0 to 1
    float relief;        // height of the brightest trail for the lighting, world units; 0 for a smooth surface
    float lamp;          // the share of all light from outside
    float occlusion;     // how much darker places that see little of the sky are, 0 to 1
    float wetness;       // how much the surface reflects, 0 to 1
    float reach;         // largest known distance to other objects, world units; 0 without other objects
} params;

#endif
