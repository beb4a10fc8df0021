// transfer_out: selected particles leave in world space, for the place where their last step continues on the object that they have
// entered.
// Reads   particle_indices, particles, motions, nearest, strips, triangles, halfedges, corners, vertices, poses, poses_before, physarums,
//         roots, nodes, faces, pseudonormals, dipoles; bias and looks (gutters filled).
// Writes  transfers; flow and flux, by atomic adds.
// One invocation per entry of the lists. During a step objects move evenly from their poses before to those now, and the crossing is that
// of the path relative to the other object, which may have moved over a particle that hardly moved. If the last step does not cross the
// other object (which covered the particle before, or counts as covering from afar), the particle goes to its nearest point. The length of
// the last step is not kept: it is the speed, with a second look that at the particle's new place. A pulse may have made it longer. A particle
// without a near triangle returns to its own place, as does one that would enter a no-go area from outside; the latter also turns round.
// Overflow: cannot happen; selection has taken a place in the lists for each.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "words.glsl"
#include "index.glsl"
#include "tables.glsl"
#include "counted.glsl"

layout(local_size_x = 64) in;

layout(constant_id = 0) const bool BORDER_REFLECTS = true;
layout(constant_id = 1) const uint SIGN_RULE = 0u;
// Some object has its own parameters.
layout(constant_id = 2) const bool OWN_PHYSARUM = false;
// The bias was painted: places attract, repel or may not be entered.
layout(constant_id = 3) const bool PAINTED = false;
// A second look was painted, and there is one.
layout(constant_id = 4) const bool LOOKS = false;

layout(push_constant) uniform Params {
    uint capacity;             // of the lists of transfers
    uint pitch;                // texels from one atlas row to the next
    uint object_count;
    uint attempts;             // edge crossings that one walk may make, unless objects have their own
    uint first_vertex_normal;  // behind those of the half-edges
    uint second_look;          // row of the physarums
} params;

layout(std430, set = 0, binding = 0) buffer FlowBlock { Flow flow[]; };
layout(std430, set = 0, binding = 1) readonly buffer ParticleIndices { uint particle_indices[]; };
PAGED_READS(uvec4, 2) particles;
PAGED_READS(uvec4, 3) motions;
READS(uint, 4) nearest;
READS(uvec4, 5) strips;
layout(std430, set = 0, binding = 6) writeonly buffer Transfers { Transfer transfers[]; };
// From each object (rows) to each.
layout(std430, set = 0, binding = 7) buffer Flux { uint flux[]; };
READS(uvec4, 8) triangles;
READS(uvec4, 9) halfedges;
READS(uint, 10) corners;
READS(uvec4, 11) vertices;
READS(vec4, 12) poses;
layout(std430, set = 0, binding = 13) readonly buffer Physarums { Physarum physarums[]; };
layout(std430, set = 0, binding = 14) readonly buffer Roots { uint roots[]; };
READS(uvec4, 15) nodes;
READS(uvec4, 16) faces;
READS(uvec4, 17) pseudonormals;
READS(uvec4, 18) dipoles;
READS(vec4, 19) poses_before;
READS(float, 20) bias_texels;  // may be absent
READS(float, 21) looks_texels;  // may be absent

const bool WALK_CARRIES = false;
#include "crossing.glsl"
#include "atlas.glsl"
#include "bilinear.glsl"
#include "strip_table.glsl"
#include "texels.glsl"
#include "no_go.glsl"
#include "looks.glsl"

// The nearest triangle of the texel with the largest weight among the four around that have one. Gutter texels have
// none, and a point near a seam may lie in one.
uint nearest_triangle(vec2 position) {
    Blend blend = blend_at(position, params.pitch);
    vec2 f = blend.way;
    precise vec2 rest = 1.0 - f;
    uint texel = blend.texel;
    uint found = NONE;
    float most = -1.0;
    for (uint k = 0u; k < 4u; k += 1u) {
        bool right = (k & 1u) != 0u;
        bool below = (k & 2u) != 0u;
        uint near = fetch1(nearest, texel + (right ? 1u : 0u) + (below ? params.pitch : 0u));
        precise float weight = (right ? f.x : rest.x) * (below ? f.y : rest.y);
        bool better = near != NONE && weight > most;
        found = better ? near : found;
        most = better ? weight : most;
    }
    return found;
}

// Maps a place from one object's space to another's, for these poses.
vec3 place_in(Pose target, Pose source, vec3 position) {
    return place_in_object(target, place_in_world(source, position));
}

// The poses of two objects when the last step began, and now.
struct Standing { Pose source_before; Pose target_before; Pose source_now; Pose target_now; };

// The place of a walker in the target's space, at a time of the last step: 0 is its beginning, 1 its end.
vec3 place_at(float time, Walker w, Standing standing) {
    vec2 uv = walker_uv(w);
    uvec4 shape = fetch4(triangles, w.triangle);
    vec3 position = position_on(shape, frame_of(w.triangle), uv.x, uv.y);
    vec3 before = place_in(standing.target_before, standing.source_before, position);
    vec3 now = place_in(standing.target_now, standing.source_now, position);
    precise vec3 place = now + (1.0 - time) * (before - now);
    return place;
}

