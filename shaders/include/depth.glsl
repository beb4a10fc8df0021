// depth: five ways from a signed distance to a depth in [0, 1), by which a depth test keeps the smallest distance. Twin
// of src/sim/depth.rs.
//
// Depths are monotonic by construction: each is a chain of operations that keep the order however they
// are rounded. The device's exp() and atan() need not be monotonic, so they are not used.

#ifndef MYXO_DEPTH
#define MYXO_DEPTH

const uint DEPTH_ORDERED = 0u;
const uint DEPTH_CLIP = 1u;
const uint DEPTH_LOGISTIC = 2u;
const uint DEPTH_ARCTANGENT = 3u;
const uint DEPTH_LINEAR = 4u;

// The greatest float below 1.
const float BELOW_ONE = 0.99999994;

// The distance in units of a length.
float share_of(float distance, float whole) {
    precise float share = clamp(distance / max(whole, 1.0e-30), -1.0e30, 1.0e30);
    return share;
}

// The bits of floats are in order but for the sign: a positive one has its sign bit flipped, a negative one all bits. Two
// bits are dropped for a float in [0, 2). Does not depend on the reach: the loss of digits is the same everywhere.
float depth_ordered(float distance) {
    uint bits = floatBitsToUint(distance);
    uint key = (bits & 0x80000000u) != 0u ? ~bits : bits ^ 0x80000000u;
    precise float depth = 0.5 * uintBitsToFloat(key >> 2u);
    return depth;
}

// Straight from 0 at -reach to 1 at reach.
float depth_linear(float distance, float reach) {
    float share = clamp(share_of(distance, reach), -1.0, 1.0);
    precise float depth = 0.5 + 0.5 * share;
    return min(depth, BELOW_ONE);
}

// As a projection makes it (Vulkan's clip space after the division): far / (far - near) * (1 - near / z), where z grows from near, at
// -reach, to far, at reach. Most depths are those of the smallest distances.
float depth_clip(float distance, float reach, float near_plane) {
    float most = max(max(reach, 1.0e-6 * near_plane), 1.0e-30);
    precise float way = clamp(distance, -most, most) + most;
    precise float place = near_plane + way;
    precise float part = near_plane / place;
    precise float factor = (near_plane + 2.0 * most) / (2.0 * most);
    precise float depth = (1.0 - part) * factor;
    return clamp(depth, 0.0, BELOW_ONE);
}

// e to the power of x, |x| up to 80. Sums of positive products keep the order.
float growth(float x) {
    precise float power = 1.44269504 * x;
    float whole = floor(power);
    precise float part = power - whole;
    precise float sum = 1.3215487e-6;
    sum = sum * part + 1.5252734e-5;
    sum = sum * part + 1.5403530e-4;
    sum = sum * part + 1.3333558e-3;
    sum = sum * part + 9.6181291e-3;
    sum = sum * part + 5.5504109e-2;
    sum = sum * part + 2.4022651e-1;
    sum = sum * part + 6.9314718e-1;
    sum = sum * part + 1.0;
    precise float value = uintBitsToFloat(uint(int(whole) + 127) << 23u) * min(sum, 2.0);
    return value;
}

float depth_logistic(float distance, float scale) {
    precise float way = -share_of(distance, scale);
    precise float sum = 1.0 + growth(clamp(way, -80.0, 80.0));
    precise float depth = 1.0 / sum;
    return min(depth, BELOW_ONE);
}

// The arctangent of at most tan(pi / 8) (Moshier, Cephes). What is added to x is too small to disturb the order.
float small_angle(float x) {
    precise float z = x * x;
    precise float sum = 8.05374449538e-2;
    sum = sum * z - 1.38776856032e-1;
    sum = sum * z + 1.99777106478e-1;
    sum = sum * z - 3.33329491539e-1;
    precise float angle = sum * z * x + x;
    return angle;
}

// The arctangent of x, not negative. Each third stays within its bounds, so that they meet in order.
float angle_of(float x) {
    if (x < 0.41421356) {
        return min(small_angle(x), 0.39269908);
    }
    if (x < 2.41421356) {
        precise float turned = 1.0 - 2.0 / (x + 1.0);
        precise float angle = 0.78539816 + small_angle(turned);
        return clamp(angle, 0.39269908, 1.17809725);
    }
    precise float inverse = 1.0 / x;
    precise float angle = 1.57079633 - small_angle(inverse);
    return max(angle, 1.17809725);
}

float depth_arctangent(float distance, float scale) {
    float way = share_of(distance, scale);
    precise float half_turns = 0.318309886 * angle_of(abs(way));
    precise float depth = way < 0.0 ? 0.5 - half_turns : 0.5 + half_turns;
    return clamp(depth, 0.0, BELOW_ONE);
}

float depth_of(uint mapping, float distance, float reach, float near_plane, float scale) {
    if (mapping == DEPTH_CLIP) return depth_clip(distance, reach, near_plane);
    if (mapping == DEPTH_LOGISTIC) return depth_logistic(distance, scale);
    if (mapping == DEPTH_ARCTANGENT) return depth_arctangent(distance, scale);
    if (mapping == DEPTH_LINEAR) return depth_linear(distance, reach);
    return depth_ordered(distance);
}

#endif
