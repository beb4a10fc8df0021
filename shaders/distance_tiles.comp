// distance_tiles: which faces of each other object may be nearest to the texels of a tile, so that `distance` examines only those; and
// which tiles need no examination.
// Reads   jobs, pairs, moves, tiles, nodes, faces, pseudonormals, corners; for signs dipoles.
// Writes  hints: one per tile and pair; candidates: the faces; tile_states; margins; listed (appended) and groups.
// One invocation per tile of a job; jobs begin at multiples of a tile. If another object is beyond the reach of a whole tile, no surface of
// it lies between the tile's texels: all are on the same side as the tile's middle. If they were on that side before, they need not be
// written again. The margin by which such a tile may come nearer before anything changes is kept, and there is no search until objects have
// moved by that much.
// Overflow: pairs of a job beyond hint_count have no hint, nor have pairs after one whose search has not ended; `distance` searches them
//         without a hint. If there are more candidates than there is room for, it starts from the one that is nearest to the middle.
//         listed has room for all tiles.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "index.glsl"
#include "tables.glsl"
#include "append.glsl"

layout(local_size_x = 64) in;

layout(constant_id = 0) const uint SIGN_RULE = 0u;

layout(push_constant) uniform Params {
    uint tile_count;           // of all jobs
    uint job_count;
    uint first_vertex_normal;  // behind those of the half-edges
    uint hint_count;           // a tile
    float reach;               // world length; distances are clamped to it
    uint is_first;             // 1 where texels do not hold what tile_states say
} params;

layout(std430, set = 0, binding = 0) readonly buffer Jobs { DistanceJob jobs[]; };
READS(uvec4, 1) pairs;
layout(std430, set = 0, binding = 2) readonly buffer Tiles { SampleTile tiles[]; };
READS(uvec4, 3) faces;
READS(uvec4, 4) pseudonormals;
READS(uint, 5) corners;
layout(std430, set = 0, binding = 6) writeonly buffer Hints { uint hints[]; };
READS(uvec4, 7) nodes;
READS(uvec4, 8) dipoles;
layout(std430, set = 0, binding = 9) writeonly buffer Candidates { uint candidates[]; };
layout(std430, set = 0, binding = 10) buffer TileStates { uint tile_states[]; };
layout(std430, set = 0, binding = 11) writeonly buffer Listed { ListedTile listed[]; };
layout(std430, set = 0, binding = 12) buffer Groups { DispatchGroups groups[]; };
// One per pair: the largest distance by which places of the one object have moved in the other's space since the last update.
layout(std430, set = 0, binding = 13) readonly buffer Moves { float moves[]; };
// hint_count for each tile of every object: how much farther than reach it is, negative inside of the other object; 0 if it may be within
// reach.
layout(std430, set = 0, binding = 14) buffer Margins { float margins[]; };

#include "sign.glsl"
#include "distance.glsl"
#include "groups.glsl"
#include "jobs.glsl"
#include "pairs.glsl"

// Bound on the rounding of distances that are compared over many updates, in slacks.
const float MARGIN_SLACK = 8.0;

// A ball of places, and the face that is nearest to its middle.
struct Ball {
    vec3 middle;
    float radius_square;
    float distance;  // of that face from the middle
    vec3 direction;  // the unit vector from there
    float bend;      // bound on the change of its distance over the ball besides that along `direction`
    float farthest;  // the most by which a candidate may be farther from the middle
};

Ball ball_of(uint tree, uint slot, vec4 point, vec3 place, SampleTile tile) {
    precise vec3 to_face = (face_word(slot, 0u) + point.x * face_word(slot, 1u)) + point.y * face_word(slot, 2u);
    precise vec3 way = place - to_face;
    precise vec3 from_middle = abs(tile.center) + abs(place);
    precise float slack = 8.0 * slack_of_tree(tree) + 4.0 * ROUNDING * max(max(from_middle.x, from_middle.y), from_middle.z);
    precise float radius = 1.001 * tile.radius + slack;
    float distance = root(point.z);
    precise float more_slack = slack + 1.0e-5 * (distance + radius);
    precise float farthest = 2.0 * radius + more_slack;
    precise float rest = distance - radius;
    precise float bend = (0.5 * radius) * quotient(radius, rest) + more_slack;
    precise float radius_square = radius * radius;
    Ball ball;
    ball.middle = place;
    ball.radius_square = radius_square;
    ball.distance = distance;
    ball.direction = direction_or(way, vec3(0.0));
    ball.bend = rest > 0.0 ? min(bend, farthest) : farthest;
    ball.farthest = farthest;
    return ball;
}

