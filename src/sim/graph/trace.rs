//! From thin lines of texels to nodes and edges.

use glam::DVec3;

use super::links::Links;

/// Branches that reach no farther than the line that they leave, and so many texels more, are unevenness of its outline.
const SPUR: f64 = 2.0;
/// Depths, taken along links, are up to 8 % more than straight ways: what reaches no farther than this many times a depth is within it.
const WITHIN: f64 = 1.1;
/// Junctions that are closer than so many texels are one, and so are those within the width of a line.
const ONE_JUNCTION: f64 = 3.0;
/// The end of a line is no longer than so many times its depth.
const OF_ENDS: f64 = 2.5;
/// And so many texels more.
const STEPS: f64 = 3.0;
/// A line has its full width at this share of it.
const FULL: f64 = 0.92;
/// Loops of fewer texels are noise.
const SMALLEST_LOOP: f64 = 9.0;
/// Lines of texels have steps. They are smoothed so often, by turns by these two factors, which leaves curves as they are (Taubin, "Curve
/// and surface smoothing without shrinkage", 1995). Straight lines are then up to 0.6 % too long, and rings of a radius of 12 texels 0.5 %
/// too short.
const SMOOTHED: usize = 30;
const FACTORS: [f64; 2] = [0.5, -0.51];

/// A place where lines meet or end.
#[derive(Clone, Debug)]
pub struct Node {
    /// Its texels, by number.
    pub texels: Vec<u32>,
    /// Its place, in scene radii.
    pub place: DVec3,
    /// From it to the border of the network, in scene radii.
    pub half_width: f64,
}

/// A line from one node to another, or to the same.
#[derive(Clone, Debug)]
pub struct Edge {
    /// The nodes at its ends.
    pub ends: [usize; 2],
    /// Its texels, by number, from the first to the second.
    pub texels: Vec<u32>,
    /// Its length, in scene radii.
    pub length: f64,
}

/// Nodes and edges; those that are gone are `None`, so that numbers stay.
#[derive(Debug)]
pub struct Traced {
    pub nodes: Vec<Option<Node>>,
    pub edges: Vec<Option<Edge>>,
}

impl Traced {
    /// The lines that thinning has left.
    pub fn of(links: &Links, depths: &[f64], stays: &[bool]) -> Self {
        let beside = |i: u32| {
            let all = links.beside[i as usize].iter().copied();
            all.filter(|&other| stays[other as usize])
                .collect::<Vec<_>>()
        };
        let left = (0..links.texels.len() as u32).filter(|&i| stays[i as usize]);
        let left: Vec<u32> = left.collect();
        let mut traced = Self {
            nodes: Vec::new(),
            edges: Vec::new(),
        };
        let mut node_of = vec![usize::MAX; links.texels.len()];
        // Texels at which lines meet and that touch each other are one junction.
        for &i in &left {
            if beside(i).len() == 2 || node_of[i as usize] != usize::MAX {
                continue;
            }
            let number = traced.nodes.len();
            let mut texels = vec![i];
            node_of[i as usize] = number;
            let mut done = 0;
            while let Some(&at) = texels.get(done) {
                done += 1;
                for other in beside(at) {
                    let meets = beside(other).len() > 2 && beside(at).len() > 2;
                    if meets && node_of[other as usize] == usize::MAX {
                        node_of[other as usize] = number;
                        texels.push(other);
                    }
                }
            }
            traced.nodes.push(Some(Node::of(links, depths, texels)));
        }
        let mut is_traced = vec![false; links.texels.len()];
        for number in 0..traced.nodes.len() {
            let node = traced.nodes[number].as_ref();
            let texels = node.map_or(Vec::new(), |node| node.texels.clone());
            for start in texels {
                for first in beside(start) {
                    traced.trace(links, &beside, &node_of, &mut is_traced, [start, first]);
                }
            }
        }
        // Loops without a junction begin anywhere.
        for &i in &left {
            if is_traced[i as usize] || node_of[i as usize] != usize::MAX {
                continue;
            }
            node_of[i as usize] = traced.nodes.len();
            traced.nodes.push(Some(Node::of(links, depths, vec![i])));
            if let [first, _] = beside(i)[..] {
                traced.trace(links, &beside, &node_of, &mut is_traced, [i, first]);
            }
        }
        traced
    }

