//! Seams that nearly close: borders that coincide within rounding error are joined.
//!
//! Programs that build a surface from pieces write the vertices of a seam once for each piece, and the last digits
//! differ: `cos(2 pi)` is not quite `cos(0)`. Two border edges are joined if
//!
//! - both ends of one are close to the ends of the other: nearer than [`REACH`] of the model's diagonal, and than
//!   [`OF_EDGE`] of the shortest edge at either vertex, so that nothing collapses;
//! - neither is as close to a third one;
//! - their triangles do not lie on each other ([`FOLDED`]): the two sides of a thin wall stay apart;
//! - no triangle that a vertex of theirs belongs to loses its area or turns over.
//!
//! Such close borders that stay open are counted for the report.

use std::collections::{HashMap, HashSet};

use glam::{DVec3, Vec3};

use super::MeshReport;
use super::edges::{EdgeGroups, ends, previous};
use crate::portable::{exponent_of, power_of_two};

/// Tolerance for rounding of vertices, as a part of the diagonal of the model's box: for a model near the origin a
/// little more than the error of six digits.
const REACH: f64 = 2e-6;

/// Largest tolerance, as a part of the shortest edge at a vertex.
const OF_EDGE: f64 = 0.02;

/// The cosine between the directions in which two triangles leave their common edge from which on they lie on each
/// other: five degrees.
const FOLDED: f64 = 0.996;

/// The most candidates of about equal length near a border; with more, it stays open.
const MOST_NEAR: usize = 64;

/// The shortest edge and the lowest height that a triangle may have: float32 can still multiply two such lengths'
/// ratios, and a scene's scale has room below.
const SMALLEST_LENGTH: f64 = 1e-30;

/// Rounds in which harmful joints are left out; after them all are left out.
const MOST_ROUNDS: usize = 8;

/// Joins borders that nearly coincide, by giving triangles the first of the vertices that become one. Corners of each
/// triangle are different before and after. Returns whether anything was joined.
pub(crate) fn stitch(
    positions: &[Vec3],
    corners: &mut [[u32; 3]],
    report: &mut MeshReport,
) -> bool {
    let borders = borders(corners);
    if borders.len() < 2 {
        return false;
    }
    let seams = Seams::new(positions, corners);
    let partners = seams.partners(&borders);
    let joined: Vec<(u32, u32)> = (partners.iter().enumerate())
        .filter_map(|(edge, partner)| match *partner {
            Partner::One(other) if edge < other as usize => Some((edge as u32, other)),
            _ => None,
        })
        .filter(|&(edge, other)| {
            partners[other as usize] == Partner::One(edge)
                && !seams.is_folded(borders[edge as usize], borders[other as usize])
        })
        .collect();

    let mut clusters = Clusters::default();
    for &(edge, other) in &joined {
        for (a, b) in seams.pairs(borders[edge as usize], borders[other as usize]) {
            clusters.join(a, b);
        }
    }
    let first_of = seams.without_damage(clusters.first_of());
    let first = |vertex: u32| first_of.get(&vertex).copied().unwrap_or(vertex);
    let near = partners.iter().filter(|p| **p != Partner::None).count();
    let closed = joined.iter().filter(|&&(edge, other)| {
        let mut pairs = seams.pairs(borders[edge as usize], borders[other as usize]);
        pairs.all(|(a, b)| first(a) == first(b))
    });
    report.open_seams = near - 2 * closed.count();
    report.stitched_vertices = first_of.len();
    for corner in corners.iter_mut().flatten() {
        *corner = first(*corner);
    }
    !first_of.is_empty()
}

/// Half-edges of edges that one triangle has.
fn borders(corners: &[[u32; 3]]) -> Vec<u32> {
    let groups = EdgeGroups::new(corners);
    let alone = groups.iter().filter(|group| group.len() == 1);
    alone.map(|group| group[0].1).collect()
}

/// The other border edges that are as close as can be joined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Partner {
    None,
    /// The number of the border.
    One(u32),
    Several,
}

struct Seams<'a> {
    positions: &'a [Vec3],
    corners: &'a [[u32; 3]],
    /// How far vertices of one place may be apart, anywhere.
    reach: f64,
    /// How far each vertex may be from others of its place.
    tolerance: Vec<f32>,
}