// May a convex shape hold the nearest point for some place in the ball? `way` leads from its point nearest to the middle to the middle.
// Since the shape is convex, its distance over the ball is at least the one extrapolated along `way`; that of the nearest face is at most
// the one extrapolated along `direction`, plus `bend`. Therefore the difference shrinks no faster than the two directions differ. Squares
// are compared, which saves roots.
bool may_be_nearest(Ball ball, vec3 way) {
    float square = dot_of(way, way);
    float by = inverse_root(square);
    precise float distance = square * by;
    precise float more = distance - ball.distance;
    precise vec3 turned = way * by - ball.direction;
    precise float turn_square = ball.radius_square * dot_of(turned, turned);
    precise float beyond = more - ball.bend;
    precise float beyond_square = beyond * beyond;
    return more <= ball.farthest && (beyond <= 0.0 || beyond_square <= turn_square);
}

vec3 way_from_box(vec3 place, int node) {
    vec3 low = uintBitsToFloat(fetch4(nodes, 2 * node).xyz);
    vec3 high = uintBitsToFloat(fetch4(nodes, 2 * node + 1).xyz);
    precise vec3 way = place - clamp(place, low, high);
    return way;
}

// Puts the faces into candidates, from `first` up to `room`, that are nearest to some place in the ball, and maybe others.
// Returns the end, more than `room` if there are too many.
uint collected(uint root, Ball ball, uint first, uint room, uint first_candidate) {
    uint stack[GREATEST_DEPTH];
    uint top = 0u;
    uint end = first;
    uint link = fetch4(nodes, 2u * root).w;
    bool searches = true;
    while (searches) {
        // Continues to a leaf, as neighbouring invocations do: devices that run both sides of every branch then examine faces together.
        if (link < LEAF) {
            while (true) {
                bool may_be_a = may_be_nearest(ball, way_from_box(ball.middle, int(link)));
                bool may_be_b = may_be_nearest(ball, way_from_box(ball.middle, int(link + 1u)));
                uint link_a = fetch4(nodes, 2u * link).w;
                uint link_b = fetch4(nodes, 2u * link + 2u).w;
                if (may_be_a && may_be_b) {
                    stack[top] = link_a;
                    top++;
                }
                link = may_be_b ? link_b : may_be_a ? link_a : NOTHING;
                if (link == NOTHING && top > 0u) {
                    top--;
                    link = stack[top];
                }
                if (link >= LEAF) break;
            }
        }
        uint last = link == NOTHING ? 0u : (link % LEAF) + link / LEAF;
        uint slot = link % LEAF;
        if (slot < last) {
            while (true) {
                precise vec3 way = ball.middle - face_word(slot, 0u);
                vec4 point = nearest_by_way(slot, way);
                if (may_be_nearest(ball, rest_of(way, face_word(slot, 1u), face_word(slot, 2u), point.x, point.y))) {
                    if (end < room) candidates[first_candidate + end] = slot;
                    end++;
                }
                slot++;
                if (slot >= last) break;
            }
        }
        searches = top > 0u && end <= room;
        if (searches) {
            top--;
            link = stack[top];
        }
    }
    return end;
}

// A place inside any other object is inside.
uint state_with(uint state, uint hint) {
    return hint < TILE_INSIDE || state == TILE_UNKNOWN ? TILE_UNKNOWN : min(state, hint);
}

// With some rules the side may change where there is no surface.
bool decides(bool is_closed) {
    return SIGN_RULE == SIGN_PSEUDONORMAL || !is_closed;
}

// Skips pairs, from `p` on, that have moved less than their margins. Returns the next one that must be searched.
uint next_to_search(uint p, uint end, uint first_pair, uint first_margin, uint first_hint, bool are_known, inout uint state) {
    bool stays = true;
    while (stays && p < end) {
        float margin = margins[first_margin + p];
        precise float left = abs(margin) - moves[first_pair + p];
        bool is_closed = fetch4(pairs, 4u * (first_pair + p) + 3u).w == 1u;
        stays = are_known && left > 0.0 && decides(is_closed);
        if (stays) {
            uint hint = margin < 0.0 ? TILE_INSIDE : TILE_OUTSIDE;
            margins[first_margin + p] = margin < 0.0 ? -left : left;
            hints[first_hint + p] = hint;
            state = state_with(state, hint);
            p++;
        }
    }
    return p;
}

