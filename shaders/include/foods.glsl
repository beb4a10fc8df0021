// foods: the parameters of both stages of `foods`.

#ifndef MYXO_FOODS
#define MYXO_FOODS

layout(push_constant) uniform Params {
    mat4 clip_from_world;
    vec3 eye;            // world space
    float lamp;          // the share of all light from outside
    vec3 key_direction;  // unit vector towards the key light, world space
    float glow;          // light that food sends out itself, as a share of its colour
} params;

#endif
