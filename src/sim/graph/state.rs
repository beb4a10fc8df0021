//! The graph of a state, with its foods and measures.

use glam::Affine3A;

use super::measures::Measures;
use super::parts::Graph;
use super::surroundings::Surroundings;
use crate::sim::setup::Setup;

/// The network counts as reaching a food from so many texels beyond its plate.
const NEAR: f64 = 3.0;

/// The graph of a trail, gutters filled, on objects with these poses, world from object; the foods that it reaches are nodes.
#[must_use]
pub fn graph_of(trail: &[f32], setup: &Setup, poses: &[Affine3A]) -> Graph {
    graph_on(&Surroundings::new(setup, poses), trail, setup)
}

fn graph_on(around: &Surroundings<'_>, trail: &[f32], setup: &Setup) -> Graph {
    let mut graph = Graph::of(trail, around);
    let side = setup.atlas.mean_texel_area.sqrt() / around.radius;
    graph.mark_foods(&setup.food_set.places, around, NEAR * side);
    graph
}

/// As [`graph_of`], and its measures. Those between foods take long where there are many foods or triangles.
#[must_use]
pub fn network_of(trail: &[f32], setup: &Setup, poses: &[Affine3A]) -> (Graph, Measures) {
    let around = Surroundings::new(setup, poses);
    let graph = graph_on(&around, trail, setup);
    let surface = graph.surface_distances(&setup.food_set.places, &around);
    let measures = graph.measures(surface);
    (graph, measures)
}
