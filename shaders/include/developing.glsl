// developing: pixels as words of four bytes, with the alpha in the highest, in rows of whole fours of pixels.
// Red and blue may change places, as formats of windows do: all work on them is the same.

#ifndef MYXO_DEVELOPING
#define MYXO_DEVELOPING

const float PER_BYTE = 1.0 / 255.0;

vec3 bytes_of(uint word) {
    return vec3(word & 255u, word >> 8u & 255u, word >> 16u & 255u);
}

// How bright a pixel looks, 0 to 1,020.
int brightness_of(uint word) {
    return int((word & 255u) + 2u * (word >> 8u & 255u) + (word >> 16u & 255u));
}

// Light that is added behind glass: white stays white. From bytes to bytes; `noise` is below half a step, so that pixels without bloom keep
// their bytes.
uint with_bloom(vec3 seen, uint alpha, vec3 bloom, float noise) {
    precise vec3 dark = 255.0 - seen;
    precise vec3 gain = dark * bloom;
    precise vec3 sum = seen + gain;
    precise vec3 steps = sum + noise;
    precise vec3 rounded = steps + 0.5;
    uvec3 result = min(uvec3(rounded), uvec3(255u));
    // Beyond the edge of an object the bloom has to cover what will be behind it, in pictures without a background.
    float most = max(bloom.x, max(bloom.y, bloom.z));
    precise float clear = 255.0 - float(alpha);
    precise float cover = clear * most;
    precise float covered = float(alpha) + cover;
    precise float whole_alpha = covered + 0.5;
    return result.x | result.y << 8u | result.z << 16u | min(uint(whole_alpha), 255u) << 24u;
}

// From -0.45 to 0.45 steps, by integers, and different in each pixel: bloom shows no bands (a Weyl sequence in two dimensions, Roberts 2018).
float noise_of(uint x, uint y) {
    uint word = x * 3242174889u + y * 2447445414u;
    precise float share = float(word >> 16u) * (0.9 / 65536.0);
    precise float result = share - 0.45;
    return result;
}

// A part of the way from one to another.
vec3 part_way(vec3 from, vec3 to, float part) {
    precise vec3 way = to - from;
    precise vec3 step = way * part;
    precise vec3 result = from + step;
    return result;
}

#endif