// Edge crossings that one walk on an object may make.
uint attempts_on(uint object) {
    return OWN_PHYSARUM ? physarums[object].attempts : params.attempts;
}

// The first crossing of the last step with the target, found by walking back, and the length walked since then.
Meeting meeting_behind(Particle particle, Motion motion, uint source, uint target, float way, out float rest) {
    Meeting first;
    first.slot = NONE;
    rest = 0.0;
    float walked = 0.0;
    Walker w = walker_at(particle.triangle, particle.u, particle.v, vec2(-motion.heading_p, -motion.heading_h), way);
    Standing standing = Standing(pose_in(poses_before, source), pose_in(poses_before, target), pose_of(source), pose_of(target));
    vec3 newer = place_at(1.0, w, standing);
    uint attempts = attempts_on(source);
    bool goes_on = true;
    for (uint i = 0u; goes_on; i += 1u) {
        // To the next edge, over it, and to the following one: each call has one straight segment.
        float before = w.remaining;
        walk(w, min(i, 1u), BORDER_REFLECTS);
        precise float segment = before - w.remaining;
        precise float older_way = walked + segment;
        goes_on = w.status == WALK_OUT_OF_ATTEMPTS && i < attempts;
        precise float time = 1.0 - share(older_way, way);
        vec3 older = place_at(goes_on ? time : 0.0, w, standing);
        Meeting meeting = meeting_between(target, older, newer, flight_of_walker(w), -1.0);
        if (meeting.slot != NONE) {
            first = meeting;
            precise float since = walked + (1.0 - meeting.t) * segment;
            rest = since;
        }
        walked = older_way;
        newer = older;
    }
    return first;
}

// The walker on the target, behind the crossing.
Walker walker_on_target(Meeting meeting, uint source, uint target, float rest) {
    Walker outer = walker_from(meeting, 1.0, rest);
    Walker inner = walker_from(meeting, -1.0, rest);
    walk(outer, attempts_on(target), BORDER_REFLECTS);
    walk(inner, attempts_on(target), BORDER_REFLECTS);
    if (inner_is_better(source, outer, inner, params.first_vertex_normal)) return inner;
    return outer;
}

// The speed of particles on an object, at an atlas position.
float speed_at(uint object, vec2 position) {
    float speed = physarums[OWN_PHYSARUM ? object : 0u].speed;
    if (LOOKS) speed = between(speed, physarums[params.second_look].speed, texel_of(looks, texel_at(position, params.pitch)));
    return speed;
}

bool is_no_go(uint triangle, float u, float v) {
    vec2 position = atlas_position(atlas_map_of(triangle), u, v);
    return texel_of(bias, texel_at(position, params.pitch)) < NO_GO;
}

void main() {
    uint i = invocation_index();
    if (i >= params.capacity || i >= flow[0].leaving) return;
    uint slot = particle_indices[i];
    Particle particle = particle_of(fetch_paged(particles, slot));
    Motion motion = motion_of(fetch_paged(motions, slot));
    uint source = fetch4(triangles, particle.triangle).w;
    vec2 here = atlas_position(atlas_map_of(particle.triangle), particle.u, particle.v);
    uint near = nearest_triangle(here);
    uint triangle = near == NONE ? particle.triangle : near;
    uint target = fetch4(triangles, triangle).w;
    Flight from = flight_of(particle, motion);
    Flight flight = from;
    float left = 0.0;
    bool crosses = false;
    if (near != NONE) {
        precise float way = speed_at(source, here) - motion.pending;
        float rest;
        Meeting meeting = meeting_behind(particle, motion, source, target, positive(way), rest);
        if (meeting.slot != NONE) {
            Walker w = walker_on_target(meeting, source, target, rest);
            triangle = w.triangle;
            left = w.status == WALK_OUT_OF_ATTEMPTS ? w.remaining : 0.0;
            crosses = true;
            flight = flight_of_walker(w);
        } else {
            // A search that has not ended may find no face; then the texel's triangle remains.
            uint face = nearest_on(roots[target], place_of(pose_of(target), flight), UNLIMITED);
            if (face != NONE) triangle = triangle_of(face);
        }
    }
    if (PAINTED && target != source && !is_no_go(particle.triangle, particle.u, particle.v)) {
        Landing landing = landing_on(triangle, flight);
        if (is_no_go(triangle, landing.u, landing.v)) {
            triangle = particle.triangle;
            target = source;
            flight = Flight(from.position, -from.heading, from.normal);
            left = 0.0;
            crosses = false;
        }
    }
    if (crosses) count_one(flow[0].crossed)
    transfers[i] = Transfer(settled(flight.position), slot, settled(flight.heading), source, settled(flight.normal), target,
        triangle, settled(left), crosses ? 2u : 0u, 0u);
    count_one(flux[source * params.object_count + target])
}
