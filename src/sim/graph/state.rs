//! The graph of a state, with its foods and measures.

use glam::Affine3A;

use super::measures::Measures;
use super::parts::Graph;
use super::surroundings::Surroundings;
use crate::sim::setup::Setup;

/// The network counts as reaching a food from so many texels beyond its plate.
const NEAR: f64 = 3.0;

/// The graph of a trail, gutters filled, on objects with these poses, world from object; and its measures.
#[must_use]
pub fn network_of(trail: &[f32], setup: &Setup, poses: &[Affine3A]) -> (Graph, Measures) {
    let around = Surroundings::new(setup, poses);
    let mut graph = Graph::of(trail, &around);
    let foods = &setup.food_set.places;
    let side = setup.atlas.mean_texel_area.sqrt() / around.radius;
    graph.mark_foods(foods, &around, NEAR * side);
    let measures = graph.measures(graph.surface_distances(foods, &around));
    (graph, measures)
}
