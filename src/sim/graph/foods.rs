//! Foods that a network reaches, as nodes of its graph.

use glam::DVec3;
use rayon::prelude::*;

use super::parts::{Edge, Graph, Node, NodeKind};
use super::surroundings::Surroundings;
use crate::mesh::surface_distance::SurfaceDistance;
use crate::sim::food::FoodPlace;

/// A food, and how far from it a network may be to reach it.
struct Sought {
    object: u32,
    /// Its place, and where walks over glued edges come to it, as [`Node::place`].
    places: Vec<DVec3>,
    /// From the food to the side of a line, scene radii.
    reach: f64,
}

impl Sought {
    fn away(&self, place: &[f64; 3]) -> f64 {
        let place = DVec3::from_array(*place);
        let away = self.places.iter().map(|own| own.distance(place));
        away.fold(f64::INFINITY, f64::min)
    }
}

impl Graph {
    /// Makes a node of the place where the network is nearest to each food, on its object, if it reaches its plate or comes within `near`,
    /// scene radii. Markers, which have no plate, count, too.
    pub fn mark_foods(&mut self, foods: &[FoodPlace], around: &Surroundings<'_>, near: f64) {
        let motions = around.motions();
        for (number, food) in foods.iter().enumerate() {
            let point = food.point;
            let at = around.place_of(point.triangle, point.u as f32, point.v as f32);
            let beyond = Surroundings::carried(&motions, food.object, at);
            let places = std::iter::once(at).chain(beyond);
            let sought = Sought {
                object: food.object,
                places: places.map(|place| around.in_world(place)).collect(),
                reach: food.size / around.radius + near,
            };
            if let Some(node) = self.node_at(&sought) {
                self.nodes[node].foods.push(number);
            }
        }
    }

    /// The node at the place of the network on the food's object that is nearest to it, if it is within reach. It is made if there is none
    /// yet.
    fn node_at(&mut self, food: &Sought) -> Option<usize> {
        let nodes = self.nodes.iter().enumerate();
        let nodes = nodes.filter(|(_, node)| node.object == food.object);
        let nodes = nodes.map(|(i, node)| (food.away(&node.place), 0.5 * node.width, i));
        let reaching = nodes.filter(|(away, half, _)| *away <= food.reach + half);
        let reaching = reaching.min_by(|a, b| a.0.total_cmp(&b.0));
        let points = self.edges.iter().enumerate().flat_map(|(number, edge)| {
            // The ends of an edge are its nodes.
            let inner = 1..edge.points.len().saturating_sub(1);
            let inner = inner.filter(|&point| edge.objects[point] == food.object);
            inner.map(move |point| {
                let away = food.away(&edge.points[point]);
                (away, edge.half_widths[point], (number, point))
            })
        });
        // The nearest one that reaches it: a thin line may be nearer than a broad one, and not reach it.
        let points = points.filter(|(away, half, _)| *away <= food.reach + half);
        let point = points.min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((beside, _, (edge, point))) = point else {
            return reaching.map(|(.., node)| node);
        };
        // A node within the width of the line is taken, so that no edge is shorter than that.
        if let Some((away, half, node)) = reaching
            && away <= beside + half
        {
            return Some(node);
        }
        let place = DVec3::from_array(self.edges[edge].points[point]);
        let is_there = |node: &Node| {
            node.object == food.object
                && DVec3::from_array(node.place).distance(place) <= 0.5 * node.width
        };
        let there = self.nodes.iter().position(is_there);
        Some(there.unwrap_or_else(|| self.split(edge, point, food.object)))
    }

    /// Makes a node of an inner point of an edge.
    fn split(&mut self, number: usize, point: usize, object: u32) -> usize {
        let node = self.nodes.len();
        let edge = &mut self.edges[number];
        let mut second = Edge {
            from: node,
            points: edge.points[point..].to_vec(),
            objects: edge.objects[point..].to_vec(),
            half_widths: edge.half_widths[point..].to_vec(),
            breaks: Vec::new(),
            ..*edge
        };
        edge.to = node;
        edge.points.truncate(point + 1);
        edge.objects.truncate(point + 1);
        edge.half_widths.truncate(point + 1);
        for place in std::mem::take(&mut edge.breaks) {
            match place > point {
                true => second.breaks.push(place - point),
                false => edge.breaks.push(place),
            }
        }
        // Points lie on the surface, and the way between them is shared as its parts are. What is beyond the ends stays there.
        let (before, after) = (edge.length_of_points(), second.length_of_points());
        let share = if before + after > 0.0 {
            before / (before + after)
        } else {
            0.5
        };
        (edge.way, second.way) = (share * edge.way, (1.0 - share) * edge.way);
        (edge.beyond[1], second.beyond[0]) = (0.0, 0.0);
        edge.length = edge.way + edge.beyond[0];
        second.length = second.way + second.beyond[1];
        self.nodes.push(Node {
            kind: NodeKind::Through,
            object,
            place: second.points[0],
            degree: 2,
            width: second.width,
            foods: Vec::new(),
        });
        self.edges.push(second);
        node
    }

    /// Distances along the surface between the foods that the network reaches, in scene radii; none between objects. They go over glued
    /// edges, as lines do.
    pub fn surface_distances(
        &self,
        foods: &[FoodPlace],
        around: &Surroundings<'_>,
    ) -> impl Fn(usize, usize) -> Option<f64> + use<> {
        let mut reached: Vec<usize> = self
            .nodes
            .iter()
            .flat_map(|node| node.foods.clone())
            .collect();
        reached.sort_unstable();
        // Each is a search over the whole surface.
        let table = reached.par_iter().map(|&from| {
            let distance =
                SurfaceDistance::new(around.surface, &[foods[from].point], f64::INFINITY);
            let to = reached.iter().map(|&to| {
                let point = foods[to].point;
                distance.at(point.triangle, point.u, point.v) / around.radius
            });
            to.collect::<Vec<f64>>()
        });
        let table: Vec<Vec<f64>> = table.collect();
        move |a, b| {
            let [a, b] = [a, b].map(|food| reached.binary_search(&food).ok());
            Some(table[a?][b?]).filter(|distance| distance.is_finite())
        }
    }
}
