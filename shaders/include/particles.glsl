// particles: the parameters of both stages of `particles`.

#ifndef MYXO_PARTICLES
#define MYXO_PARTICLES

layout(push_constant) uniform Params {
    mat4 clip_from_world;
    vec3 eye;        // world space
    float lift;      // how far points are moved towards the eye, world units
    float diameter;  // pixels
    float strength;  // light of one point, 0 to 1
    uint hued;       // 1: its hue is its heading's direction; 0: all have the brightest colour
    float ground;    // brightness at which colours begin
    uint mortal;     // 1: particles may be dead, and are not drawn then
} params;

#endif
