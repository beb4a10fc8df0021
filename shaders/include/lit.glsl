// lit: the light from a place of the surface to the eye, with the trail on it.
// The includer has `params` with `eye`, `key_direction`, `trail_share`, `lamp`, `glow`, `wetness`, `occlusion` and `reach`, the varying
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

// The normal on which the trail stands up from the surface, from the change of its height to the right and down the picture, per pixel
// (Mikkelsen, "Bump Mapping Unparametrized Surfaces on the GPU", 2010). Its slope is limited, so that no wall of a vein is vertical.
vec3 raised(vec3 n, vec2 rises) {
    vec3 right = dFdx(position);
    vec3 down = dFdy(position);
    vec3 across_right = cross(down, n);
    vec3 across_down = cross(n, right);
    float area = dot(right, across_right);
    vec3 steepest = (rises.x * across_right + rises.y * across_down) * (area < 0.0 ? -1.0 : 1.0);
    float size = max(abs(area), 1e-20);
    float steepness = length(steepest) / size;
    return normalize(n - steepest / (size * (1.0 + 0.8 * steepness)));
}

// The changes from pixel to pixel, of what changes by twice `steep` between the first two of four places, and by twice `level` between the
// others; the places are an eighth and three eighths of a pixel, times `reach`, from the middle.
vec2 changes_of(float steep, float level, float reach) {
    return vec2(0.125 * steep + 0.375 * level, 0.375 * steep - 0.125 * level) * (3.2 / reach);
}

// The share of reflections that is shown; colours that mean something need to be seen without.
float shine = 1.0;

// `smooth_normal` is that of the bare surface, `outwards` the one on which the trail stands up.
vec4 lit(float trail_value, vec3 bare, vec3 smooth_normal, vec3 outwards, float open) {
    vec3 n = gl_FrontFacing ? outwards : -outwards;
    vec3 to_eye = normalize(params.eye - position);
    // What is reflected does not get to what is under the skin. It also dims trails at the edge of an object, where a pixel covers so many
    // texels that they would sparkle.
    float under = 1.0 - 0.85 * grazing_share(gl_FrontFacing ? smooth_normal : -smooth_normal, to_eye);
    float brightness = params.trail_share * tone_of_any(trail_value, brightest[0]);
    vec4 trail_color = color_of(brightness);
    // Where many veins meet there is more than the brightest colour: more light, which the film curve turns white.
    vec3 trail_light = trail_color.rgb * (1.0 + 1.6 * max(brightness - 1.0, 0.0));
    vec3 matte = bare * (1.0 - trail_color.a) + trail_light;
    float left = 1.0 - params.occlusion * (1.0 - open);
    float wet = params.wetness * (0.55 + 0.45 * trail_color.a);
    vec3 light = params.lamp * (under * matte * diffuse_light(n, params.key_direction, left)
            + shine * left * specular_light(n, to_eye, params.key_direction, wet))
        + params.glow * under * trail_light;
    return exposed(light, gl_FragCoord.xy);
}

#endif
