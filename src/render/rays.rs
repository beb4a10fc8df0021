//! Rays through the triangles of one object, by a tree of boxes.

use std::time::Duration;

use glam::{Vec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::ray::Ray;
use obvhs::triangle::Triangle;

/// Triangles, in the space that their positions are in, and the tree over them.
pub(super) struct Rays {
    pub triangles: Vec<Triangle>,
    tree: Bvh2,
    /// Half of the diagonal of the box round them.
    pub radius: f32,
}

impl Rays {
    /// `None` if they have no size or a coordinate is NaN.
    pub fn new(positions: &[Vec3], corners: &[[u32; 3]]) -> Option<Self> {
        let corner = |vertex: u32| Vec3A::from(positions[vertex as usize]);
        let triangles: Vec<Triangle> = corners
            .iter()
            .map(|&[a, b, c]| Triangle {
                v0: corner(a),
                v1: corner(b),
                v2: corner(c),
            })
            .collect();
        let (low, high) = triangles
            .iter()
            .flat_map(|t| [t.v0, t.v1, t.v2])
            .fold((Vec3A::INFINITY, Vec3A::NEG_INFINITY), |(low, high), p| {
                (low.min(p), high.max(p))
            });
        let radius = 0.5 * (high - low).length();
        if !(radius > 0.0 && radius.is_finite()) {
            return None;
        }
        let mut spent = Duration::default();
        let tree = build_bvh2_from_tris(&triangles, BvhBuildParams::fast_build(), &mut spent);
        Some(Self {
            triangles,
            tree,
            radius,
        })
    }

    /// The distance at which a ray first meets a triangle, from either side, between two distances; the larger one if it meets none.
    pub fn free(&self, from: Vec3A, direction: Vec3A, begin: f32, end: f32) -> f32 {
        let mut nearest = end;
        let ray = Ray::new(from, direction, begin, end);
        self.tree.ray_traverse_anyhit(ray, |ray, place| {
            let triangle = &self.triangles[self.tree.primitive_indices[place] as usize];
            nearest = nearest.min(triangle.intersect(ray));
        });
        nearest
    }

    /// Does a ray meet no triangle between two distances? Ends at the first one that it meets.
    pub fn is_free(&self, from: Vec3A, direction: Vec3A, begin: f32, end: f32) -> bool {
        let ray = Ray::new(from, direction, begin, end);
        (self.tree).ray_traverse_miss(ray, |ray, place| {
            self.triangles[self.tree.primitive_indices[place] as usize].intersect(ray)
        })
    }
}
