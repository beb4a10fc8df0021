//! A mesh's sizes and topology, its defects, and their repairs.

use std::collections::BTreeSet;
use std::fmt;

use super::edges::{next, previous};
use super::surface::NONE;
use super::trees::MOST_CHECKED;
use crate::plain_text::{counted, with_commas};

/// The most names of a kind that a report lists.
const MOST_NAMES: usize = 8;

/// Pairs of triangles without a common corner that go through each other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Crossings {
    /// How many were found.
    pub pairs: usize,
    /// Triangles crowd so that not all were compared: there may be more pairs.
    pub are_partial: bool,
    /// None were compared, because the mesh has too many triangles, or is too large or too small.
    pub are_unchecked: bool,
}

/// Sizes, topology and oddities of one mesh; printed in one line when nothing is odd.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MeshReport {
    /// Triangles, without those that were dropped.
    pub triangles: usize,
    /// Welded vertices that triangles use.
    pub vertices: usize,
    /// Edges, borders included.
    pub edges: usize,
    /// Connected parts.
    pub parts: usize,
    /// Half-edges without a twin.
    pub border_edges: usize,
    /// Closed chains of border edges.
    pub border_loops: usize,
    /// Pairs of border edges that are glued, although they lie apart. All other numbers are those before that.
    pub glued_pairs: usize,
    /// Vertices where the surface touches itself in a point; a walk cannot pass from one sheet to the other there.
    pub pinched_vertices: usize,
    /// Vertices - edges + triangles, where a pinched vertex counts once for each sheet that meets there.
    pub euler_characteristic: i64,

    /// Triangles in the file, polygons cut up.
    pub file_triangles: usize,
    /// Vertices in the file, welded or not, used or not.
    pub file_vertices: usize,
    /// Vertices that no triangle names; left out.
    pub unreferenced_vertices: usize,
    /// Of those, the ones with coordinates that are not finite.
    pub unreferenced_non_finite: usize,
    /// Triangles of which two corners are one vertex; dropped.
    pub repeated_corners: usize,
    /// Triangles that are so small in a model of this size that single precision changes their shape.
    pub too_small: usize,
    /// Triangles with three corners and no area; dropped.
    pub without_area: usize,
    /// Triangles with the same corners as an earlier one; dropped.
    pub duplicates: usize,
    /// Vertices at borders that coincide with another one within rounding error; made one with it.
    pub stitched_vertices: usize,
    /// Border edges that coincide with another one within rounding error and stay open: the surface would fold there, a
    /// triangle would lose its area, or more than two meet.
    pub open_seams: usize,
    /// Edges of three or more triangles: the first two that can be are joined, the others end there.
    pub non_manifold_edges: usize,
    /// Triangles that were wound against their neighbours; flipped.
    pub mended_triangles: usize,
    /// Closed parts that faced inwards as a whole; turned.
    pub turned_parts: usize,
    /// Edges of two triangles that cannot be made to agree, as on a Moebius band; cut, so borders.
    pub cut_edges: usize,
    /// Polygons that cross themselves or are far from flat, cut up so that triangles may overlap.
    pub crossed_polygons: usize,
    /// Lines in the file; left out.
    pub lines: usize,
    /// Points in the file; left out.
    pub points: usize,
    /// Lines of an OBJ file that describe curves and free-form surfaces; left out.
    pub free_form_lines: usize,
    /// Lines of a PLY file with more values than its header names; the rest of each is left out.
    pub longer_rows: usize,
    /// Bytes behind the triangles that a binary STL file counts; left out.
    pub trailing_bytes: usize,
    /// STL text ends without `endsolid`.
    pub without_endsolid: bool,
    /// Of coordinates stored in single precision far from the origin: how many steps of it lie across the model, or
    /// across the part with the fewest.
    pub stored_steps: Option<usize>,
    /// Nodes of a scene graph that are reached twice; taken once.
    pub repeated_nodes: usize,
    /// Meshes that nodes of a scene graph would show, but hide; left out.
    pub hidden_meshes: usize,
    /// Triangles that lack corners, at the end of a list of triangles; left out.
    pub incomplete_triangles: usize,
    /// Parts of meshes that have no positions; left out.
    pub without_positions: usize,
    /// Extensions of the file format that may change the shape or its place, and that are not read.
    pub unapplied_extensions: BTreeSet<String>,
    /// Pairs of triangles without a common corner that go through each other: the mesh intersects itself. Counted in files of at most
    /// [`MOST_CHECKED`] triangles.
    pub self_crossings: Crossings,
    /// Texture coordinates are missing at some corners, or not finite; all left out.
    pub incomplete_uvs: bool,
}

