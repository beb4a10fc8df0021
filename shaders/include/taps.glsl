// taps: where in the atlas a pixel of a triangle reads, and interpolation between four texels.
// The includer has `params` with `size` and `pitch`.

#ifndef MYXO_TAPS
#define MYXO_TAPS

// Four texels, of the row above and then of the one below, and the share of the right and of the lower ones.
struct Taps { uvec4 texels; vec2 weight; };

// The texels round a position. Inside a triangle these are its own or gutter texels, which are filled.
Taps taps_at(vec2 texel) {
    vec2 q = texel - 0.5;
    vec2 corner = floor(q);
    ivec2 last = ivec2(int(params.size) - 1);
    ivec2 low = clamp(ivec2(corner), ivec2(0), last);
    ivec2 high = min(low + 1, last);
    int row_low = low.y * int(params.pitch);
    int row_high = high.y * int(params.pitch);
    return Taps(uvec4(row_low + low.x, row_low + high.x, row_high + low.x, row_high + high.x), q - corner);
}

float between(vec4 values, vec2 weight) {
    return mix(mix(values.x, values.y, weight.x), mix(values.z, values.w, weight.x), weight.y);
}

// Its slope there, per texel, to the right and downwards.
vec2 growth(vec4 values, vec2 weight) {
    return vec2(
        mix(values.y - values.x, values.w - values.z, weight.y),
        mix(values.z - values.x, values.w - values.y, weight.x));
}

#endif
