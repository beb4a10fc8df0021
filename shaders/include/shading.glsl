// shading: the light on all objects, and other functions for pictures: poses, packed normals, dither.
// All colours are linear light; the format of the image that is drawn to encodes them to sRGB.

#ifndef MYXO_SHADING
#define MYXO_SHADING

#include "types.glsl"

// The material under the trail: dark, neutral, a little cool.
const vec3 BARE = vec3(0.021, 0.022, 0.025);
// The material in the relief view, which must be light for shadows to be seen.
const vec3 CLAY = vec3(0.135, 0.128, 0.120);

// Three lights: a warm key from beside the camera, a dome that is brighter above, and a cool rim from behind.
const vec3 KEY = vec3(1.00, 0.96, 0.90) * 0.80;
const vec3 DOME_ABOVE = vec3(0.30, 0.33, 0.38);
const vec3 DOME_BELOW = vec3(0.09, 0.085, 0.08);
const vec3 RIM = vec3(0.36, 0.42, 0.52);

// sRGB to linear light.
vec3 light_of(vec3 seen) {
    vec3 steep = pow((seen + 0.055) / 1.055, vec3(2.4));
    return mix(steep, seen / 12.92, lessThan(seen, vec3(0.04045)));
}

vec3 place_in_world(Pose pose, vec3 position_in_object) {
    vec4 p = vec4(position_in_object, 1.0);
    return vec3(dot(pose.x, p), dot(pose.y, p), dot(pose.z, p));
}

vec3 turn_to_world(Pose pose, vec3 direction_in_object) {
    return vec3(dot(pose.x.xyz, direction_in_object), dot(pose.y.xyz, direction_in_object), dot(pose.z.xyz, direction_in_object));
}

// Inverse of `pack_normal` in src/render/normals.rs.
vec3 unpack_normal(uint bits) {
    vec2 side = unpackSnorm2x16(bits);
    vec3 normal = vec3(side, 1.0 - abs(side.x) - abs(side.y));
    float below = max(-normal.z, 0.0);
    normal.x -= side.x < 0.0 ? -below : below;
    normal.y -= side.y < 0.0 ? -below : below;
    return normalize(normal);
}

// Light that a matte surface of white colour sends back; half of the key wraps round the terminator, as it does
// in everything that is a little translucent. If only the share `open` of the sky is visible, the dome is darker, and the key, which is
// large, half as much.
vec3 diffuse_light(vec3 normal, vec3 key_direction, float open) {
    const float wrap = 0.25;
    float key = max((dot(normal, key_direction) + wrap) / (1.0 + wrap), 0.0);
    return KEY * (key * key * (0.5 + 0.5 * open)) + open * mix(DOME_BELOW, DOME_ABOVE, 0.5 + 0.5 * normal.y);
}

// The share of the sky that is seen at a distance from another object; `reach` is the distance of far places.
float open_at(float from_other, float reach) {
    return 1.0 - 0.85 * exp(-4.5 * max(from_other, 0.0) / reach);
}

// A colour of this hue, in turns from red by way of yellow, green and blue; all hues are equally light.
// Twin of `hue_light` in src/render/hues.rs; OKLab to light by Ottosson's matrices (2020).
vec3 hue_light(float turn) {
    float angle = 6.28318531 * turn + 0.5;
    vec2 ab = 0.125 * vec2(cos(angle), sin(angle));
    vec3 roots = vec3(
        0.75 + 0.3963377774 * ab.x + 0.2158037573 * ab.y,
        0.75 - 0.1055613458 * ab.x - 0.0638541728 * ab.y,
        0.75 - 0.0894841775 * ab.x - 1.2914855480 * ab.y);
    vec3 lms = roots * roots * roots;
    return clamp(vec3(
        4.0767416621 * lms.x - 3.3077115913 * lms.y + 0.2309699292 * lms.z,
        -1.2684380046 * lms.x + 2.6097574011 * lms.y - 0.3413193965 * lms.z,
        -0.0041960863 * lms.x - 0.7034186147 * lms.y + 1.7076147010 * lms.z), 0.0, 1.0);
}

// The light of a damp skin: a soft highlight of the key, and the rim light at grazing angles.
// The highlight is Blinn and Phong's, normalized, with Schlick's Fresnel term for water (0.02).
vec3 specular_light(vec3 normal, vec3 to_eye, vec3 key_direction) {
    const float sharpness = 60.0;
    vec3 halfway = normalize(key_direction + to_eye);
    float lobe = pow(max(dot(normal, halfway), 0.0), sharpness) * (sharpness + 8.0) / 8.0;
    float facing = clamp(dot(normal, to_eye), 0.0, 1.0);
    float grazing = (1.0 - facing) * (1.0 - facing);
    grazing *= grazing;
    float fresnel = 0.02 + 0.98 * grazing * (1.0 - facing);
    float key = max(dot(normal, key_direction), 0.0);
    return KEY * (0.02 * lobe * key) + RIM * (fresnel * (0.45 + 0.55 * normal.y) * 0.5);
}

// Half a step of an 8-bit image of noise, which keeps smooth gradients from showing bands.
// Interleaved gradient noise (Jimenez, "Next Generation Post Processing in Call of Duty", 2014), applied where steps are
// even: to the square root of light, which is nearly sRGB's curve.
vec3 dithered(vec3 color, vec2 pixel) {
    float noise = fract(52.9829189 * fract(dot(pixel, vec2(0.06711056, 0.00583715)))) - 0.5;
    vec3 root = max(sqrt(max(color, vec3(0.0))) + noise * (1.0 / 255.0), vec3(0.0));
    return root * root;
}

#endif
