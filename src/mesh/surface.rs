//! The pooled surface: every object's triangles in one set of arrays, with precomputed data for walks.
//!
//! Triangle ids are global over all objects of a scene; a triangle says which object it belongs to.

use std::borrow::Cow;

use bytemuck::{Pod, Zeroable};
use glam::{DVec2, Vec2, Vec3};
use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};

use super::Mesh;
use super::edges::{EdgeGroups, ends};
use super::walk::{Frame, rotate_across};

/// No half-edge: the other side of an open border.
pub const NONE: u32 = u32::MAX;

/// A triangle's shape in its own tangent frame: corner A is the origin, B is `(ab, 0)`, C is `(cp, ch)`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Triangle {
    /// `|B - A|`, world units.
    pub ab: f32,
    /// `p` of corner C; negative where the angle at A is obtuse.
    pub cp: f32,
    /// `h` of corner C, always positive.
    pub ch: f32,
    /// The object that the triangle belongs to.
    pub object: u32,
}

/// The data that a walk needs to cross a half-edge.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct HalfEdge {
    /// The half-edge of the neighbour at this edge, or [`NONE`] at an open border.
    pub twin: u32,
    /// Cosine of the rotation that takes a heading in this triangle's frame to the twin's frame. At an open border:
    /// of twice the angle of the edge, which takes the heading with its `h` negated to its mirror image.
    pub cos: f32,
    /// Sine of the same angle.
    pub sin: f32,
    /// What rounding dropped of `cos` (low half) and `sin` (high half): 16-bit signed normalised numbers in units of
    /// 2^-25. Long walks need it.
    pub fine: u32,
}

/// Half the distance of two neighbouring float32 numbers just below 1: as much as rounding can drop of a cosine.
const FINE_UNIT: f64 = 1.0 / 33_554_432.0;

/// The step of [`HalfEdge::fine`].
const FINE_STEP: f32 = (FINE_UNIT / 32_767.0) as f32;

impl HalfEdge {
    /// With the rotation by the angle of a unit vector.
    fn new(twin: u32, rotation: DVec2) -> Self {
        let (cos, sin) = (rotation.x as f32, rotation.y as f32);
        let pack = |exact: f64, rounded: f32| {
            let share = ((exact - f64::from(rounded)) / FINE_UNIT).clamp(-1.0, 1.0);
            u32::from((share * 32_767.0).round() as i16 as u16)
        };
        Self {
            twin,
            cos,
            sin,
            fine: pack(rotation.x, cos) | pack(rotation.y, sin) << 16,
        }
    }

    /// What rounding dropped of `cos` and `sin`.
    #[must_use]
    pub fn fine_parts(&self) -> [f32; 2] {
        [self.fine as i16, (self.fine >> 16) as i16].map(|steps| FINE_STEP * f32::from(steps))
    }

    /// Cosine and sine to a dozen digits.
    fn rotation(&self) -> DVec2 {
        let [cos, sin] = self.fine_parts();
        DVec2::new(
            f64::from(self.cos) + f64::from(cos),
            f64::from(self.sin) + f64::from(sin),
        )
    }
}

/// The affine map from a triangle's `uv` to atlas texels: `origin + u * du + v * dv`; texel centres lie at `+ 0.5`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct AtlasMap {
    /// Texel position of corner A.
    pub origin: Vec2,
    /// Texel position of B minus that of A.
    pub du: Vec2,
    /// Texel position of C minus that of A.
    pub dv: Vec2,
}

/// How one gutter texel is filled: a weighted sum of up to four owned texels across the seam.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Seam {
    /// Owned texels; unused places repeat a used one with weight 0.
    pub source: [u32; 4],
    /// The gutter texel, `y * pitch + x`.
    pub texel: u32,
    /// Four weights of 16 bits, from the lowest, in units of 1 / [`Seam::UNITS`], which they sum to exactly.
    pub weight: [u32; 2],
    /// Nothing.
    pub pad0: u32,
}

impl Seam {
    /// Units of a whole.
    pub const UNITS: u32 = 32_768;

    /// A seam with weights in [`Seam::UNITS`].
    #[must_use]
    pub fn new(texel: u32, source: [u32; 4], units: [u32; 4]) -> Self {
        assert_eq!(units.iter().sum::<u32>(), Self::UNITS);
        Self {
            source,
            texel,
            weight: [units[0] | units[1] << 16, units[2] | units[3] << 16],
            pad0: 0,
        }
    }

