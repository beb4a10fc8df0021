// fields: lights a triangle in the colours of a field: its edges, the density of particles, the distance to another object, or which object
// is nearest.
// Reads   trail, colors, brightest; deposits, density; distances; nearest, corners, vertices, object_colors.
// Writes  the pixel, in linear light.
// One invocation per pixel and triangle; edges are multisampled.
// Overflow: cannot happen; texel coordinates are clamped to the atlas.
#version 460
#include "types.glsl"
#include "shading.glsl"
#include "fields.glsl"

layout(set = 0, binding = 0) uniform usamplerBuffer corners;
layout(set = 0, binding = 1) uniform usamplerBuffer vertices;
layout(set = 0, binding = 5) uniform samplerBuffer trail_texels;
layout(set = 0, binding = 6) readonly buffer Colors { vec4 colors[]; };
layout(set = 0, binding = 7) readonly buffer Exposure { float brightest[]; };
layout(set = 0, binding = 8) uniform usamplerBuffer deposits_texels;
layout(set = 0, binding = 10) uniform samplerBuffer density_texels;
layout(set = 0, binding = 11) uniform samplerBuffer distances_texels;
layout(set = 0, binding = 12) uniform usamplerBuffer nearest_texels;
layout(set = 0, binding = 13) readonly buffer ObjectColors { vec4 object_colors[]; };

// The field that is shown; as `Field` in src/render/renderer/fields.rs.
const uint FIELD_WIREFRAME = 0u;
const uint FIELD_DENSITY = 1u;
const uint FIELD_DISTANCE = 2u;
const uint FIELD_NEAREST = 3u;


#include "colormap.glsl"
#include "texels.glsl"

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) centroid in vec2 uv;
layout(location = 3) flat in vec2 atlas_origin;
layout(location = 4) flat in vec4 atlas_axes;
layout(location = 5) flat in uint triangle;
layout(location = 6) in float open_share;

#include "taps.glsl"
#include "triangle_texel.glsl"

layout(location = 0) out vec4 color;

// Beyond the reach of distances.
const vec3 BEYOND_REACH = vec3(0.045, 0.047, 0.052);

// Edges of triangles as light lines over a faint trail; lines fade away where triangles are only a few pixels large.
vec3 wireframe() {
    vec3 weights = vec3(uv.y, 1.0 - uv.x - uv.y, uv.x);
    vec3 a_pixel = max(fwidth(weights), vec3(1e-9));
    vec3 in_pixels = weights / a_pixel;
    float line = clamp(1.25 - min(min(in_pixels.x, in_pixels.y), in_pixels.z), 0.0, 1.0);
    float side = 1.0 / max(max(a_pixel.x, a_pixel.y), a_pixel.z);
    Taps taps = taps_at(texel_at(uv));
    vec4 there = vec4(texel_of(trail, taps.texels.x), texel_of(trail, taps.texels.y),
        texel_of(trail, taps.texels.z), texel_of(trail, taps.texels.w));
    vec3 under = 0.3 * color_of(tone(between(there, taps.weight), brightest[0])).rgb;
    return mix(BARE + under, vec3(0.62, 0.66, 0.70), line * mix(0.05, 0.85, smoothstep(2.0, 14.0, side)));
}

// Particles per area, over the surrounding texels that triangles own, with smaller weights farther away; relative to the usual density, on
// a logarithmic scale: the brightest colour is 63 times it.
vec3 crowd() {
    const float weights[3] = float[](6.0, 4.0, 1.0);
    ivec2 middle = ivec2(texel_at(uv));
    float particles = 0.0;
    float area = 0.0;
    for (int y = -2; y <= 2; y++) {
        for (int x = -2; x <= 2; x++) {
            ivec2 place = clamp(middle + ivec2(x, y), ivec2(0), ivec2(int(params.size) - 1));
            uint texel = uint(place.y) * params.pitch + uint(place.x);
            float inverse_area = texel_of(density, texel);
            if (inverse_area > 0.0) {
                float weight = weights[abs(x)] * weights[abs(y)];
                particles += weight * float(texel_of(deposits, texel));
                area += weight / inverse_area;
            }
        }
    }
    return color_of(log2(1.0 + particles / max(area * params.usual, 1e-20)) / 6.0).rgb;
}

