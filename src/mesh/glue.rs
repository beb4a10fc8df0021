//! Glued edges: two border edges of one length that are one edge, although they lie apart. Walks, diffusion and distances along the surface
//! go over it as over any other; what works by place, such as pictures and distances between objects, does not know it.

use std::collections::HashMap;

use super::edges::{EdgeGroups, ends};
use super::surface::NONE;
use super::{Mesh, MeshProblem};

/// Lengths of glued edges differ by no more than this part: files round coordinates.
const OF_LENGTH: f64 = 1e-3;

impl Mesh {
    /// The mesh with more pairs of edges glued, each given by a face of the file and its edge, then the other face and its edge. Faces are
    /// numbered as in [`point_from_file`](Self::point_from_file); edge 0 of a face goes from its first corner to its second. The edges of a
    /// pair run against each other, as those of neighbours do.
    ///
    /// # Errors
    /// When there is no such edge, it is no border, it is in two pairs, or the two are not equally long.
    pub fn glued(mut self, pairs: &[[u32; 4]]) -> Result<Self, MeshProblem> {
        let twins = EdgeGroups::new(&self.corners).twins(&self.corners);
        // Half-edges that are glued; with the number of their pair, if it is in the list.
        let mut glued: HashMap<u32, Option<usize>> = HashMap::new();
        glued.extend(self.glue.as_flattened().iter().map(|&h| (h, None)));
        for (number, &[face, edge, other_face, other_edge]) in pairs.iter().enumerate() {
            let bad = |problem| MeshProblem::Glue {
                pair: number,
                problem,
            };
            let mut found = [0; 2];
            for (k, (face, edge)) in [(face, edge), (other_face, other_edge)]
                .into_iter()
                .enumerate()
            {
                let h = self.halfedge_in_file(face, edge).map_err(bad)?;
                let what = format!("edge {edge} of face {face}");
                if twins[h as usize] != NONE {
                    let beyond = self.file_triangle[twins[h as usize] as usize / 3];
                    return Err(bad(format!(
                        "{what} is no border: face {beyond} lies beyond it. Glue edges that have no neighbour"
                    )));
                }
                match glued.insert(h, Some(number)) {
                    None => {}
                    Some(Some(before)) if before == number => {
                        return Err(bad(format!(
                            "{what} is glued to itself: name two different edges"
                        )));
                    }
                    Some(before) => {
                        let before = before.map_or_else(
                            || "by the built-in mesh".to_owned(),
                            |before| format!("in pair {before}"),
                        );
                        return Err(bad(format!(
                            "{what} is glued already, {before}: name each edge once"
                        )));
                    }
                }
                found[k] = h;
            }
            let [one, other] = found.map(|h| self.length_of(h));
            if (one - other).abs() > OF_LENGTH * one.max(other) {
                return Err(bad(format!(
                    "edge {edge} of face {face} is {one:.6} long, and edge {other_edge} of face {other_face} is {other:.6}: glue edges of \
                     one length"
                )));
            }
            found.sort_unstable();
            self.glue.push(found);
        }
        self.glue.sort_unstable();
        self.report.glued_pairs = self.glue.len();
        Ok(self)
    }

    /// The half-edge at an edge of a face of the file.
    fn halfedge_in_file(&self, face: u32, edge: u32) -> Result<u32, String> {
        if edge > 2 {
            return Err(format!(
                "face {face} has no edge {edge}: edges are 0, 1 and 2, and edge 0 goes from the first corner to the second"
            ));
        }
        let Ok(triangle) = self.file_triangle.binary_search(&face) else {
            let count = self.report.file_triangles;
            return Err(if (face as usize) < count {
                format!("face {face} was dropped when the mesh was repaired: name other edges")
            } else {
                format!(
                    "there is no face {face}: the faces are 0 to {}, polygons cut into triangles",
                    count - 1
                )
            });
        };
        // The edge is opposite to one corner, whichever way the triangle was turned.
        let opposite = (edge + 2) % 3;
        let place = self.file_corners[triangle].map(u32::from);
        let corner = (0..3).find(|&corner| place[(corner + 2) % 3] == opposite);
        let corner = corner.expect("the corners of a triangle are 0, 1 and 2");
        Ok((3 * triangle + corner) as u32)
    }

