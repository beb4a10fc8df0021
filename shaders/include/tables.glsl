// tables: arrays that kernels read and write by index. On CPU drivers they are texel buffers, which those gather from at once,
// and from storage blocks value by value. In the form for graphics cards (MYXO_CARD) they are storage blocks: there a fetch of a
// texel goes through one of few texture units, and a load from a block does not.
// A shader that includes this file directly is compiled in both forms; the device decides which one runs.
// No twin: an index.
//
//   READS(uvec4, 3) strips;      uvec4, vec4, uvec2, uint, float    fetch4(strips, i), fetch2, fetch1
//   WRITES(uvec4, 4) motions;    uvec4, vec4, uint, float           store4(motions, i, value), store1
//   CHANGES(uvec4, 5) motions;   the same                           load4(motions, i), load1, and as above

#ifndef MYXO_TABLES
#define MYXO_TABLES

#ifdef MYXO_CARD

#define READS(type, number) layout(std430, set = 0, binding = number) readonly buffer Table##number { type at[]; }
#define WRITES(type, number) layout(std430, set = 0, binding = number) writeonly buffer Table##number { type at[]; }
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

#endif
