//! The surface under a network.

use std::collections::HashSet;

use glam::{Affine3A, DAffine3, DMat3, DVec3, Vec3};

use crate::mesh::atlas::Atlas;
use crate::mesh::surface::{NONE, Surface};
use crate::sim::setup::Setup;

/// Texels that are neighbours over a seam, in texel sides: no farther apart than this.
const APART: f64 = 4.0;

/// Motions over glued edges that differ by less than this, in scene radii, count as one.
const SAME: f64 = 1e-4;
/// If there are no more motions than this, those over two glued edges, one after the other, are looked at, too.
const FEW: usize = 16;

/// What an object's glued edges do: the motion carries what lies beyond one of them to where a walk over the edge comes to it.
#[derive(Clone, Copy, Debug)]
pub struct Over {
    object: u32,
    motion: DAffine3,
}

/// The surface under a trail.
#[derive(Clone, Copy)]
pub struct Surroundings<'a> {
    /// Its triangles.
    pub surface: &'a Surface,
    /// Where they lie in the texture.
    pub atlas: &'a Atlas,
    /// World from object, for each object.
    pub poses: &'a [Affine3A],
    /// From where poses count, in world coordinates. Far from zero, places that count from it are more exact.
    pub origin: DVec3,
    /// The scene radius, world units.
    pub radius: f64,
}

impl<'a> Surroundings<'a> {
    /// Those of a simulation.
    #[must_use]
    pub fn new(setup: &'a Setup, poses: &'a [Affine3A]) -> Self {
        Self {
            surface: &setup.surface,
            atlas: &setup.atlas,
            poses,
            origin: setup.origin(),
            radius: f64::from(setup.radius),
        }
    }

    fn triangle(&self, texel: u32) -> u32 {
        self.atlas.owner[texel as usize]
    }

    pub(super) fn object(&self, texel: u32) -> u32 {
        self.surface.triangles[self.triangle(texel) as usize].object
    }

    pub(super) fn side(&self, texel: u32) -> f64 {
        f64::from(self.atlas.area[texel as usize]).sqrt() / self.radius
    }

    /// The centre of an owned texel.
    pub(super) fn place(&self, texel: u32) -> DVec3 {
        let (triangle, u, v) = self.atlas.surface_point_of(texel).expect("it is owned");
        self.place_of(triangle, u, v)
    }

    /// A point of the surface in world coordinates that count from `origin`, scene radii.
    pub(super) fn place_of(&self, triangle: u32, u: f32, v: f32) -> DVec3 {
        let corners = self.surface.corners[triangle as usize];
        let [a, b, c]: [Vec3; 3] = corners.map(|corner| self.surface.positions[corner as usize]);
        let object = self.surface.triangles[triangle as usize].object;
        let pose = &self.poses[object as usize];
        let place = pose.transform_point3(a + u * (b - a) + v * (c - a));
        place.as_dvec3() / self.radius
    }

    /// A place in world coordinates, scene radii.
    pub(super) fn in_world(&self, place: DVec3) -> DVec3 {
        place + self.origin / self.radius
    }

    /// The place of a corner of a triangle, as [`Self::place`].
    fn corner(&self, triangle: u32, corner: u32) -> DVec3 {
        let [u, v] = [f32::from(corner == 1), f32::from(corner == 2)];
        self.place_of(triangle, u, v)
    }

    /// The motions over all glued edges, each once; also over two of them, because four texels may meet where the corners of a plane do.
    pub(super) fn motions(&self) -> Vec<Over> {
        let mut found = Vec::new();
        let mut known = HashSet::new();
        let mut add = |found: &mut Vec<Over>, over: Over| {
            let numbers = over.motion.to_cols_array();
            let key = numbers.map(|number| (number / SAME).round() as i64);
            if known.insert((over.object, key)) {
                found.push(over);
            }
        };
        for &halfedge in &self.surface.glued {
            let object = self.surface.triangles[(halfedge / 3) as usize].object;
            let motion = self.motion_over(halfedge);
            add(&mut found, Over { object, motion });
        }
        let single = found.clone();
        if single.len() <= FEW {
            for a in &single {
                for b in single.iter().filter(|b| b.object == a.object) {
                    let motion = a.motion * b.motion;
                    add(&mut found, Over { motion, ..*a });
                }
            }
        }
        found
    }

    /// Carries the triangle behind a glued half-edge to this side, into the plane of this triangle.
    fn motion_over(&self, halfedge: u32) -> DAffine3 {
        // Along the edge, into this triangle, and its normal.
        let frame = |halfedge: u32| {
            let (triangle, k) = (halfedge / 3, halfedge % 3);
            let [start, end, third] =
                [k, (k + 1) % 3, (k + 2) % 3].map(|k| self.corner(triangle, k));
            let along = (end - start).normalize_or(DVec3::X);
            let normal = along.cross(third - start);
            let normal = normal.normalize_or(along.any_orthonormal_vector());
            (start, end, along, normal)
        };
        let (here, _, along, normal) = frame(halfedge);
        let (_, there, against, other) = frame(self.surface.halfedges[halfedge as usize].twin);
        let matrix =
            |along: DVec3, normal: DVec3| DMat3::from_cols(along, normal.cross(along), normal);
        // The twin runs the other way, so that its end is here.
        let turn = matrix(along, normal) * matrix(-against, other).transpose();
        DAffine3::from_mat3_translation(turn, here - turn * there)
    }

    /// Does a glued edge lie between two texels that the texture has side by side? Its two sides lie apart.
    pub(super) fn is_glued_between(&self, a: u32, b: u32) -> bool {
        !self.surface.glued.is_empty() && {
            let apart = self.place(a).distance(self.place(b));
            apart > APART * 0.5 * (self.side(a) + self.side(b))
        }
    }

    /// Of the motions, the one that carries texel `b` to beside texel `a`, if any does.
    pub(super) fn motion_between(&self, motions: &[Over], a: u32, b: u32) -> Option<DAffine3> {
        let (at, from) = (self.place(a), self.place(b));
        let object = self.object(a);
        let near = APART * 0.5 * (self.side(a) + self.side(b));
        let of_object = motions.iter().filter(|over| over.object == object);
        let apart = of_object.map(|over| {
            let there = over.motion.transform_point3(from);
            (at.distance(there), over.motion)
        });
        let nearest = apart.min_by(|a, b| a.0.total_cmp(&b.0));
        nearest.and_then(|(apart, motion)| (apart <= near).then_some(motion))
    }

    /// Where walks over an object's glued edges come to a place on it.
    pub(super) fn carried(motions: &[Over], object: u32, place: DVec3) -> Vec<DVec3> {
        let of_object = motions.iter().filter(|over| over.object == object);
        of_object
            .map(|over| over.motion.transform_point3(place))
            .collect()
    }

    /// Does the mesh end at the triangle of this texel?
    pub(super) fn is_at_open_border(&self, texel: u32) -> bool {
        let first = 3 * self.triangle(texel) as usize;
        let edges = &self.surface.halfedges[first..first + 3];
        edges.iter().any(|edge| edge.twin == NONE)
    }
}
