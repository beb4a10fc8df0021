// id_marks: a bit for each particle's id, in two sets: of particles that divide, and of those that are dead. Twin: IdMarks of
// src/sim/step/population.rs.

#ifndef MYXO_ID_MARKS
#define MYXO_ID_MARKS

const uint IDS_IN_A_WORD = 32u;

// Words of a set.
uint words_of_ids(uint count) {
    return (count + (IDS_IN_A_WORD - 1u)) / IDS_IN_A_WORD;
}

// The word of an id in its set, and the bit in the word.
uint word_of_id(uint id) {
    return id / IDS_IN_A_WORD;
}

uint bit_of_id(uint id) {
    return 1u << (id % IDS_IN_A_WORD);
}

// How many ids below this one are marked, of those in its word.
uint marked_below(uint word, uint id) {
    return uint(bitCount(word & (bit_of_id(id) - 1u)));
}

#endif
