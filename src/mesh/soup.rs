//! Triangles as in a file, and their conversion to a [`Mesh`].

use glam::{DVec3, Vec2, Vec3};

use super::edges::EdgeGroups;
use super::error::MeshProblem;
use super::orient::orient;
use super::polygon::triangulate;
use super::weld::weld;
use super::{Mesh, MeshReport, origin};

/// More triangles than this have no room in the largest texture that a device may offer, with a few texels each.
pub(crate) const MOST_TRIANGLES: usize = 1 << 26;

/// Coordinates reach no farther: beyond, double precision has no digits to spare for models of usual sizes.
pub(crate) const FARTHEST: f64 = 1e12;

/// Of a triangle's shortest edge: a corner that is moved farther changes how the triangle looks.
const CHANGED: f64 = 0.01;

/// The output of a loader: vertices and triangles in file order, nothing merged and nothing repaired.
#[derive(Debug, Default)]
pub(crate) struct Soup {
    /// Vertices, as precise as the file has them; those of several primitives one after the other.
    pub positions: Vec<DVec3>,
    /// Corners of each triangle, in range: loaders check that, because their messages need the file's numbering.
    pub triangles: Vec<[u32; 3]>,
    /// Texture coordinates of each triangle's corners, if every one has them.
    pub uvs: Option<Vec<[Vec2; 3]>>,
    /// The loader's part of the report; the rest is filled in later.
    pub seen: MeshReport,
}

impl Soup {
    /// The origin of positions. Vertices without triangles do not count.
    fn origin(&self) -> DVec3 {
        let used = || self.triangles.as_flattened().iter();
        let used = || used().map(|&vertex| &self.positions[vertex as usize]);
        if !used().all(|position| position.is_finite()) {
            return DVec3::ZERO;
        }
        let (low, high) = origin::bounds(used());
        origin::of_mesh(low, high)
    }

    /// Triangles whose shape rounding changes: it moves a corner by more than a part of the shortest edge.
    fn too_small(&self, rounded: &[Vec3], origin: DVec3) -> usize {
        let is_changed = |corners: &[u32; 3]| {
            let exact = corners.map(|vertex| self.positions[vertex as usize] - origin);
            let moved = [0, 1, 2]
                .map(|k| exact[k].distance_squared(rounded[corners[k] as usize].as_dvec3()));
            let edge = |k: usize| exact[k].distance_squared(exact[(k + 1) % 3]);
            let shortest = edge(0).min(edge(1)).min(edge(2));
            let farthest = moved[0].max(moved[1]).max(moved[2]);
            shortest > 0.0 && farthest > CHANGED * CHANGED * shortest
        };
        self.triangles
            .iter()
            .filter(|corners| is_changed(corners))
            .count()
    }

    /// Adds a polygon of vertices that exist, cut into triangles; `uvs` are those of its corners.
    pub fn add_polygon(&mut self, vertices: &[u32], uvs: Option<&[Vec2]>) {
        let mut add = |corners: [u32; 3]| {
            let corners = corners.map(|corner| corner as usize);
            self.triangles.push(corners.map(|corner| vertices[corner]));
            if let (Some(all), Some(uvs)) = (&mut self.uvs, uvs) {
                all.push(corners.map(|corner| uvs[corner]));
            }
        };
        if vertices.len() <= 3 {
            return if vertices.len() == 3 {
                add([0, 1, 2])
            };
        }
        let position = |&vertex: &u32| self.positions[vertex as usize];
        let corners: Vec<DVec3> = vertices.iter().map(position).collect();
        if !triangulate(&corners, add) {
            self.seen.crossed_polygons += 1;
        }
    }
}

impl Mesh {
    /// Welds, drops degenerate triangles, makes the winding agree, and reports all of it.
    pub(crate) fn from_soup(name: &str, soup: Soup) -> Result<Self, MeshProblem> {
        let origin = soup.origin();
        if origin.abs().max_element() > FARTHEST {
            return Err(MeshProblem::TooFar {
                farthest: origin.abs().max_element(),
            });
        }
        let rounded = soup
            .positions
            .iter()
            .map(|&position| (position - origin).as_vec3());
        let positions: Vec<Vec3> = rounded.collect();
        let too_small = soup.too_small(&positions, origin);
        let mut report = soup.seen;
        report.file_triangles = soup.triangles.len();
        report.file_vertices += soup.positions.len();
        report.too_small = too_small;
        let welded = weld(&positions, &soup.triangles, &mut report)?;
        let mut corners = welded.corners;
        let mut groups = EdgeGroups::new(&corners);
        report.non_manifold_edges = groups.iter().filter(|group| group.len() > 2).count();
        let flipped = orient(&welded.positions, &mut corners, &mut groups, &mut report);
        report.measure(&corners, &groups.twins(&corners), welded.positions.len());

        let file_corners: Vec<[u8; 3]> = corners
            .iter_mut()
            .zip(flipped)
            .map(|(corners, flipped)| {
                let mut file_corners = if flipped { [0, 2, 1] } else { [0, 1, 2] };
                let shortest = shortest_edge(&welded.positions, *corners);
                corners.rotate_left(shortest);
                file_corners.rotate_left(shortest);
                file_corners
            })
            .collect();
        let uvs = soup.uvs.map(|uvs| {
            welded
                .file_triangle
                .iter()
                .zip(&file_corners)
                .map(|(&file, corners)| corners.map(|corner| uvs[file as usize][corner as usize]))
                .collect()
        });
        Ok(Self {
            name: name.to_owned(),
            positions: welded.positions,
            origin,
            corners,
            file_corners,
            file_triangle: welded.file_triangle,
            uvs,
            glue: Vec::new(),
            report,
        })
    }
}

/// The corner that a triangle's shortest edge starts from, the first of equal ones.
fn shortest_edge(positions: &[Vec3], corners: [u32; 3]) -> usize {
    let [a, b, c] = corners.map(|vertex| positions[vertex as usize].as_dvec3());
    let squares = [
        a.distance_squared(b),
        b.distance_squared(c),
        c.distance_squared(a),
    ];
    (0..3).fold(0, |shortest, k| {
        if squares[k] < squares[shortest] {
            k
        } else {
            shortest
        }
    })
}
