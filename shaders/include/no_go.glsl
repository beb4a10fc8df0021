// no_go: the bias of areas that particles may not enter. Twin: NO_GO_BELOW in src/sim/paint.rs.

#ifndef MYXO_NO_GO
#define MYXO_NO_GO

// A bias below this is that of a no-go area; gutters may mix it with others.
const float NO_GO = -5.0e8;

#endif
