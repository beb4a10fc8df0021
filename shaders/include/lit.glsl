// lit: the light from a place of the surface to the eye, with the trail on it.
// The includer has `params` with `eye`, `key_direction`, `trail_share`, `lamp`, `glow`, `occlusion` and `reach`, the varying
// `position`, `colors`, `brightest` and `distances`, and includes shading.glsl, colormap.glsl and taps.glsl first.

#ifndef MYXO_LIT
#define MYXO_LIT

#include "texels.glsl"

// The share of the sky that the nearest other object does not hide.
float open_beside_others(vec2 texel) {
    if (params.reach == 0.0) return 1.0;
    Taps taps = taps_at(texel);
    vec4 there = vec4(
        texel_of(distances, taps.texels.x), texel_of(distances, taps.texels.y),
        texel_of(distances, taps.texels.z), texel_of(distances, taps.texels.w));
    return open_at(between(there, taps.weight), params.reach);
}

vec4 lit(float trail_value, vec3 bare, vec3 outwards, float open) {
    vec3 n = gl_FrontFacing ? outwards : -outwards;
    vec3 to_eye = normalize(params.eye - position);
    float brightness = params.trail_share * tone(trail_value, brightest[0]);
    vec4 trail_color = color_of(brightness);
    vec3 matte = bare * (1.0 - trail_color.a) + trail_color.rgb;
    float left = 1.0 - params.occlusion * (1.0 - open);
    vec3 light = params.lamp * (matte * diffuse_light(n, params.key_direction, left)
            + left * specular_light(n, to_eye, params.key_direction))
        + params.glow * trail_color.rgb;
    return vec4(dithered(light, gl_FragCoord.xy), 1.0);
}

#endif
