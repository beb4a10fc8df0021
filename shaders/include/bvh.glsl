// bvh: searches in the tree of one object, in object space: the nearest face to a place, and the first face that a
// segment crosses. Twin of src/mesh/trees/search.rs.
// The includer declares `nodes` first, a table of two words, and what nearest.glsl needs.
//
// A box is skipped only if it is farther than the nearest face by more than rounding. Therefore the result is the face that examining every
// face would give, in any order.
//
// Inner loops test at their end whether they continue. If they did at the beginning, lavapipe would execute the body once more, with all
// invocations masked out.

#ifndef MYXO_BVH
#define MYXO_BVH

#include "tables.glsl"
#include "nearest.glsl"

// As in src/mesh/trees/build.rs.
const uint LEAF = 1u << 28u;
const uint GREATEST_DEPTH = 32u;

// A leaf without faces.
const uint NOTHING = 15u << 28u;

// More than any square.
const float FAR = 3.0e38;

// A reach to which everything is near.
const float UNLIMITED = 1.0e18;

// Bound on the rounding of a length in a tree, relative to its largest coordinate.
const float ROUNDING = 1.0e-6;

// Bounds on the relative rounding of a length, so that its square is not below that of the exact distance, and of its square.
const float LENGTH_ROUNDING = 1.000001;
const float SQUARE_ROUNDING = 1.000003;

float box_square(vec3 place, vec3 low, vec3 high) {
    precise vec3 way = max(max(low - place, place - high), vec3(0.0));
    return dot_of(way, way);
}

// Bound on the rounding of a length in a tree.
float slack_of(uvec4 root_low, uvec4 root_high) {
    vec3 extent = max(abs(uintBitsToFloat(root_low.xyz)), abs(uintBitsToFloat(root_high.xyz)));
    precise float slack = ROUNDING * max(max(extent.x, extent.y), extent.z);
    return slack;
}

float slack_of_tree(uint root) {
    return slack_of(fetch4(nodes, 2u * root), fetch4(nodes, 2u * root + 1u));
}

// Squared distance up to which boxes may hold a face that is nearer than `distance`.
float limit_of(float distance, float slack) {
    precise float most = distance * LENGTH_ROUNDING + slack;
    precise float square = most * most;
    return min(square, FAR);
}

// As limit_of, from the squared distance. Instead of the root it takes a number that is up to 7 % larger, found by integer arithmetic.
float limit_of_square(float square, float slack) {
    float above = uintBitsToFloat(0x1fc00000u + (floatBitsToUint(square) >> 1u));
    precise float limit = (square * SQUARE_ROUNDING + (2.0 * slack) * above) + slack * slack;
    return min(limit, FAR);
}

// Does a place lie in the box round an object?
bool is_in_box(uint root, vec3 place) {
    vec3 low = uintBitsToFloat(fetch4(nodes, 2u * root).xyz);
    vec3 high = uintBitsToFloat(fetch4(nodes, 2u * root + 1u).xyz);
    return all(greaterThanEqual(place, low)) && all(lessThanEqual(place, high));
}

// The slot of the face nearest to a place, NONE if none is nearer than reach (or little more). nearest_on_face gives the point on it.
uint nearest_on(uint root, vec3 place, float reach) {
    uint stack_link[GREATEST_DEPTH];
    float stack_square[GREATEST_DEPTH];
    uint top = 0u;

    uvec4 low = fetch4(nodes, 2u * root);
    uvec4 high = fetch4(nodes, 2u * root + 1u);
    float slack = slack_of(low, high);
    float limit = limit_of(reach, slack);
    float best_square = FAR;
    uint best_triangle = NONE;
    uint best_slot = NONE;
    uint link = low.w;
    bool searches = box_square(place, uintBitsToFloat(low.xyz), uintBitsToFloat(high.xyz)) <= limit;
    while (searches) {
        // Down to a leaf, the nearer box first; the other one is put aside.
        if (link < LEAF) {
            while (true) {
                int child = int(2u * link);
                uvec4 low_a = fetch4(nodes, child);
                uvec4 high_a = fetch4(nodes, child + 1);
                uvec4 low_b = fetch4(nodes, child + 2);
                uvec4 high_b = fetch4(nodes, child + 3);
                float square_a = box_square(place, uintBitsToFloat(low_a.xyz), uintBitsToFloat(high_a.xyz));
                float square_b = box_square(place, uintBitsToFloat(low_b.xyz), uintBitsToFloat(high_b.xyz));
                bool a_first = square_a <= square_b;
                float far_square = a_first ? square_b : square_a;
                if (far_square <= limit) {
                    stack_link[top] = a_first ? low_b.w : low_a.w;
                    stack_square[top] = far_square;
                    top++;
                }
                link = min(square_a, square_b) > limit ? NOTHING : a_first ? low_a.w : low_b.w;
                if (link >= LEAF) break;
            }
        }
        uint end = link == NOTHING ? 0u : (link % LEAF) + link / LEAF;
        uint slot = link % LEAF;
        if (slot < end) {
            while (true) {
                uvec4 first = fetch4(faces, 4u * slot);
                precise vec3 way = place - uintBitsToFloat(first.xyz);
                float square = nearest_by_way(slot, way).z;
                if (is_nearer(square, first.w, best_square, best_triangle)) {
                    best_square = square;
                    best_triangle = first.w;
                    best_slot = slot;
                }
                slot++;
                if (slot >= end) break;
            }
        }
        limit = min(limit, limit_of_square(best_square, slack));
        searches = false;
        if (top > 0u) {
            while (true) {
                top--;
                link = stack_link[top];
                searches = stack_square[top] <= limit;
                if (searches || top == 0u) break;
            }
        }
    }
    return best_slot;
}

