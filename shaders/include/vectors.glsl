// vectors: products, lengths and directions of vectors in strict arithmetic. Twin of src/strict.rs.
// The order of sums is the twin's; dot() may take any.

#ifndef MYXO_VECTORS
#define MYXO_VECTORS

#include "strict.glsl"

float dot_of(vec2 a, vec2 b) {
    precise float sum = a.x * b.x + a.y * b.y;
    return sum;
}

float dot_of(vec3 a, vec3 b) {
    precise float sum = (a.x * b.x + a.y * b.y) + a.z * b.z;
    return sum;
}

float cross_of(vec2 a, vec2 b) {
    precise float product = a.x * b.y - a.y * b.x;
    return product;
}

vec3 cross_of(vec3 a, vec3 b) {
    precise vec3 product = a.yzx * b.zxy - a.zxy * b.yzx;
    return product;
}

// One coordinate of a place in another space.
float along(vec4 row, vec3 place) {
    precise float sum = ((row.x * place.x + row.y * place.y) + row.z * place.z) + row.w;
    return sum;
}

// 0 below 2^-50.
float length_of(vec3 a) {
    return root(dot_of(a, a));
}

// The power of two that brings a number to between 1 and 2: 1 / 2^e.
float scale_of(float most) {
    return uintBitsToFloat(0x7f000000u - (clamp(floatBitsToUint(most), LEAST, MOST) & 0x7f800000u));
}

// A vector whose components are all below this has no direction: sides of thin triangles can coincide by rounding. 2^-60.
const float LEAST_COMPONENT = 8.6736174e-19;

// The direction of a vector, or another one if the vector is too short to have one.
vec3 direction_or(vec3 way, vec3 other) {
    vec3 sides = abs(way);
    float most = max(max(sides.x, sides.y), sides.z);
    precise vec3 scaled = way * scale_of(most);
    float by = inverse_root(dot_of(scaled, scaled));
    precise vec3 direction = scaled * by;
    return most >= LEAST_COMPONENT ? settled(direction) : other;
}

vec2 direction_or(vec2 way, vec2 other) {
    vec2 sides = abs(way);
    float most = max(sides.x, sides.y);
    precise vec2 scaled = way * scale_of(most);
    float by = inverse_root(dot_of(scaled, scaled));
    precise vec2 direction = scaled * by;
    return most >= LEAST_COMPONENT ? settled(direction) : other;
}

#endif
