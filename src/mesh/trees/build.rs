//! The bounding volume hierarchy of one object, built by the `obvhs` crate and put into the records that kernels read.

use std::time::Duration;

use bytemuck::{Pod, Zeroable};
use glam::{Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::{Boundable, BvhBuildParams};

use super::Face;

/// A box and its content.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Node {
    /// Lowest corner.
    pub low: Vec3,
    /// Below [`Node::LEAF`] the first of two nodes that lie side by side; else the first face, and in multiples of
    /// `LEAF` how many there are.
    pub link: u32,
    /// Highest corner.
    pub high: Vec3,
    /// Nothing.
    pub pad0: u32,
}

impl Node {
    /// One face, in `link`.
    pub const LEAF: u32 = 1 << 28;
    /// Faces of a leaf at the most; kernels take one more for no leaf at all.
    const MOST_FACES: u32 = 14;
}

/// Most steps from a root to a leaf: as many boxes a search puts aside at the most, and it has room for no more.
pub const GREATEST_DEPTH: usize = 32;

/// Faces of a leaf at the most. The kernel `distance` on two tori one on the other takes 168 ms with 1, 137 with 2, 124
/// with 4 and 120 with 8 (lavapipe, two cores).
const FACES_A_LEAF: u32 = 4;

struct Bounded(Aabb);

impl Boundable for Bounded {
    fn aabb(&self) -> Aabb {
        self.0
    }
}

/// Puts the faces of one object, which is the `first_face`-th and following ones, into the order of the leaves, and
/// appends the nodes, the root first.
pub(super) fn append_tree(nodes: &mut Vec<Node>, faces: &mut [Face], first_face: u32) {
    let bounded: Vec<Bounded> = faces
        .iter()
        .map(|face| {
            let corners = [face.a, face.a + face.ab, face.a + face.ac].map(Vec3A::from);
            Bounded(Aabb::from_points(&corners))
        })
        .collect();
    let params = BvhBuildParams {
        max_prims_per_leaf: FACES_A_LEAF,
        ..BvhBuildParams::medium_build()
    };
    let bvh = build_bvh2(&bounded, params, &mut Duration::default());
    let tree = flat(&bvh);
    let tree = if depth(&tree.nodes) > GREATEST_DEPTH {
        halved(&bounded)
    } else {
        tree
    };
    let sorted: Vec<Face> = tree.order.iter().map(|&i| faces[i as usize]).collect();
    faces.copy_from_slice(&sorted);
    let first_node = nodes.len() as u32;
    nodes.extend(tree.nodes.iter().map(|node| Node {
        link: node.link
            + if node.link < Node::LEAF {
                first_node
            } else {
                first_face
            },
        ..*node
    }));
}

/// Nodes whose links count from the object's own first node and face, and which face lies where.
struct Flat {
    nodes: Vec<Node>,
    order: Vec<u32>,
}

/// The children of a node lie side by side, and whole subtrees lie together.
fn flat(bvh: &Bvh2) -> Flat {
    let mut flat = Flat {
        nodes: vec![Node::zeroed()],
        order: Vec::with_capacity(bvh.primitive_indices.len()),
    };
    // The new index, and the old one.
    let mut open = vec![(0, 0)];
    while let Some((to, from)) = open.pop() {
        let node = &bvh.nodes[from];
        let first = node.first_index as usize;
        let link = if node.is_leaf() {
            assert!(node.prim_count <= Node::MOST_FACES);
            let start = flat.order.len() as u32;
            let end = first + node.prim_count as usize;
            flat.order.extend(&bvh.primitive_indices[first..end]);
            start + node.prim_count * Node::LEAF
        } else {
            let children = flat.nodes.len();
            flat.nodes.extend([Node::zeroed(); 2]);
            open.extend([(children + 1, first + 1), (children, first)]);
            children as u32
        };
        let bounds = node.aabb();
        flat.nodes[to] = Node {
            low: bounds.min.into(),
            link,
            high: bounds.max.into(),
            pad0: 0,
        };
    }
    flat
}

/// The most steps from the root to a leaf.
pub(super) fn depth(nodes: &[Node]) -> usize {
    let mut deepest = 0;
    let mut open = vec![(0, 0)];
    while let Some((node, depth)) = open.pop() {
        deepest = deepest.max(depth);
        let link = nodes[node as usize].link;
        if link < Node::LEAF {
            open.extend([(link, depth + 1), (link + 1, depth + 1)]);
        }
    }
    deepest
}

/// A tree that halves the number of faces at each node, for meshes of which the other kind becomes too deep: triangles
/// in one another, each much smaller than the last.
fn halved(bounded: &[Bounded]) -> Flat {
    let mut flat = Flat {
        nodes: vec![Node::zeroed()],
        order: (0..bounded.len() as u32).collect(),
    };
    let mut open = vec![(0, 0, bounded.len())];
    while let Some((to, start, end)) = open.pop() {
        let faces = &mut flat.order[start..end];
        let mut bounds = Aabb::INVALID;
        for &face in faces.iter() {
            bounds.extend(bounded[face as usize].0.min);
            bounds.extend(bounded[face as usize].0.max);
        }
        let link = if end - start <= FACES_A_LEAF as usize {
            start as u32 + (end - start) as u32 * Node::LEAF
        } else {
            let size = Vec3::from(bounds.max - bounds.min);
            let axis = size.max_position();
            let centre = |face: u32| {
                let Aabb { min, max } = bounded[face as usize].0;
                min[axis] + max[axis]
            };
            // By number for equal places, so that the order is unique.
            faces.sort_unstable_by(|&a, &b| centre(a).total_cmp(&centre(b)).then(a.cmp(&b)));
            let middle = start + (end - start) / 2;
            let children = flat.nodes.len();
            flat.nodes.extend([Node::zeroed(); 2]);
            open.extend([(children + 1, middle, end), (children, start, middle)]);
            children as u32
        };
        flat.nodes[to] = Node {
            low: bounds.min.into(),
            link,
            high: bounds.max.into(),
            pad0: 0,
        };
    }
    flat
}
