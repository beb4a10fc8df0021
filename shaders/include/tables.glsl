// tables: arrays that kernels read and write by index. On CPU drivers they are texel buffers, which such drivers gather from in one
// operation; from storage blocks they read value by value. In the form for graphics cards (MYXO_CARD) they are storage blocks: there texel
// fetches share few texture units, and loads from a block do not. A shader that includes this file directly is compiled in both forms; the
// device decides which one runs. No twin: an index.
//
//   READS(uvec4, 3) strips;      uvec4, vec4, uvec2, uint, float    fetch4(strips, i), fetch2, fetch1
//   WRITES(uvec4, 4) motions;    uvec4, vec4, uint, float           store4(motions, i, value), store1
//   CHANGES(uvec4, 5) motions;   the same                           load4(motions, i), load1, and as above
//
// Tables of particles may outgrow a block. They are declared by names of their own:
//
//   PAGED_READS(uvec4, 0) particles;      fetch_paged(particles, i)
//   PAGED_WRITES(uvec4, 1) motions;       write_paged(motions, i, value)
//   PAGED_CHANGES(uvec4, 1) motions;      load_paged(motions, i), store_paged(motions, i, value)
//
// In the form for pages (MYXO_PAGES), which exists in addition for shaders that use these names, such a table lies in pages of equally many
// elements, a power of two; the block has their addresses. Elsewhere it is a table as any other, with one exception: PAGED_WRITES are
// storage blocks in the plain form, too, because CPU drivers store faster into blocks. In the form for large tables (MYXO_LARGE), which
// shaders with PAGED_WRITES have in addition, they are texel buffers, because the tables are larger than a block. Otherwise that form is
// the plain one.

#ifndef MYXO_TABLES
#define MYXO_TABLES

#define BLOCK_WRITES(type, number) layout(std430, set = 0, binding = number) writeonly buffer Table##number { type at[]; }

#ifdef MYXO_CARD

#define READS(type, number) layout(std430, set = 0, binding = number) readonly buffer Table##number { type at[]; }
#define WRITES(type, number) BLOCK_WRITES(type, number)
#define CHANGES(type, number) layout(std430, set = 0, binding = number) buffer Table##number { type at[]; }

#define fetch4(table, i) table.at[i]
#define fetch2(table, i) table.at[i]
#define fetch1(table, i) table.at[i]
#define load4(table, i) table.at[i]
#define load1(table, i) table.at[i]
#define store4(table, i, value) table.at[i] = value
#define store1(table, i, value) table.at[i] = value

#else

#define READS(type, number) layout(set = 0, binding = number) uniform READ_##type
#define WRITES(type, number) layout(FORMAT_##type, set = 0, binding = number) uniform writeonly WRITTEN_##type
#define CHANGES(type, number) layout(FORMAT_##type, set = 0, binding = number) uniform WRITTEN_##type

#define READ_uvec4 usamplerBuffer
#define READ_uvec2 usamplerBuffer
#define READ_uint usamplerBuffer
#define READ_vec4 samplerBuffer
#define READ_float samplerBuffer
#define WRITTEN_uvec4 uimageBuffer
#define WRITTEN_uint uimageBuffer
#define WRITTEN_vec4 imageBuffer
#define WRITTEN_float imageBuffer
#define FORMAT_uvec4 rgba32ui
#define FORMAT_uint r32ui
#define FORMAT_vec4 rgba32f
#define FORMAT_float r32f

#define fetch4(table, i) texelFetch(table, int(i))
#define fetch2(table, i) texelFetch(table, int(i)).xy
#define fetch1(table, i) texelFetch(table, int(i)).x
#define load4(table, i) imageLoad(table, int(i))
#define load1(table, i) imageLoad(table, int(i)).x
#define store4(table, i, value) imageStore(table, int(i), value)
#define store1(table, i, value) imageStore(table, int(i), uvec4(value))

#endif

#ifdef MYXO_PAGES

#extension GL_EXT_buffer_reference : require

// log2 of a page's elements, a mask of the bits that count within a page, the pages. The build fixes their number by MYXO_PAGES, because
// arrays of references without a fixed size need more device features.
#define PAGED(access, type, number) \
    layout(buffer_reference, std430, buffer_reference_align = 16) access buffer Page##number { type at[]; }; \
    layout(std430, set = 0, binding = number) readonly buffer Pages##number { uint shift; uint mask; Page##number page[MYXO_PAGES]; }
#define PAGED_READS(type, number) PAGED(readonly, type, number)
#define PAGED_WRITES(type, number) PAGED(writeonly, type, number)
#define PAGED_CHANGES(type, number) PAGED(, type, number)

#define element_of(table, i) table.page[uint(i) >> table.shift].at[uint(i) & table.mask]
#define fetch_paged(table, i) element_of(table, i)
#define load_paged(table, i) element_of(table, i)
#define store_paged(table, i, value) element_of(table, i) = value
#define write_paged(table, i, value) element_of(table, i) = value

#else

#define PAGED_READS(type, number) READS(type, number)
#define PAGED_CHANGES(type, number) CHANGES(type, number)
#define fetch_paged(table, i) fetch4(table, i)
#define load_paged(table, i) load4(table, i)
#define store_paged(table, i, value) store4(table, i, value)

#ifdef MYXO_LARGE
#define PAGED_WRITES(type, number) WRITES(type, number)
#define write_paged(table, i, value) store4(table, i, value)
#else
#define PAGED_WRITES(type, number) BLOCK_WRITES(type, number)
#define write_paged(table, i, value) table.at[i] = value
#endif

#endif

#endif
