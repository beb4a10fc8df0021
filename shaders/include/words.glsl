// words: particles and motions as texels of four words. There may be more of them than a storage block holds.

#ifndef MYXO_WORDS
#define MYXO_WORDS

#include "types.glsl"

Particle particle_of(uvec4 words) {
    return Particle(words.x, uintBitsToFloat(words.y), uintBitsToFloat(words.z), words.w);
}

Motion motion_of(uvec4 words) {
    return Motion(uintBitsToFloat(words.x), uintBitsToFloat(words.y), uintBitsToFloat(words.z), words.w);
}

uvec4 words_of(Particle particle) {
    return uvec4(particle.triangle, floatBitsToUint(particle.u), floatBitsToUint(particle.v), particle.id);
}

uvec4 words_of(Motion motion) {
    return uvec4(floatBitsToUint(motion.heading_p), floatBitsToUint(motion.heading_h), floatBitsToUint(motion.pending), motion.flags);
}

#endif
