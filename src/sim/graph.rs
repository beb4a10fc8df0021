//! The network as a graph: nodes where lines meet or end, edges with lengths, widths and trail.
//!
//! The network is where the trail is more than [`THRESHOLD`](super::network::THRESHOLD) times its mean, as for
//! [`Network`](super::network::Network). Its texels are thinned to lines, over seams and from object to object where they touch, and the
//! lines are followed. All of it is on the host.
//!
//! Lines go on over glued edges, whose two sides lie apart, and so do distances between foods: what lies beyond is carried to where the
//! walk goes on, so that lengths are those along the surface.
//!
//! In atlases by `grid`, small stars may be left on lines where the corners of cells meet.

mod find;
mod foods;
mod links;
mod measures;
mod parts;
mod state;
mod surroundings;
#[cfg(test)]
mod tests;
mod thinning;
mod trace;

pub use measures::{Between, Measures, Pair};
pub use parts::{Edge, Graph, Node, NodeKind};
pub use state::{graph_of, network_of};
pub use surroundings::Surroundings;