    /// Follows a line from a texel of a node, by its neighbour `first`.
    fn trace(
        &mut self,
        links: &Links,
        beside: &impl Fn(u32) -> Vec<u32>,
        node_of: &[usize],
        is_traced: &mut [bool],
        [start, first]: [u32; 2],
    ) {
        let (mut before, mut at) = (start, first);
        let mut texels = Vec::new();
        let from = node_of[start as usize];
        loop {
            let to = node_of[at as usize];
            if to != usize::MAX {
                // Between neighbouring nodes there is no texel by which to see that the edge is there.
                let is_new = !texels.is_empty() || (from != to && start < at);
                if is_new {
                    self.add(links, [from, to], texels);
                }
                return;
            }
            if std::mem::replace(&mut is_traced[at as usize], true) {
                return;
            }
            texels.push(at);
            let next = beside(at).into_iter().find(|&other| other != before);
            let Some(next) = next else { return };
            (before, at) = (at, next);
        }
    }

    fn add(&mut self, links: &Links, ends: [usize; 2], texels: Vec<u32>) {
        let mut edge = Edge {
            ends,
            texels,
            length: 0.0,
        };
        edge.length = length_of(&self.points(links, &edge, false));
        self.edges.push(Some(edge));
    }

    /// Removes what is unevenness or noise, and joins edges where nothing branches any more.
    pub fn simplify(&mut self, links: &Links, depths: &[f64]) {
        loop {
            let is_simpler = self.remove_spurs(links, depths)
                || self.join_junctions(links, depths)
                || self.remove_loops(links);
            self.join_edges(links);
            if !is_simpler {
                return;
            }
        }
    }

    /// Cuts ends of lines back to where they have their full width: before that, thinning leads them into a corner.
    pub fn cut_ends(&mut self, links: &Links, depths: &[f64]) {
        let degrees = self.degrees();
        for number in 0..self.edges.len() {
            let Some(mut edge) = self.edges[number].take() else {
                continue;
            };
            for end in [0, 1] {
                let node = edge.ends[end];
                if degrees[node] != 1 {
                    continue;
                }
                let Some(last) = self.nodes[node].take() else {
                    continue;
                };
                // From the end on.
                if end == 1 {
                    edge.texels.reverse();
                }
                let (mut along, mut before, mut full) =
                    (last.half_width, last.place, last.half_width);
                for &i in &edge.texels {
                    let place = links.places[i as usize];
                    along += before.distance(place);
                    before = place;
                    // Where the width grows by less than this it is that of the line; steps of texels are none.
                    if along > OF_ENDS * full + STEPS * links.sides[i as usize] {
                        break;
                    }
                    full = full.max(depths[i as usize]);
                }
                let is_full = |depth: f64| depth >= FULL * full;
                let cut = if is_full(last.half_width) {
                    None
                } else {
                    edge.texels
                        .iter()
                        .position(|&i| is_full(depths[i as usize]))
                };
                let gone = cut.map(|count| edge.texels.drain(..=count).next_back());
                self.nodes[node] = Some(match gone.flatten() {
                    Some(i) => Node::of(links, depths, vec![i]),
                    None => last,
                });
                if end == 1 {
                    edge.texels.reverse();
                }
            }
            edge.length = length_of(&self.points(links, &edge, false));
            self.edges[number] = Some(edge);
        }
    }

