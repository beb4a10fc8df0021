// colormap: from a trail value to a colour in linear light.
// Include it after a block that has `vec4 colors[]`, the table that src/render/colormap.rs makes.

#ifndef MYXO_COLORMAP
#define MYXO_COLORMAP

const uint COLOR_COUNT = 256u;

// A trail value as a brightness; `brightest` is the value that gets the brightest colour, at 1, and larger ones get up to 1.45.
// Steep at first, so that thin veins show, and flat towards the end, so that thick ones keep their detail.
float tone_of_any(float trail, float brightest) {
    const float shoulder = 0.45;
    float x = max(trail, 0.0) / brightest;
    return (1.0 + shoulder) * x / (x + shoulder);
}

// The same in [0, 1].
float tone(float trail, float brightest) {
    return min(tone_of_any(trail, brightest), 1.0);
}

// The slope of the same, by the trail. It is not cut off at the brightest value, so the brightest trail is not flat.
float tone_slope(float trail, float brightest) {
    const float shoulder = 0.45;
    float x = max(trail, 0.0) / brightest + shoulder;
    return (1.0 + shoulder) * shoulder / (x * x * brightest);
}

// The slope of the square of the tone: the height of veins, which stand up from a surface that is level where there is little trail.
float height_slope(float trail, float brightest) {
    return 2.0 * min(tone_of_any(trail, brightest), 1.0) * tone_slope(trail, brightest);
}

// The colour of a brightness, between the two nearest entries of the table, and its opacity.
vec4 color_of(float brightness) {
    float place = clamp(brightness, 0.0, 1.0) * float(COLOR_COUNT - 1u);
    uint entry = min(uint(place), COLOR_COUNT - 2u);
    return mix(colors[entry], colors[entry + 1u], place - float(entry));
}

#endif
