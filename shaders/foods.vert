// foods: a low dome on the surface for each food and marker; of food that is eaten, a smaller one.
// Reads   marks, meals, poses.
// Writes  the corner's place and normal, and its colour.
// SIDES * RINGS * 6 invocations an instance, which is a food.
// Overflow: cannot happen; the draw has one instance for each mark.
#version 460
#include "types.glsl"
#include "shading.glsl"
#include "foods.glsl"

layout(set = 0, binding = 0) readonly buffer Marks { Mark marks[]; };
layout(set = 0, binding = 1) readonly buffer Meals { Meal meals[]; };
layout(set = 0, binding = 2) readonly buffer Poses { Pose poses[]; };

layout(location = 0) out vec3 position;
layout(location = 1) out vec3 normal;
layout(location = 2) flat out vec3 albedo;

// src/render/renderer/foods.rs draws as many.
const uint SIDES = 20u;
const uint RINGS = 8u;
// Its height, as a share of its radius.
const float HEIGHT = 0.5;
// The radius of a crumb, which remains when all is eaten, as a share of that of the whole.
const float CRUMB = 0.22;

const vec3 OAT = vec3(0.80, 0.62, 0.34);
const vec3 STALE = vec3(0.11, 0.09, 0.07);
const vec3 LURE = vec3(0.10, 0.75, 0.30);
const vec3 SCARE = vec3(0.95, 0.35, 0.05);

void main() {
    uint corner = uint(gl_VertexIndex) % 6u;
    uint patch_of = uint(gl_VertexIndex) / 6u;
    uint side = patch_of % SIDES + uint(corner == 1u || corner == 2u || corner == 4u);
    uint ring = patch_of / SIDES + uint(corner == 2u || corner == 4u || corner == 5u);
    float turn = 6.28318531 * float(side) / float(SIDES);
    float rise = 3.14159265 * (float(ring) / float(RINGS) - 0.5);
    vec3 unit = vec3(cos(rise) * cos(turn), cos(rise) * sin(turn), sin(rise));

    Mark mark = marks[gl_InstanceIndex];
    Meal meal = meals[gl_InstanceIndex];
    float left = meal.amount == 0u ? 1.0 : float(meal.remaining) / float(meal.amount);
    bool is_food = mark.is_food != 0u;
    float radius = mark.radius * (is_food ? mix(CRUMB, 1.0, sqrt(left)) : 1.0);
    vec3 along = normalize(abs(mark.normal.x) < 0.7 ? cross(mark.normal, vec3(1.0, 0.0, 0.0)) : cross(mark.normal, vec3(0.0, 1.0, 0.0)));
    vec3 across = cross(mark.normal, along);
    vec3 from_middle = radius * (unit.x * along + unit.y * across + HEIGHT * unit.z * mark.normal);
    vec3 outward = normalize(unit.x * along + unit.y * across + unit.z / HEIGHT * mark.normal);
    Pose pose = poses[mark.object];
    position = place_in_world(pose, mark.position + from_middle);
    normal = turn_to_world(pose, outward);
    albedo = is_food ? mix(STALE, OAT, left > 0.0 ? 0.35 + 0.65 * left : 0.0) : (meal.strength < 0.0 ? SCARE : LURE);
    gl_Position = params.clip_from_world * vec4(position, 1.0);
}
