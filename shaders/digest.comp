// digest: subtracts from each food the amount eaten in the step, and updates the strength of its scent.
// Reads   meals.
// Writes  meals; the group count of the scent dispatch, if any scent has changed.
// One invocation per food.
// Scents fall in discrete steps, so that the field is rarely summed up again, and a resumed run has the same field.
// Overflow: cannot happen; the remaining amount is never negative.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "index.glsl"

layout(local_size_x = 64) in;

layout(push_constant) uniform Params {
    uint food_count;
    uint scented_count;  // texels with any scent
    uint scent_group;    // invocations in a group of scent
} params;

// Levels of a scent. MOST_AMOUNT in src/sim/food.rs keeps the product below 2^32.
const uint LEVELS = 64u;

layout(std430, set = 0, binding = 0) buffer Meals { Meal meals[]; };  // one an invocation
layout(std430, set = 0, binding = 1) buffer Groups { DispatchGroups groups[]; };

void main() {
    uint i = invocation_index();
    if (i >= params.food_count) return;
    Meal meal = meals[i];
    uint eaten = meal.eaten;
    meals[i].eaten = 0u;
    // Endless food always has a meal left.
    if (meal.amount == 0u || eaten == 0u) return;
    uint remaining = meal.remaining - min(meal.remaining, eaten);
    uint level = (LEVELS * remaining + (meal.amount - 1u)) / meal.amount;
    precise float scent = meal.strength * (float(level) * (1.0 / float(LEVELS)));
    meals[i].remaining = remaining;
    meals[i].level = level;
    meals[i].scent = scent;
    if (level != meal.level) {
        DispatchGroups all = dispatch_groups(params.scented_count, params.scent_group);
        atomicMax(groups[0].x, all.x);
        atomicMax(groups[0].y, all.y);
    }
}
