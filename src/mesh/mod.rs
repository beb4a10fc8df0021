//! Triangle-mesh geometry: loading, half-edges, the pooled surface, straight walks and the world atlas.
//!
//! Nothing here knows Vulkan or particles.
//!
//! Conventions, stated once:
//! - half-edge `h = 3 * triangle + corner` runs from that corner to the next one of its triangle;
//! - `uv` are the barycentric weights of corners 1 and 2: `P = A + u (B - A) + v (C - A)`;
//! - the tangent frame of a triangle is `p` along `B - A` and `h` perpendicular to it, towards `C`;
//! - closed meshes face outwards: the normal is `(B - A) x (C - A)`.
pub mod atlas;
pub mod surface;
pub mod walk;
