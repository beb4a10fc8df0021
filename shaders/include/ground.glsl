// ground: the square under a scene in which shadows lie, in cells.

#ifndef MYXO_GROUND
#define MYXO_GROUND

// Cells along a side; as SIDE in src/render/renderer/ground.rs.
const uint SIDE = 128u;

#endif
