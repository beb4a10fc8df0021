// exposure: the bins that trail values are counted in: eight for each doubling, computed from a float's bits.

#ifndef MYXO_EXPOSURE
#define MYXO_EXPOSURE

// 2^-16 to 2^16; smaller values share the first bin and larger ones the last.
const uint BIN_COUNT = 256u;
const uint BIN_SHIFT = 20u;
const uint FIRST_BIN_BITS = (127u - 16u) << 3u;

uint bin_of(float trail) {
    uint bits = floatBitsToUint(max(trail, 0.0)) >> BIN_SHIFT;
    return clamp(bits, FIRST_BIN_BITS, FIRST_BIN_BITS + BIN_COUNT - 1u) - FIRST_BIN_BITS;
}

// The smallest value of a bin; that of the bin after the last is the largest value counted.
float bin_edge(uint bin) {
    return uintBitsToFloat((FIRST_BIN_BITS + bin) << BIN_SHIFT);
}

#endif