impl<'a> Seams<'a> {
    fn new(positions: &'a [Vec3], corners: &'a [[u32; 3]]) -> Self {
        let used = || corners.iter().flatten().map(|&v| positions[v as usize]);
        let low = used().fold(Vec3::INFINITY, Vec3::min).as_dvec3();
        let high = used().fold(Vec3::NEG_INFINITY, Vec3::max).as_dvec3();
        let reach = REACH * low.distance(high);
        let mut tolerance = vec![reach as f32; positions.len()];
        for &[a, b, c] in corners {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                let length = positions[from as usize].distance(positions[to as usize]);
                for vertex in [from, to] {
                    let tolerance = &mut tolerance[vertex as usize];
                    *tolerance = tolerance.min(OF_EDGE as f32 * length);
                }
            }
        }
        Self {
            positions,
            corners,
            reach,
            tolerance,
        }
    }

    fn at(&self, vertex: u32) -> DVec3 {
        self.positions[vertex as usize].as_dvec3()
    }

    fn ends(&self, halfedge: u32) -> (u32, u32) {
        ends(self.corners, halfedge)
    }

    fn middle(&self, halfedge: u32) -> DVec3 {
        let (from, to) = self.ends(halfedge);
        self.at(from).midpoint(self.at(to))
    }

    fn are_close(&self, a: u32, b: u32) -> bool {
        let tolerance = self.tolerance[a as usize].min(self.tolerance[b as usize]);
        self.at(a).distance(self.at(b)) <= f64::from(tolerance)
    }

    /// For each border edge, the one that coincides with it.
    ///
    /// Border edges are in grids by their middles, with a separate grid for each length (up to a factor of two): a cell is as wide as such
    /// edges may be apart, so that few share a cell, also in small parts of the model.
    fn partners(&self, borders: &[u32]) -> Vec<Partner> {
        let mut in_cell: HashMap<[i64; 4], Vec<u32>> = HashMap::with_capacity(borders.len());
        for (border, &halfedge) in borders.iter().enumerate() {
            let level = exponent_of(self.length(halfedge));
            let [x, y, z] = self.cell(level, self.middle(halfedge));
            let cell = in_cell.entry([level, x, y, z]).or_default();
            cell.push(border as u32);
        }
        let partner_of = |(border, &halfedge): (usize, &u32)| {
            let (length, middle) = (self.length(halfedge), self.middle(halfedge));
            let apart = self.reach.min(OF_EDGE * length);
            let mut found = Partner::None;
            let mut looked_at = 0;
            // The coinciding border may be slightly shorter or longer.
            let level = exponent_of(length);
            for level in level - 1..=level + 1 {
                let [low, high] = [-apart, apart].map(|way| self.cell(level, middle + way));
                for [x, y, z] in cells(low, high) {
                    for &other in in_cell.get(&[level, x, y, z]).into_iter().flatten() {
                        if other as usize == border {
                            continue;
                        }
                        looked_at += 1;
                        let lies_there = self.lie_on_each_other(halfedge, borders[other as usize]);
                        found = match found {
                            _ if looked_at > MOST_NEAR => return Partner::Several,
                            found if !lies_there => found,
                            Partner::None => Partner::One(other),
                            _ => return Partner::Several,
                        };
                    }
                }
            }
            found
        };
        borders.iter().enumerate().map(partner_of).collect()
    }

    fn length(&self, halfedge: u32) -> f64 {
        let (from, to) = self.ends(halfedge);
        self.at(from).distance(self.at(to))
    }

    /// The cell of a place in the grid of one level.
    fn cell(&self, level: i64, place: DVec3) -> [i64; 3] {
        let longest = power_of_two(level + 1);
        let width = 2.0 * self.reach.min(OF_EDGE * longest);
        (place / width).floor().to_array().map(|c| c as i64)
    }

    fn lie_on_each_other(&self, one: u32, other: u32) -> bool {
        self.pairs(one, other).all(|(a, b)| self.are_close(a, b))
    }

    /// The ends of two edges, each with the nearer one of the other edge. Windings may not agree yet.
    fn pairs(&self, one: u32, other: u32) -> impl Iterator<Item = (u32, u32)> {
        let ((a, b), (c, d)) = (self.ends(one), self.ends(other));
        let straight = self.at(a).distance_squared(self.at(c));
        let crossed = self.at(a).distance_squared(self.at(d));
        match straight < crossed {
            true => [(a, c), (b, d)],
            false => [(a, d), (b, c)],
        }
        .into_iter()
    }

    /// Do the triangles at two edges that lie on each other, lie on each other, too?
    fn is_folded(&self, one: u32, other: u32) -> bool {
        let [one, other] = [one, other].map(|halfedge| {
            let (from, to) = self.ends(halfedge);
            let (apex, _) = self.ends(previous(halfedge));
            let along = (self.at(to) - self.at(from)).normalize_or_zero();
            let inwards = self.at(apex) - self.at(from);
            (inwards - along * inwards.dot(along)).normalize_or_zero()
        });
        one.dot(other) > FOLDED
    }

    /// Leaves out joints that would make a triangle lose its area or flip.
    fn without_damage(&self, mut first_of: HashMap<u32, u32>) -> HashMap<u32, u32> {
        // Leaving out a joint may harm another triangle, so this repeats until there is no harm.
        for _ in 0..MOST_ROUNDS {
            let first = |vertex: u32| first_of.get(&vertex).copied().unwrap_or(vertex);
            let normal =
                |[a, b, c]: [u32; 3]| (self.at(b) - self.at(a)).cross(self.at(c) - self.at(a));
            let damaged: HashSet<u32> = (self.corners.iter())
                .filter(|corners| corners.iter().any(|corner| first(*corner) != *corner))
                .filter(|corners| {
                    let after = corners.map(first);
                    normal(**corners).dot(normal(after)) <= 0.0
                        || !has_inside(after.map(|corner| self.at(corner)))
                })
                .flatten()
                .map(|&corner| first(corner))
                .collect();
            if damaged.is_empty() {
                return first_of;
            }
            first_of.retain(|_, first| !damaged.contains(first));
        }
        HashMap::new()
    }
}

