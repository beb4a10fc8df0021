//! What the literature measures of a network's graph.

use std::collections::HashMap;

use petgraph::algo::{bridges, connected_components, dijkstra, min_spanning_tree};
use petgraph::data::FromElements as _;
use petgraph::graph::{EdgeIndex, NodeIndex, UnGraph};
use serde::{Deserialize, Serialize};

use super::parts::Graph;

/// Measures of a network's graph. Lengths are in scene radii.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Measures {
    /// Nodes.
    pub nodes: usize,
    /// Edges.
    pub edges: usize,
    /// Nodes at which lines meet.
    pub junctions: usize,
    /// Nodes at which a line ends.
    pub ends: usize,
    /// Connected parts.
    pub parts: usize,
    /// Independent cycles: edges, less nodes, and parts.
    pub cycles: usize,
    /// The mean number of ends of edges at a node.
    pub mean_degree: f64,
    /// The length of all edges.
    pub length: f64,
    /// The mean width of edges, by length.
    pub width: f64,
    /// The share of the length at which the network can be cut without falling into more parts, 0 to 1 (the fault tolerance of Tero et al.,
    /// "Rules for biologically inspired adaptive network design", Science 327, 2010, for all nodes).
    pub tolerance: f64,
    /// What there is between foods, if the network reaches two or more.
    pub foods: Option<Between>,
}

/// Measures of what a network has between foods.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Between {
    /// How many foods it reaches.
    pub reached: usize,
    /// The share of their pairs that are connected, 0 to 1.
    pub connected: f64,
    /// The mean distance of connected pairs along the network. None if there is no such pair.
    pub distance: Option<f64>,
    /// The mean, over connected pairs on one object, of the distance along the surface as a share of that along the network, 0 to 1: the
    /// transport efficiency. None if there is no such pair.
    pub efficiency: Option<f64>,
    /// The network's length as a multiple of the shortest tree of surface distances that connects the foods. None if they lie on several
    /// objects.
    pub cost: Option<f64>,
    /// The share of the length at which the network can be cut without parting foods that were connected, 0 to 1.
    pub tolerance: f64,
    /// The distances of each pair of foods that it reaches, in the order of their numbers.
    #[serde(default)]
    pub pairs: Vec<Pair>,
}

/// Two foods, and how far they are from each other, scene radii.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pair {
    /// The number of one of them.
    pub a: usize,
    /// The number of the other one, which is higher.
    pub b: usize,
    /// Their distance along the surface. None if no way along it leads from one to the other, as between objects.
    pub surface: Option<f64>,
    /// Their distance along the network. None if it does not connect them.
    pub network: Option<f64>,
}

impl Graph {
    /// Measures of the graph. `surface` is the distance along the surface from one food to another, in scene radii, where there is one.
    #[must_use]
    pub fn measures(&self, surface: impl Fn(usize, usize) -> Option<f64>) -> Measures {
        let (graph, bridges) = (self.as_petgraph(), self.bridges());
        let measures = self.of_lines(&graph, &bridges);
        Measures {
            foods: self.between(&graph, &bridges, measures.length, surface),
            ..measures
        }
    }

    /// As [`Self::measures`], without those between foods, which take the longest.
    #[must_use]
    pub fn measures_of_lines(&self) -> Measures {
        self.of_lines(&self.as_petgraph(), &self.bridges())
    }

    fn of_lines(&self, graph: &UnGraph<(), f64>, bridges: &[EdgeIndex]) -> Measures {
        let parts = connected_components(graph);
        // An empty sum is -0.0.
        let length = 0.0 + self.edges.iter().map(|edge| edge.length).sum::<f64>();
        let area: f64 = self.edges.iter().map(|edge| edge.length * edge.width).sum();
        let of_degree =
            |is: fn(usize) -> bool| self.nodes.iter().filter(|node| is(node.degree)).count();
        let share = |part: f64, of: f64| if of > 0.0 { part / of } else { 0.0 };
        let at_risk = self.length_of(bridges.iter().copied());
        Measures {
            nodes: self.nodes.len(),
            edges: self.edges.len(),
            junctions: of_degree(|degree| degree > 2),
            ends: of_degree(|degree| degree == 1),
            parts,
            cycles: self.edges.len() + parts - self.nodes.len(),
            mean_degree: share(2.0 * self.edges.len() as f64, self.nodes.len() as f64),
            length,
            width: share(area, length),
            tolerance: share(length - at_risk, length),
            foods: None,
        }
    }

