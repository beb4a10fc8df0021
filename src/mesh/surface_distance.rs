//! Distance along the surface: the length of the shortest path to the nearest of some places, exact on the triangles.
//!
//! The places' light is followed over the edges, as Mitchell, Mount and Papadimitriou (1987) and Chen and Han (1990) do:
//! a window is the part of an edge that is seen from one place through one strip of triangles laid flat. Windows go on in
//! the order of their distance, and those that a path by a vertex beats are dropped (Xin and Wang 2009). Shortest paths
//! turn only at vertices with more than a full angle round them and at borders: these are places of their own.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use glam::DVec2;

use super::surface::{NONE, Surface};
use super::walk::SurfacePoint;

/// Paths are told apart where they differ by more than this part of an edge.
const ROUNDING: f64 = 1e-9;
/// Places are moved so far, in weights, into their triangles: from an edge nothing is seen through it.
const INSET: f64 = 1e-7;

/// What is seen through a part of an edge. Seen from the triangle that it enters: the edge is the x axis from 0 on, the
/// triangle lies above it, and the place that it is seen from below.
#[derive(Clone, Copy, Debug)]
struct Window {
    from: f64,
    to: f64,
    origin: DVec2,
    /// The way up to the origin.
    before: f64,
}

impl Window {
    /// Of the nearest point in it.
    fn least(&self) -> f64 {
        let x = self.origin.x.clamp(self.from, self.to);
        self.before + self.origin.distance(DVec2::new(x, 0.0))
    }

    /// The distance of a place above the edge, if it is seen.
    fn distance_to(&self, place: DVec2, slack: f64) -> Option<f64> {
        let x = crossing(self.origin, place);
        (x >= self.from - slack && x <= self.to + slack)
            .then(|| self.before + self.origin.distance(place))
    }
}

/// Where the line between a place below the x axis and one above crosses it.
fn crossing(below: DVec2, above: DVec2) -> f64 {
    let part = -below.y / (above.y - below.y).max(f64::MIN_POSITIVE);
    below.x + part * (above.x - below.x)
}

/// What comes next: a window that enters a triangle by a half-edge, or a vertex that paths turn at.
#[derive(Clone, Copy, Debug)]
enum Next {
    Enter(u32, Window),
    Turn(u32),
}

#[derive(Clone, Copy, Debug)]
struct Queued {
    distance: f64,
    /// Equal distances come in the order in which they were found.
    order: u64,
    next: Next,
}

impl PartialEq for Queued {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Queued {}

impl PartialOrd for Queued {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Queued {
    // The least is the greatest: heaps give the greatest first.
    fn cmp(&self, other: &Self) -> Ordering {
        let distance = other.distance.total_cmp(&self.distance);
        distance.then(other.order.cmp(&self.order))
    }
}

/// The shape of a triangle, seen from one of its half-edges.
#[derive(Clone, Copy, Debug)]
struct Seen {
    length: f64,
    /// The corner that is not on the edge.
    apex: DVec2,
}

/// Distances along the surface from some places.
pub struct SurfaceDistance<'a> {
    surface: &'a Surface,
    sources: Vec<SurfacePoint>,
    /// One a vertex.
    vertices: Vec<f64>,
    /// One list a half-edge: what enters by it.
    windows: Vec<Vec<Window>>,
    reach: f64,
}

impl<'a> SurfaceDistance<'a> {
    /// From the nearest of the sources, as far as `reach`, a world length. Objects without a source are not reached. What
    /// is taken grows with the triangles within reach.
    ///
    /// # Panics
    /// If a source is on no triangle of the surface.
    #[must_use]
    pub fn new(surface: &'a Surface, sources: &[SurfacePoint], reach: f64) -> Self {
        let mut search = Search::new(surface, sources, reach);
        search.run();
        let mut distance = search.found;
        // What is only a vertex's own path further on.
        for (h, windows) in distance.windows.iter_mut().enumerate() {
            let ends = ends_of(surface, h as u32);
            let length = seen_from(surface, h as u32).length;
            let [start, end] = ends.map(|vertex| distance.vertices[vertex as usize]);
            windows.retain(|window| !is_beaten(window, start, end, length));
        }
        distance
    }

