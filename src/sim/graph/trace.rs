//! From thin lines of texels to nodes and edges.

use std::collections::{HashMap, HashSet};
use std::f64::consts::SQRT_2;

use glam::{DAffine3, DVec3};

use super::links::Links;

/// Depths, taken along links, are up to 8 % more than straight ways: what reaches no farther than this many times a depth is within it.
const WITHIN: f64 = 1.1;
/// Where a line ends straight across, thinning leads into both of its corners, which are so many times as far as its sides. Branches that
/// reach no farther from the middle of a line, and so many texels more, are its corners, or unevenness of its outline, of which fine textures
/// show more.
const OF_CORNERS: f64 = SQRT_2;
const SPUR: f64 = 2.0;
/// Junctions that are closer than so many texels are one, and so are those within the width of a line. From the middle of a right-angled
/// crossing to the border of the network it is `SQRT_2` times half of that width, so that their ratio is `SQRT_2`, too.
const ONE_JUNCTION: f64 = 3.0;
const OF_CROSSING: f64 = SQRT_2;
/// The end of a line is no longer than so many times its depth.
const OF_ENDS: f64 = 2.5;
/// And so many texels more.
const STEPS: f64 = 3.0;
/// Motions whose numbers differ by less than this are one.
const ALIKE: f64 = 1e-6;
/// A line has its full width at this share of it.
const FULL: f64 = 0.92;
/// Loops of fewer texels are noise.
const SMALLEST_LOOP: f64 = 9.0;
/// Lines of texels have steps, and follow the roughness of the outline. They are smoothed so often by local parabolas, fitted to so many
/// half widths of the line to each side, and to no fewer or more points than these (Savitzky and Golay, "Smoothing and Differentiation of
/// Data by Simplified Least Squares Procedures", Analytical Chemistry 36(8), 1964). Parabolas leave bends as they are: straight lines are
/// then up to 0.2 % too long at any angle, rings of a radius of 20 texels up to 0.4 % too short, and a right-angled corner loses up to 3
/// texels.
const SMOOTHED: usize = 2;
const HALF_WIDTHS: f64 = 3.0;
const POINTS: [f64; 2] = [6.0, 10.0];
/// Nor is the window to each side longer than this part of the line, or of a ring.
const PART: usize = 4;
const PART_OF_RING: usize = 8;

/// A place where lines meet or end.
#[derive(Clone, Debug)]
pub struct Node {
    /// Its texels, by number.
    pub texels: Vec<u32>,
    /// For each of its texels, the motion over glued edges that carries it to the others; empty where nothing is glued.
    motions: Vec<DAffine3>,
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

/// The course of an edge, its nodes included, as a walk from its first node has it before itself: what lies beyond a glued edge is carried
/// to where the walk goes on.
#[derive(Clone, Debug)]
pub struct Course {
    pub points: Vec<DVec3>,
    /// What has carried each point there; empty where nothing is glued.
    motions: Vec<DAffine3>,
}

/// Nodes and edges; those that are gone are `None`, so that numbers stay.
#[derive(Debug)]
pub struct Traced {
    pub nodes: Vec<Option<Node>>,
    pub edges: Vec<Option<Edge>>,
    /// How far each texel is from the border of the network.
    depths: Vec<f64>,
}

impl Traced {
    /// How far a texel is from the border of the network, in scene radii.
    pub fn depth(&self, texel: u32) -> f64 {
        self.depths[texel as usize]
    }