    fn length_of(&self, halfedge: u32) -> f64 {
        let (start, end) = ends(&self.corners, halfedge);
        let [start, end] = [start, end].map(|v| self.positions[v as usize].as_dvec3());
        start.distance(end)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::mesh::surface::Surface;

    /// A strip of three squares along X, each of two triangles; the last is wider across if `widens`.
    fn strip(flips: bool, widens: bool) -> Mesh {
        let across = |i: u32| if widens && i == 3 { 1.5 } else { 1.0 };
        let positions = (0..4).flat_map(|i| {
            let x = f64::from(i);
            [DVec3::new(x, 0.0, 0.0), DVec3::new(x, across(i), 0.0)]
        });
        let mut triangles = Vec::new();
        for i in 0..3 {
            let [a, b, c, d] = [2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
        if flips {
            // Wound against its neighbours: the loader turns it.
            triangles[1] = [triangles[1][0], triangles[1][2], triangles[1][1]];
        }
        Mesh::from_triangles("strip", positions.collect(), triangles).unwrap()
    }

    /// Catches an edge that is looked up in the mesh's order of corners, which is another one than the file's, also of a triangle that was
    /// turned; and twins that do not carry a heading over.
    #[test]
    fn the_ends_of_a_strip_are_glued_to_a_band() {
        for flips in [false, true] {
            let mesh = strip(flips, false);
            // The strip's far end, and its beginning, whose edge is another one in the file if the triangle was turned.
            let mesh = mesh.glued(&[[4, 1, 1, if flips { 0 } else { 2 }]]).unwrap();
            assert_eq!(mesh.report.glued_pairs, 1);
            for &h in &mesh.glue[0] {
                let (start, end) = ends(&mesh.corners, h);
                let [start, end] = [start, end].map(|v| mesh.positions[v as usize]);
                assert_eq!(start.x, end.x, "an end of the strip");
                assert!(start.x == 0.0 || start.x == 3.0);
            }
            let surface = Surface::build(&[(&mesh, 2.0), (&mesh, 1.0)]);
            surface.validate().unwrap();
            assert_eq!(surface.glued.len(), 4);
            assert!(surface.glued.is_sorted());
            let whole = surface.cut();
            let whole: &Surface = &whole;
            assert!(whole.glued.is_empty());
            whole.validate().unwrap();
            let borders = |of: &Surface| of.halfedges.iter().filter(|h| h.twin == NONE).count();
            assert_eq!(borders(whole), borders(&surface) + 4);
        }
    }

    /// Catches each mistake that would give a walk a wrong way: none of them may pass, and each has a message of its own.
    #[test]
    fn mistakes_in_lists_are_named() {
        let long = strip(false, true);
        let even = strip(false, false);
        for (mesh, pairs, words) in [
            (
                &long,
                &[[4, 1, 1, 2]][..],
                "glued pair 0: edge 1 of face 4 is 1.500000 long, and edge 2 of face 1 is 1.000000",
            ),
            (
                &even,
                &[[4, 1, 1, 0]][..],
                "edge 0 of face 1 is no border: face 0 lies beyond it",
            ),
            (
                &even,
                &[[4, 1, 1, 2], [0, 0, 4, 1]][..],
                "glued pair 1: edge 1 of face 4 is glued already, in pair 0",
            ),
            (
                &even,
                &[[4, 1, 4, 1]][..],
                "edge 1 of face 4 is glued to itself",
            ),
            (
                &even,
                &[[6, 0, 1, 2]][..],
                "there is no face 6: the faces are 0 to 5",
            ),
            (&even, &[[4, 3, 1, 2]][..], "face 4 has no edge 3"),
        ] {
            let message = mesh.clone().glued(pairs).unwrap_err().to_string();
            assert!(message.contains(words), "{words} in {message}");
        }
        let periodic = Mesh::builtin("plane?columns=2&rows=2&periodic=true").unwrap();
        let message = periodic.glued(&[[0, 0, 3, 1]]).unwrap_err().to_string();
        assert!(
            message.contains("is glued already, by the built-in mesh"),
            "{message}"
        );
    }
}