// The first crossing of a segment with a surface.
struct Crossing {
    uint slot;  // NONE if nowhere
    float t;    // how much of the way from its start
    float u;    // weights of B and C
    float v;
};

// How far outside of a triangle, in weights, a crossing still counts, so that no segment passes between two triangles.
const float CROSSING_MARGIN = 1.0e-6;

// The share of a segment, in [0, 1], at which it enters a box enlarged by slack; FAR if it doesn't.
float entry_of(vec3 from, vec3 inverse, vec3 low, vec3 high, float slack) {
    precise vec3 to_low = ((low - slack) - from) * inverse;
    precise vec3 to_high = ((high + slack) - from) * inverse;
    vec3 enters = min(to_low, to_high);
    vec3 leaves = max(to_low, to_high);
    float enter = max(max(enters.x, enters.y), max(enters.z, 0.0));
    float leave = min(min(leaves.x, leaves.y), min(leaves.z, 1.0));
    return enter <= leave ? enter : FAR;
}

// The first face that the segment from a place to another crosses, both included; the one with the lowest triangle, of several at the same
// place. Moeller and Trumbore (1997).
Crossing first_crossing(uint root, vec3 from, vec3 to) {
    uint stack_link[GREATEST_DEPTH];
    float stack_entry[GREATEST_DEPTH];
    uint top = 0u;

    Crossing best;
    best.slot = NONE;
    best.t = FAR;
    best.u = 0.0;
    best.v = 0.0;
    uint best_triangle = NONE;

    precise vec3 way = to - from;
    // Along an axis that the segment does not move on, it is in the slab or far outside: the reciprocal of 0 is 2^100.
    vec3 inverse = vec3(reciprocal(way.x), reciprocal(way.y), reciprocal(way.z));
    uvec4 root_low = fetch4(nodes, 2u * root);
    uvec4 root_high = fetch4(nodes, 2u * root + 1u);
    float slack = slack_of(root_low, root_high);
    uint link = root_low.w;
    bool searches = entry_of(from, inverse, uintBitsToFloat(root_low.xyz), uintBitsToFloat(root_high.xyz), slack) < FAR;
    while (searches) {
        if (link < LEAF) {
            while (true) {
                int child = int(2u * link);
                uvec4 low_a = fetch4(nodes, child);
                uvec4 high_a = fetch4(nodes, child + 1);
                uvec4 low_b = fetch4(nodes, child + 2);
                uvec4 high_b = fetch4(nodes, child + 3);
                float entry_a = entry_of(from, inverse, uintBitsToFloat(low_a.xyz), uintBitsToFloat(high_a.xyz), slack);
                float entry_b = entry_of(from, inverse, uintBitsToFloat(low_b.xyz), uintBitsToFloat(high_b.xyz), slack);
                bool a_first = entry_a <= entry_b;
                float far_entry = a_first ? entry_b : entry_a;
                if (far_entry < FAR && far_entry <= best.t) {
                    stack_link[top] = a_first ? low_b.w : low_a.w;
                    stack_entry[top] = far_entry;
                    top++;
                }
                float near_entry = min(entry_a, entry_b);
                link = near_entry == FAR || near_entry > best.t ? NOTHING : a_first ? low_a.w : low_b.w;
                if (link >= LEAF) break;
            }
        }
        uint end = link == NOTHING ? 0u : (link % LEAF) + link / LEAF;
        uint slot = link % LEAF;
        if (slot < end) {
            while (true) {
                uvec4 first = fetch4(faces, 4u * slot);
                vec3 ab = face_word(slot, 1u);
                vec3 ac = face_word(slot, 2u);
                precise vec3 start = from - uintBitsToFloat(first.xyz);
                vec3 across = cross_of(way, ac);
                float volume = dot_of(ab, across);
                vec3 along = cross_of(start, ab);
                float by = reciprocal(volume);
                precise float u = dot_of(start, across) * by;
                precise float v = dot_of(way, along) * by;
                precise float w = (1.0 - u) - v;
                // The end belongs to the segment. Whether it is passed is decided without the division, which rounds.
                float from_plane = dot_of(ac, along);
                float passed = volume < 0.0 ? -from_plane : from_plane;
                float size = abs(volume);
                precise float part = passed * abs(by);
                float t = passed >= size ? 1.0 : within(part, 0.0, 1.0);
                bool crosses = u >= -CROSSING_MARGIN && v >= -CROSSING_MARGIN && w >= -CROSSING_MARGIN && passed >= 0.0 && passed <= size && size >= LEAST_SIZE;
                if (crosses && is_nearer(t, first.w, best.t, best_triangle)) {
                    best.slot = slot;
                    best.t = t;
                    best.u = within(u, 0.0, 1.0);
                    precise float most = 1.0 - best.u;
                    best.v = within(v, 0.0, most);
                    best_triangle = first.w;
                }
                slot++;
                if (slot >= end) break;
            }
        }
        searches = false;
        if (top > 0u) {
            while (true) {
                top--;
                link = stack_link[top];
                searches = stack_entry[top] <= best.t;
                if (searches || top == 0u) break;
            }
        }
    }
    return best;
}

#endif