/// Whether the edges and heights of a triangle are greater than zero by more than rounding.
pub(crate) fn has_inside([a, b, c]: [DVec3; 3]) -> bool {
    let edges = [b - a, c - b, a - c].map(DVec3::length);
    let longest = edges[0].max(edges[1]).max(edges[2]);
    let shortest = edges[0].min(edges[1]).min(edges[2]);
    let lowest = (b - a).cross(c - a).length() / longest;
    shortest >= SMALLEST_LENGTH && lowest >= SMALLEST_LENGTH
}

/// The cells from one to another, at most three on each axis.
fn cells(low: [i64; 3], high: [i64; 3]) -> impl Iterator<Item = [i64; 3]> {
    let range = move |axis: usize| low[axis]..=high[axis];
    range(0).flat_map(move |x| range(1).flat_map(move |y| range(2).map(move |z| [x, y, z])))
}

/// Sets of vertices that become one.
#[derive(Default)]
struct Clusters {
    parent: HashMap<u32, u32>,
}

impl Clusters {
    fn root(&mut self, vertex: u32) -> u32 {
        let mut root = vertex;
        while let Some(&parent) = self.parent.get(&root) {
            root = parent;
        }
        // Shortens the way for the next search.
        let mut on_the_way = vertex;
        while on_the_way != root {
            let parent = self.parent.insert(on_the_way, root);
            on_the_way = parent.unwrap_or(root);
        }
        root
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        if a != b {
            // The first in the file represents the set.
            self.parent.insert(a.max(b), a.min(b));
        }
    }

