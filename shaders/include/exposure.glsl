// exposure: the bins that trail values are counted in: eight for each doubling, computed from a float's bits; and what a texel counts.
// Twin: src/render/exposure.rs.

#ifndef MYXO_EXPOSURE
#define MYXO_EXPOSURE

// 2^-16 to 2^40; smaller values share the first bin and larger ones the last.
const uint BIN_COUNT = 448u;
const uint BIN_SHIFT = 20u;
const uint FIRST_BIN_BITS = (127u - 16u) << 3u;

// A texel of mean area counts as so many, and none as more than the latter: sums of all samples stay below 2^31.
const float MEAN_AREA = 256.0;
const float MOST_AREA = 16384.0;

// What a texel of this density counts, by the area of the surface that it covers.
uint area_of(float density) {
    return uint(clamp(MEAN_AREA / density + 0.5, 1.0, MOST_AREA));
}

uint bin_of(float trail) {
    uint bits = floatBitsToUint(max(trail, 0.0)) >> BIN_SHIFT;
    return clamp(bits, FIRST_BIN_BITS, FIRST_BIN_BITS + BIN_COUNT - 1u) - FIRST_BIN_BITS;
}

// The smallest value of a bin; that of the bin after the last is the largest value counted.
float bin_edge(uint bin) {
    return uintBitsToFloat((FIRST_BIN_BITS + bin) << BIN_SHIFT);
}

#endif