    /// The edges whose loss makes two parts of one.
    fn bridges(&self) -> Vec<EdgeIndex> {
        // The library's search takes a graph without parallel edges, of which none is a bridge.
        let mut between: HashMap<[usize; 2], Vec<usize>> = HashMap::new();
        for (number, edge) in self.edges.iter().enumerate() {
            let ends = [edge.from.min(edge.to), edge.from.max(edge.to)];
            between.entry(ends).or_default().push(number);
        }
        let mut simple: UnGraph<(), Option<usize>> = UnGraph::new_undirected();
        self.nodes.iter().for_each(|_| _ = simple.add_node(()));
        let mut pairs: Vec<_> = between.into_iter().filter(|([a, b], _)| a != b).collect();
        pairs.sort_unstable();
        for ([a, b], numbers) in pairs {
            let only = (numbers.len() == 1).then(|| numbers[0]);
            simple.add_edge(NodeIndex::new(a), NodeIndex::new(b), only);
        }
        let found = bridges(&simple).filter_map(|bridge| *bridge.weight());
        let mut found: Vec<_> = found.map(EdgeIndex::new).collect();
        found.sort_unstable();
        found
    }

    fn length_of(&self, edges: impl Iterator<Item = EdgeIndex>) -> f64 {
        edges.map(|edge| self.edges[edge.index()].length).sum()
    }

    /// Weights are ways from node to node.
    fn as_petgraph(&self) -> UnGraph<(), f64> {
        let mut graph = UnGraph::new_undirected();
        for _ in &self.nodes {
            graph.add_node(());
        }
        for edge in &self.edges {
            graph.add_edge(NodeIndex::new(edge.from), NodeIndex::new(edge.to), edge.way);
        }
        graph
    }