    /// The distance of a place, a world length; infinite beyond reach.
    ///
    /// # Panics
    /// If there is no such triangle.
    #[must_use]
    pub fn at(&self, triangle: u32, u: f64, v: f64) -> f64 {
        let weights = [1.0 - u - v, u, v];
        let mut least = f64::INFINITY;
        for k in 0..3 {
            let h = 3 * triangle + k as u32;
            let seen = seen_from(self.surface, h);
            let above = weights[(k + 2) % 3];
            let place = DVec2::new(
                weights[(k + 1) % 3] * seen.length + above * seen.apex.x,
                above * seen.apex.y,
            );
            let by_vertex = self.vertices[ends_of(self.surface, h)[0] as usize] + place.length();
            least = least.min(by_vertex);
            let slack = 1e-6 * seen.length;
            for window in &self.windows[h as usize] {
                least = least.min(window.distance_to(place, slack).unwrap_or(least));
            }
        }
        let own = self.sources.iter().filter(|s| s.triangle == triangle);
        for source in own {
            let frame = seen_from(self.surface, 3 * triangle);
            let way = DVec2::new(
                (u - source.u) * frame.length + (v - source.v) * frame.apex.x,
                (v - source.v) * frame.apex.y,
            );
            least = least.min(way.length());
        }
        if least <= self.reach {
            least
        } else {
            f64::INFINITY
        }
    }
}

/// Distances while they are found.
struct Search<'a> {
    found: SurfaceDistance<'a>,
    queue: BinaryHeap<Queued>,
    order: u64,
    /// Do shortest paths turn at this vertex?
    turns: Vec<bool>,
    /// For each vertex the half-edges that begin there: where its own begin, and one end more.
    first_leaving: Vec<u32>,
    leaving: Vec<u32>,
}

impl<'a> Search<'a> {
    fn new(surface: &'a Surface, sources: &[SurfacePoint], reach: f64) -> Self {
        let vertex_count = surface.positions.len();
        let mut angles = vec![0.0_f64; vertex_count];
        let mut at_border = vec![false; vertex_count];
        let mut first_leaving = vec![0_u32; vertex_count + 1];
        for h in 0..surface.halfedges.len() as u32 {
            let [start, end] = ends_of(surface, h);
            let apex = seen_from(surface, h).apex;
            angles[start as usize] += apex.y.atan2(apex.x);
            if surface.halfedges[h as usize].twin == NONE {
                at_border[start as usize] = true;
                at_border[end as usize] = true;
            }
            first_leaving[start as usize + 1] += 1;
        }
        for vertex in 0..vertex_count {
            first_leaving[vertex + 1] += first_leaving[vertex];
        }
        let mut places = first_leaving.clone();
        let mut leaving = vec![0; surface.halfedges.len()];
        for h in 0..surface.halfedges.len() as u32 {
            let place = &mut places[ends_of(surface, h)[0] as usize];
            leaving[*place as usize] = h;
            *place += 1;
        }
        let full = std::f64::consts::TAU * (1.0 + 1e-9);
        let turns = angles.iter().zip(&at_border);
        Self {
            turns: turns
                .map(|(&angle, &border)| border || angle > full)
                .collect(),
            first_leaving,
            leaving,
            queue: BinaryHeap::new(),
            order: 0,
            found: SurfaceDistance {
                surface,
                sources: sources.iter().map(inset).collect(),
                vertices: vec![f64::INFINITY; vertex_count],
                windows: vec![Vec::new(); surface.halfedges.len()],
                reach,
            },
        }
    }

    fn run(&mut self) {
        for source in self.found.sources.clone() {
            self.leave(source);
        }
        while let Some(Queued { distance, next, .. }) = self.queue.pop() {
            match next {
                Next::Turn(vertex) if distance <= self.found.vertices[vertex as usize] => {
                    self.turn_at(vertex, distance);
                }
                Next::Turn(_) => {}
                Next::Enter(h, window) => self.enter(h, window),
            }
        }
    }

    fn push(&mut self, distance: f64, next: Next) {
        if distance <= self.found.reach {
            self.order += 1;
            let order = self.order;
            self.queue.push(Queued {
                distance,
                order,
                next,
            });
        }
    }

    /// From a place out of its triangle.
    fn leave(&mut self, source: SurfacePoint) {
        let surface = self.found.surface;
        let weights = [1.0 - source.u - source.v, source.u, source.v];
        for k in 0..3_usize {
            let h = 3 * source.triangle + k as u32;
            let seen = seen_from(surface, h);
            let above = weights[(k + 2) % 3];
            let place = DVec2::new(
                weights[(k + 1) % 3] * seen.length + above * seen.apex.x,
                above * seen.apex.y,
            );
            self.reach_vertex(ends_of(surface, h)[0], place.length());
            self.cross(h, place, 0.0, seen.length, 0.0);
        }
    }

    /// From a vertex into the triangles round it.
    fn turn_at(&mut self, vertex: u32, distance: f64) {
        let surface = self.found.surface;
        let range = self.first_leaving[vertex as usize]..self.first_leaving[vertex as usize + 1];
        for place in range {
            let h = self.leaving[place as usize];
            let seen = seen_from(surface, h);
            self.reach_vertex(ends_of(surface, h)[1], distance + seen.length);
            let before = previous(h);
            self.reach_vertex(ends_of(surface, before)[0], distance + seen.apex.length());
            // Seen from the edge opposite, it is the apex.
            let opposite = next(h);
            let seen = seen_from(surface, opposite);
            self.cross(opposite, seen.apex, 0.0, seen.length, distance);
        }
    }

