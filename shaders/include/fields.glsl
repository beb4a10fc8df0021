// fields: the parameters of both stages of `fields`.

#ifndef MYXO_FIELDS
#define MYXO_FIELDS

layout(push_constant) uniform Params {
    mat4 clip_from_world;
    vec3 eye;            // world space
    uint field;          // which one is shown
    vec3 key_direction;  // unit vector towards the key light, world space
    float occlusion;     // how much darker places that see little of the sky are, 0 to 1
    uint size;           // side of the atlas, texels
    uint pitch;          // texels from one row of the atlas to the next
    float reach;         // largest known distance to other objects, world units
    float usual;         // particles in a texel of mean area, if all were spread evenly
} params;

#endif
