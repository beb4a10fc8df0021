// expose: finds the trail value that gets the brightest colour, and empties the histogram for the next picture.
// Reads   histogram, brightest (the last picture's).
// Writes  brightest, histogram (zeroed).
// One invocation per picture: its 448 bins are too few to share out.
// Overflow: cannot happen.
#version 460
#include "index.glsl"
#include "exposure.glsl"

layout(local_size_x = 8) in;

layout(set = 0, binding = 0) buffer Histogram { uint histogram[]; };
layout(set = 0, binding = 1) buffer Exposure { float brightest[]; };

layout(push_constant) uniform Params {
    uint count;           // pictures, each with a histogram of its own
    float clipped_share;  // share of the trail, by mass, that may be brighter than the brightest colour
    float adaptation;     // 1 forgets the last picture, less follows it slowly
} params;

void main() {
    uint i = invocation_index();
    if (i >= params.count) return;
    uint first = i * BIN_COUNT;
    // Mass, not texels: where most of the surface is bare, the veins alone decide.
    precise float mass = 0.0;
    for (uint bin = 0u; bin < BIN_COUNT; bin++) {
        mass += float(histogram[first + bin]) * bin_edge(bin);
    }
    precise float wanted = params.clipped_share * mass;
    precise float above = 0.0;
    precise float value = bin_edge(0u);
    for (uint k = 0u; k < BIN_COUNT; k++) {
        uint bin = BIN_COUNT - 1u - k;
        precise float here = float(histogram[first + bin]) * bin_edge(bin);
        if (here > 0.0 && above + here >= wanted) {
            // Within the bin, as if its texels were spread evenly.
            precise float into = (wanted - above) / here;
            value = bin_edge(bin + 1u) - into * (bin_edge(bin + 1u) - bin_edge(bin));
            break;
        }
        above += here;
    }
    for (uint bin = 0u; bin < BIN_COUNT; bin++) {
        histogram[first + bin] = 0u;
    }
    precise float last = brightest[i];
    brightest[i] = last + params.adaptation * (value - last);
}
