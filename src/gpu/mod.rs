//! Vulkan in small nouns; no meshes, no particles.
