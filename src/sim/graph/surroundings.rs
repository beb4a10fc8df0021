//! The surface under a network.

use glam::{Affine3A, DVec3, Vec3};

use crate::mesh::atlas::Atlas;
use crate::mesh::surface::{NONE, Surface};
use crate::sim::setup::Setup;

/// Texels that are neighbours over a seam, in texel sides: no farther apart than this.
const APART: f64 = 4.0;

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

    /// Does a glued edge lie between two texels that the texture has side by side? Its two sides lie apart.
    pub(super) fn is_glued_between(&self, a: u32, b: u32) -> bool {
        !self.surface.glued.is_empty() && {
            let apart = self.place(a).distance(self.place(b));
            apart > APART * 0.5 * (self.side(a) + self.side(b))
        }
    }

    /// Does the mesh end at the triangle of this texel?
    pub(super) fn is_at_open_border(&self, texel: u32) -> bool {
        let first = 3 * self.triangle(texel) as usize;
        let edges = &self.surface.halfedges[first..first + 3];
        edges.iter().any(|edge| edge.twin == NONE)
    }
}
