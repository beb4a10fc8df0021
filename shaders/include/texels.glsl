// texels: single texels of textures, however large. Twin: an index.
// The constants are those of src/sim/texel_paths.rs, which the host fills in for every shader that includes this.

#ifndef MYXO_TEXELS
#define MYXO_TEXELS

// A texture with more texels than a texel buffer has elements is viewed four texels at once.
layout(constant_id = 100) const bool TEXELS_IN_QUADS = false;
// What is written texel by texel takes two views then; the texels of the first one.
layout(constant_id = 101) const uint BAND = 0xffffffffu;
// What a storage block does not hold is written through texel buffers, which CPU drivers are slower with.
layout(constant_id = 102) const bool OUTGROWS_BLOCK = false;

float texel_of(samplerBuffer view, uint texel) {
    if (TEXELS_IN_QUADS) return texelFetch(view, int(texel >> 2u))[texel & 3u];
    return texelFetch(view, int(texel)).x;
}

uint texel_of(usamplerBuffer view, uint texel) {
    if (TEXELS_IN_QUADS) return texelFetch(view, int(texel >> 2u))[texel & 3u];
    return texelFetch(view, int(texel)).x;
}

// Macros, because what is written to has a format, which parameters cannot have. Each is a whole block.
#define store_texel(low, high, texel, value) \
    { if ((texel) < BAND) { imageStore(low, int(texel), value); } else { imageStore(high, int((texel) - BAND), value); } }

#define add_to_texel(low, high, texel, value) \
    { if ((texel) < BAND) { imageAtomicAdd(low, int(texel), value); } else { imageAtomicAdd(high, int((texel) - BAND), value); } }

#endif
