// arriving: what a particle does where it has come to: it eats, deposits, and is selected where it enters another object.
// Twin of `Arrival` in src/sim/step/advance.rs.
// The includer declares the constants FOOD, HUNGER and SELECTS, the parameters and the buffers that follow here, and includes motor.glsl or
// declares what it needs of it.

#ifndef MYXO_ARRIVING
#define MYXO_ARRIVING

#include "tables.glsl"
#include "texels.glsl"
#include "atlas.glsl"
#include "distances.glsl"
#include "append.glsl"
#include "ring.glsl"
#include "eating.glsl"

// Bound on the rounding of a distance.
const float ROUNDING = 1.0e-6;

// A particle that has come to a texel and had the flags `before` eats and deposits; its flags.
uint arrived_flags(uint texel, uint before) {
    uint flags = 0u;
    if (FOOD) flags = fed_flags(texel, before);
    uint fed = flags >> FED_SHIFT;
    uint deposit = fed == 0u ? 1u : params.fed_deposit;
    add_to_texel(deposits, texel, deposit)
    return flags;
}

// A particle that has entered another object is listed, by slot; its flag.
uint selected_flag(vec2 position, uint slot) {
    float now = distance_at(position, params.pitch);
    float before = distance_at(previous_position(), params.pitch);
    // Gutter values are rounded, so the distances beyond reach, which are equal, may seem to change.
    precise float less = before - ROUNDING * abs(before);
    if (now < params.transfer_threshold && now < less) {
        append_to(flow[0].wanted, place)
        if (place < params.transfer_capacity) particle_indices[place] = slot;
        return SELECTED;
    }
    return 0u;
}

// The flags of a particle that has come to a place and had the flags `before`, by slot; `is_far` if it cannot have entered another
// object.
uint flags_at(vec2 position, uint slot, uint before, bool is_far) {
    uint flags = arrived_flags(texel_at(position, params.pitch), before);
    if (SELECTS && !is_far) flags |= selected_flag(position, slot);
    return flags;
}

#endif
