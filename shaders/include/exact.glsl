// exact: exact sums and products. Twin of src/sim/exact.rs.
// Each result is a pair: the rounded value in x, the rounding error in y.

#ifndef MYXO_EXACT
#define MYXO_EXACT

// Knuth 1969.
vec2 exact_sum(float a, float b) {
    precise float sum = a + b;
    precise float b_in_sum = sum - a;
    precise float dropped = (a - (sum - b_in_sum)) + (b - b_in_sum);
    return vec2(sum, dropped);
}

// A number as the sum of two that have half as many digits each (Veltkamp 1968).
vec2 halves(float a) {
    precise float scaled = 4097.0 * a;
    precise float high = scaled - (scaled - a);
    precise float low = a - high;
    return vec2(high, low);
}

// Dekker 1971. Not by fma, which need not be one operation here.
vec2 exact_product(float a, float b) {
    precise float product = a * b;
    vec2 ha = halves(a);
    vec2 hb = halves(b);
    precise float dropped = ((ha.x * hb.x - product) + ha.x * hb.y + ha.y * hb.x) + ha.y * hb.y;
    return vec2(product, dropped);
}

#endif