    /// The weights in [`Seam::UNITS`].
    #[must_use]
    pub fn units(&self) -> [u32; 4] {
        let [low, high] = self.weight;
        [low & 0xffff, low >> 16, high & 0xffff, high >> 16]
    }

    /// The weights, which sum to exactly 1, in whatever order they are added.
    #[must_use]
    pub fn weights(&self) -> [f32; 4] {
        self.units().map(|units| units as f32 / Self::UNITS as f32)
    }

    /// The owned texel with the largest weight, the first of equals: it stands for the gutter texel.
    #[must_use]
    pub fn main_source(&self) -> u32 {
        let units = self.units();
        let mut main = 0;
        for k in 1..4 {
            if units[k] > units[main] {
                main = k;
            }
        }
        self.source[main]
    }
}

/// The range of one object in the pooled arrays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ObjectRange {
    /// First triangle, and one past the last.
    pub triangles: (u32, u32),
    /// First vertex, and one past the last.
    pub vertices: (u32, u32),
}

/// All objects of a scene, pooled.
#[derive(Clone, Debug)]
pub struct Surface {
    /// Welded vertices in object space, already multiplied by the object's scale, so lengths are world lengths.
    pub positions: Vec<Vec3>,
    /// Corners of each triangle, consistently wound.
    pub corners: Vec<[u32; 3]>,
    /// Tangent-frame shape of each triangle.
    pub triangles: Vec<Triangle>,
    /// Three for each triangle.
    pub halfedges: Vec<HalfEdge>,
    /// Half-edges whose twin lies at another place, ascending: edges that are glued.
    pub glued: Vec<u32>,
    /// One for each object.
    pub objects: Vec<ObjectRange>,
    /// One for each object: texture coordinates of each corner of its triangles, if the model has them.
    pub uvs: Vec<Option<Vec<[Vec2; 3]>>>,
}

impl Surface {
    /// Pools meshes, each multiplied by its scale, into one surface; object `i` is the `i`-th mesh.
    ///
    /// Shapes and rotations are computed in double precision from the scaled float32 positions.
    ///
    /// # Panics
    /// When a scale is not positive and finite, or all meshes together have more than 2^31 half-edges.
    #[must_use]
    pub fn build(objects: &[(&Mesh, f32)]) -> Self {
        let mut surface = Self {
            positions: Vec::new(),
            corners: Vec::new(),
            triangles: Vec::new(),
            halfedges: Vec::new(),
            glued: Vec::new(),
            objects: Vec::new(),
            uvs: Vec::new(),
        };
        for &(mesh, scale) in objects {
            surface.append(mesh, scale);
        }
        surface
    }

    fn append(&mut self, mesh: &Mesh, scale: f32) {
        assert!(
            scale > 0.0 && scale.is_finite(),
            "the scale of `{}` must be positive and finite, not {scale}",
            mesh.name
        );
        let object = self.objects.len() as u32;
        let first_triangle = self.corners.len();
        let first_vertex = self.positions.len();
        assert!(
            3 * (first_triangle + mesh.corners.len()) <= i32::MAX as usize,
            "half-edges are numbered by 31 bits"
        );
        self.positions
            .extend(mesh.positions.iter().map(|&position| position * scale));
        self.corners.extend(
            mesh.corners
                .iter()
                .map(|corners| corners.map(|vertex| vertex + first_vertex as u32)),
        );
        self.objects.push(ObjectRange {
            triangles: (first_triangle as u32, self.corners.len() as u32),
            vertices: (first_vertex as u32, self.positions.len() as u32),
        });

        self.uvs.push(mesh.uvs.clone());

        let frames: Vec<Frame> = mesh
            .corners
            .par_iter()
            .map(|corners| frame_of(mesh, corners, scale))
            .collect();
        self.triangles.extend(frames.iter().map(|frame| Triangle {
            ab: frame.ab as f32,
            cp: frame.cp as f32,
            ch: frame.ch as f32,
            object,
        }));
        let first_halfedge = 3 * first_triangle as u32;
        let mut twins = EdgeGroups::new(&mesh.corners).twins(&mesh.corners);
        let first_glued = self.glued.len();
        for &[one, other] in &mesh.glue {
            twins[one as usize] = other;
            twins[other as usize] = one;
            self.glued.extend([one, other].map(|h| first_halfedge + h));
        }
        self.glued[first_glued..].sort_unstable();
        let halfedges: Vec<HalfEdge> = twins
            .par_iter()
            .enumerate()
            .map(|(h, &twin)| {
                let edge = frames[h / 3].edge(h % 3);
                if twin == NONE {
                    let along = edge.normalize();
                    return HalfEdge::new(NONE, along.rotate(along));
                }
                let twin_edge = frames[twin as usize / 3].edge(twin as usize % 3);
                HalfEdge::new(
                    first_halfedge + twin,
                    rotate_across(edge, twin_edge, DVec2::X),
                )
            })
            .collect();
        self.halfedges.extend(halfedges);
    }

