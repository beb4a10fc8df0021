// shading: the light on all objects, and other functions for pictures: poses, packed normals, dither.
// All colours are linear light; the format of the image that is drawn to encodes them to sRGB.

#ifndef MYXO_SHADING
#define MYXO_SHADING

#include "types.glsl"

// The material under the trail: dark, neutral, a little cool.
const vec3 BARE = vec3(0.014, 0.015, 0.017);
// The material in the relief view, which must be light for shadows to be seen.
const vec3 CLAY = vec3(0.135, 0.128, 0.120);

// How far from the middle of a pixel its trail is read at least, texels, and at most, against a pixel of its own size.
const float LEAST_REACH = 0.55;
const float MOST_REACH = 8.0;

// A warm key from beside the camera, a dome that is bright and cool above and dark and warm below, and a cool rim from behind.
const vec3 KEY = vec3(1.00, 0.89, 0.74) * 1.00;
const vec3 DOME_ABOVE = vec3(0.27, 0.32, 0.40);
const vec3 DOME_BELOW = vec3(0.085, 0.075, 0.068);
const vec3 RIM = vec3(0.34, 0.50, 0.80);

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

// Where the rim light comes from: behind the objects, opposite to the key, and above.
vec3 rim_direction(vec3 key_direction) {
    return normalize(vec3(-key_direction.x, 0.55, -key_direction.z));
}

// The light of the room that a mirror sees in a direction: a studio with a large warm softbox at the key, a tall cool one behind, and a
// ceiling that is lighter than the floor. It is the environment map, as a function.
vec3 room_light(vec3 direction, vec3 key_direction) {
    float beside = dot(direction, key_direction);
    float softbox = smoothstep(0.78, 0.95, beside) * (0.55 + 0.45 * smoothstep(0.85, 1.0, beside));
    float strip = smoothstep(0.55, 0.90, dot(direction, rim_direction(key_direction)));
    float up = 0.5 + 0.5 * direction.y;
    return 2.6 * softbox * KEY + 1.3 * strip * RIM + mix(0.25 * DOME_BELOW, 0.8 * DOME_ABOVE, up * up);
}

// From 0 where a surface is seen from above to 1 where it is seen along itself (Schlick, 1994).
float grazing_share(vec3 normal, vec3 to_eye) {
    float away = 1.0 - clamp(dot(normal, to_eye), 0.0, 1.0);
    float squared = away * away;
    return squared * squared * away;
}

// What a skin of water reflects, from dry (0) to wet (1), by Schlick's Fresnel term. Dry skin reflects a blurred room, which is the dome.
vec3 specular_light(vec3 normal, vec3 to_eye, vec3 key_direction, float wet) {
    float fresnel = mix(0.015, 0.045, wet) + 0.55 * grazing_share(normal, to_eye);
    vec3 mirrored = reflect(-to_eye, normal);
    vec3 blurred = mix(DOME_BELOW, DOME_ABOVE, 0.5 + 0.5 * mirrored.y) + 0.5 * RIM * max(dot(normal, rim_direction(key_direction)), 0.0);
    return fresnel * mix(blurred, room_light(mirrored, key_direction), 0.35 + 0.65 * wet);
}

// The film curve: light up to 0.6 stays as it is, more is pressed below 1, and what is far too bright turns white, as on film. The shoulder
// keeps slope and hue at its beginning (after the Khronos PBR Neutral tone mapper, 2024).
vec3 film(vec3 light) {
    const float straight = 0.6;
    float most = max(light.x, max(light.y, light.z));
    float over = max(most - straight, 0.0) / (1.0 - straight);
    float pressed = most > straight ? straight + (1.0 - straight) * over / (1.0 + over) : most;
    vec3 hue = light * (pressed / max(most, 1e-6));
    float white = 1.0 - 1.0 / (0.30 * max(most - pressed, 0.0) + 1.0);
    return mix(hue, vec3(pressed), white);
}

// Half a step of an 8-bit image of noise, which keeps smooth gradients from showing bands.
// Interleaved gradient noise (Jimenez, "Next Generation Post Processing in Call of Duty", 2014), applied where steps are
// even: to the square root of light, which is nearly sRGB's curve.
vec3 dithered(vec3 color, vec2 pixel) {
    float noise = fract(52.9829189 * fract(dot(pixel, vec2(0.06711056, 0.00583715)))) - 0.5;
    vec3 root = max(sqrt(max(color, vec3(0.0))) + noise * (1.0 / 255.0), vec3(0.0));
    return root * root;
}

// A lit pixel, through the film curve. Light that is not a number, or without end, is not shown: its pixel is black, and the alpha marks
// it, so that it is counted.
vec4 exposed(vec3 light, vec2 pixel) {
    bool is_light = all(lessThan(abs(light), vec3(1e30)));
    return is_light ? vec4(dithered(film(light), pixel), 1.0) : vec4(0.0);
}

#endif
