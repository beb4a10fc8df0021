//! CPU twins of the kernels: same names, same arguments, same order of statements; clarity over speed.
