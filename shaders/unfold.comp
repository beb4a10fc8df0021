// unfold: for texels that another object covers, the place on that object where walks continue, so that sensors see it there.
// Reads   jobs, pairs, samples, listed, covered, groups, owners, distances, nearest, triangles, halfedges, corners, vertices, strips.
// Writes  across and across_triangles: covered texels of the objects that have a job, with LISTED those of listed tiles; other texels keep
//         their old values, which are not read. Without LISTED, the marks of surroundings that have changed.
// One invocation per sample of a job, jobs begin at multiples of the group size; with LISTED, one per covered texel. Two planes meet in a
// line. A place behind the line in one plane is as far from it in the other plane, from either side.
// Overflow: cannot happen; nothing is appended.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "index.glsl"
#include "tables.glsl"

layout(local_size_x = 64) in;

layout(constant_id = 0) const bool BORDER_REFLECTS = true;
// With distances by tiles, covered texels are listed, and other texels have no work.
layout(constant_id = 1) const bool LISTED = false;

layout(push_constant) uniform Params {
    uint thread_count;
    uint job_count;
    uint pitch;       // texels from one atlas row to the next
    uint attempts;    // edge crossings that one walk may make: the most of any object
    float threshold;  // world length of signed distance below which a place is covered
    float farthest;   // largest world length behind the line at which places are found
    float deepest;    // world length of signed distance up to which sensors see nothing
    float near;       // world length of signed distance below which a step may lead to where it is covered
    float sight;      // the same of which sensors that walk may get to where it is covered
} params;

layout(std430, set = 0, binding = 0) readonly buffer Jobs { DistanceJob jobs[]; };
READS(uvec4, 9) pairs;
READS(uvec4, 1) samples;
layout(std430, set = 0, binding = 2) readonly buffer Owners { uint owners[]; };
READS(float, 3) distances;
READS(uint, 4) nearest;
READS(uvec4, 5) triangles;
READS(uvec4, 6) halfedges;
READS(uint, 7) corners;
READS(uvec4, 8) vertices;
READS(uvec4, 10) strips;
layout(std430, set = 0, binding = 11) writeonly buffer Across { uint across[]; };
layout(std430, set = 0, binding = 12) writeonly buffer AcrossTriangles { uint across_triangles[]; };
READS(uvec4, 13) listed;
layout(std430, set = 0, binding = 14) readonly buffer Groups { DispatchGroups groups[]; };
READS(uint, 15) covered;
layout(std430, set = 0, binding = 16) buffer Surroundings { uint surroundings[]; };

const bool WALK_CARRIES = false;
#include "jobs.glsl"
#include "pairs.glsl"
#include "listed.glsl"
#include "distance.glsl"
#include "walk.glsl"
#include "frame.glsl"
#include "across.glsl"
#include "strip_table.glsl"
#include "surroundings.glsl"

// Planes that meet at a smaller sine than this meet far away, or nowhere.
const float LEAST_SINE = 0.02;

// The pairs have the poses for which distances were computed.
// The packed position, and the triangle that it is on.
uvec2 place_across(ObjectPair pair, vec3 position, uint own_triangle, uint triangle) {
    uvec4 shape = fetch4(triangles, triangle);
    Frame frame = frame_of(triangle);
    precise vec3 place = place_in_other(pair, position) - frame.origin;
    vec3 normal = frame_of(own_triangle).normal;
    vec3 own_normal = vec3(dot_of(pair.x.xyz, normal), dot_of(pair.y.xyz, normal), dot_of(pair.z.xyz, normal));
    float cosine = dot_of(own_normal, frame.normal);
    float sine = length_of(cross_of(own_normal, frame.normal));
    // A place over the plane is not behind the line: it is covered from afar.
    float depth = positive(-dot_of(place, frame.normal));
    precise float most = params.farthest * sine;
    if (sine < LEAST_SINE || depth > most) return uvec2(NONE);
    float by_sine = reciprocal(sine);
    precise float behind = depth * by_sine;
    // Down the own plane to the line, and from there up the other one.
    precise vec3 to_line = (behind * by_sine) * (frame.normal - cosine * own_normal);
    precise vec3 up = by_sine * (own_normal - cosine * frame.normal);
    // Only the nearest triangle is known, so the walk begins at its nearest point.
    vec2 weights = nearest_weights(uintBitsToFloat(shape.x), uintBitsToFloat(shape.y), uintBitsToFloat(shape.z),
        dot_of(place, frame.p), dot_of(place, frame.h));
    precise vec3 way = to_line + behind * up;
    vec2 flat_way = vec2(dot_of(way, frame.p), dot_of(way, frame.h));
    float distance = root(dot_of(flat_way, flat_way));
    vec2 heading = flat_direction(flat_way);
    Walker w = walker_at(triangle, weights.x, weights.y, heading, distance);
    walk(w, params.attempts, BORDER_REFLECTS);
    vec2 uv = walker_uv(w);
    return uvec2(packed_position(atlas_position(atlas_map_of(w.triangle), uv.x, uv.y), params.pitch), w.triangle);
}

void main() {
    uint i = invocation_index();
    uint first_pair;
    uint pair_count;
    uint sample_index;
    if (LISTED) {
        if (i >= groups[1].x) return;
        uint which = fetch1(covered, i);
        ListedTile tile = listed_tile(which / TILE_SAMPLES);
        first_pair = tile.first_pair;
        pair_count = tile.pair_count;
        sample_index = tile.first_sample + which % TILE_SAMPLES;
    } else {
        if (i >= params.thread_count) return;
        DistanceJob job = jobs[job_of(i, params.job_count)];
        if (i - job.first_thread >= job.sample_count) return;
        first_pair = job.first_pair;
        pair_count = job.pair_count;
        sample_index = job.first_sample + (i - job.first_thread);
    }
    SurfaceSample here = sample_at(sample_index);
    uint triangle = fetch1(nearest, here.texel);
    bool is_marked = LISTED;
    if (!is_marked) {
        float distance = fetch1(distances, here.texel);
        uint marked = marks_at(distance, params.deepest, params.threshold, params.near, params.sight);
        MARK(surroundings, here.texel, marked)
        if ((marked & COVERED) == 0u) return;
    }
    // The other object that the triangle belongs to.
    uint p = first_pair;
    uint last = first_pair + pair_count - 1u;
    ObjectPair pair = pair_at(p);
    while (p < last && triangle - pair.first_face >= pair.face_count) {
        p++;
        pair = pair_at(p);
    }
    uvec2 place = place_across(pair, here.position, owners[sample_index], triangle);
    across[here.texel] = place.x;
    across_triangles[here.texel] = place.y;
}
