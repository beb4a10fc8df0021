//! Tests of the atlas, and their common code.

mod charts;
mod clearance;
mod control;
mod exchange;
mod layout;
mod measure;
mod outlook;
mod own_uvs;
mod reads;
mod torus;

use super::*;
use crate::mesh::Mesh;
use crate::rng::{Purpose, random, unit};

fn surface(names: &[&str]) -> Surface {
    let meshes: Vec<Mesh> = names.iter().map(|n| Mesh::builtin(n).unwrap()).collect();
    let objects: Vec<(&Mesh, f32)> = meshes.iter().map(|mesh| (mesh, 1.0)).collect();
    Surface::build(&objects)
}

impl Atlas {
    /// A built-in mesh, a cell a triangle.
    pub(crate) fn of_cells(mesh: &str, size: u32) -> (Surface, Self) {
        let surface = surface(&[mesh]);
        let options = AtlasOptions {
            method: AtlasMethod::Grid,
            size,
            ..AtlasOptions::default()
        };
        let atlas = Self::build(&surface, &options).unwrap();
        (surface, atlas)
    }
}

/// A flat plane whose inner vertices are moved about by up to a third of a quad.
pub(super) fn crooked_plane() -> Surface {
    let quads = 12;
    let mut mesh = crate::mesh::primitive::plane(quads, quads);
    for (k, position) in mesh.positions.iter_mut().enumerate() {
        if position.x.abs().max(position.z.abs()) < 0.99 {
            let words = random(5, k as u32, 0, Purpose::Start);
            let reach = 2.0 / quads as f32 / 3.0;
            position.x += reach * (2.0 * unit(words[0]) - 1.0);
            position.z += reach * (2.0 * unit(words[1]) - 1.0);
        }
    }
    Surface::build(&[(&mesh, 1.0)])
}

fn options(size: u32, gutter: u32) -> AtlasOptions {
    AtlasOptions {
        method: AtlasMethod::Grid,
        size,
        cell_size: 0,
        gutter,
        ..AtlasOptions::default()
    }
}

fn build(surface: &Surface, size: u32, gutter: u32) -> Atlas {
    let atlas = Atlas::build(surface, &options(size, gutter)).unwrap();
    if let Err(problem) = atlas.validate(surface) {
        panic!("{atlas}: {problem}");
    }
    atlas
}

/// Points of a triangle, its corners and edges first.
fn points_of(triangle: u32) -> impl Iterator<Item = (f32, f32)> {
    const EDGES: [(f32, f32); 6] = [
        (0.0, 0.0),
        (1.0, 0.0),
        (0.0, 1.0),
        (0.5, 0.0),
        (0.0, 0.5),
        (0.5, 0.5),
    ];
    EDGES.into_iter().chain((0..60).map(move |k| {
        let words = random(11, triangle, k, Purpose::Start);
        let (u, v) = (unit(words[0]), unit(words[1]));
        match k % 4 {
            0 => (u, 1.0 - u),
            1 => (0.0, v),
            2 => (u, 0.0),
            _ if u + v > 1.0 => (1.0 - u, 1.0 - v),
            _ => (u, v),
        }
    }))
}
