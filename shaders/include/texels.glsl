// texels: single texels of textures, however large. Twin: an index.
// The includer declares TEXELS_IN_QUADS first: a texture with more texels than a texel buffer has elements is viewed four
// texels at once. What is written texel by texel takes two views then, and BAND says how many texels the first one has.

#ifndef MYXO_TEXELS
#define MYXO_TEXELS

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
