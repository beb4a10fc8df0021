//! Distance along the surface: the length of the shortest path to the nearest of some places, exact on the triangles.
//!
//! Windows are propagated over the edges, as by Mitchell, Mount and Papadimitriou (1987) and Chen and Han (1990): a window is the part of
//! an edge that is visible from one place through one strip of unfolded triangles. Windows are propagated in the order of their distance,
//! each only where no earlier window over the edge is equally near; windows that are longer than a path by a vertex are dropped (Xin and
//! Wang 2009). Thus an edge keeps only a few windows: over n reached triangles there are about n^1.5. Shortest paths turn only at vertices
//! with more than a full angle round them and at borders: these are places of their own.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use glam::DVec2;

use super::atlas::{AtlasError, Control};
use super::surface::{NONE, Surface};
use super::walk::SurfacePoint;
use crate::portable::atan2;
use window::{Window, crossing, cut, is_beaten};

#[cfg(test)]
mod tests;
mod window;

/// Lengths of paths count as different if they differ by more than this part of an edge.
const ROUNDING: f64 = 1e-9;
/// Places are moved into their triangles by this much, in weights: from a place on an edge, no window through it is visible.
const INSET: f64 = 1e-7;
/// Windows and turns between two checks for cancellation: some milliseconds.
const BETWEEN_LOOKS: u64 = 4096;

/// The next event: a window that enters a triangle by a half-edge, or a vertex at which paths turn.
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
    /// One per vertex.
    vertices: Vec<f64>,
    /// One list a half-edge: what enters by it.
    windows: Vec<Vec<Window>>,
    reach: f64,
}

impl<'a> SurfaceDistance<'a> {
    /// From the nearest of the sources, as far as `reach`, a world length. Objects without a source are not reached. Memory and time grow
    /// with the triangles within reach.
    ///
    /// # Panics
    /// If a source is on no triangle of the surface.
    #[must_use]
    pub fn new(surface: &'a Surface, sources: &[SurfacePoint], reach: f64) -> Self {
        Self::with_control(surface, sources, reach, &Control::default())
            .expect("it cannot be cancelled")
    }

