//! Scenes: objects, parameters and the files that hold them.
