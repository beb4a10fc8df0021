// sensing: the readings of the three sensors of a particle, at the ends of walks or straight ahead in the atlas.
// Twin: src/sim/step/advance.rs.
// The includer declares the constants, parameters and buffers of advance.comp first, and includes motor.glsl.

#ifndef MYXO_SENSING
#define MYXO_SENSING

#include "tables.glsl"
#include "strip.glsl"
#include "field.glsl"
#include "distances.glsl"
#include "across.glsl"
#include "surroundings.glsl"
#include "frame.glsl"
#include "pose_table.glsl"

// Unused terms cost nothing: each optional term is compiled in or out.
layout(constant_id = 50) const bool SENSOR_NOISE = false;
layout(constant_id = 51) const bool FAVOURITE_DENSITY = false;
layout(constant_id = 52) const bool GRAVITY = false;
layout(constant_id = 53) const bool DECROWDING = false;
layout(constant_id = 54) const bool DISTANCE = false;
// Sensors read whole cells, and not between texels.
layout(constant_id = 55) const bool CELLS = false;
// How many cells a sensor reads on each side of the one that it is in.
layout(constant_id = 56) const int REACH = 0;
// Weak trail is not sensed.
layout(constant_id = 57) const bool SENSITIVITY = false;

FIELD(trail)
FIELD(bias)
FIELD(scent)

// The share of the attraction of food and markers that the particle feels.
float own_appetite;

// Height of a point along the scene's up axis, world units.
float height_at(uint triangle, float u, float v) {
    vec4 row = pose_of(shape_words(triangle).w).y;
    float a = along(row, corner_position(triangle, 0u));
    float b = along(row, corner_position(triangle, 1u));
    float c = along(row, corner_position(triangle, 2u));
    precise float height = (a + u * (b - a)) + v * (c - a);
    return height;
}

// Does this form of the shader handle other objects?
bool sees_others() {
    // In two lines because the reflection of shaders cannot evaluate && of constants alone.
    bool sees = ACROSS;
    return sees && SENSING != SENSORS_STRAIGHT && SENSING != SENSORS_WALK_LISTED;
}

// The mean of the trail on the cells round a place. Beside a cell lies its chart, or the gutter, which is as broad as sensors reach.
float trail_on_cells(vec2 position) {
    uint cell = texel_of(homes, texel_at(position, params.pitch));
    precise float sum = 0.0;
    for (int row = -REACH; row <= REACH; row++) {
        for (int column = -REACH; column <= REACH; column++) {
            sum += texel_of(trail, cell + uint(row) * params.pitch + uint(column));
        }
    }
    precise float mean = sum * params.sensor_share;
    return mean;
}

// The reading of a sensor at a place. Particles at covered places see no other object.
float sensed_at(vec2 position, uint triangle, vec2 uv, bool from_open) {
    if (sees_others()) {
        uint texel = texel_at(position, params.pitch);
        float distance = distances_of(texel);
        bool is_covered = from_open && params.deepest < distance && distance < params.transfer_threshold;
        uint beyond = is_covered ? fetch1(across, texel) : NONE;
        position = beyond == NONE ? position : unpacked_position(beyond, params.pitch);
        if (GRAVITY && beyond != NONE) {
            triangle = fetch1(across_triangles, texel);
            uv = weights_at(atlas_map_of(triangle), position);
        }
    }
    precise float value = CELLS ? trail_on_cells(position) : trail_at(position, params.pitch);
    if (SENSITIVITY && value < params.sensitivity) value = 0.0;
    // It is negative where more is better; by a favourite of 0 the emptiest place is the best.
    if (FAVOURITE_DENSITY && own.favourite_density >= 0.0) {
        value = -abs(value - own.favourite_density);
    }
    if (GRAVITY) {
        value += own.gravity_weight * height_at(triangle, uv.x, uv.y);
    }
    if (DECROWDING) {
        value -= own.decrowding_weight * float(texel_of(previous_deposits, texel_at(position, params.pitch)));
    }
    if (DISTANCE) {
        value += own.distance_weight * distance_at(position, params.pitch);
    }
    if (PAINTED) {
        value += bias_at(position, params.pitch);
    }
    if (FOOD) {
        // Repelling places also repel fed particles.
        float smelled = scent_at(position, params.pitch);
        value += smelled > 0.0 ? own_appetite * smelled : smelled;
    }
    return value;
}

// The reading of a sensor at the end of its walk.
float sensed_by_walking(StripWalk w, vec2 heading, bool from_open) {
    w.heading = heading;
    w.remaining = own.sensor_offset;
    walk_strip(w, own_attempts(), BORDER_REFLECTS);
    vec2 position = walked_position(w);
    return sensed_at(position, w.triangle, vec2(w.u, w.v), from_open);
}

// The way of a sensor in the atlas, texels.
vec2 straight_way(mat2 texels_of_axes, vec2 heading) {
    precise vec2 way = own.sensor_offset * (heading.x * texels_of_axes[0] + heading.y * texels_of_axes[1]);
    return way;
}

uint around_texel(uint texel) {
#ifdef MYXO_CARD
    return surroundings_in(fetch1(surroundings, texel >> 1u), texel);
#else
    uvec2 words = fetch2(surroundings, texel >> 2u);
    return surroundings_in((texel & 2u) == 0u ? words.x : words.y, texel);
#endif
}

uint around(vec2 position) {
    return around_texel(texel_at(position, params.pitch));
}

// The surroundings at the end of a straight path in the atlas.
uint around_end(vec2 from, vec2 way) {
    precise vec2 to = from + way;
    // No negative number and no NaN is left, so whole() would check again.
    uvec2 texel = uvec2(within(to.x, 0.0, params.last_texel), within(to.y, 0.0, params.last_texel));
    return around_texel(texel.y * params.pitch + texel.x);
}

// Three independent normal numbers (Box and Muller 1958).
vec3 normals(uvec4 words) {
    // 1 - x lies in (0, 1], so the logarithm is finite.
    precise float share_1 = 1.0 - unit_float(words.x);
    precise float share_2 = 1.0 - unit_float(words.z);
    precise float square_1 = -2.0 * logarithm(share_1);
    precise float square_2 = -2.0 * logarithm(share_2);
    vec2 turn_1 = turn_of(words.y);
    vec2 turn_2 = turn_of(words.w);
    precise vec2 first = root(square_1) * turn_1;
    precise float third = root(square_2) * turn_2.x;
    return vec3(first, third);
}

vec2 rotated(vec2 heading, float c, float s) {
    precise vec2 result = vec2(c * heading.x - s * heading.y, s * heading.x + c * heading.y);
    return result;
}

// The headings of the sensors beside the middle one.
vec2 left_of(vec2 heading) {
    return rotated(heading, own.sensor_cos, own.sensor_sin);
}

vec2 right_of(vec2 heading) {
    return rotated(heading, own.sensor_cos, -own.sensor_sin);
}

#endif
