//! The state of a simulation as arrays. Particles are read in parts, so that there is little memory beside the array itself; only where
//! their number changes there is as much again.

use bytemuck::{Pod, Zeroable};
use glam::{Affine3A, DMat4, DVec3, Vec3};
use rayon::prelude::*;

use crate::export::corners;
use crate::mesh::surface::NONE;
use crate::mesh::walk::Frame;
use crate::scene::Scene;
use crate::scene::motion::double;
use crate::sim::types::{Motion, Particle};
use crate::sim::{Setup, Simulation};
use crate::{Error, Result};

/// Particles that are read at once.
const PART: usize = 1 << 18;

/// A row of the array of particles; `python/myxo/_simulation.py` has its dtype.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub struct Row {
    /// Far from the world's origin single precision has too few digits.
    position: [f64; 3],
    heading: [f32; 3],
    texel: [f32; 2],
    uv: [f32; 2],
    triangle: i32,
    object: i32,
    pending: f32,
    fed: i32,
    pad0: i32,
}

/// Fills a row for each living particle, in the order of their ids.
///
/// # Errors
/// When the device is lost or its memory is full, or there are not as many rows as living particles.
pub fn fill_particles(simulation: &Simulation, rows: &mut [Row]) -> Result<()> {
    let (setup, poses) = (simulation.setup(), simulation.world_from_object());
    let origin = setup.origin();
    let (ctx, state) = (simulation.ctx(), simulation.state());
    let count = state.particles.len();
    let len = rows.len();
    let check = |living: usize| match len == living {
        true => Ok(()),
        false => Err(Error::Invalid(
            "the array has another number of particles".into(),
        )),
    };
    let is_constant = state.growth.is_none();
    if is_constant {
        check(count)?;
    }
    // Where some are dead, the place of a row depends on the ids of all others.
    let mut living: Vec<(u32, Row)> = Vec::new();
    for first in (0..count).step_by(PART) {
        let range = first..count.min(first + PART);
        let particles = ctx.download_range(&state.particles, range.clone())?;
        let motions = ctx.download_range(&state.motions, range)?;
        let both = particles.par_iter().zip(&motions);
        let both = both.filter(|(_, motion)| !motion.is_dead());
        let made: Vec<(u32, Row)> = both
            .map(|(particle, motion)| {
                let row = row(setup, &poses, origin, particle, motion);
                (particle.id, row)
            })
            .collect();
        if is_constant {
            for (id, row) in made {
                rows[id as usize] = row;
            }
        } else {
            living.extend(made);
        }
    }
    if !is_constant {
        check(living.len())?;
        living.par_sort_unstable_by_key(|(id, _)| *id);
        for (place, (_, row)) in rows.iter_mut().zip(living) {
            *place = row;
        }
    }
    Ok(())
}

fn row(
    setup: &Setup,
    poses: &[Affine3A],
    origin: DVec3,
    particle: &Particle,
    motion: &Motion,
) -> Row {
    let Particle { triangle, u, v, .. } = *particle;
    let object = setup.surface.triangles[triangle as usize].object;
    let pose = &poses[object as usize];
    let frame = Frame::of(&setup.surface, triangle);
    let heading = f64::from(motion.heading_p) * frame.p + f64::from(motion.heading_h) * frame.h;
    Row {
        position: (place(setup, pose, triangle, u, v).as_dvec3() + origin).to_array(),
        heading: pose.transform_vector3(heading.as_vec3()).to_array(),
        texel: setup.atlas.position_of(triangle, u, v).to_array(),
        uv: [u, v],
        triangle: triangle as i32,
        object: object as i32,
        pending: motion.pending,
        fed: motion.fed() as i32,
        pad0: 0,
    }
}

fn place(setup: &Setup, pose: &Affine3A, triangle: u32, u: f32, v: f32) -> Vec3 {
    let [a, b, c] = [0, 1, 2].map(|k| corners::position(&setup.surface, 3 * triangle + k));
    pose.transform_point3(a + u * (b - a) + v * (c - a))
}

/// Rows of the texture without what pads them in buffers.
pub fn rows_of<T: Copy>(setup: &Setup, texels: &[T]) -> Vec<T> {
    let (size, pitch) = (setup.atlas.size as usize, setup.atlas.pitch as usize);
    let rows = texels.chunks(pitch).take(size);
    rows.flat_map(|row| &row[..size]).copied().collect()
}

/// A whole number for each texel that a triangle owns, -1 for the others.
pub fn of_owners(setup: &Setup, value: impl Fn(u32) -> u32) -> Vec<i32> {
    let owners = setup.atlas.owner.iter();
    let values = owners.map(|&owner| match owner {
        NONE => -1,
        triangle => value(triangle) as i32,
    });
    rows_of(setup, &values.collect::<Vec<_>>())
}

/// The place of each owned texel in world coordinates, not a number for the others.
pub fn texel_places(simulation: &Simulation) -> Vec<[f64; 3]> {
    let (setup, poses) = (simulation.setup(), simulation.world_from_object());
    let origin = setup.origin();
    let places = (0..setup.atlas.owner.len() as u32).into_par_iter();
    let places = places.map(|texel| match setup.atlas.surface_point_of(texel) {
        Some((triangle, u, v)) => {
            let object = setup.surface.triangles[triangle as usize].object as usize;
            (place(setup, &poses[object], triangle, u, v).as_dvec3() + origin).to_array()
        }
        None => [f64::NAN; 3],
    });
    rows_of(setup, &places.collect::<Vec<_>>())
}

/// World from scaled object coordinates, both as in files, rows first.
pub fn poses(scene: &Scene, simulation: &Simulation) -> Vec<[[f64; 4]; 4]> {
    let poses = simulation.world_from_object();
    let poses = poses.iter().zip(&scene.origins);
    poses
        .map(|(pose, origins)| {
            let pose = DMat4::from(origins.to_world(double(pose)));
            pose.transpose().to_cols_array_2d()
        })
        .collect()
}
