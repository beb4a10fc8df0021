//! A set of triangles as a mesh of its own: its vertices, its neighbours, its border, and whether it is a disc.
//!
//! A vertex is a fan of corners that are connected within the patch. A vertex at which the patch only touches itself becomes two, and every
//! edge that two triangles of the patch share is glued.

use glam::DVec3;

use super::metric::{Metric, Shape};
use crate::mesh::edges::{next, previous};
use crate::mesh::surface::{NONE, Surface};

/// A disc.
pub(super) struct Patch {
    /// Triangles of the surface, ascending.
    pub triangles: Vec<u32>,
    /// Per triangle its three vertices. Behind the triangles of the surface stand made-up ones that close holes.
    pub corners: Vec<[u32; 3]>,
    /// Shapes of the made-up triangles.
    filling: Vec<Shape>,
    /// Per half-edge of the patch, [`NONE`] at its border.
    pub twins: Vec<u32>,
    pub vertex_count: usize,
    /// Half-edges of the outer border, in order, the patch on their left.
    pub border: Vec<u32>,
}

/// The index of each triangle of the surface in the patch that is being made; all [`NONE`]
/// between uses.
pub(super) type Places = Vec<u32>;

struct Fans {
    /// Per half-edge, the vertex that it starts at.
    vertex_of: Vec<u32>,
    /// Per vertex, the half-edge of the border that leaves it, or [`NONE`] inside.
    leaving: Vec<u32>,
}

impl Patch {
    /// The patch of some triangles in ascending order, or `None` if they are no disc. Holes whose whole rim is open border are closed with
    /// made-up triangles: they need no cut.
    pub fn new(surface: &Surface, triangles: &[u32], places: &mut Places) -> Option<Self> {
        let twins = twins(surface, triangles, places);
        let fans = Fans::new(&twins);
        let mut loops = fans.loops();
        let border_count: usize = loops.iter().map(Vec::len).sum();
        let edge_count = (twins.len() + border_count) / 2;
        // A sphere with holes, one of which is the outside.
        let euler = fans.leaving.len() as i64 - edge_count as i64 + triangles.len() as i64;
        if loops.is_empty() || euler != 2 - loops.len() as i64 {
            return None;
        }
        let global = |h: u32| 3 * triangles[h as usize / 3] + h % 3;
        let length = |along: &[u32]| -> f64 {
            let positions = along.iter().map(|&h| position(surface, global(h)));
            let ends = along.iter().map(|&h| position(surface, global(next(h))));
            positions.zip(ends).map(|(a, b)| a.distance(b)).sum()
        };
        let outer =
            (0..loops.len()).max_by(|&i, &j| length(&loops[i]).total_cmp(&length(&loops[j])))?;
        let border = loops.swap_remove(outer);
        let mut patch = Self {
            triangles: triangles.to_vec(),
            corners: fans
                .vertex_of
                .chunks_exact(3)
                .map(|of| [of[0], of[1], of[2]])
                .collect(),
            filling: Vec::new(),
            twins,
            vertex_count: fans.leaving.len(),
            border,
        };
        for hole in &loops {
            let open = |&h: &u32| surface.halfedges[global(h) as usize].twin == NONE;
            if !hole.iter().all(open) || !patch.fill(surface, hole) {
                return None;
            }
        }
        Some(patch)
    }

