// looks: parameters of particles between those of two looks. Twin of src/sim/looks.rs.

#ifndef MYXO_LOOKS
#define MYXO_LOOKS

#include "types.glsl"
#include "vectors.glsl"

float between(float one, float other, float weight) {
    precise float result = one + weight * (other - one);
    return result;
}

vec2 turn_between(vec2 one, vec2 other, float weight) {
    return direction_or(vec2(between(one.x, other.x, weight), between(one.y, other.y, weight)), one);
}

// Those of one look at the weight 0, those of the other at 1.
Physarum mixed_look(Physarum one, Physarum other, float weight) {
    if (weight <= 0.0) return one;
    vec2 sensor = turn_between(vec2(one.sensor_cos, one.sensor_sin), vec2(other.sensor_cos, other.sensor_sin), weight);
    vec2 rotation = turn_between(vec2(one.rotation_cos, one.rotation_sin), vec2(other.rotation_cos, other.rotation_sin), weight);
    // Without a favourite density more is better; there is nothing between.
    bool both = one.favourite_density >= 0.0 && other.favourite_density >= 0.0;
    float nearer = weight < 0.5 ? one.favourite_density : other.favourite_density;
    float favourite = both ? between(one.favourite_density, other.favourite_density, weight) : nearer;
    return Physarum(
        between(one.speed, other.speed, weight),
        between(one.sensor_offset, other.sensor_offset, weight),
        sensor.x,
        sensor.y,
        rotation.x,
        rotation.y,
        between(one.sensor_noise, other.sensor_noise, weight),
        favourite,
        between(one.gravity_weight, other.gravity_weight, weight),
        between(one.decrowding_weight, other.decrowding_weight, weight),
        between(one.distance_weight, other.distance_weight, weight),
        one.attempts);
}

#endif
