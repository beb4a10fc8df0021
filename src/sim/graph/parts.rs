//! What a network's graph is made of.

use glam::DVec3;
use serde::Serialize;

/// The network as a graph.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Graph {
    /// Where lines meet or end.
    pub nodes: Vec<Node>,
    /// Lines between nodes.
    pub edges: Vec<Edge>,
}

/// What a node is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum NodeKind {
    /// Lines meet.
    Junction,
    /// A line ends.
    End,
    /// A part of the network without lines.
    Spot,
    /// Any place on a loop at which nothing branches.
    Loop,
    /// A line goes through it; it is a node for the food there.
    Through,
}

/// A node.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Node {
    /// What it is.
    pub kind: NodeKind,
    /// The object it lies on.
    pub object: u32,
    /// Its place in world coordinates, in scene radii from the world's origin.
    pub place: [f64; 3],
    /// How many edges end here; one from here to here counts twice.
    pub degree: usize,
    /// The width of the network there, scene radii.
    pub width: f64,
    /// The foods that it reaches there.
    pub foods: Vec<usize>,
}

/// An edge.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Edge {
    /// The node at its beginning.
    pub from: usize,
    /// The node at its end.
    pub to: usize,
    /// Its length, scene radii. A line that ends is counted up to the border of the network.
    pub length: f64,
    /// Its length from node to node.
    pub way: f64,
    /// What is counted beyond its first and its last node.
    #[serde(skip)]
    pub beyond: [f64; 2],
    /// Its mean width, scene radii.
    pub width: f64,
    /// The mean trail on it, trail units.
    pub trail: f64,
    /// Points along it, from node to node, as [`Node::place`].
    pub points: Vec<[f64; 3]>,
    /// The object that each of them lies on.
    #[serde(skip)]
    pub objects: Vec<u32>,
    /// How far each of them is from the border of the network, scene radii.
    #[serde(skip)]
    pub half_widths: Vec<f64>,
    /// Numbers of the points before which it goes over a glued edge, whose two sides lie apart.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub breaks: Vec<usize>,
}

impl Edge {
    /// Its points, in pieces between which it goes over a glued edge.
    pub fn pieces(&self) -> impl Iterator<Item = &[[f64; 3]]> {
        let mut first = 0;
        let ends = self.breaks.iter().copied().chain([self.points.len()]);
        ends.map(move |end| {
            let piece = &self.points[first..end];
            first = end;
            piece
        })
    }

    /// Its points, in pieces that each lie on one object, with that object, and between which it goes over a glued edge or to another
    /// object. A step to another object is the end of the piece that it leaves. A piece is a single point where only the last point of the
    /// edge, or the last before a glued edge, lies on its object.
    ///
    /// # Panics
    /// If not every point has its object.
    #[must_use]
    pub fn pieces_by_object(&self) -> Vec<(u32, &[[f64; 3]])> {
        let mut pieces = Vec::new();
        let mut first = 0;
        for end in self.breaks.iter().copied().chain([self.points.len()]) {
            while first < end {
                let object = self.objects[first];
                let others = (first..end).find(|&point| self.objects[point] != object);
                let next = others.unwrap_or(end);
                pieces.push((object, &self.points[first..end.min(next + 1)]));
                first = next;
            }
        }
        pieces
    }

    /// The length of its points, without the steps over glued edges.
    pub(super) fn length_of_points(&self) -> f64 {
        let steps = self.pieces().flat_map(|piece| piece.windows(2));
        let lengths =
            steps.map(|step| DVec3::from_array(step[0]).distance(DVec3::from_array(step[1])));
        lengths.sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Would catch: a step to another object that is drawn twice or not at all, and a piece over a glued edge.
    #[test]
    fn pieces_end_where_objects_and_sides_do() {
        let points: Vec<[f64; 3]> = (0..7).map(|x| [f64::from(x), 0.0, 0.0]).collect();
        let edge = Edge {
            from: 0,
            to: 0,
            length: 6.0,
            way: 6.0,
            beyond: [0.0; 2],
            width: 0.1,
            trail: 1.0,
            points,
            objects: vec![2, 2, 0, 0, 0, 0, 1],
            half_widths: Vec::new(),
            breaks: vec![4],
        };
        let pieces = edge.pieces_by_object();
        let ends = pieces.iter().map(|(object, piece)| {
            let [first, .., last] = piece else {
                return (*object, piece[0][0], piece[0][0]);
            };
            (*object, first[0], last[0])
        });
        let ends: Vec<(u32, f64, f64)> = ends.collect();
        let wanted = [(2, 0.0, 2.0), (0, 2.0, 3.0), (0, 4.0, 6.0), (1, 6.0, 6.0)];
        assert_eq!(ends, wanted);
    }
}
