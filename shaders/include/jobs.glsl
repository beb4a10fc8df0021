// jobs: which object's distances an invocation computes. Twin of src/sim/step/distance.rs.
// The includer declares `jobs` (DistanceJob[]) first.

#ifndef MYXO_JOBS
#define MYXO_JOBS

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

#endif