vec4 distances_of(uvec4 texels) {
    return vec4(texel_of(distances, texels.x), texel_of(distances, texels.y),
        texel_of(distances, texels.z), texel_of(distances, texels.w));
}

// White at the contact and blue away from it; orange inside of another object. A line at each eighth of the reach, and a
// bright one where objects touch.
vec3 from_others(float apart, float a_pixel) {
    float share = clamp(abs(apart) / params.reach, 0.0, 1.0);
    const vec3 near = vec3(0.72, 0.72, 0.70);
    vec3 far = apart < 0.0 ? vec3(0.60, 0.13, 0.02) : vec3(0.015, 0.10, 0.40);
    vec3 shown = mix(mix(near, far, sqrt(share)), BEYOND_REACH, smoothstep(0.75, 1.0, share));
    float line_pixels = abs(fract(8.0 * apart / params.reach - 0.5) - 0.5) * params.reach / (8.0 * max(a_pixel, 1e-20));
    float crowded = 8.0 * a_pixel / params.reach;
    float line = clamp(1.4 - line_pixels, 0.0, 1.0) * (1.0 - smoothstep(0.1, 0.3, crowded)) * float(share < 0.99);
    return shown * (1.0 - 0.45 * line);
}

uint object_of(uint of) {
    return texelFetch(vertices, int(texelFetch(corners, int(3u * of)).x)).w;
}

// The colour of the nearest object; if none is within reach, the colour of the triangle's own object, darkened.
vec3 nearest_object(float apart) {
    vec3 own = 0.14 * object_colors[object_of(triangle)].rgb;
    if (abs(apart) >= 0.999 * params.reach) return own;
    Taps taps = taps_at(texel_at(uv));
    vec4 weights = vec4((1.0 - taps.weight.x) * (1.0 - taps.weight.y), taps.weight.x * (1.0 - taps.weight.y),
        (1.0 - taps.weight.x) * taps.weight.y, taps.weight.x * taps.weight.y);
    // Triangle ids cannot be mixed, so this takes the owned texel with the largest weight. Gutter texels have no owner.
    float most = -1.0;
    uint found = NONE;
    for (int k = 0; k < 4; k++) {
        uint other = texel_of(nearest, taps.texels[k]);
        if (other != NONE && weights[k] > most) {
            most = weights[k];
            found = other;
        }
    }
    return found == NONE ? own : 0.8 * object_colors[object_of(found)].rgb;
}

void main() {
    vec3 shown;
    float bright = 0.0;
    if (params.field == FIELD_WIREFRAME) {
        shown = wireframe();
    } else if (params.field == FIELD_DENSITY) {
        shown = crowd();
    } else {
        Taps taps = taps_at(texel_at(uv));
        float apart = between(distances_of(taps.texels), taps.weight);
        float a_pixel = fwidth(apart);
        if (params.field == FIELD_DISTANCE) {
            shown = from_others(apart, a_pixel);
        } else {
            shown = nearest_object(apart);
        }
        bright = clamp(1.8 - abs(apart) / max(a_pixel, 1e-20), 0.0, 1.0);
    }
    vec3 n = normalize(gl_FrontFacing ? normal : -normal);
    vec3 to_eye = normalize(params.eye - position);
    float open = 1.0 - params.occlusion * (1.0 - open_share);
    // Without the colours of the lights, because those of the surface mean something.
    const vec3 grey = vec3(1.0 / 3.0);
    vec3 light = shown * (dot(diffuse_light(n, params.key_direction, open), grey) + 0.25)
        + 0.3 * open * dot(specular_light(n, to_eye, params.key_direction, 0.0), grey);
    light = mix(light, vec3(1.0, 0.95, 0.80), bright);
    color = vec4(dithered(light, gl_FragCoord.xy), 1.0);
}