    /// Is an edge glued, so that its other side lies at another place?
    #[must_use]
    pub fn is_glued(&self, halfedge: u32) -> bool {
        self.glued.binary_search(&halfedge).is_ok()
    }

    /// The surface with open borders in place of glued edges.
    #[must_use]
    pub fn cut(&self) -> Cow<'_, Self> {
        if self.glued.is_empty() {
            return Cow::Borrowed(self);
        }
        let mut cut = self.clone();
        for h in std::mem::take(&mut cut.glued) {
            let along = Frame::of(self, h / 3).edge(h as usize % 3).normalize();
            cut.halfedges[h as usize] = HalfEdge::new(NONE, along.rotate(along));
        }
        Cow::Owned(cut)
    }

    /// Has an object no open border and no glued edge? Then it has an inside.
    #[must_use]
    pub fn is_closed(&self, object: usize) -> bool {
        let (first, end) = self.objects[object].triangles;
        let halfedges = &self.halfedges[3 * first as usize..3 * end as usize];
        !self.has_glued_edges(object) && halfedges.iter().all(|halfedge| halfedge.twin != NONE)
    }

    /// Has an object glued edges? Then a way along it may be shorter than the straight line.
    #[must_use]
    pub fn has_glued_edges(&self, object: usize) -> bool {
        let (first, end) = self.objects[object].triangles;
        let next_glued = self.glued.partition_point(|&h| h < 3 * first);
        self.glued.get(next_glued).is_some_and(|&h| h < 3 * end)
    }

    /// A triangle's area, world units squared.
    #[must_use]
    pub fn area(&self, triangle: u32) -> f64 {
        let shape = &self.triangles[triangle as usize];
        0.5 * f64::from(shape.ab) * f64::from(shape.ch)
    }

    /// The lowest and the highest corner of the box round an object, in object space.
    #[must_use]
    pub fn bounds(&self, object: usize) -> [Vec3; 2] {
        let (first, end) = self.objects[object].vertices;
        let positions = &self.positions[first as usize..end as usize];
        let empty = [Vec3::INFINITY, Vec3::NEG_INFINITY];
        let both = |[low, high]: [Vec3; 2], &p: &Vec3| [low.min(p), high.max(p)];
        positions.iter().fold(empty, both)
    }

    /// Checks everything that walks rely on: ids in range, shapes that are positive and agree with the positions,
    /// twins that are each other's and run against each other within one object, and rotations that carry one onto the
    /// other.
    ///
    /// # Errors
    /// The first violation, with its numbers.
    pub fn validate(&self) -> Result<(), String> {
        let triangle_count = self.corners.len();
        if self.triangles.len() != triangle_count || self.halfedges.len() != 3 * triangle_count {
            return Err(format!(
                "{triangle_count} triangles have {} shapes and {} half-edges",
                self.triangles.len(),
                self.halfedges.len()
            ));
        }
        self.validate_objects()?;
        for triangle in 0..triangle_count as u32 {
            self.validate_triangle(triangle)?;
        }
        for halfedge in 0..self.halfedges.len() as u32 {
            self.validate_halfedge(halfedge)?;
        }
        Ok(())
    }

    fn validate_objects(&self) -> Result<(), String> {
        let mut triangle = 0;
        let mut vertex = 0;
        for (object, range) in self.objects.iter().enumerate() {
            if range.triangles.0 != triangle || range.vertices.0 != vertex {
                return Err(format!(
                    "object {object} does not begin where the last one ends"
                ));
            }
            triangle = range.triangles.1;
            vertex = range.vertices.1;
            for t in range.triangles.0..range.triangles.1 {
                if self.triangles[t as usize].object != object as u32 {
                    return Err(format!(
                        "triangle {t} lies in object {object} and names another"
                    ));
                }
                let inside = |v: &u32| (range.vertices.0..range.vertices.1).contains(v);
                if !self.corners[t as usize].iter().all(inside) {
                    return Err(format!("triangle {t} has a corner outside object {object}"));
                }
            }
        }
        if triangle as usize != self.corners.len() || vertex as usize != self.positions.len() {
            return Err("the objects do not cover all triangles and vertices".to_owned());
        }
        Ok(())
    }

    fn validate_triangle(&self, triangle: u32) -> Result<(), String> {
        let shape = self.triangles[triangle as usize];
        let positive =
            shape.ab.is_normal() && shape.ab > 0.0 && shape.ch.is_normal() && shape.ch > 0.0;
        if !positive || !shape.cp.is_finite() {
            return Err(format!(
                "triangle {triangle} has no shape to walk on: {shape:?}"
            ));
        }
        let frame = Frame::of(self, triangle);
        let size = frame.ab.max(frame.cp.abs()).max(frame.ch);
        let off = (frame.ab - f64::from(shape.ab))
            .abs()
            .max((frame.cp - f64::from(shape.cp)).abs())
            .max((frame.ch - f64::from(shape.ch)).abs());
        if off > 1e-5 * size {
            return Err(format!(
                "triangle {triangle}: {shape:?} is not the shape of its corners"
            ));
        }
        Ok(())
    }

    /// How well the directions of a triangle's edges can be recomputed: to all digits that are kept, but where
    /// rounding has left the corners without area, only from the shape in float32.
    fn precision(&self, triangle: u32) -> f64 {
        let [a, b, c] =
            self.corners[triangle as usize].map(|i| self.positions[i as usize].as_dvec3());
        if Frame::from_corners(a, b, c).has_area() {
            1e-10
        } else {
            1e-6
        }
    }

    fn validate_halfedge(&self, h: u32) -> Result<(), String> {
        let HalfEdge { twin, cos, sin, .. } = self.halfedges[h as usize];
        let rotation = self.halfedges[h as usize].rotation();
        let along = Frame::of(self, h / 3).edge(h as usize % 3).normalize();
        if twin == NONE {
            let turned = rotation.rotate(along * DVec2::new(1.0, -1.0));
            if (turned - along).length() > self.precision(h / 3) {
                return Err(format!(
                    "the border half-edge {h} is not mirrored onto itself"
                ));
            }
            return Ok(());
        }
        let Some(other) = self.halfedges.get(twin as usize) else {
            return Err(format!(
                "half-edge {h} has the twin {twin}, which does not exist"
            ));
        };
        if other.twin != h || twin == h {
            return Err(format!(
                "half-edge {h} has the twin {twin}, whose twin is {}",
                other.twin
            ));
        }
        let (start, end) = ends(&self.corners, h);
        if self.is_glued(h) != self.is_glued(twin) {
            return Err(format!(
                "of the half-edges {h} and {twin} only one counts as glued"
            ));
        }
        if !self.is_glued(h) && ends(&self.corners, twin) != (end, start) {
            return Err(format!(
                "half-edge {h} does not run against its twin {twin}"
            ));
        }
        let against = Frame::of(self, twin / 3)
            .edge(twin as usize % 3)
            .normalize();
        let turned = rotation.rotate(along);
        if (turned + against).length() > self.precision(h / 3).max(self.precision(twin / 3)) {
            return Err(format!(
                "the rotation across half-edge {h} does not carry it onto its twin"
            ));
        }
        let error = (other.cos - cos).abs().max((other.sin + sin).abs());
        if error > 1e-6 {
            return Err(format!(
                "the rotations across half-edge {h} and back are not inverse"
            ));
        }
        Ok(())
    }
}

/// The frame of a triangle at a scale. If the scaled corners have no area after rounding to float32, it uses the exact ones.
fn frame_of(mesh: &Mesh, corners: &[u32; 3], scale: f32) -> Frame {
    let [a, b, c] = corners.map(|vertex| mesh.positions[vertex as usize]);
    let rounded = [a * scale, b * scale, c * scale].map(|position| position.as_dvec3());
    let frame = Frame::from_corners(rounded[0], rounded[1], rounded[2]);
    if frame.has_area() {
        return frame;
    }
    let exact = [a, b, c].map(|position| position.as_dvec3() * f64::from(scale));
    Frame::from_corners(exact[0], exact[1], exact[2])
}
