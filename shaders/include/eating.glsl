// eating: a particle on food. Twin of `fed_at` in src/sim/step/advance.rs.
// The includer declares `plates`, `meals` and `params.fed_steps` first.

#ifndef MYXO_EATING
#define MYXO_EATING

#include "texels.glsl"

// The remaining fed steps of a particle that has reached a texel and had `fed` steps remaining. Hungry particles eat where there is food,
// even if there are more of them in one step than the food feeds, so that their order cannot matter.
uint fed_at(uint texel, uint fed) {
    fed -= min(fed, 1u);
    uint plate = texel_of(plates, texel);
    uint food = max(plate, 1u) - 1u;
    if (fed == 0u && plate != 0u && meals[food].remaining != 0u) {
        atomicAdd(meals[food].eaten, 1u);
        fed = params.fed_steps;
    }
    return fed;
}

#endif
