// strict: arithmetic that gives the same bits on every device: sums, differences and products by IEEE 754, and functions that are composed
// of these. Twin of src/strict.rs. Kernels of the state use no operation that Vulkan lets devices round as they like: no /, sqrt, sin, log,
// atan, dot, cross, length, normalize, mix. The build refuses kernels that use such, and sums and products that a compiler may contract:
// write each as a `precise` variable of its own, arguments and results too, because `precise` does not reach into or out of functions.

#ifndef MYXO_STRICT
#define MYXO_STRICT

const uint SIGN = 0x80000000u;
// The upper 12 of 24 digits: products of two such are exact.
const uint UPPER = 0xfffff000u;
// Bits of 2^-100 and 2^100. Divisors beyond these are replaced by them, so that every result is finite.
const uint LEAST = 0x0d800000u;
const uint MOST = 0x71800000u;
// 2^-100 itself: smaller rates, volumes and the like count as zero.
const float LEAST_SIZE = 7.8886091e-31;

// A number as it is stored: no zero has a sign, and what devices may take for zero is zero. By integers, because a compiler may
// leave out x + 0.0.
float settled(float x) {
    uint bits = floatBitsToUint(x);
    return uintBitsToFloat((bits & ~SIGN) < 0x00800000u ? 0u : bits);
}

vec2 settled(vec2 v) {
    return vec2(settled(v.x), settled(v.y));
}

vec3 settled(vec3 v) {
    return vec3(settled(v.x), settled(v.y), settled(v.z));
}

// x, or 0 if it is negative or NaN. max() may return either of two zeros, and either of a number and NaN.
float positive(float x) {
    return x > 0.0 ? x : 0.0;
}

vec2 positive(vec2 v) {
    return vec2(positive(v.x), positive(v.y));
}

// Whole texels. The conversion of a float beyond the range of integers is undefined, so this is the one place where positions become
// integers. None is too large: points of the surface lie inside of the atlas, and paths that may leave it are clamped before. Negative
// numbers and NaN become 0, as in Rust.
uvec2 whole(vec2 position) {
    return uvec2(positive(position));
}

// x from low to high. Of two zeros it takes `low`, where clamp() may take either.
float within(float x, float low, float high) {
    return x > low ? (x < high ? x : high) : low;
}

// 1 / x, off by 0.56 units in the last place. An integer operation guesses it within 6 %, a Newton step makes that 0.13 %, cut to 12
// digits, so that its error is computed exactly; a step of third order corrects it.
float reciprocal(float x) {
    uint bits = floatBitsToUint(x);
    uint size = clamp(bits & ~SIGN, LEAST, MOST);
    float a = uintBitsToFloat(size);
    float guess = uintBitsToFloat(0x7ef33400u - size);
    precise float better = guess * (2.0013 - a * guess);
    float r = uintBitsToFloat(floatBitsToUint(better) & UPPER);
    float high = uintBitsToFloat(size & UPPER);
    precise float low = a - high;
    precise float wrong = (1.0 - high * r) - low * r;
    precise float result = r + r * (wrong + wrong * wrong);
    return uintBitsToFloat(floatBitsToUint(result) | (bits & SIGN));
}

// n / d, off by 1.6 units in the last place.
float quotient(float n, float d) {
    precise float result = n * reciprocal(d);
    return result;
}

// n / d from 0 to 1: exactly 1 where they are equal.
float share(float n, float d) {
    return n <= 0.0 ? 0.0 : n >= d ? 1.0 : min(quotient(n, d), 1.0);
}

// 1 / sqrt(x), off by 1.5 units in the last place.
float inverse_root(float x) {
    uint size = clamp(floatBitsToUint(x), LEAST, MOST);
    float a = uintBitsToFloat(size);
    float guess = uintBitsToFloat(0x5f377800u - (size >> 1u));
    precise float half_a = 0.5 * a;
    precise float r = guess * (1.5009 - (half_a * guess) * guess);
    precise float wrong = 1.0 - (a * r) * r;
    precise float result = r + r * (wrong * (0.5 + 0.375 * wrong));
    return result;
}