    /// Closes a hole with a fan around its middle; false if a triangle of the fan would have no area.
    fn fill(&mut self, surface: &Surface, hole: &[u32]) -> bool {
        let position = |h: u32| position(surface, 3 * self.triangles[h as usize / 3] + h % 3);
        let middle = hole.iter().map(|&h| position(h)).sum::<DVec3>() / hole.len() as f64;
        let radius = hole
            .iter()
            .map(|&h| position(h).distance(middle))
            .sum::<f64>()
            / hole.len() as f64;
        // If an edge points at the middle, the middle is lifted a little, so that every triangle has an area.
        let made_with = |lift: f64| {
            let shape_of = |&h: &u32| {
                let (start, end) = (position(next(h)), position(h));
                let ab = start.distance(end);
                let [a, b] = [start, end].map(|p| p.distance_squared(middle) + lift * lift);
                let cp = 0.5 * (ab * ab + a - b) / ab;
                let ch = (a - cp * cp).max(0.0).sqrt();
                (ch > 1e-2 * ab).then(|| Shape::new(ab, cp, ch))
            };
            hole.iter().map(shape_of).collect::<Option<Vec<_>>>()
        };
        let Some(shapes) = made_with(0.0).or_else(|| made_with(0.1 * radius)) else {
            return false;
        };
        let first = self.corners.len() as u32;
        let count = hole.len() as u32;
        for (k, &h) in (0..count).zip(hole) {
            let [start, end] = [h, next(h)].map(|h| self.vertex_of(h));
            self.corners.push([end, start, self.vertex_count as u32]);
            let h0 = 3 * (first + k);
            self.twins[h as usize] = h0;
            // The fan's triangles stand in the order of the hole's edges, each beginning where the last one ends.
            let before = 3 * (first + (k + count - 1) % count) + 2;
            let after = 3 * (first + (k + 1) % count) + 1;
            self.twins.extend([h, before, after]);
        }
        self.filling.extend(shapes);
        self.vertex_count += 1;
        true
    }

    /// The vertex that a half-edge starts at.
    pub fn vertex_of(&self, halfedge: u32) -> u32 {
        self.corners[halfedge as usize / 3][halfedge as usize % 3]
    }

    /// The shape of a triangle, which may be a made-up one.
    pub fn shape<'a>(&'a self, metric: &'a Metric, triangle: usize) -> &'a Shape {
        match self.triangles.get(triangle) {
            Some(&t) => &metric.shapes[t as usize],
            None => &self.filling[triangle - self.triangles.len()],
        }
    }
}

/// The start of a half-edge of the surface.
fn position(surface: &Surface, halfedge: u32) -> DVec3 {
    let vertex = surface.corners[halfedge as usize / 3][halfedge as usize % 3];
    surface.positions[vertex as usize].as_dvec3()
}

fn twins(surface: &Surface, triangles: &[u32], places: &mut Places) -> Vec<u32> {
    places.resize(surface.corners.len(), NONE);
    for (i, &t) in triangles.iter().enumerate() {
        places[t as usize] = i as u32;
    }
    let mut twins = Vec::with_capacity(3 * triangles.len());
    for &t in triangles {
        for h in 3 * t..3 * t + 3 {
            let twin = surface.halfedges[h as usize].twin;
            twins.push(match twin {
                NONE => NONE,
                _ => match places[twin as usize / 3] {
                    NONE => NONE,
                    place => 3 * place + twin % 3,
                },
            });
        }
    }
    for &t in triangles {
        places[t as usize] = NONE;
    }
    twins
}

impl Fans {
    fn new(twins: &[u32]) -> Self {
        let mut fans = Self {
            vertex_of: vec![NONE; twins.len()],
            leaving: Vec::new(),
        };
        for first in 0..twins.len() as u32 {
            if fans.vertex_of[first as usize] != NONE {
                continue;
            }
            // Clockwise to the border, if there is one; then everything from there on.
            let (mut start, mut on_border) = (first, false);
            loop {
                match twins[start as usize] {
                    NONE => on_border = true,
                    twin if next(twin) != first => {
                        start = next(twin);
                        continue;
                    }
                    _ => {}
                }
                break;
            }
            let vertex = fans.leaving.len() as u32;
            fans.leaving.push(if on_border { start } else { NONE });
            let mut h = start;
            loop {
                fans.vertex_of[h as usize] = vertex;
                h = twins[previous(h) as usize];
                if h == NONE || h == start {
                    break;
                }
            }
        }
        fans
    }

    /// The border's loops, each in the order of its half-edges.
    fn loops(&self) -> Vec<Vec<u32>> {
        let mut seen = vec![false; self.leaving.len()];
        let mut loops = Vec::new();
        for vertex in 0..seen.len() {
            if self.leaving[vertex] == NONE || seen[vertex] {
                continue;
            }
            let mut along = Vec::new();
            let mut at = vertex;
            while !seen[at] {
                seen[at] = true;
                let h = self.leaving[at];
                along.push(h);
                at = self.vertex_of[next(h) as usize] as usize;
            }
            loops.push(along);
        }
        loops
    }
}