/// Fields with their meaning, for one and for several.
macro_rules! counts {
    ($report:ident: $($field:ident: $one:literal, $many:literal;)*) => {
        [$(($report.$field, $one, $many)),*]
    };
}

impl MeshReport {
    /// Measures the topology of welded triangles.
    pub(crate) fn measure(&mut self, corners: &[[u32; 3]], twins: &[u32], vertices: usize) {
        let fans = Fans::count(corners, twins, vertices);
        self.triangles = corners.len();
        self.vertices = vertices;
        self.border_edges = twins.iter().filter(|&&twin| twin == NONE).count();
        self.edges = self.border_edges + (twins.len() - self.border_edges) / 2;
        self.parts = count_parts(twins);
        self.border_loops = count_border_loops(twins);
        self.pinched_vertices = fans.pinched_vertices;
        self.euler_characteristic = fans.all as i64 - self.edges as i64 + corners.len() as i64;
    }

    /// Is no edge open?
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.border_edges == 0
    }

    /// The number of handles, summed over all parts, with every border loop taken for a hole in a closed surface.
    #[must_use]
    pub fn genus(&self) -> u64 {
        let capped = self.euler_characteristic + self.border_loops as i64;
        u64::try_from((2 * self.parts as i64 - capped) / 2).unwrap_or(0)
    }

    /// Sizes and topology in one line: `27,648 triangles, 13,824 vertices, closed, genus 1`.
    #[must_use]
    pub fn summary(&self) -> String {
        let mut text = format!(
            "{}, {}",
            counted(self.triangles, "triangle", "triangles"),
            counted(self.vertices, "vertex", "vertices")
        );
        if self.parts > 1 {
            text += &format!(", {}", counted(self.parts, "part", "parts"));
        }
        if self.is_closed() {
            text += ", closed";
        } else {
            text += &format!(
                ", {} in {}",
                counted(self.border_edges, "border edge", "border edges"),
                counted(self.border_loops, "loop", "loops")
            );
        }
        if self.glued_pairs > 0 {
            text += &format!(
                ", {} of them glued",
                counted(self.glued_pairs, "pair", "pairs")
            );
        }
        text + &format!(", genus {}", self.genus())
    }

    /// All defects, one sentence each, with their treatment; empty if there are none.
    #[must_use]
    pub fn oddities(&self) -> Vec<String> {
        let mut list = Vec::new();
        let counts = counts! { self:
            repeated_corners: "triangle with a corner twice, dropped", "triangles with a corner twice, dropped";
            too_small: "triangle too small for single precision in a model of this size, its shape changed: is a vertex far from the others?",
                "triangles too small for single precision in a model of this size, their shapes changed: is a vertex far from the others?";
            without_area: "triangle without area, dropped", "triangles without area, dropped";
            duplicates: "triangle that is there already, dropped", "triangles that are there already, dropped";
            stitched_vertices: "border vertex that coincides with another one within rounding error, made one with it",
                "border vertices that coincide with others within rounding error, made one with these";
            open_seams: "border edge that coincides with another one within rounding error, not joined",
                "border edges that coincide with others within rounding error, not joined";
            non_manifold_edges: "edge with three or more triangles: two are joined, the others end there",
                "edges with three or more triangles: two are joined at each, the others end there";
            mended_triangles: "triangle wound against its neighbours, flipped", "triangles wound against their neighbours, flipped";
            turned_parts: "closed part that faced inwards, turned", "closed parts that faced inwards, turned";
            cut_edges: "edge whose two sides cannot agree (the surface is one-sided), cut",
                "edges whose two sides cannot agree (the surface is one-sided), cut";
            pinched_vertices: "vertex where the surface only touches itself", "vertices where the surface only touches itself";
            unreferenced_vertices: "vertex that no triangle uses, ignored", "vertices that no triangle uses, ignored";
            unreferenced_non_finite: "of the unused vertices is not finite", "of the unused vertices are not finite";
            crossed_polygons: "polygon that crosses itself or is far from flat: its triangles may overlap",
                "polygons that cross themselves or are far from flat: their triangles may overlap";
            lines: "line, ignored", "lines, ignored";
            points: "point, ignored", "points, ignored";
            free_form_lines: "line of curves or free-form surfaces, ignored", "lines of curves or free-form surfaces, ignored";
            longer_rows: "line with more values than the PLY header names, the rest ignored",
                "lines with more values than the PLY header names, the rest ignored";
            trailing_bytes: "byte behind the last triangle, ignored", "bytes behind the last triangle, ignored";
            repeated_nodes: "node of the scene graph that is reached again, taken once",
                "nodes of the scene graph that are reached again, taken once";
            hidden_meshes: "mesh that the file hides, left out", "meshes that the file hides, left out";
            incomplete_triangles: "triangle that lacks corners, ignored", "triangles that lack corners, ignored";
            without_positions: "part of a mesh without positions, ignored", "parts of meshes without positions, ignored";
        };
        for (count, one, many) in counts {
            if count > 0 {
                list.push(counted(count, one, many));
            }
        }
        let Crossings {
            pairs,
            are_partial,
            are_unchecked,
        } = self.self_crossings;
        if pairs > 0 {
            list.push(format!(
                "{}{} of triangles that go through each other: the mesh intersects itself, and walks go on inside of it",
                if are_partial { "at least " } else { "" },
                counted(pairs, "pair", "pairs"),
            ));
        } else if are_partial {
            list.push(
                "not all pairs of triangles were compared, because too many lie together: the mesh may intersect itself"
                    .to_owned(),
            );
        } else if are_unchecked {
            let why = if self.triangles > MOST_CHECKED {
                format!("there are more than {}", with_commas(MOST_CHECKED as f64))
            } else {
                "the mesh is too large or too small".to_owned()
            };
            list.push(format!(
                "no pairs of triangles were compared, because {why}: the mesh may intersect itself"
            ));
        }
        for name in self.unapplied_extensions.iter().take(MOST_NAMES) {
            list.push(format!("the extension {name} is not applied"));
        }
        let unnamed = self.unapplied_extensions.len().saturating_sub(MOST_NAMES);
        if unnamed > 0 {
            list.push(format!("{unnamed} more extensions are not applied"));
        }
        if let Some(steps) = self.stored_steps {
            list.push(format!(
                "the file has coordinates of single precision far from the origin, {} across the model: finer details \
                 are lost; export it with its own middle as the origin",
                counted(steps, "step", "steps"),
            ));
        }
        if self.without_endsolid {
            list.push("the STL text has no `endsolid`: it may be cut off".to_owned());
        }
        if self.incomplete_uvs {
            list.push("texture coordinates that are incomplete or not finite, ignored".to_owned());
        }
        list
    }
}

