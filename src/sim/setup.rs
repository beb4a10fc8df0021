//! What a scene becomes before its first step: the surface, its atlas and the particles at their start.
//! The GPU simulation and the CPU twins begin from the same setup.

use glam::{Mat4, Vec4};

use super::params::seed_word;
use super::start;
use super::types::{Motion, Particle};
use crate::error::Result;
use crate::mesh::atlas::{Atlas, AtlasOptions};
use crate::mesh::surface::Surface;
use crate::scene::Scene;

/// The state of a scene at step 0, on the host.
#[derive(Clone, Debug)]
pub struct Setup {
    /// All objects, pooled.
    pub surface: Surface,
    /// Where every triangle lies in the trail's texture.
    pub atlas: Atlas,
    /// Particles at their start; the slot is the id.
    pub particles: Vec<Particle>,
    /// Their headings.
    pub motions: Vec<Motion>,
    /// Three vertex indices a triangle.
    pub corners: Vec<u32>,
    /// Object space, `w` = 1.
    pub positions: Vec<Vec4>,
    /// World from object, one an object.
    pub poses: Vec<Mat4>,
    /// Scene radius, world units: what lengths in settings are multiplied by.
    pub radius: f32,
}

impl Setup {
    /// Lays out the atlas and starts the particles.
    ///
    /// # Errors
    /// When the texture has no room for the triangles; the message names a size that has.
    pub fn new(scene: &Scene) -> Result<Self> {
        let settings = &scene.settings;
        let atlas = Atlas::build(
            &scene.surface,
            &AtlasOptions {
                size: settings.atlas.size,
                cell_size: settings.atlas.cell_size,
                gutter: settings.trail.diffusion_distance.max(1),
            },
        )?;
        let poses: Vec<Mat4> = scene.poses.iter().map(|&pose| Mat4::from(pose)).collect();
        let (particles, motions) = start::start(scene, seed_word(settings.seed))?;
        Ok(Self {
            corners: scene.surface.corners.as_flattened().to_vec(),
            positions: scene.surface.positions.iter().map(|p| p.extend(1.0)).collect(),
            surface: scene.surface.clone(),
            radius: scene.radius,
            atlas,
            particles,
            motions,
            poses,
        })
    }
}
