//! From a trail to the graph of its network.

use super::links::{Links, cover_holes};
use super::parts::{Edge, Graph, Node, NodeKind};
use super::surroundings::Surroundings;
use super::thinning::thinned;
use super::trace::{self, Traced, length_of};
use crate::mesh::surface::NONE;
use crate::sim::network::THRESHOLD;

/// Parts of the network, and holes in it, with fewer texels are noise.
const SMALLEST: usize = 9;

impl Graph {
    /// The graph of a trail, gutters filled.
    #[must_use]
    pub fn of(trail: &[f32], around: &Surroundings<'_>) -> Self {
        let (mut mass, mut whole) = (0.0, 0.0);
        let owned = |texel: &usize| around.atlas.owner[*texel] != NONE;
        for texel in (0..trail.len()).filter(owned) {
            let area = f64::from(around.atlas.area[texel]);
            mass += area * f64::from(trail[texel]);
            whole += area;
        }
        let most = (THRESHOLD * mass / whole) as f32;
        let covered: Vec<bool> = trail.iter().map(|&value| value > most).collect();
        Self::of_covered(&covered, trail, around)
    }

    /// The graph of the covered texels.
    #[must_use]
    pub fn of_covered(covered: &[bool], trail: &[f32], around: &Surroundings<'_>) -> Self {
        let mut covered = covered.to_vec();
        cover_holes(around, &mut covered, SMALLEST);
        let mut links = Links::of(around, &covered);
        if remove_noise(&links, &mut covered) {
            links = Links::of(around, &covered);
        }
        let depths = links.depths();
        let stays = thinned(&links, &depths, trail);
        let mut traced = Traced::of(&links, depths, &stays);
        traced.simplify(&links);
        traced.cut_ends(&links);
        Self::new(&links, &traced, trail, around)
    }

    fn new(links: &Links, traced: &Traced, trail: &[f32], around: &Surroundings<'_>) -> Self {
        let degrees = traced.degrees();
        let mut numbers = vec![usize::MAX; traced.nodes.len()];
        let mut graph = Self::default();
        for (i, node) in traced.nodes.iter().enumerate() {
            let Some(node) = node else { continue };
            numbers[i] = graph.nodes.len();
            graph.nodes.push(Node {
                kind: match degrees[i] {
                    0 => NodeKind::Spot,
                    1 => NodeKind::End,
                    2 => NodeKind::Loop,
                    _ => NodeKind::Junction,
                },
                object: links.objects[node.texels[0] as usize],
                place: around.in_world(node.place).to_array(),
                degree: degrees[i],
                width: 2.0 * node.half_width,
                foods: Vec::new(),
            });
        }
        let sums = sums_of(links, traced, trail, around);
        for (edge, (area, mass)) in traced.edges.iter().zip(sums) {
            let Some(edge) = edge else { continue };
            let is_ring = edge.ends[0] == edge.ends[1] && degrees[edge.ends[0]] == 2;
            let course = traced.course(links, edge, is_ring);
            let way = length_of(&course.points);
            let points = course.places();
            if is_ring {
                graph.nodes[numbers[edge.ends[0]]].place = around.in_world(points[0]).to_array();
            }
            // A line ends at the border of the network, and not in its middle.
            let beyond = [0, 1].map(|end| match degrees[edge.ends[end]] {
                1 => traced.beyond(links, edge, &course, end),
                _ => 0.0,
            });
            let length = way + beyond[0] + beyond[1];
            let (objects, half_widths) = along(links, traced, edge);
            graph.edges.push(Edge {
                from: numbers[edge.ends[0]],
                to: numbers[edge.ends[1]],
                length,
                way,
                beyond,
                width: if length > 0.0 { area / length } else { 0.0 },
                trail: if area > 0.0 { mass / area } else { 0.0 },
                points: points
                    .iter()
                    .map(|&point| around.in_world(point).to_array())
                    .collect(),
                objects,
                half_widths,
                breaks: course.breaks(),
            });
        }
        graph
    }
}

/// Of each point of an edge's course, its nodes included, the object, and how far it is from the border of the network.
fn along(links: &Links, traced: &Traced, edge: &trace::Edge) -> (Vec<u32>, Vec<f64>) {
    let object = |texel: u32| links.objects[texel as usize];
    let [first, last] = edge.ends.map(|node| {
        let node = traced.nodes[node].as_ref();
        node.map(|node| (object(node.texels[0]), node.half_width))
    });
    let between = edge.texels.iter();
    let between = between.map(|&texel| (object(texel), traced.depth(texel)));
    first.into_iter().chain(between).chain(last).unzip()
}

/// Uncovers parts of few texels; were there any?
fn remove_noise(links: &Links, covered: &mut [bool]) -> bool {
    let mut is_seen = vec![false; links.texels.len()];
    let mut found = false;
    for start in 0..links.texels.len() as u32 {
        if std::mem::replace(&mut is_seen[start as usize], true) {
            continue;
        }
        let mut part = vec![start];
        let mut done = 0;
        while let Some(&at) = part.get(done) {
            done += 1;
            for &other in &links.beside[at as usize] {
                if !std::mem::replace(&mut is_seen[other as usize], true) {
                    part.push(other);
                }
            }
        }
        if part.len() < SMALLEST {
            found = true;
            for i in part {
                covered[links.texels[i as usize] as usize] = false;
            }
        }
    }
    found
}

/// For each edge, the area in square scene radii of the texels that are nearest to it, and the trail on them.
fn sums_of(
    links: &Links,
    traced: &Traced,
    trail: &[f32],
    around: &Surroundings<'_>,
) -> Vec<(f64, f64)> {
    let mut sums = vec![(0.0, 0.0); traced.edges.len()];
    let mut nearest = vec![usize::MAX; links.texels.len()];
    let mut front = Vec::new();
    for (number, edge) in traced.edges.iter().enumerate() {
        let Some(edge) = edge else { continue };
        let ends = edge
            .ends
            .iter()
            .filter_map(|&end| traced.nodes[end].as_ref());
        let texels = edge.texels.iter().chain(ends.flat_map(|node| &node.texels));
        for &i in texels {
            if nearest[i as usize] == usize::MAX {
                nearest[i as usize] = number;
                front.push(i);
            }
        }
    }
    let mut done = 0;
    while let Some(&at) = front.get(done) {
        done += 1;
        let number = nearest[at as usize];
        let texel = links.texels[at as usize];
        let area = f64::from(around.atlas.area[texel as usize]) / (around.radius * around.radius);
        sums[number].0 += area;
        sums[number].1 += area * f64::from(trail[texel as usize]);
        for &other in &links.beside[at as usize] {
            if nearest[other as usize] == usize::MAX {
                nearest[other as usize] = number;
                front.push(other);
            }
        }
    }
    sums
}