    /// The lines that thinning has left.
    pub fn of(links: &Links, depths: Vec<f64>, stays: &[bool]) -> Self {
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
            depths,
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
            traced.push_node(links, texels);
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
            traced.push_node(links, vec![i]);
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

    fn push_node(&mut self, links: &Links, texels: Vec<u32>) {
        let node = Node::of(links, &self.depths, texels);
        self.nodes.push(Some(node));
    }

    fn add(&mut self, links: &Links, ends: [usize; 2], texels: Vec<u32>) {
        let mut edge = Edge {
            ends,
            texels,
            length: 0.0,
        };
        edge.length = length_of(&self.course(links, &edge, false).points);
        self.edges.push(Some(edge));
    }

    /// Removes what is unevenness or noise, and joins edges where nothing branches any more.
    pub fn simplify(&mut self, links: &Links) {
        loop {
            let is_simpler =
                self.remove_spurs(links) || self.join_junctions(links) || self.remove_loops(links);
            self.join_edges(links);
            if !is_simpler {
                return;
            }
        }
    }

    /// Cuts ends of lines back to where they have their full width: before that, thinning leads them into a corner.
    pub fn cut_ends(&mut self, links: &Links) {
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
                let mut points = unfolded(&self.nodes, links, &edge).points;
                let Some(last) = self.nodes[node].take() else {
                    continue;
                };
                // From the end on.
                if end == 1 {
                    edge.texels.reverse();
                    points.reverse();
                }
                let depths = &self.depths;
                let (mut along, mut full) = (last.half_width, last.half_width);
                for (&i, step) in edge.texels.iter().zip(points.windows(2)) {
                    along += step[0].distance(step[1]);
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
            edge.length = length_of(&self.course(links, &edge, false).points);
            self.edges[number] = Some(edge);
        }
    }

    /// Removes branches that end within the width of the line that they leave, the shortest first, as long as something branches there.
    fn remove_spurs(&mut self, links: &Links) -> bool {
        let mut degrees = self.degrees();
        let branches = (0..self.edges.len()).filter_map(|edge| self.branch(links, &degrees, edge));
        let mut spurs: Vec<Branch> = branches.collect();
        spurs.retain(|branch| {
            let is_spot = degrees[branch.from] == 1;
            branch.is_within(WITHIN * if is_spot { 1.0 } else { OF_CORNERS })
        });
        spurs.sort_by(|a, b| a.length.total_cmp(&b.length).then(a.edge.cmp(&b.edge)));
        let before = spurs.len();
        spurs.retain(|branch| {
            let is_spot = degrees[branch.from] == 1;
            let branches = is_spot || degrees[branch.from] > 2;
            if branches {
                degrees[branch.from] -= 1;
                let edge = self.edges[branch.edge].take();
                let last = self.nodes[branch.end].take();
                if is_spot {
                    self.become_spot(links, branch.from, edge.as_ref(), last.as_ref());
                }
            }
            branches
        });
        before > 0 && !spurs.is_empty()
    }

    /// Of a spot one of two ends is left, at its rim: moves that node to the texel of the spot's line that is the farthest from the border
    /// of the network.
    fn become_spot(
        &mut self,
        links: &Links,
        node: usize,
        edge: Option<&Edge>,
        other: Option<&Node>,
    ) {
        let ends = self.nodes[node].as_ref().into_iter().chain(other);
        let on_edge = edge.into_iter().flat_map(|edge| &edge.texels);
        let texels = ends.flat_map(|end| &end.texels).chain(on_edge).copied();
        let depth = |texel: u32| self.depths[texel as usize];
        let deepest = texels.max_by(|&a, &b| depth(a).total_cmp(&depth(b)));
        if let Some(deepest) = deepest {
            self.nodes[node] = Some(Node::of(links, &self.depths, vec![deepest]));
        }
    }

    /// An edge as a branch, if it has an end.
    fn branch(&self, links: &Links, degrees: &[usize], number: usize) -> Option<Branch> {
        let edge = self.edges[number].as_ref()?;
        let [end, from] = match edge.ends.map(|node| degrees[node]) {
            // Of a spot, one of two ends is left.
            [1, other] if other != 2 => edge.ends,
            [other, 1] if other != 2 => [edge.ends[1], edge.ends[0]],
            _ => return None,
        };
        let [last, node] = [end, from].map(|node| self.nodes[node].as_ref());
        let (last, node) = (last?, node?);
        let ways = if degrees[from] == 1 {
            let on_edge = edge.texels.iter().map(|&i| self.depths[i as usize]);
            let widest = on_edge.fold(node.half_width.max(last.half_width), f64::max);
            [(edge.length + node.half_width, 2.0 * widest); 2]
        } else {
            let begun = self.begun_at_texel(links, edge, usize::from(edge.ends[1] == from))?;
            [(edge.length, node.half_width), begun]
        };
        Some(Branch {
            edge: number,
            end,
            from,
            length: edge.length,
            ways: ways.map(|(length, anyway)| (length + last.half_width, anyway)),
            more: SPUR * node.side(links),
        })
    }

    /// The length of a branch from the texel of its junction at which it begins, and how far that texel is from the border of the network.
    /// A junction may be as many texels long as a line is wide, and from its middle the branch would look that much longer.
    fn begun_at_texel(&self, links: &Links, edge: &Edge, end: usize) -> Option<(f64, f64)> {
        let node = self.nodes[edge.ends[end]].as_ref()?;
        let points = unfolded(&self.nodes, links, edge).begun_at(end);
        let next = *points.get(1)?;
        let away = node.places(links).into_iter().map(|at| at.distance(next));
        let nearest = away.zip(&node.texels).min_by(|a, b| a.0.total_cmp(&b.0));
        let (away, &texel) = nearest?;
        // Smoothed from there on: where trail is uneven, the way over texels is rougher than those that depths go.
        let half = half_in_texels(&self.depths, links, edge);
        let rest = smoothed(points[1..].to_vec(), half, None);
        let length = away + length_of(&rest);
        Some((length, self.depths[texel as usize]))
    }

    /// Joins junctions that are one, the closest first: a crossing of wide lines is two forks at first.
    fn join_junctions(&mut self, links: &Links) -> bool {
        let degrees = self.degrees();
        let pairs = self.edges.iter().enumerate().filter_map(|(number, edge)| {
            let edge = edge.as_ref()?;
            let [a, b] = edge.ends;
            if a == b || degrees[a] < 3 || degrees[b] < 3 {
                return None;
            }
            let [a, b] = [a, b].map(|node| self.nodes[node].as_ref());
            let (a, b) = (a?, b?);
            let width = OF_CROSSING * a.half_width.max(b.half_width);
            let side = a.side(links).max(b.side(links));
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
            self.nodes[kept] = Some(Node::of(links, &self.depths, texels));
            (is_joined[kept], is_joined[gone]) = (true, true);
            joined_to[gone] = kept;
        }
        for edge in self.edges.iter_mut().flatten() {
            if edge.ends.iter().any(|&node| is_joined[node]) {
                edge.ends = edge.ends.map(|node| joined_to[node]);
                let course = course_of((&self.nodes, &self.depths), links, edge, false);
                edge.length = length_of(&course.points);
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
                let side = node.map_or(0.0, |node| node.side(links));
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
            let middle = gone.middle(links).map(|k| gone.texels[k]);
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

    /// The course of an edge, smoothed.
    pub fn course(&self, links: &Links, edge: &Edge, is_ring: bool) -> Course {
        course_of((&self.nodes, &self.depths), links, edge, is_ring)
    }

    /// How far it is from an end of an edge along its course to the border of the network, scene radii: thinning and cutting have taken
    /// away more or less of what is beyond, so that no depth says it.
    pub fn beyond(&self, links: &Links, edge: &Edge, course: &Course, end: usize) -> f64 {
        let Some(node) = &self.nodes[edge.ends[end]] else {
            return 0.0;
        };
        let points = course.begun_at(end);
        let (half, side) = (node.half_width, node.side(links));
        let long = (2.0 * half).max(STEPS * side);
        let back = points.iter().find(|at| at.distance(points[0]) >= long);
        let back = back.or(points.last()).copied().unwrap_or(node.place);
        let along = (node.place - back).normalize_or_zero();
        if along == DVec3::ZERO {
            return half;
        }
        let farthest = OF_ENDS * half + 2.0 * STEPS * side;
        let beside = (0.5 * half).max(side);
        let starts = node.texels.iter().enumerate();
        let mut found: Vec<(u32, DAffine3)> = starts.map(|(k, &i)| (i, node.motion(k))).collect();
        let mut known: HashSet<u32> = node.texels.iter().copied().collect();
        let mut beyond = 0.0_f64;
        while let Some((at, motion)) = found.pop() {
            for &other in &links.beside[at as usize] {
                let step = links.glued.get(&(at, other));
                let motion = step.map_or(motion, |step| motion * *step);
                let away = motion.transform_point3(links.places[other as usize]) - node.place;
                let reaches = away.dot(along);
                let is_ahead = (-side..=farthest).contains(&reaches)
                    && (away - reaches * along).length() <= beside;
                if is_ahead && known.insert(other) {
                    beyond = beyond.max(reaches);
                    found.push((other, motion));
                }
            }
        }
        // To the border of the last texel.
        beyond + 0.5 * side
    }
}

/// An edge that ends at one of its nodes.
struct Branch {
    edge: usize,
    /// The node at which it ends, and that which it leaves.
    end: usize,
    from: usize,
    length: f64,
    /// How far it reaches, and how far what it leaves reaches anyway: from the middle of its junction, and from the texel there at which it
    /// begins.
    ways: [(f64, f64); 2],
    /// How much farther it has to reach, scene radii.
    more: f64,
}

impl Branch {
    /// Does it reach no farther than so many times what it leaves?
    fn is_within(&self, times: f64) -> bool {
        let mut ways = self.ways.iter();
        ways.any(|(reach, anyway)| *reach < times * anyway + self.more)
    }
}

impl Course {
    /// Its points from an end on, as that end's node has them.
    fn begun_at(&self, end: usize) -> Vec<DVec3> {
        if end == 0 {
            return self.points.clone();
        }
        let last = self.motion(self.points.len().saturating_sub(1)).inverse();
        let points = self.points.iter().rev();
        points.map(|&at| last.transform_point3(at)).collect()
    }

    fn motion(&self, point: usize) -> DAffine3 {
        let motion = self.motions.get(point).copied();
        motion.unwrap_or(DAffine3::IDENTITY)
    }

    /// Its points where they lie.
    pub fn places(&self) -> Vec<DVec3> {
        let points = self.points.iter().enumerate();
        points
            .map(|(k, &at)| match self.motions.get(k) {
                Some(motion) => motion.inverse().transform_point3(at),
                None => at,
            })
            .collect()
    }

    /// The points before which it goes over a glued edge.
    pub fn breaks(&self) -> Vec<usize> {
        let pairs = self.motions.windows(2).zip(1..);
        let breaks = pairs.filter(|(pair, _)| !pair[0].abs_diff_eq(pair[1], ALIKE));
        breaks.map(|(_, point)| point).collect()
    }
}

/// The course of an edge, not smoothed.
fn unfolded(nodes: &[Option<Node>], links: &Links, edge: &Edge) -> Course {
    let place = |node: usize| nodes[node].as_ref().map(|node| node.place);
    let texels = &edge.texels;
    let between = texels.iter().map(|&i| links.places[i as usize]);
    let points = place(edge.ends[0]).into_iter().chain(between);
    let mut course = Course {
        points: points.chain(place(edge.ends[1])).collect(),
        motions: Vec::new(),
    };
    if links.glued.is_empty() {
        return course;
    }
    let [Some(first), Some(last)] = edge.ends.map(|node| nodes[node].as_ref()) else {
        return course;
    };
    let mut motion = DAffine3::IDENTITY;
    course.motions.push(motion);
    let mut before = None;
    for &i in texels {
        motion = match before {
            None => first.motion_to(links, i),
            Some(before) => motion * links.motion(before, i),
        };
        course.motions.push(motion);
        before = Some(i);
    }
    course.motions.push(match before {
        Some(before) => motion * last.motion_to(links, before).inverse(),
        None => first.motion_to_node(links, last),
    });
    for (point, motion) in course.points.iter_mut().zip(&course.motions) {
        *point = motion.transform_point3(*point);
    }
    course
}

fn course_of(
    (nodes, depths): (&[Option<Node>], &[f64]),
    links: &Links,
    edge: &Edge,
    is_ring: bool,
) -> Course {
    let mut course = unfolded(nodes, links, edge);
    let half = half_in_texels(depths, links, edge);
    // Once round a ring, and over the glued edges that it goes over.
    let round = is_ring.then(|| course.motion(course.points.len().saturating_sub(1)));
    course.points = smoothed(course.points, half, round);
    course
}

/// How many texels it is in the mean from an edge to the border of the network.
fn half_in_texels(depths: &[f64], links: &Links, edge: &Edge) -> f64 {
    let halves = (edge.texels.iter()).map(|&i| depths[i as usize] / links.sides[i as usize]);
    halves.sum::<f64>() / edge.texels.len().max(1) as f64
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
        let half_width = texels
            .iter()
            .map(|&i| depths[i as usize])
            .fold(0.0, f64::max);
        let mut node = Self {
            motions: motions_among(links, &texels),
            texels,
            place: DVec3::ZERO,
            half_width,
        };
        let places = node.places(links);
        node.place = places.iter().sum::<DVec3>() / places.len() as f64;
        // Its place is that on the side of a glued edge on which its middle lies.
        if let Some(middle) = node.middle(links)
            && !node.motions.is_empty()
        {
            let back = node.motions[middle].inverse();
            node.place = back.transform_point3(node.place);
            for motion in &mut node.motions {
                *motion = back * *motion;
            }
        }
        node
    }

    /// The largest side of its texels: beside seams they differ.
    fn side(&self, links: &Links) -> f64 {
        let sides = self.texels.iter().map(|&i| links.sides[i as usize]);
        sides.fold(0.0, f64::max)
    }

    fn motion(&self, texel: usize) -> DAffine3 {
        let motion = self.motions.get(texel).copied();
        motion.unwrap_or(DAffine3::IDENTITY)
    }

    /// The places of its texels, side by side.
    fn places(&self, links: &Links) -> Vec<DVec3> {
        let texels = self.texels.iter().enumerate();
        texels
            .map(|(k, &i)| {
                let place = links.places[i as usize];
                match self.motions.get(k) {
                    Some(motion) => motion.transform_point3(place),
                    None => place,
                }
            })
            .collect()
    }

    /// Which of its texels is the nearest to its place.
    fn middle(&self, links: &Links) -> Option<usize> {
        let places = self.places(links).into_iter();
        let away = places.map(|place| place.distance_squared(self.place));
        let nearest = away.enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
        nearest.map(|(k, _)| k)
    }

    /// The motion that carries a texel beside it to where it lies as seen from here.
    fn motion_to(&self, links: &Links, texel: u32) -> DAffine3 {
        let beside = &links.beside[texel as usize];
        let linked = self.texels.iter().position(|i| beside.contains(i));
        let from = linked.unwrap_or_default();
        self.motion(from) * links.motion(self.texels[from], texel)
    }

    /// The motion that carries a node beside it to where it lies as seen from here.
    fn motion_to_node(&self, links: &Links, other: &Self) -> DAffine3 {
        let is_beside = |i: &u32| {
            let beside = &links.beside[*i as usize];
            self.texels.iter().any(|own| beside.contains(own))
        };
        let there = other.texels.iter().position(is_beside).unwrap_or_default();
        self.motion_to(links, other.texels[there]) * other.motion(there).inverse()
    }
}

/// For each of some texels that touch, the motion over glued edges that carries it to the first; empty where nothing is glued.
fn motions_among(links: &Links, texels: &[u32]) -> Vec<DAffine3> {
    if links.glued.is_empty() {
        return Vec::new();
    }
    let mut motions: HashMap<u32, DAffine3> = HashMap::new();
    let mut found = vec![texels[0]];
    motions.insert(texels[0], DAffine3::IDENTITY);
    while let Some(at) = found.pop() {
        let motion = motions[&at];
        for &other in texels {
            let is_linked = links.beside[at as usize].binary_search(&other).is_ok();
            if is_linked && !motions.contains_key(&other) {
                let step = links.glued.get(&(at, other));
                motions.insert(other, step.map_or(motion, |step| motion * *step));
                found.push(other);
            }
        }
    }
    let motion = |i: &u32| match motions.get(i) {
        Some(motion) => *motion,
        None => links.motion(texels[0], *i),
    };
    texels.iter().map(motion).collect()
}

impl Edge {
    fn reverse(&mut self) {
        self.ends.reverse();
        self.texels.reverse();
    }
}

/// Smoothes a line of points; `half` is how many texels it is from its middle to the border of the network. Its ends stay: beyond each the
/// line is continued by its image in that point. `round` is the motion once round a ring, which has no ends.
fn smoothed(mut points: Vec<DVec3>, half: f64, round: Option<DAffine3>) -> Vec<DVec3> {
    let last = points.len().saturating_sub(1);
    if last < 3 {
        return points;
    }
    let part = if round.is_some() { PART_OF_RING } else { PART };
    let [least, most] = POINTS;
    let wide = (HALF_WIDTHS * half).clamp(least, most).round() as usize;
    let window = wide.min(last / part).max(2);
    let weights = parabola(window);
    for _ in 0..SMOOTHED {
        let before = points.clone();
        let at = |i: isize| {
            let end = last as isize;
            match round {
                Some(round) if i < 0 => {
                    let back = round.inverse();
                    back.transform_point3(before[(i + end) as usize])
                }
                Some(round) if i > end => round.transform_point3(before[(i - end) as usize]),
                None if i < 0 => 2.0 * before[0] - before[-i as usize],
                None if i > end => 2.0 * before[last] - before[(2 * end - i) as usize],
                _ => before[i as usize],
            }
        };
        for (i, point) in (0..).zip(&mut points) {
            let around = (i - window as isize..).zip(&weights);
            *point = around.map(|(k, &weight)| weight * at(k)).sum();
        }
    }
    points
}

/// What each of `window` points to each side, and the one between, adds to the value there of the parabola that fits them best.
fn parabola(window: usize) -> Vec<f64> {
    let reach = window as f64;
    let all = (2.0 * reach - 1.0) * (2.0 * reach + 1.0) * (2.0 * reach + 3.0);
    let weight = |k: usize| {
        let away = k as f64 - reach;
        3.0 * (3.0 * reach * reach + 3.0 * reach - 1.0 - 5.0 * away * away) / all
    };
    (0..=2 * window).map(weight).collect()
}
