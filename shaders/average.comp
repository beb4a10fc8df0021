// average: adds a picture to a sum of pictures, as light, and puts their mean in its place.
// Reads   light, sums.
// Writes  sums, picture.
// One invocation per pixel.
// Overflow: cannot happen up to 65,536 pictures.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "index.glsl"
#include "tables.glsl"

layout(local_size_x = 64) in;

layout(push_constant) uniform Params {
    uint pixel_count;
    uint pictures;      // this one included
} params;

READS(uint, 0) light;   // the light of each byte of sRGB, 0 to 65,535
CHANGES(uvec4, 1) sums; // light of three colours, and alpha
CHANGES(uint, 2) picture;

// The byte whose light is nearest.
uint byte_of(uint mean) {
    uint found = 0u;
    for (uint step = 128u; step > 0u; step >>= 1u) {
        uint next = found + step;
        if (2u * mean >= fetch1(light, next - 1u) + fetch1(light, next)) found = next;
    }
    return found;
}

void main() {
    uint i = invocation_index();
    if (i >= params.pixel_count) return;
    uint word = load1(picture, i);
    uvec4 sum = uvec4(
        fetch1(light, word & 255u),
        fetch1(light, word >> 8u & 255u),
        fetch1(light, word >> 16u & 255u),
        word >> 24u
    );
    if (params.pictures > 1u) sum += load4(sums, i);
    store4(sums, i, sum);
    uvec4 mean = (sum + params.pictures / 2u) / params.pictures;
    uint seen = byte_of(mean.x) | byte_of(mean.y) << 8u | byte_of(mean.z) << 16u | mean.w << 24u;
    store1(picture, i, seen);
}
