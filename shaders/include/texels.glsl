// texels: textures of any size. Twin: an index.
// The constants are those of src/sim/texel_paths.rs, which the host fills in for every shader that includes this.
//
// A binding is one access path to a texture, by the end of its name. The build makes one argument of all bindings whose names begin alike:
//
//   NAME_texels  table to read                 single texels; four at once where TEXELS_IN_QUADS
//   NAME_quads   table, either kind            four texels at once
//   NAME_low     table to write                single texels below BAND
//   NAME_high    table to write                single texels from BAND on
//   NAME_block   storage block                 either, unless OUTGROWS_BLOCK
//
// The macros below take the NAME and use the access path that suits the texture; the shader declares these paths. In the form for
// graphics cards every path is a storage block, which holds the whole texture there.

#ifndef MYXO_TEXELS
#define MYXO_TEXELS

#extension GL_KHR_memory_scope_semantics : require

#include "tables.glsl"

// A texture with more texels than a texel buffer has elements is viewed four texels at once.
layout(constant_id = 100) const bool TEXELS_IN_QUADS = false;
// Textures that are written texel by texel take two views then; the number of texels of the first one.
layout(constant_id = 101) const uint BAND = 0xffffffffu;
// Textures that outgrow a storage block are written through texel buffers, which are slower on CPU drivers.
layout(constant_id = 102) const bool OUTGROWS_BLOCK = false;

#ifdef MYXO_CARD

#define texel_of(name, texel) name##_texels.at[texel]
#define quad_of(name, quad) name##_quads.at[quad]
#define store_texel(name, texel, value) { name##_low.at[texel] = (value).x; }
#define put_texel(name, texel, value) { name##_block[texel] = value; }
#define store_quad(name, quad, value) { name##_block[quad] = value; }
#define add_to_texel(name, texel, value) { atomicAdd(name##_block[texel], value); }
#define lower_texel(name, texel, value, before) uint before = atomicMin(name##_block[texel], value);
#define read_texel(name, texel, value) uint value = atomicLoad(name##_block[texel], gl_ScopeDevice, 0, 0);

#else

float texel_in(samplerBuffer view, uint texel) {
    if (TEXELS_IN_QUADS) return texelFetch(view, int(texel >> 2u))[texel & 3u];
    return texelFetch(view, int(texel)).x;
}

uint texel_in(usamplerBuffer view, uint texel) {
    if (TEXELS_IN_QUADS) return texelFetch(view, int(texel >> 2u))[texel & 3u];
    return texelFetch(view, int(texel)).x;
}

// Reads by NAME_texels, and by NAME_quads.
#define texel_of(name, texel) texel_in(name##_texels, texel)
#define quad_of(name, quad) texelFetch(name##_quads, int(quad))

// Macros, because what is written to has a format, which parameters cannot have. Each is a whole block.

// By NAME_low and NAME_high.
#define store_texel(name, texel, value) \
    { if ((texel) < BAND) { imageStore(name##_low, int(texel), value); } else { imageStore(name##_high, int((texel) - BAND), value); } }

// As store_texel, by NAME_block, or NAME_low and NAME_high.
#define put_texel(name, texel, value) \
    { if (OUTGROWS_BLOCK) { \
        if ((texel) < BAND) { imageStore(name##_low, int(texel), uvec4(value)); } else { imageStore(name##_high, int((texel) - BAND), uvec4(value)); } \
    } else { name##_block[texel] = value; } }

// By NAME_block, or NAME_quads.
#define store_quad(name, quad, value) \
    { if (OUTGROWS_BLOCK) { imageStore(name##_quads, int(quad), value); } else { name##_block[quad] = value; } }

// By NAME_block, or NAME_low and NAME_high.
#define add_to_texel(name, texel, value) \
    { if (OUTGROWS_BLOCK) { \
        if ((texel) < BAND) { imageAtomicAdd(name##_low, int(texel), value); } else { imageAtomicAdd(name##_high, int((texel) - BAND), value); } \
    } else { atomicAdd(name##_block[texel], value); } }

// The smaller of a texel and a value remains; declares `before`, what was there.
#define lower_texel(name, texel, value, before) \
    uint before; \
    { if (OUTGROWS_BLOCK) { \
        if ((texel) < BAND) { before = imageAtomicMin(name##_low, int(texel), value); } \
        else { before = imageAtomicMin(name##_high, int((texel) - BAND), value); } \
    } else { before = atomicMin(name##_block[texel], value); } }

// Declares `value`, what a texel is while others may write it. A minimum with the largest value reads: texel buffers have no simpler atomic.
#define read_texel(name, texel, value) \
    uint value; \
    { if (OUTGROWS_BLOCK) { \
        if ((texel) < BAND) { value = imageAtomicMin(name##_low, int(texel), 0xffffffffu); } \
        else { value = imageAtomicMin(name##_high, int((texel) - BAND), 0xffffffffu); } \
    } else { value = atomicLoad(name##_block[texel], gl_ScopeDevice, 0, 0); } }

#endif

#endif
