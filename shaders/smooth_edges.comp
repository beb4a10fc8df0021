// smooth_edges: mixes a pixel at a jagged edge with the one across it, by the place of the pixel along the edge.
// Reads   edges, groups, picture, bloom (its finest level).
// Writes  developed, at the pixels that are listed; each is listed once.
// One invocation per listed pixel (indirect).
// Overflow: cannot happen; beyond its edges the picture continues as at them.
// The way along an edge to its ends is as in FXAA (Lottes, 2009), without what softens single pixels: trails are smooth already.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "index.glsl"
#include "tables.glsl"

layout(local_size_x = 64) in;

layout(constant_id = 0) const bool BLOOMS = true;
layout(constant_id = 1) const bool MAY_BE_CLEAR = true;

layout(push_constant) uniform Params {
    uint pitch;       // of the picture, pixels
    uint width;
    uint height;
    uint cells_down;
    uint is_opaque;
} params;

layout(std430, set = 0, binding = 0) readonly buffer Edges { uint edges[]; };
layout(std430, set = 0, binding = 1) readonly buffer Groups { DispatchGroups groups[]; };
READS(uint, 2) picture;
READS(vec4, 3) bloom;
WRITES(uint, 4) developed;

#include "strict.glsl"
#include "developing.glsl"

// Pixels along an edge that are looked at, each way.
const int LONGEST = 12;

uint word_at(ivec2 place) {
    ivec2 inside = clamp(place, ivec2(0), ivec2(int(params.width), int(params.height)) - 1);
    return fetch1(picture, uint(inside.y) * params.pitch + uint(inside.x));
}

int bright(ivec2 place) {
    return brightness_of(word_at(place));
}

vec3 bloom_at(int column, int row) {
    uint across = params.pitch >> 2u;
    uint x = uint(clamp(column, 0, int(across) - 1));
    uint y = uint(clamp(row, 0, int(params.cells_down) - 1));
    return fetch4(bloom, y * across + x).xyz;
}

vec3 bloom_of(ivec2 place) {
    ivec2 cell = place >> 2;
    ivec2 eighths = 2 * (place & 3) - 3;
    ivec2 beside = cell + ivec2(eighths.x < 0 ? -1 : 1, eighths.y < 0 ? -1 : 1);
    precise float down = float(abs(eighths.y)) * 0.125;
    precise float aside = float(abs(eighths.x)) * 0.125;
    vec3 here = part_way(bloom_at(cell.x, cell.y), bloom_at(cell.x, beside.y), down);
    vec3 there = part_way(bloom_at(beside.x, cell.y), bloom_at(beside.x, beside.y), down);
    return part_way(here, there, aside);
}

// How many pixels the edge goes on in a direction, and in `end` how much brighter than at the pixel it is there, twice.
int length_along(ivec2 place, ivec2 along, ivec2 side, int twice, int contrast, out int end) {
    end = 0;
    for (int k = 1; k <= LONGEST; k++) {
        ivec2 at = place + k * along;
        end = bright(at) + bright(at + side) - twice;
        if (2 * abs(end) >= contrast) return k;
    }
    return LONGEST;
}

void main() {
    uint i = invocation_index();
    if (i >= groups[1].x) return;
    // The condition above is the bound; the list has room for as many entries as it counts.
    uint pixel = edges[i];
    ivec2 place = ivec2(int(pixel % params.pitch), int(pixel / params.pitch));
    uint word = word_at(place);
    int own = brightness_of(word);
    int above = bright(place - ivec2(0, 1));
    int below = bright(place + ivec2(0, 1));
    int left = bright(place - ivec2(1, 0));
    int right = bright(place + ivec2(1, 0));
    int left_above = bright(place + ivec2(-1, -1));
    int right_above = bright(place + ivec2(1, -1));
    int left_below = bright(place + ivec2(-1, 1));
    int right_below = bright(place + ivec2(1, 1));
    int changes_down = 2 * abs(above + below - 2 * own) + abs(left_above + left_below - 2 * left)
        + abs(right_above + right_below - 2 * right);
    int changes_across = 2 * abs(left + right - 2 * own) + abs(left_above + right_above - 2 * above)
        + abs(left_below + right_below - 2 * below);
    bool is_level = changes_down >= changes_across;
    ivec2 along = is_level ? ivec2(1, 0) : ivec2(0, 1);
    ivec2 across = is_level ? ivec2(0, 1) : ivec2(1, 0);
    int before = is_level ? above : left;
    int after = is_level ? below : right;
    bool is_before = abs(before - own) >= abs(after - own);
    int other = is_before ? before : after;
    ivec2 side = is_before ? -across : across;
    int contrast = abs(other - own);
    int twice = own + other;
    int end_back;
    int end_ahead;
    int back = length_along(place, -along, side, twice, contrast, end_back);
    int ahead = length_along(place, along, side, twice, contrast, end_ahead);
    int nearer = min(back, ahead);
    int end = back < ahead ? end_back : end_ahead;
    // Only the half of the edge where the other side reaches over this one is mixed.
    bool is_reached = contrast > 0 && (end < 0) != (own - other < 0);
    precise float part = 0.5 - quotient(float(nearer), float(back + ahead));
    float share = is_reached ? part : 0.0;
    uint beyond = word_at(place + side);
    vec3 seen = part_way(bytes_of(word), bytes_of(beyond), share);
    vec3 alphas = part_way(vec3(float(word >> 24u)), vec3(float(beyond >> 24u)), share);
    precise float half_more = alphas.x + 0.5;
    uint alpha = params.is_opaque == 1u ? 255u : uint(half_more);
    vec3 glow = vec3(0.0);
    if (BLOOMS) glow = bloom_of(place);
    store1(developed, pixel, with_bloom(seen, alpha, glow, noise_of(uint(place.x), uint(place.y)), MAY_BE_CLEAR));
}