    /// Vertices that another one replaces, with that one.
    fn first_of(mut self) -> HashMap<u32, u32> {
        let vertices: Vec<u32> = self.parent.keys().copied().collect();
        vertices.into_iter().map(|v| (v, self.root(v))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;
    use crate::mesh::soup::Soup;

    /// A torus of 32 by 16 quads in double precision whose last row and column repeat the first, moved by up to `error`.
    fn torus(error: f64) -> Soup {
        let (around, across) = (32, 16);
        let mut soup = Soup::default();
        for i in 0..=around {
            for j in 0..=across {
                let [u, v] = [(i, around), (j, across)].map(|(k, count)| {
                    std::f64::consts::TAU * f64::from(k % count) / f64::from(count)
                });
                let out = 1.0 + 0.4 * v.cos();
                // Another one at every vertex.
                let turn = f64::from(31 * i + 17 * j);
                let moved = error * DVec3::new(turn.sin(), turn.cos(), (2.0 * turn).sin());
                soup.positions
                    .push(DVec3::new(out * u.cos(), 0.4 * v.sin(), out * u.sin()) + moved);
            }
        }
        for i in 0..around as u32 {
            for j in 0..across as u32 {
                let at = |i, j| i * (across as u32 + 1) + j;
                let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
                soup.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        soup
    }

    /// Without this a model that another program rounded would be an open strip, and walks would end at its seam.
    #[test]
    fn seams_close_up_to_a_millionth_of_the_diagonal() {
        for error in [0.0, 1e-16, 1e-9, 1e-7, 1e-6] {
            let mesh = Mesh::from_soup("torus", torus(error)).unwrap();
            let report = &mesh.report;
            assert!(report.is_closed(), "{error:e}: {report}");
            assert_eq!(
                (report.genus(), report.parts, report.triangles),
                (1, 1, 1024)
            );
            // 33 x 17 vertices, of which 32 x 16 are places.
            assert_eq!(report.vertices, 512, "{error:e}");
            assert_eq!(report.open_seams, 0);
        }
        // A gap larger than rounding is a border, which the summary mentions.
        let report = Mesh::from_soup("torus", torus(1e-4)).unwrap().report;
        assert_eq!((report.border_edges, report.stitched_vertices), (96, 0));
        assert!(report.summary().contains("96 border edges"), "{report}");
    }

    /// A plate of two sheets that coincide within rounding error, open at all sides: joined, it would be a wall
    /// without thickness, with both sides on the same texels.
    #[test]
    fn sheets_that_lie_on_each_other_stay_apart() {
        let mut soup = Soup::default();
        for (sheet, height) in [(0, 0.0), (1, 1e-7)] {
            let first = soup.positions.len() as u32;
            for (x, z) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
                soup.positions.push(DVec3::new(x, height, z));
            }
            for corners in [[0, 1, 2], [0, 2, 3]] {
                let [a, b, c] = corners.map(|corner| first + corner);
                soup.triangles
                    .push(if sheet == 0 { [a, b, c] } else { [a, c, b] });
            }
        }
        let mesh = Mesh::from_soup("plate", soup).unwrap();
        assert_eq!((mesh.report.parts, mesh.report.border_edges), (2, 8));
        assert_eq!(
            (mesh.report.stitched_vertices, mesh.report.open_seams),
            (0, 8)
        );
        let text = mesh.report.to_string();
        assert!(text.contains("8 border edges that coincide"), "{text}");
    }

    /// One far vertex enlarges the tolerance for the whole model; small borders must still fall into many cells.
    #[test]
    fn many_small_borders_and_a_far_corner_take_no_time() {
        let mut soup = torus(1e-9);
        let small = 1e-4;
        let loose = 60_000;
        for k in 0..loose {
            let first = soup.positions.len() as u32;
            let corner = DVec3::new(3.0 * f64::from(k % 250), 3.0 * f64::from(k / 250), 0.0);
            for (x, y) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)] {
                soup.positions
                    .push(small * (corner + DVec3::new(x, y, 0.0)));
            }
            soup.triangles.push([first, first + 1, first + 2]);
        }
        let far = soup.positions.len() as u32;
        soup.positions
            .extend([DVec3::X, DVec3::Y, DVec3::Z].map(|axis| 1e5 * axis));
        soup.triangles.push([far, far + 1, far + 2]);
        let report = Mesh::from_soup("torus", soup).unwrap().report;
        assert_eq!((report.parts, report.open_seams), (2 + loose as usize, 0));
        assert_eq!(report.border_edges, 3 + 3 * loose as usize);
    }

    /// Edges shorter than the tolerance would be closed up with it.
    #[test]
    fn a_strip_thinner_than_the_reach_is_not_closed_up() {
        let mut soup = Soup::default();
        for k in 0..=8 {
            for z in [0.0, 1e-6] {
                soup.positions.push(DVec3::new(f64::from(k), 0.0, z));
            }
        }
        for k in 0..8 {
            let first = 2 * k;
            soup.triangles.extend([
                [first, first + 1, first + 2],
                [first + 1, first + 3, first + 2],
            ]);
        }
        let report = Mesh::from_soup("strip", soup).unwrap().report;
        assert_eq!((report.triangles, report.border_edges), (16, 18));
        assert_eq!((report.stitched_vertices, report.open_seams), (0, 0));
    }

    /// Three sheets whose edges coincide within rounding error: it is ambiguous which two belong together.
    #[test]
    fn what_could_be_joined_in_two_ways_is_left() {
        let mut soup = Soup::default();
        for (k, (x, z)) in [(1.0, 0.0), (-1.0, 0.5), (-1.0, -0.5)]
            .into_iter()
            .enumerate()
        {
            let first = soup.positions.len() as u32;
            let off = 1e-7 * k as f64;
            soup.positions.extend([
                DVec3::new(off, 0.0, 0.0),
                DVec3::new(off, 1.0, 0.0),
                DVec3::new(x, 0.5, z),
            ]);
            soup.triangles.push([first, first + 1, first + 2]);
        }
        let report = Mesh::from_soup("fan", soup).unwrap().report;
        assert_eq!((report.parts, report.open_seams), (3, 3), "{report}");
    }
}
