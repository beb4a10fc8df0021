//! Dipoles that approximate the faces of a node from a distance, for winding numbers: Barill, Dickson, Schmidt, Levin and Jacobson,
//! "Fast Winding Numbers for Soups and Clouds" (2018), to first order.

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};

use super::{Face, Node};

/// All faces of a node as one small one.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Dipole {
    /// The mean place of their areas.
    pub centre: Vec3,
    /// The farthest corner of the node's box is this far from it.
    pub radius: f32,
    /// The sum of their normals, each as long as its face is large.
    pub normal: Vec3,
    /// Nothing.
    pub pad0: u32,
}

#[derive(Clone, Copy, Default)]
struct Sum {
    area: f64,
    moment: DVec3,
    normal: DVec3,
}

impl Sum {
    fn plus(self, other: Self) -> Self {
        Self {
            area: self.area + other.area,
            moment: self.moment + other.moment,
            normal: self.normal + other.normal,
        }
    }
}

/// One for each node.
pub(super) fn dipoles(nodes: &[Node], faces: &[Face]) -> Vec<Dipole> {
    let mut sums = vec![Sum::default(); nodes.len()];
    // Children come after their parents.
    for (i, node) in nodes.iter().enumerate().rev() {
        sums[i] = if node.link < Node::LEAF {
            let children = node.link as usize;
            sums[children].plus(sums[children + 1])
        } else {
            let first = (node.link % Node::LEAF) as usize;
            let leaf = &faces[first..first + (node.link / Node::LEAF) as usize];
            leaf.iter()
                .map(of_face)
                .reduce(Sum::plus)
                .unwrap_or_default()
        };
    }
    let pairs = nodes.iter().zip(&sums);
    pairs
        .map(|(node, sum)| {
            let (low, high) = (node.low.as_dvec3(), node.high.as_dvec3());
            let centre = if sum.area > 0.0 {
                sum.moment / sum.area
            } else {
                0.5 * (low + high)
            };
            let radius = (centre - low).max(high - centre).length();
            Dipole {
                centre: centre.as_vec3(),
                radius: radius as f32,
                normal: sum.normal.as_vec3(),
                pad0: 0,
            }
        })
        .collect()
}

fn of_face(face: &Face) -> Sum {
    let (ab, ac) = (face.ab.as_dvec3(), face.ac.as_dvec3());
    let normal = 0.5 * ab.cross(ac);
    let area = normal.length();
    Sum {
        area,
        moment: area * (face.a.as_dvec3() + (ab + ac) / 3.0),
        normal,
    }
}