    /// Removes branches that end within the width of the line that they leave, the shortest first, as long as something branches there.
    fn remove_spurs(&mut self, links: &Links, depths: &[f64]) -> bool {
        let mut degrees = self.degrees();
        let spurs = self.edges.iter().enumerate().filter_map(|(number, edge)| {
            let edge = edge.as_ref()?;
            let [end, other] = match edge.ends.map(|node| degrees[node]) {
                // Of a spot, one of two ends is left.
                [1, other] if other != 2 => edge.ends,
                [other, 1] if other != 2 => [edge.ends[1], edge.ends[0]],
                _ => return None,
            };
            let [last, node] = [end, other].map(|node| self.nodes[node].as_ref());
            let (last, node) = (last?, node?);
            // How far the branch reaches, and how far what it leaves reaches anyway.
            let (reaches, anyway) = if degrees[other] == 1 {
                let on_edge = edge.texels.iter().map(|&i| depths[i as usize]);
                let widest = on_edge.fold(node.half_width.max(last.half_width), f64::max);
                (
                    edge.length + last.half_width + node.half_width,
                    2.0 * widest,
                )
            } else {
                (edge.length + last.half_width, node.half_width)
            };
            let side = links.sides[node.texels[0] as usize];
            (reaches < WITHIN * anyway + SPUR * side).then_some((edge.length, number, end, other))
        });
        let mut spurs: Vec<_> = spurs.collect();
        spurs.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let before = spurs.len();
        spurs.retain(|&(_, edge, end, other)| {
            let branches = degrees[other] == 1 || degrees[other] > 2;
            if branches {
                degrees[other] -= 1;
                self.edges[edge] = None;
                self.nodes[end] = None;
            }
            branches
        });
        before > 0 && !spurs.is_empty()
    }

    /// Joins junctions that are one, the closest first: a crossing of wide lines is two forks at first.
    fn join_junctions(&mut self, links: &Links, depths: &[f64]) -> bool {
        let degrees = self.degrees();
        let pairs = self.edges.iter().enumerate().filter_map(|(number, edge)| {
            let edge = edge.as_ref()?;
            let [a, b] = edge.ends;
            if a == b || degrees[a] < 3 || degrees[b] < 3 {
                return None;
            }
            let [a, b] = [a, b].map(|node| self.nodes[node].as_ref());
            let width = a?.half_width.max(b?.half_width);
            let side = links.sides[a?.texels[0] as usize];
            (edge.length < width.max(ONE_JUNCTION * side)).then_some((edge.length, number))
        });
        let mut pairs: Vec<_> = pairs.collect();
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut is_joined = vec![false; self.nodes.len()];
        let mut joined_to: Vec<usize> = (0..self.nodes.len()).collect();
        for (_, number) in &pairs {
            let ends = self.edges[*number]
                .as_ref()
                .map_or([0; 2], |edge| edge.ends);
            // Each once a turn: widths and lengths are others then.
            if ends.iter().any(|&node| is_joined[node]) {
                continue;
            }
            let [kept, gone] = ends;
            let mut texels = self.edges[*number]
                .take()
                .map_or(Vec::new(), |edge| edge.texels);
            let other = self.nodes[gone].take();
            for node in [&self.nodes[kept], &other].into_iter().flatten() {
                texels.extend(&node.texels);
            }
            self.nodes[kept] = Some(Node::of(links, depths, texels));
            (is_joined[kept], is_joined[gone]) = (true, true);
            joined_to[gone] = kept;
        }
        for edge in self.edges.iter_mut().flatten() {
            if edge.ends.iter().any(|&node| is_joined[node]) {
                edge.ends = edge.ends.map(|node| joined_to[node]);
                edge.length = length_of(&points_of(&self.nodes, links, edge, false));
            }
        }
        !pairs.is_empty()
    }

    /// Removes loops that are too small to be one.
    fn remove_loops(&mut self, links: &Links) -> bool {
        let mut found = false;
        for edge in &mut self.edges {
            let is_noise = edge.as_ref().is_some_and(|edge| {
                let node = self.nodes[edge.ends[0]].as_ref();
                let side = node.map_or(0.0, |node| links.sides[node.texels[0] as usize]);
                edge.ends[0] == edge.ends[1] && edge.length < SMALLEST_LOOP * side
            });
            if is_noise {
                *edge = None;
                found = true;
            }
        }
        found
    }