void main() {
    uint i = invocation_index();
    if (i >= params.tile_count) return;
    DistanceJob job = jobs[job_of(i * TILE_SAMPLES, params.job_count)];
    uint in_job = i - job.first_thread / TILE_SAMPLES;
    if (in_job * TILE_SAMPLES >= job.sample_count) return;
    SampleTile tile = tiles[job.first_tile + in_job];
    precise float near = params.reach + tile.radius;
    // The state of all its texels, while it is uniform.
    uint state = job.pair_count <= params.hint_count ? TILE_OUTSIDE : TILE_UNKNOWN;
    uint pairs_end = min(job.pair_count, params.hint_count);
    uint first_margin = (job.first_tile + in_job) * params.hint_count;
    uint first_hint = i * params.hint_count;
    uint end = 0u;

    // Devices that run both sides of every branch execute a whole search in each round of this loop, so there are rounds only for pairs
    // that are searched.
    bool are_known = tile_states[job.first_tile + in_job] != TILE_UNDECIDED;
    uint p = next_to_search(0u, pairs_end, job.first_pair, first_margin, first_hint, are_known, state);
    while (p < pairs_end) {
        ObjectPair pair = pair_at(job.first_pair + p);
        vec3 place = place_in_other(pair, tile.center);
        bool is_closed = pair.is_closed == 1u;
        bool is_decided = decides(is_closed);
        bool may_be_inside = is_closed && is_in_box(pair.first_node, place);
        // Searches farther than needed, so that the next search is not due soon.
        precise float twice_as_far = near + params.reach;
        float limit = may_be_inside ? UNLIMITED : is_decided ? twice_as_far : near;
        uint slot = nearest_on(pair.first_node, place, limit);
        uint hint = is_decided ? TILE_OUTSIDE : TILE_UNKNOWN;
        float slack = slack_of_tree(pair.first_node);
        float margin = 0.0;
        if (slot == NONE) {
            precise float beyond_reach = params.reach - MARGIN_SLACK * slack;
            margin = is_decided && beyond_reach > 0.0 ? beyond_reach : 0.0;
        } else {
            vec4 point = nearest_on_face(slot, place);
            float distance = root(point.z);
            precise float beyond = near + slack;
            bool searches = distance <= beyond || !is_decided;
            if (searches) {
                Ball ball = ball_of(pair.first_node, slot, point, place, tile);
                uint first = end;
                end = collected(pair.first_node, ball, first, TILE_CANDIDATES, i * TILE_CANDIDATES);
                bool have_room = end <= TILE_CANDIDATES;
                hint = have_room ? LIST + 256u * first + end : slot;
                end = have_room ? end : first;
            } else {
                bool inside = is_closed && !is_outside(pair.first_node, slot, place, point, params.first_vertex_normal);
                hint = inside ? TILE_INSIDE : TILE_OUTSIDE;
                precise float rest = (distance - beyond) - MARGIN_SLACK * slack;
                margin = rest > 0.0 ? (inside ? -rest : rest) : 0.0;
            }
        }
        if (!searches_ended()) {
            // There may be nearer faces: then `distance` starts its search from the one that was found.
            hint = slot == NONE ? TILE_UNKNOWN : hint < TILE_UNDECIDED ? slot : hint;
            margin = 0.0;
        }
        margins[first_margin + p] = margin;
        hints[first_hint + p] = hint;
        state = state_with(state, hint);
        p = next_to_search(p + 1u, pairs_end, job.first_pair, first_margin, first_hint, are_known, state);
    }
    // If a search has not ended, this loop has not either: the sides and margins of the remaining pairs are unknown.
    if (p != pairs_end) state = TILE_UNDECIDED;
    if (state == TILE_UNDECIDED || state == TILE_UNKNOWN || params.is_first == 1u || tile_states[job.first_tile + in_job] != state) {
        uint first = in_job * TILE_SAMPLES;
        uint count = min(job.sample_count - first, TILE_SAMPLES);
        listed[appended(gl_WorkGroupSize.x / TILE_SAMPLES)] = ListedTile(i, job.first_sample + first, count, job.first_pair, job.pair_count, p, 0u, 0u);
    }
    tile_states[job.first_tile + in_job] = state;
}
