//! Foods that a network reaches, as nodes of its graph.

use glam::DVec3;

use super::parts::{Edge, Graph, Node, NodeKind};
use super::surroundings::Surroundings;
use crate::mesh::surface_distance::SurfaceDistance;
use crate::sim::food::FoodPlace;

impl Graph {
    /// Makes a node of the place where the network is nearest to each food, if it reaches its plate or comes within `near`, scene radii.
    /// Markers, which have no plate, count, too.
    pub fn mark_foods(&mut self, foods: &[FoodPlace], around: &Surroundings<'_>, near: f64) {
        for (number, food) in foods.iter().enumerate() {
            let at = around.place_of(
                food.point.triangle,
                food.point.u as f32,
                food.point.v as f32,
            );
            let reach = food.size / around.radius + near;
            if let Some(node) = self.node_at(at, reach) {
                // Of two foods at one place the first has the node.
                self.nodes[node].food.get_or_insert(number);
            }
        }
    }

    /// The node at the nearest place of the network, which is made if it is none yet.
    fn node_at(&mut self, at: DVec3, reach: f64) -> Option<usize> {
        let away = |place: &[f64; 3]| at.distance(DVec3::from_array(*place));
        let nodes = self
            .nodes
            .iter()
            .enumerate()
            .map(|(i, node)| (away(&node.place), i));
        let node = nodes.min_by(|a, b| a.0.total_cmp(&b.0));
        let points = self.edges.iter().enumerate().flat_map(|(edge, of)| {
            let points = of.points.iter().enumerate();
            points.map(move |(point, place)| (away(place), edge, point))
        });
        let point = points.min_by(|a, b| a.0.total_cmp(&b.0))?;
        match node {
            // The ends of an edge are its nodes.
            Some((distance, i)) if distance <= point.0 + 1e-9 => (distance <= reach).then_some(i),
            _ => (point.0 <= reach).then(|| self.split(point.1, point.2)),
        }
    }

    /// Makes a node of a point of an edge.
    fn split(&mut self, number: usize, point: usize) -> usize {
        let length_of = |points: &[[f64; 3]]| {
            let pairs = points.windows(2);
            let lengths =
                pairs.map(|pair| DVec3::from_array(pair[0]).distance(DVec3::from_array(pair[1])));
            lengths.sum::<f64>()
        };
        let node = self.nodes.len();
        let edge = &mut self.edges[number];
        let rest = edge.points[point..].to_vec();
        edge.points.truncate(point + 1);
        // What is added to the length at ends of lines is shared as the rest is.
        let (before, after) = (length_of(&edge.points), length_of(&rest));
        let share = if before + after > 0.0 {
            before / (before + after)
        } else {
            0.5
        };
        let second = Edge {
            from: node,
            to: edge.to,
            length: (1.0 - share) * edge.length,
            points: rest,
            ..*edge
        };
        (edge.to, edge.length) = (node, share * edge.length);
        let place = second.points[0];
        let object = self.nodes[edge.from].object;
        self.nodes.push(Node {
            kind: NodeKind::Through,
            object,
            place,
            degree: 2,
            food: None,
        });
        self.edges.push(second);
        node
    }
}

/// Distances along the surface between foods, in scene radii; none between objects.
pub fn distances_between(
    foods: &[FoodPlace],
    around: &Surroundings<'_>,
) -> impl Fn(usize, usize) -> Option<f64> {
    let table: Vec<Vec<f64>> = foods
        .iter()
        .map(|from| {
            let distance = SurfaceDistance::new(around.surface, &[from.point], f64::INFINITY);
            let to = foods.iter().map(|to| {
                let point = to.point;
                distance.at(point.triangle, point.u, point.v) / around.radius
            });
            to.collect()
        })
        .collect();
    move |a, b| {
        table
            .get(a)?
            .get(b)
            .copied()
            .filter(|distance| distance.is_finite())
    }
}
