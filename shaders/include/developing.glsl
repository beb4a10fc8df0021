// developing: pixels as words of four bytes, with the alpha in the highest, in rows of whole fours of pixels.
// Red and blue may change places, as formats of windows do: all work on them is the same.
// Include it after strict.glsl.

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

// How bright a share of white light looks, 0 to 1: the curve of sRGB, within 0.024.
float seen_of(float light) {
    float edge = root(light);
    precise float up = 1.1 * edge;
    precise float down = 0.1 * light;
    precise float result = up - down;
    return result;
}

// Light that is added behind glass: white stays white. From bytes to bytes; `noise` is below half a step, so that pixels without bloom
// keep their bytes. In pictures without a background pixels may be clear, and their light is multiplied by alpha: what a pixel covers
// stays below white of its alpha, and beside that the bloom covers what will be behind it, in its brightest colour, so that the picture
// over black is the opaque one.
uint with_bloom(vec3 seen, uint alpha, vec3 bloom, float noise, bool may_be_clear) {
    float most = max(bloom.x, max(bloom.y, bloom.z));
    precise float clear = 255.0 - float(alpha);
    precise float cover = clear * most;
    float white = 255.0;
    if (may_be_clear && alpha < 255u) {
        precise float own_share = float(alpha) * PER_BYTE;
        precise float own_white = 255.0 * seen_of(own_share);
        white = own_white;
    }
    precise vec3 dark = white - seen;
    precise vec3 gain = dark * bloom;
    precise vec3 sum = seen + gain;
    if (may_be_clear && cover > 0.0) {
        precise float bloom_share = cover * PER_BYTE;
        precise float bloom_white = 255.0 * seen_of(bloom_share);
        precise vec3 beside = bloom * quotient(bloom_white, most);
        // Nearly the sum of their light.
        precise vec3 both = sum * sum + beside * beside;
        sum = vec3(root(both.x), root(both.y), root(both.z));
    }
    precise vec3 steps = sum + noise;
    precise vec3 rounded = steps + 0.5;
    uvec3 result = min(uvec3(rounded), uvec3(255u));
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