    /// Joins the two edges of each node at which nothing branches and nothing ends.
    fn join_edges(&mut self, links: &Links) {
        let mut at_node = vec![Vec::new(); self.nodes.len()];
        for (number, edge) in self.edges.iter().enumerate() {
            for node in edge.iter().flat_map(|edge| edge.ends) {
                at_node[node].push(number);
            }
        }
        for node in 0..self.nodes.len() {
            let [first, second] = at_node[node][..] else {
                continue;
            };
            // A ring has one edge, whose both ends are here.
            if first == second {
                continue;
            }
            let (Some(mut a), Some(mut b), Some(gone)) = (
                self.edges[first].take(),
                self.edges[second].take(),
                self.nodes[node].take(),
            ) else {
                continue;
            };
            if a.ends[0] == node {
                a.reverse();
            }
            if b.ends[1] == node {
                b.reverse();
            }
            // Of what was a junction, the texel nearest to its middle is on the line.
            let away = |i: &u32| links.places[*i as usize].distance_squared(gone.place);
            let middle = gone
                .texels
                .iter()
                .copied()
                .min_by(|a, b| away(a).total_cmp(&away(b)));
            let texels = a.texels.into_iter().chain(middle).chain(b.texels);
            let (ends, texels) = ([a.ends[0], b.ends[1]], texels.collect());
            let number = self.edges.len();
            self.add(links, ends, texels);
            for other in &mut at_node[ends[1]] {
                *other = if *other == second { number } else { *other };
            }
            for other in &mut at_node[ends[0]] {
                *other = if *other == first { number } else { *other };
            }
        }
    }

    /// How many ends of edges each node has.
    pub fn degrees(&self) -> Vec<usize> {
        let mut degrees = vec![0; self.nodes.len()];
        for node in self.edges.iter().flatten().flat_map(|edge| edge.ends) {
            degrees[node] += 1;
        }
        degrees
    }

    /// The points of an edge, its nodes included, smoothed.
    pub fn points(&self, links: &Links, edge: &Edge, is_ring: bool) -> Vec<DVec3> {
        points_of(&self.nodes, links, edge, is_ring)
    }
}

fn points_of(nodes: &[Option<Node>], links: &Links, edge: &Edge, is_ring: bool) -> Vec<DVec3> {
    let place = |node: usize| nodes[node].as_ref().map(|node| node.place);
    let between = edge.texels.iter().map(|&i| links.places[i as usize]);
    let points = place(edge.ends[0]).into_iter().chain(between);
    smoothed(points.chain(place(edge.ends[1])).collect(), is_ring)
}

/// The length of a line of points.
pub fn length_of(points: &[DVec3]) -> f64 {
    points
        .windows(2)
        .map(|pair| pair[0].distance(pair[1]))
        .sum()
}

impl Node {
    fn of(links: &Links, depths: &[f64], texels: Vec<u32>) -> Self {
        let places = texels.iter().map(|&i| links.places[i as usize]);
        let place = places.sum::<DVec3>() / texels.len() as f64;
        let half_width = texels
            .iter()
            .map(|&i| depths[i as usize])
            .fold(0.0, f64::max);
        Self {
            texels,
            place,
            half_width,
        }
    }
}

impl Edge {
    fn reverse(&mut self) {
        self.ends.reverse();
        self.texels.reverse();
    }
}

/// Smoothes the steps of a line of texels; its ends stay, unless it is a ring.
fn smoothed(mut points: Vec<DVec3>, is_ring: bool) -> Vec<DVec3> {
    let count = points.len();
    if count < 3 {
        return points;
    }
    for _ in 0..SMOOTHED {
        for factor in FACTORS {
            let before = points.clone();
            let moved = |a: usize, i: usize, b: usize| {
                before[i] + factor * (0.5 * (before[a] + before[b]) - before[i])
            };
            for (i, point) in points.iter_mut().enumerate().take(count - 1).skip(1) {
                *point = moved(i - 1, i, i + 1);
            }
            if is_ring {
                points[0] = moved(count - 2, 0, 1);
                points[count - 1] = points[0];
            }
        }
    }
    points
}
