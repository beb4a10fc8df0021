// distance: what the kernels `distance` and `distance_brute` share. Twin of src/sim/twin/distance.rs.
// The includer declares `jobs` (DistanceJob[]) first.

#ifndef MYXO_DISTANCE
#define MYXO_DISTANCE

// As in src/sim/distance.rs: samples side by side share one hint for each other object: a face that is near.
const uint TILE_SAMPLES = 16u;

// Instead of a face: all of a tile is beyond reach, on this side of a closed object; or nothing is known.
const uint TILE_OUTSIDE = 0xffffffffu;
const uint TILE_INSIDE = 0xfffffffeu;
const uint TILE_UNKNOWN = 0xfffffffdu;

// A place in the space of a pair's other object.
vec3 place_in_other(ObjectPair pair, vec3 place) {
    precise float x = ((pair.x.x * place.x + pair.x.y * place.y) + pair.x.z * place.z) + pair.x.w;
    precise float y = ((pair.y.x * place.x + pair.y.y * place.y) + pair.y.z * place.z) + pair.y.w;
    precise float z = ((pair.z.x * place.x + pair.z.y * place.y) + pair.z.z * place.z) + pair.z.w;
    return vec3(x, y, z);
}

// The job that an invocation belongs to: the last one that begins at it or before.
uint job_of(uint thread, uint job_count) {
    uint low = 0u;
    uint high = job_count;
    while (high - low > 1u) {
        uint middle = (low + high) / 2u;
        if (jobs[middle].first_thread <= thread) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

// The signed distance to an object whose nearest face is known, clamped to reach, as it counts against that to others.
// Deep inside a closed object is deep inside; far over an open sheet there is no side.
float clamped_distance(float distance, bool outside, bool is_closed, float reach) {
    bool within = distance < reach;
    float clamped = within ? distance : reach;
    return outside || !(within || is_closed) ? clamped : -clamped;
}

#endif