// sqrt(x), off by 0.51 units in the last place; 0 below 2^-100.
float root(float x) {
    uint size = clamp(floatBitsToUint(x), LEAST, MOST);
    float a = uintBitsToFloat(size);
    float r = inverse_root(a);
    precise float about = a * r;
    float s = uintBitsToFloat(floatBitsToUint(about) & UPPER);
    precise float rest = a - s * s;
    precise float t = (0.5 * r) * rest;
    precise float result = s + (t + (0.5 * r) * (t * t));
    return x >= uintBitsToFloat(LEAST) ? result : 0.0;
}

// Cosine and sine of word / 2^32 turns, by its upper 24 bits, off by 1.1e-7 (polynomials of Moshier's, Cephes). An angle itself would be
// rounded.
vec2 turn_of(uint word) {
    int k = int(word >> 8u);
    int quarter = (k + 0x200000) >> 22;
    float rest = float(k - (quarter << 22));
    precise float x = rest * 3.7450703e-7;
    precise float z = x * x;
    precise float s = x + x * (z * (-1.6666654611e-1 + z * (8.3321608736e-3 + z * -1.9515295891e-4)));
    precise float c = (1.0 - 0.5 * z) + (z * z) * (4.166664568298827e-2 + z * (-1.388731625493765e-3 + z * 2.443315711809948e-5));
    bool is_odd = (quarter & 1) != 0;
    float along = is_odd ? s : c;
    float across = is_odd ? c : s;
    bool is_left = quarter == 1 || quarter == 2;
    bool is_lower = (quarter & 2) != 0;
    return vec2(settled(is_left ? -along : along), settled(is_lower ? -across : across));
}

// The natural logarithm of a normal positive number, off by 0.9 units in the last place (Moshier, Cephes).
float logarithm(float x) {
    uint bits = floatBitsToUint(x);
    int exponent = int(bits >> 23u) - 127;
    float m = uintBitsToFloat((bits & 0x007fffffu) | 0x3f800000u);
    bool is_high = m > 1.41421356;
    exponent += is_high ? 1 : 0;
    precise float half_m = 0.5 * m;
    precise float y = (is_high ? half_m : m) - 1.0;
    float e = float(exponent);
    precise float z = y * y;
    precise float p = 7.0376836292e-2;
    p = p * y - 1.1514610310e-1;
    p = p * y + 1.1676998740e-1;
    p = p * y - 1.2420140846e-1;
    p = p * y + 1.4249322787e-1;
    p = p * y - 1.6668057665e-1;
    p = p * y + 2.0000714765e-1;
    p = p * y - 2.4999993993e-1;
    p = p * y + 3.3333331174e-1;
    precise float rest = ((p * y) * z - 2.12194440e-4 * e) - 0.5 * z;
    precise float result = (y + rest) + 0.693359375 * e;
    return result;
}

// The arctangent of 0 to 1, off by 3.1 units in the last place (Moshier, Cephes).
float arc_of(float x) {
    bool is_wide = x > 0.41421356;
    precise float less = x - 1.0;
    precise float more = x + 1.0;
    float t = is_wide ? quotient(less, more) : x;
    precise float z = t * t;
    precise float sum = 8.05374449538e-2;
    sum = sum * z - 1.38776856032e-1;
    sum = sum * z + 1.99777106478e-1;
    sum = sum * z - 3.33329491539e-1;
    precise float angle = (sum * z) * t + t;
    precise float wide = angle + 0.785398163;
    return is_wide ? wide : angle;
}

// The angle of the vector (x, y), from -pi to pi, as atan(y, x). That of the zero vector is 0.
float angle_of_vector(float y, float x) {
    float side_x = abs(x);
    float side_y = abs(y);
    bool is_steep = side_y > side_x;
    float angle = arc_of(share(is_steep ? side_x : side_y, is_steep ? side_y : side_x));
    precise float steep = 1.57079633 - angle;
    angle = is_steep ? steep : angle;
    precise float back = 3.14159265 - angle;
    angle = x < 0.0 ? back : angle;
    return y < 0.0 ? -angle : angle;
}

#endif