    /// As [`new`](Self::new), with progress reports and cancellation by `control`.
    ///
    /// # Errors
    /// [`AtlasError::Cancelled`] when it was stopped.
    ///
    /// # Panics
    /// As [`new`](Self::new).
    pub fn with_control(
        surface: &'a Surface,
        sources: &[SurfacePoint],
        reach: f64,
        control: &Control<'_>,
    ) -> Result<Self, AtlasError> {
        let mut search = Search::new(surface, sources, reach);
        search.run(control)?;
        Ok(search.done())
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
    /// For each vertex the next one that glued edges make one with it, in a ring; most are alone.
    copies: Vec<u32>,
    /// Those of the window that enters, kept so that no memory is taken for each.
    parts: Vec<(f64, f64)>,
    /// Tests compare results with and without cutting.
    cuts: bool,
    /// The number of vertices reached by a path, and of those of all objects with a source.
    reached_count: u32,
    to_reach: u32,
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
            angles[start as usize] += atan2(apex.y, apex.x);
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
        let copies = copies(surface);
        let is_turn = |vertex: u32| {
            let angle: f64 = ring(&copies, vertex).map(|v| angles[v as usize]).sum();
            angle > full || ring(&copies, vertex).any(|v| at_border[v as usize])
        };
        let turns = (0..vertex_count as u32).map(is_turn).collect();
        Self {
            turns,
            first_leaving,
            leaving,
            copies,
            parts: Vec::new(),
            cuts: true,
            reached_count: 0,
            to_reach: vertices_of(surface, sources),
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

    fn run(&mut self, control: &Control<'_>) -> Result<(), AtlasError> {
        for source in self.found.sources.clone() {
            self.leave(source);
        }
        let mut looks = 0_u64;
        while let Some(Queued { distance, next, .. }) = self.queue.pop() {
            if looks.is_multiple_of(BETWEEN_LOOKS) {
                control.step("measuring distances", self.share(distance))?;
            }
            looks += 1;
            match next {
                Next::Turn(vertex) if distance <= self.found.vertices[vertex as usize] => {
                    self.turn_at(vertex, distance);
                }
                Next::Turn(_) => {}
                Next::Enter(h, window) => self.enter(h, window),
            }
        }
        Ok(())
    }

    /// The progress at this distance: by the area within reach, or by vertices if everything is within reach.
    fn share(&self, distance: f64) -> f32 {
        let way = distance / self.found.reach;
        let by_distance = way * way;
        let by_vertices = f64::from(self.reached_count) / f64::from(self.to_reach.max(1));
        by_distance.max(by_vertices).min(1.0) as f32
    }

    fn done(self) -> SurfaceDistance<'a> {
        let mut distance = self.found;
        // Only the continuation of a vertex's own path.
        for (h, windows) in distance.windows.iter_mut().enumerate() {
            if windows.is_empty() {
                continue;
            }
            let ends = ends_of(distance.surface, h as u32);
            let length = seen_from(distance.surface, h as u32).length;
            let [start, end] = ends.map(|vertex| distance.vertices[vertex as usize]);
            windows.retain(|window| !is_beaten(window, start, end, length));
            // The windows are kept for later queries.
            windows.shrink_to_fit();
        }
        distance
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
        let window = Window {
            from,
            to,
            origin: place,
            before,
        };
        let window = window.turned(length);
        if !self.is_beaten(twin, &window) {
            self.push(window.least(), Next::Enter(twin, window));
        }
    }

    fn is_beaten(&self, h: u32, window: &Window) -> bool {
        let surface = self.found.surface;
        let ends = ends_of(surface, h).map(|vertex| self.found.vertices[vertex as usize]);
        is_beaten(window, ends[0], ends[1], seen_from(surface, h).length)
    }

    /// Propagates the part of a window that no other window beats through a triangle.
    fn enter(&mut self, h: u32, window: Window) {
        if self.is_beaten(h, &window) {
            return;
        }
        let surface = self.found.surface;
        let length = seen_from(surface, h).length;
        let twin = surface.halfedges[h as usize].twin;
        let mut parts = std::mem::take(&mut self.parts);
        parts.clear();
        parts.push((window.from, window.to));
        if self.cuts {
            for other in &self.found.windows[h as usize] {
                cut(&mut parts, &window, other, length);
            }
            // Windows that cross the edge the other way have covered it, too.
            for other in &self.found.windows[twin as usize] {
                cut(
                    &mut parts,
                    &window,
                    &other.turned(length).mirrored(),
                    length,
                );
            }
        }
        for &(from, to) in &parts {
            let part = Window { from, to, ..window };
            if !self.is_beaten(h, &part) && part.least() <= self.found.reach {
                self.pass(h, part);
            }
        }
        self.parts = parts;
    }

    /// Through a triangle to its two other edges.
    fn pass(&mut self, h: u32, window: Window) {
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
        let mut copy = vertex;
        loop {
            let known = &mut self.found.vertices[copy as usize];
            if distance < *known {
                self.reached_count += u32::from(known.is_infinite());
                *known = distance;
                if self.turns[copy as usize] {
                    self.push(distance, Next::Turn(copy));
                }
            }
            copy = self.copies[copy as usize];
            if copy == vertex {
                return;
            }
        }
    }
}

/// For each vertex the next one that glued edges make one with it, in rings.
fn copies(surface: &Surface) -> Vec<u32> {
    let mut copies: Vec<u32> = (0..surface.positions.len() as u32).collect();
    for &h in &surface.glued {
        let [start, end] = ends_of(surface, h);
        let [from, to] = ends_of(surface, surface.halfedges[h as usize].twin);
        for (one, other) in [(start, to), (end, from)] {
            // Within a ring this would make two of it.
            if ring(&copies, one).all(|vertex| vertex != other) {
                copies.swap(one as usize, other as usize);
            }
        }
    }
    copies
}

fn ring(copies: &[u32], first: u32) -> impl Iterator<Item = u32> + '_ {
    std::iter::successors(Some(first), move |&vertex| {
        Some(copies[vertex as usize]).filter(|&next| next != first)
    })
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

/// Those of all objects that some of these places are on.
fn vertices_of(surface: &Surface, places: &[SurfacePoint]) -> u32 {
    let has_one = |object: usize| {
        let object_of = |place: &SurfacePoint| surface.triangles[place.triangle as usize].object;
        places
            .iter()
            .any(|place| object_of(place) as usize == object)
    };
    let objects = surface.objects.iter().enumerate();
    let counts = objects.filter(|(object, _)| has_one(*object));
    counts
        .map(|(_, range)| range.vertices.1 - range.vertices.0)
        .sum()
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
