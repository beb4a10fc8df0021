// eating: a particle on food. Twin of `Arriving` in src/sim/step/advance.rs.
// The includer declares the constant HUNGER, `plates`, `meals` and `params.fed_steps` first.

#ifndef MYXO_EATING
#define MYXO_EATING

#include "texels.glsl"
#include "ring.glsl"

// The flags of a particle that has reached a texel and had the flags `before`: for how many steps it stays fed, or has been hungry. Hungry
// particles eat where there is food, even if there are more of them in one step than the food feeds, so that their order cannot matter.
uint fed_flags(uint texel, uint before) {
    uint fed = before >> FED_SHIFT;
    fed -= min(fed, 1u);
    uint hungry = fed == 0u ? min(hungry_steps(before) + 1u, MOST_HUNGRY) : 0u;
    uint plate = texel_of(plates, texel);
    uint food = max(plate, 1u) - 1u;
    if (fed == 0u && plate != 0u && meals[food].remaining != 0u) {
        atomicAdd(meals[food].eaten, 1u);
        fed = params.fed_steps;
        hungry = 0u;
    }
    uint flags = fed << FED_SHIFT;
    if (HUNGER) flags |= hungry << HUNGRY_SHIFT;
    return flags;
}

#endif
