// distance: signed distance from an object's texels to the nearest other object, and its nearest triangle.
// Reads   pairs, samples, listed, listed_groups, hints, candidates, nodes, faces, pseudonormals, corners; for signs dipoles.
// Writes  owned texels of distances and nearest, of the tiles that `distance_tiles` has listed; with SEES_ACROSS, the marks of surroundings
//         that have changed; covered texels are listed in covered (appended) and groups.
// One invocation per sample of a listed tile.
// Overflow: cannot happen; covered has room for all samples, and no tree is deeper than a search has room for.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "index.glsl"
#include "tables.glsl"
#include "append.glsl"

layout(local_size_x = 64) in;

layout(constant_id = 0) const uint SIGN_RULE = 0u;
// Sensors see other objects where these cover the surface.
layout(constant_id = 1) const bool SEES_ACROSS = false;

layout(push_constant) uniform Params {
    uint tile_count;           // of all jobs; no more are listed
    uint first_vertex_normal;  // behind those of the half-edges
    uint hint_count;           // a tile
    float reach;               // world length; distances are clamped to it
    float threshold;           // world length of signed distance below which a place is covered
    float deepest;             // world length of signed distance up to which sensors see nothing
    float near;                // world length of signed distance below which a step may lead to where it is covered
    float sight;               // the same of which sensors that walk may get to where it is covered
} params;

READS(uvec4, 0) listed;
READS(uvec4, 1) pairs;
READS(uvec4, 2) samples;
READS(uvec4, 3) faces;
READS(uvec4, 4) pseudonormals;
READS(uint, 5) corners;
layout(std430, set = 0, binding = 6) writeonly buffer Distances { float distances[]; };
layout(std430, set = 0, binding = 7) writeonly buffer Nearest { uint nearest[]; };
READS(uvec4, 8) nodes;
READS(uvec4, 9) dipoles;
READS(uint, 10) hints;

READS(uvec4, 11) candidates;
layout(std430, set = 0, binding = 12) readonly buffer ListedGroups { DispatchGroups listed_groups[]; };
// The invocations that have found covered places.
layout(std430, set = 0, binding = 13) writeonly buffer Covered { uint covered[]; };
layout(std430, set = 0, binding = 14) buffer Surroundings { uint surroundings[]; };
layout(std430, set = 0, binding = 15) buffer Groups { DispatchGroups groups[]; };

#include "candidate.glsl"
#include "pairs.glsl"
#include "listed.glsl"
#include "groups.glsl"
#include "surroundings.glsl"

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
        if (k == first || k % 4u == 0u) four = fetch4(candidates, k / 4u);
        uint slot = four[k % 4u];
        uvec4 corner = fetch4(faces, 4u * slot);
        precise vec3 way = place - uintBitsToFloat(corner.xyz);
        vec4 point = nearest_by_way(slot, way);
        if (is_nearer(point.z, corner.w, best.point.z, best.triangle)) {
            best = Found(slot, corner.w, point);
        }
    }
    return best;
}

Found nearest_in_tree(ObjectPair pair, vec3 place, uint hint, float bound) {
    if (hint != TILE_UNKNOWN) bound = min(bound, root(nearest_on_face(hint, place).z));
    uint slot = nearest_on(pair.first_node, place, bound);
    // A search that ends early with nothing nearer keeps the hint; if the hint is beyond the bound, it does not count.
    if (slot == NONE && hint != TILE_UNKNOWN) slot = hint;
    if (slot == NONE) return Found(NONE, NONE, vec4(0.0));
    return Found(slot, triangle_of(slot), nearest_on_face(slot, place));
}

// Skips pairs, from `p` on, whose side the tile's hints give. Returns the next pair to search.
uint next_to_look_at(ListedTile tile, uint p, inout float least, inout uint triangle) {
    bool is_decided = true;
    while (is_decided && p < tile.pair_count) {
        uint hint = p < tile.hinted ? fetch1(hints, tile.tile * params.hint_count + p) : TILE_UNKNOWN;
        bool is_least = hint == TILE_INSIDE && -params.reach < least;
        least = is_least ? -params.reach : least;
        triangle = is_least ? NONE : triangle;
        is_decided = hint == TILE_OUTSIDE || hint == TILE_INSIDE;
        p += is_decided ? 1u : 0u;
    }
    return p;
}

void main() {
    uint i = invocation_index();
    if (i / TILE_SAMPLES >= params.tile_count || i / TILE_SAMPLES >= listed_groups[1].x) return;
    ListedTile tile = listed_tile(i / TILE_SAMPLES);
    if (i % TILE_SAMPLES >= tile.sample_count) return;
    SurfaceSample here = sample_at(tile.first_sample + i % TILE_SAMPLES);

    float least = params.reach;
    uint triangle = NONE;
    uint first_candidate = tile.tile * TILE_CANDIDATES;
    // Devices that run both sides of every branch execute the whole body in each round of this loop, so there are rounds only for pairs
    // that are searched.
    uint p = next_to_look_at(tile, 0u, least, triangle);
    while (p < tile.pair_count) {
        uint hint = p < tile.hinted ? fetch1(hints, tile.tile * params.hint_count + p) : TILE_UNKNOWN;
        ObjectPair pair = pair_at(tile.first_pair + p);
        vec3 place = place_in_other(pair, here.position);
        // A place in the box of a closed object may be inside, however deep.
        bool may_be_inside = pair.is_closed == 1u && is_in_box(pair.first_node, place);
        float bound = may_be_inside ? UNLIMITED : params.reach;
        Found found;
        if (hint >= LIST && hint != TILE_UNKNOWN) {
            found = nearest_of(first_candidate + (hint - LIST) / 256u, first_candidate + hint % 256u, place);
        } else {
            found = nearest_in_tree(pair, place, hint, bound);
        }
        float distance = root(found.point.z);
        if (found.slot != NONE && distance < bound) {
            float candidate = candidate_distance(pair, found.slot, place, found.point, params.reach, params.first_vertex_normal);
            bool is_least = candidate < least;
            least = is_least ? candidate : least;
            triangle = is_least ? (distance < params.reach ? found.triangle : NONE) : triangle;
        }
        p = next_to_look_at(tile, p + 1u, least, triangle);
    }
    distances[here.texel] = settled(least);
    nearest[here.texel] = triangle;
    if (SEES_ACROSS) {
        uint marked = marks_at(least, params.deepest, params.threshold, params.near, params.sight);
        MARK(surroundings, here.texel, marked)
        if ((marked & COVERED) != 0u) covered[appended(gl_WorkGroupSize.x)] = i;
    }
}
