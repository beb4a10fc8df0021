// debug: lets a kernel send values to the host: debug_value(tag, value) with any tag and a uint, an int or a float.
// Including it is enough; the recorder binds the list, and Context::debug_entries returns the values.
// Values past the list's capacity are only counted. Remove the include when done: it costs a barrier per dispatch.

#ifndef MYXO_DEBUG
#define MYXO_DEBUG

struct myxo_debug_entry { uint dispatch; uint invocation; uint tag; uint kind; uint bits; };

layout(std430, binding = 31) buffer myxo_debug {
    uint myxo_debug_count;
    uint myxo_debug_capacity;
    uint myxo_debug_dispatch;
    uint myxo_debug_pad0;
    myxo_debug_entry myxo_debug_entries[];
};

void myxo_debug_push(uint invocation, uint tag, uint kind, uint bits) {
    uint slot = atomicAdd(myxo_debug_count, 1u);
    if (slot >= myxo_debug_capacity) return;
    myxo_debug_entries[slot] = myxo_debug_entry(myxo_debug_dispatch, invocation, tag, kind, bits);
}

void myxo_debug_typed(uint invocation, uint tag, uint value) { myxo_debug_push(invocation, tag, 0u, value); }
void myxo_debug_typed(uint invocation, uint tag, int value) { myxo_debug_push(invocation, tag, 1u, uint(value)); }
void myxo_debug_typed(uint invocation, uint tag, float value) { myxo_debug_push(invocation, tag, 2u, floatBitsToUint(value)); }

#if defined(MYXO_COMPUTE)
#include "index.glsl"
#define MYXO_DEBUG_INVOCATION invocation_index()
#elif defined(MYXO_VERTEX)
#define MYXO_DEBUG_INVOCATION uint(gl_VertexIndex)
#else
// Row in the upper half, column in the lower.
#define MYXO_DEBUG_INVOCATION (uint(gl_FragCoord.y) << 16 | uint(gl_FragCoord.x))
#endif

#define debug_value(tag, value) myxo_debug_typed(MYXO_DEBUG_INVOCATION, tag, value)

#endif