    fn between(
        &self,
        graph: &UnGraph<(), f64>,
        bridges: &[EdgeIndex],
        length: f64,
        surface: impl Fn(usize, usize) -> Option<f64>,
    ) -> Option<Between> {
        let nodes = (0..).zip(&self.nodes);
        let foods = nodes.flat_map(|(i, node)| node.foods.iter().map(move |&food| (food, i)));
        let foods: Vec<(usize, usize)> = foods.collect();
        if foods.len() < 2 {
            return None;
        }
        let mut pairs = 0;
        let mut each = Vec::new();
        let (mut distances, mut shares) = (Vec::new(), Vec::new());
        let mut complete: UnGraph<(), f64> = UnGraph::new_undirected();
        foods.iter().for_each(|_| _ = complete.add_node(()));
        for (i, &(food, node)) in foods.iter().enumerate() {
            let along = dijkstra(graph, NodeIndex::new(node), None, |edge| *edge.weight());
            for (k, &(other, there)) in foods.iter().enumerate().skip(i + 1) {
                pairs += 1;
                let over = surface(food, other);
                if let Some(over) = over {
                    complete.add_edge(NodeIndex::new(i), NodeIndex::new(k), over);
                }
                // Nodes lie beside foods, and two foods may have one: no way between foods is shorter than that over the surface.
                let along = along.get(&NodeIndex::new(there)).copied();
                let along = along.map(|along| along.max(over.unwrap_or_default()));
                each.push(Pair {
                    a: food.min(other),
                    b: food.max(other),
                    surface: over,
                    network: along,
                });
                if let Some(along) = along {
                    distances.push(along);
                    shares.extend(over.map(|over| if along > 0.0 { over / along } else { 1.0 }));
                }
            }
        }
        each.sort_unstable_by_key(|pair| (pair.a, pair.b));
        let mean = |values: &[f64]| values.iter().sum::<f64>() / (values.len() as f64).max(1.0);
        let tree: UnGraph<(), f64> = UnGraph::from_elements(min_spanning_tree(&complete));
        let whole = tree.edge_count() + 1 == foods.len();
        let tree: f64 = tree.edge_weights().sum();
        // A bridge parts foods if there are some of its part on both sides.
        let food_nodes: Vec<usize> = foods.iter().map(|&(_, node)| node).collect();
        let parts_foods = |&&bridge: &&EdgeIndex| {
            let (from, _) = graph
                .edge_endpoints(bridge)
                .expect("it is one of its edges");
            let whole = dijkstra(graph, from, None, |_| 1);
            let mut cut = graph.clone();
            cut.remove_edge(bridge);
            let side = dijkstra(&cut, from, None, |_| 1);
            let in_part = food_nodes
                .iter()
                .filter(|&&node| whole.contains_key(&NodeIndex::new(node)))
                .count();
            let here = food_nodes
                .iter()
                .filter(|&&node| side.contains_key(&NodeIndex::new(node)))
                .count();
            0 < here && here < in_part
        };
        let at_risk = self.length_of(bridges.iter().filter(parts_foods).copied());
        Some(Between {
            reached: foods.len(),
            connected: distances.len() as f64 / f64::from(pairs),
            distance: (!distances.is_empty()).then(|| mean(&distances)),
            efficiency: (!shares.is_empty()).then(|| mean(&shares)),
            cost: (whole && tree > 0.0).then(|| length / tree),
            tolerance: if length > 0.0 {
                (length - at_risk) / length
            } else {
                0.0
            },
            pairs: each,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::parts::{Edge, Node, NodeKind};
    use super::*;

    /// A square of side 1 with a tail of length 2, foods at two opposite corners and at the end of the tail.
    fn square_with_a_tail() -> Graph {
        let node = |degree, food: Option<usize>| Node {
            kind: if degree == 1 {
                NodeKind::End
            } else {
                NodeKind::Junction
            },
            object: 0,
            place: [0.0; 3],
            degree,
            width: 0.1,
            foods: food.into_iter().collect(),
        };
        let edge = |from, to, length| Edge {
            from,
            to,
            length,
            way: length,
            beyond: [0.0; 2],
            width: 0.1,
            trail: 1.0,
            points: Vec::new(),
            objects: Vec::new(),
            half_widths: Vec::new(),
            breaks: Vec::new(),
        };
        Graph {
            nodes: vec![
                node(3, Some(0)),
                node(2, None),
                node(2, Some(2)),
                node(2, None),
                node(1, Some(1)),
            ],
            edges: vec![
                edge(0, 1, 1.0),
                edge(1, 2, 1.0),
                edge(2, 3, 1.0),
                edge(3, 0, 1.0),
                edge(0, 4, 2.0),
            ],
        }
    }

    #[test]
    fn measures_are_those_of_the_literature() {
        let surface = |a: usize, b: usize| Some(if a + b == 2 { 2.0_f64.sqrt() } else { 2.0 });
        let measures = square_with_a_tail().measures(surface);
        assert_eq!(
            (
                measures.nodes,
                measures.edges,
                measures.parts,
                measures.cycles
            ),
            (5, 5, 1, 1)
        );
        assert_eq!((measures.junctions, measures.ends), (1, 1));
        assert!((measures.length - 6.0).abs() < 1e-12 && (measures.width - 0.1).abs() < 1e-12);
        assert!(
            (measures.tolerance - 4.0 / 6.0).abs() < 1e-12,
            "only the tail is a bridge"
        );
        let foods = measures.foods.expect("there are three");
        assert_eq!((foods.reached, foods.connected), (3, 1.0));
        // Pairs 0-2 over two sides, 0-1 along the tail, 1-2 along both.
        assert!(
            (foods.distance.expect("they are connected") - (2.0 + 2.0 + 4.0) / 3.0).abs() < 1e-12
        );
        let efficiency = (2.0_f64.sqrt() / 2.0 + 1.0 + 0.5) / 3.0;
        assert!((foods.efficiency.expect("they are on one object") - efficiency).abs() < 1e-12);
        let tree = 2.0_f64.sqrt() + 2.0;
        assert!((foods.cost.expect("there is a tree") - 6.0 / tree).abs() < 1e-12);
        assert!((foods.tolerance - 4.0 / 6.0).abs() < 1e-12);
        // In the order of their numbers, which is not that of nodes.
        let pair = |a, b, over, along| Pair {
            a,
            b,
            surface: Some(over),
            network: Some(along),
        };
        let pairs = [
            pair(0, 1, 2.0, 2.0),
            pair(0, 2, 2.0_f64.sqrt(), 2.0),
            pair(1, 2, 2.0, 4.0),
        ];
        assert_eq!(foods.pairs, pairs);
        let apart = square_with_a_tail()
            .measures(|_, _| None)
            .foods
            .expect("there are three");
        assert_eq!((apart.efficiency, apart.cost), (None, None));
        assert!(apart.pairs.iter().all(|pair| pair.surface.is_none()));
        let mut cut = square_with_a_tail();
        cut.edges.pop();
        let foods = cut.measures(surface).foods.expect("there are three");
        let along: Vec<_> = foods.pairs.iter().map(|pair| pair.network).collect();
        assert_eq!(along, [None, Some(2.0), None]);
    }

    #[test]
    fn nothing_has_no_measures() {
        let measures = Graph::default().measures(|_, _| None);
        assert_eq!(measures, Measures::default());
    }

    /// Catches two edges between the same nodes that count as bridges, and two foods at one node of which one is lost.
    #[test]
    fn parallel_edges_are_no_bridges() {
        let mut graph = square_with_a_tail();
        let tail = graph.edges[4].clone();
        graph.edges.push(tail);
        assert_eq!(graph.measures(|_, _| None).tolerance, 1.0);
        graph.nodes[0].foods.push(7);
        let foods = graph.measures(|_, _| None).foods.expect("there are four");
        assert_eq!(
            (foods.reached, foods.connected, foods.tolerance),
            (4, 1.0, 1.0)
        );
    }

    /// Catches a tail without food that counts as a risk to foods.
    #[test]
    fn only_bridges_between_foods_part_them() {
        let mut graph = square_with_a_tail();
        graph.nodes[4].foods.clear();
        let measures = graph.measures(|_, _| Some(1.0));
        let foods = measures.foods.expect("there are two");
        assert_eq!((foods.reached, foods.tolerance), (2, 1.0));
        assert!(measures.tolerance < 0.7);
    }
}
