// distance: signed distance from an object's texels to the nearest other object, and which triangle of it is nearest.
// Reads   pairs, samples, listed, groups, hints, candidates, nodes, faces, pseudonormals, corners; for signs dipoles.
// Writes  owned texels of distances and nearest, of the tiles that `distance_tiles` has listed.
// One invocation a sample of a listed tile.
// Overflow: cannot happen; nothing is appended, and no tree is deeper than a search has room for.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "index.glsl"

layout(local_size_x = 64) in;

layout(constant_id = 0) const uint SIGN_RULE = 0u;

layout(push_constant) uniform Params {
    uint tile_count;           // of all jobs; no more are listed
    uint first_vertex_normal;  // behind those of the half-edges
    uint hint_count;           // a tile
    float reach;               // world length; distances are clamped to it
} params;

layout(set = 0, binding = 0) uniform usamplerBuffer listed;
layout(set = 0, binding = 1) uniform usamplerBuffer pairs;
layout(set = 0, binding = 2) uniform usamplerBuffer samples;
layout(set = 0, binding = 3) uniform usamplerBuffer faces;
layout(set = 0, binding = 4) uniform usamplerBuffer pseudonormals;
layout(std430, set = 0, binding = 5) readonly buffer Corners { uint corners[]; };
layout(std430, set = 0, binding = 6) writeonly buffer Distances { float distances[]; };
layout(std430, set = 0, binding = 7) writeonly buffer Nearest { uint nearest[]; };
layout(set = 0, binding = 8) uniform usamplerBuffer nodes;
layout(set = 0, binding = 9) uniform usamplerBuffer dipoles;
layout(set = 0, binding = 10) uniform usamplerBuffer hints;

layout(set = 0, binding = 11) uniform usamplerBuffer candidates;
layout(std430, set = 0, binding = 12) readonly buffer Groups { DispatchGroups groups[]; };

#include "candidate.glsl"
#include "pairs.glsl"
#include "listed.glsl"

// A face and the nearest point on it.
struct Found {
    uint slot;
    uint triangle;
    vec4 point;
};

// The nearest of some faces.
Found nearest_of(uint first, uint end, vec3 place) {
    Found best = Found(NONE, NONE, vec4(0.0, 0.0, FAR, 0.0));
    uvec4 four;
    for (uint k = first; k < end; k++) {
        if (k == first || k % 4u == 0u) four = texelFetch(candidates, int(k / 4u));
        uint slot = four[k % 4u];
        uvec4 corner = texelFetch(faces, int(3u * slot));
        precise vec3 way = place - uintBitsToFloat(corner.xyz);
        vec4 point = nearest_in_face(way, face_word(slot, 1u), face_word(slot, 2u));
        if (is_nearer(point.z, corner.w, best.point.z, best.triangle)) {
            best = Found(slot, corner.w, point);
        }
    }
    return best;
}

Found nearest_in_tree(ObjectPair pair, vec3 place, uint hint, float bound) {
    if (hint != TILE_UNKNOWN) bound = min(bound, sqrt(nearest_on_face(hint, place).z));
    uint slot = nearest_on(pair.first_node, place, bound);
    if (slot == NONE) return Found(NONE, NONE, vec4(0.0));
    return Found(slot, triangle_of(slot), nearest_on_face(slot, place));
}

void main() {
    uint i = invocation_index();
    if (i / TILE_SAMPLES >= params.tile_count || i / TILE_SAMPLES >= groups[1].x) return;
    ListedTile tile = listed_tile(i / TILE_SAMPLES);
    if (i % TILE_SAMPLES >= tile.sample_count) return;
    SurfaceSample here = sample_at(tile.first_sample + i % TILE_SAMPLES);

    float least = params.reach;
    uint triangle = NONE;
    uint first_hint = tile.tile * params.hint_count;
    uint first_candidate = tile.tile * TILE_CANDIDATES;
    for (uint p = 0u; p < tile.pair_count; p++) {
        uint hint = p < params.hint_count ? texelFetch(hints, int(first_hint + p)).x : TILE_UNKNOWN;
        if (hint == TILE_OUTSIDE) continue;
        if (hint == TILE_INSIDE) {
            bool is_least = -params.reach < least;
            least = is_least ? -params.reach : least;
            triangle = is_least ? NONE : triangle;
            continue;
        }
        ObjectPair pair = pair_at(tile.first_pair + p);
        vec3 place = place_in_other(pair, here.position);
        // What lies in a closed object may be inside, however deep.
        bool may_be_inside = pair.is_closed == 1u && is_in_box(pair.first_node, place);
        float bound = may_be_inside ? UNLIMITED : params.reach;
        Found found;
        if (hint >= LIST && hint != TILE_UNKNOWN) {
            found = nearest_of(first_candidate + (hint - LIST) / 256u, first_candidate + hint % 256u, place);
        } else {
            found = nearest_in_tree(pair, place, hint, bound);
        }
        float distance = sqrt(found.point.z);
        if (found.slot == NONE || distance >= bound) continue;
        float candidate = candidate_distance(pair, found.slot, place, found.point, params.reach, params.first_vertex_normal);
        if (candidate < least) {
            least = candidate;
            triangle = distance < params.reach ? found.triangle : NONE;
        }
    }
    distances[here.texel] = least;
    nearest[here.texel] = triangle;
}
