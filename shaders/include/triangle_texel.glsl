// triangle_texel: where in the atlas a place of a triangle lies.
// The includer has the varyings `atlas_origin` and `atlas_axes`.

#ifndef MYXO_TRIANGLE_TEXEL
#define MYXO_TRIANGLE_TEXEL

// A texel position for uv that may lie a little outside of the triangle: taps stay inside, because beyond the gutter
// begins another triangle.
vec2 texel_at(vec2 inside) {
    inside = max(inside, vec2(0.0));
    inside /= max(inside.x + inside.y, 1.0);
    return atlas_origin + inside.x * atlas_axes.xy + inside.y * atlas_axes.zw;
}

#endif