    /// Out of a triangle over part of its half-edge `h`, from a place above it.
    fn cross(&mut self, h: u32, place: DVec2, from: f64, to: f64, before: f64) {
        let surface = self.found.surface;
        let twin = surface.halfedges[h as usize].twin;
        let length = seen_from(surface, h).length;
        let (from, to) = (from.max(0.0), to.min(length));
        if twin == NONE || to - from <= ROUNDING * length {
            return;
        }
        // From the other side the edge runs the other way.
        let window = Window {
            from: length - to,
            to: length - from,
            origin: DVec2::new(length - place.x, -place.y),
            before,
        };
        if !self.is_beaten(twin, &window) {
            self.push(window.least(), Next::Enter(twin, window));
        }
    }

    fn is_beaten(&self, h: u32, window: &Window) -> bool {
        let surface = self.found.surface;
        let ends = ends_of(surface, h).map(|vertex| self.found.vertices[vertex as usize]);
        is_beaten(window, ends[0], ends[1], seen_from(surface, h).length)
    }

    /// Through a triangle to its two other edges.
    fn enter(&mut self, h: u32, window: Window) {
        if self.is_beaten(h, &window) {
            return;
        }
        let surface = self.found.surface;
        let Seen { length, apex } = seen_from(surface, h);
        self.found.windows[h as usize].push(window);
        let split = crossing(window.origin, apex);
        if let Some(distance) = window.distance_to(apex, ROUNDING * length) {
            self.reach_vertex(ends_of(surface, previous(h))[0], distance);
        }
        // On the half-edge from the apex to the start, and on the one from the end to the apex.
        let sides = [
            (previous(h), window.from, window.to.min(split)),
            (next(h), window.from.max(split), window.to),
        ];
        for (side, from, to) in sides {
            if to <= from {
                continue;
            }
            let corners = if side == next(h) {
                [DVec2::new(length, 0.0), apex]
            } else {
                [apex, DVec2::ZERO]
            };
            let along = (corners[1] - corners[0]).normalize();
            let seen = |place: DVec2| {
                let way = place - corners[0];
                DVec2::new(way.dot(along), along.perp_dot(way))
            };
            let origin = seen(window.origin);
            let hit = |x: f64| {
                let through = seen(DVec2::new(x, 0.0));
                // The ray goes down to the side, on which y is 0.
                let fall = (origin.y - through.y).max(f64::MIN_POSITIVE);
                origin.x + origin.y / fall * (through.x - origin.x)
            };
            let (a, b) = (hit(from), hit(to));
            self.cross(side, origin, a.min(b), a.max(b), window.before);
        }
    }

    fn reach_vertex(&mut self, vertex: u32, distance: f64) {
        let known = &mut self.found.vertices[vertex as usize];
        if distance < *known {
            *known = distance;
            if self.turns[vertex as usize] {
                self.push(distance, Next::Turn(vertex));
            }
        }
    }
}

/// Is every way through the window longer than one by an end of the edge? If the way by the start is shorter to the far end
/// of the window, it crosses all that come through nearer, and is shorter for them, too.
fn is_beaten(window: &Window, start: f64, end: f64, length: f64) -> bool {
    let to = |x: f64| window.before + window.origin.distance(DVec2::new(x, 0.0));
    let slack = ROUNDING * length;
    start + window.to + slack < to(window.to)
        || end + length - window.from + slack < to(window.from)
}

fn inset(point: &SurfacePoint) -> SurfacePoint {
    let weights = [1.0 - point.u - point.v, point.u, point.v].map(|w| w.max(INSET));
    let sum: f64 = weights.iter().sum();
    SurfacePoint {
        triangle: point.triangle,
        u: weights[1] / sum,
        v: weights[2] / sum,
    }
}

fn next(h: u32) -> u32 {
    if h % 3 == 2 { h - 2 } else { h + 1 }
}

fn previous(h: u32) -> u32 {
    if h.is_multiple_of(3) { h + 2 } else { h - 1 }
}

fn ends_of(surface: &Surface, h: u32) -> [u32; 2] {
    let corners = surface.corners[h as usize / 3];
    [corners[h as usize % 3], corners[next(h) as usize % 3]]
}

fn seen_from(surface: &Surface, h: u32) -> Seen {
    let [start, end] = ends_of(surface, h);
    let apex = ends_of(surface, previous(h))[0];
    let [start, end, apex] =
        [start, end, apex].map(|vertex| surface.positions[vertex as usize].as_dvec3());
    let (edge, way) = (end - start, apex - start);
    let length = edge.length();
    Seen {
        length,
        apex: DVec2::new(way.dot(edge) / length, edge.cross(way).length() / length),
    }
}

#[cfg(test)]
mod tests;