impl fmt::Display for MeshReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.summary())?;
        for oddity in self.oddities() {
            write!(f, "\n  - {oddity}")?;
        }
        Ok(())
    }
}

fn count_parts(twins: &[u32]) -> usize {
    let mut seen = vec![false; twins.len() / 3];
    let mut parts = 0;
    let mut open = Vec::new();
    for first in 0..seen.len() {
        if std::mem::replace(&mut seen[first], true) {
            continue;
        }
        parts += 1;
        open.push(first);
        while let Some(triangle) = open.pop() {
            for &twin in &twins[3 * triangle..3 * triangle + 3] {
                if twin != NONE && !std::mem::replace(&mut seen[twin as usize / 3], true) {
                    open.push(twin as usize / 3);
                }
            }
        }
    }
    parts
}

/// Fans: the runs of triangles around a vertex that are connected over edges. A plain vertex has one.
struct Fans {
    all: usize,
    pinched_vertices: usize,
}

impl Fans {
    fn count(corners: &[[u32; 3]], twins: &[u32], vertices: usize) -> Self {
        let mut seen = vec![false; twins.len()];
        let mut fans_at = vec![0_u32; vertices];
        for corner in 0..twins.len() {
            if !seen[corner] {
                mark_fan(twins, corner as u32, &mut seen);
                fans_at[corners[corner / 3][corner % 3] as usize] += 1;
            }
        }
        Self {
            all: fans_at.iter().map(|&fans| fans as usize).sum(),
            pinched_vertices: fans_at.iter().filter(|&&fans| fans > 1).count(),
        }
    }
}

/// Marks every corner of the fan that one corner belongs to, turning left and then right.
fn mark_fan(twins: &[u32], corner: u32, seen: &mut [bool]) {
    seen[corner as usize] = true;
    let mut left = twins[previous(corner) as usize];
    while left != NONE && !seen[left as usize] {
        seen[left as usize] = true;
        left = twins[previous(left) as usize];
    }
    let mut right = twins[corner as usize];
    while right != NONE && !seen[next(right) as usize] {
        seen[next(right) as usize] = true;
        right = twins[next(right) as usize];
    }
}

fn count_border_loops(twins: &[u32]) -> usize {
    let mut seen = vec![false; twins.len()];
    let mut loops = 0;
    for first in 0..twins.len() {
        if twins[first] != NONE || seen[first] {
            continue;
        }
        loops += 1;
        let mut border = first as u32;
        while !std::mem::replace(&mut seen[border as usize], true) {
            // Turn about the end of this border until the next one leaves it.
            border = next(border);
            while twins[border as usize] != NONE {
                border = next(twins[border as usize]);
            }
        }
    }
    loops
}
