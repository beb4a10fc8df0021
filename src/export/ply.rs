//! PLY 1.0, binary and little-endian: all objects as one mesh in world coordinates, with normals, the colours of
//! pictures (sRGB, as viewers expect them) and the trail at each vertex.
//!
//! The format's few lines are written here: the crates for it build up every element in maps of names first.

use std::io::{self, Write};

use glam::Vec3;

use super::Export;
use super::corners::{self, Split};

/// Writes the file.
///
/// # Errors
/// When the disk is full.
pub(super) fn write(export: &Export<'_>, out: &mut impl Write) -> io::Result<()> {
    let (surface, atlas) = (&export.setup.surface, &export.setup.atlas);
    let normals = corners::normals(surface);
    let paint = export.paint();
    let all = 0..surface.corners.len() as u32;
    let shared = corners::share(surface, atlas, &normals, all, Split::Creases);
    // Single precision has too few digits far from the origin.
    let number = if export.is_far_from_origin() {
        "double"
    } else {
        "float"
    };
    write!(
        out,
        "ply\n\
         format binary_little_endian 1.0\n\
         comment myxo {version}: {name} at step {step}, seed {seed}\n\
         element vertex {vertices}\n\
         property {number} x\nproperty {number} y\nproperty {number} z\n\
         property float nx\nproperty float ny\nproperty float nz\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\n\
         property float trail\n\
         property int object\n\
         element face {faces}\n\
         property list uchar int vertex_indices\n\
         end_header\n",
        version = env!("CARGO_PKG_VERSION"),
        name = export.scene.name.replace(|c: char| c.is_control(), " "),
        step = export.snapshot.step,
        seed = export.scene.settings.seed,
        vertices = shared.corners.len(),
        faces = surface.corners.len(),
    )?;
    for &corner in &shared.corners {
        let object = surface.triangles[corner as usize / 3].object;
        let pose = &export.world_from_object[object as usize];
        let place = corners::atlas_position(atlas, corner);
        let (trail, second_look) = export.trail_and_second_look(place);
        let position = pose.transform_point3(corners::position(surface, corner));
        if export.is_far_from_origin() {
            for x in export.in_world(position).to_array() {
                out.write_all(&x.to_le_bytes())?;
            }
        } else {
            put(out, position)?;
        }
        put(out, pose.transform_vector3(normals[corner as usize]))?;
        out.write_all(&paint.srgb(trail, second_look))?;
        out.write_all(&trail.to_le_bytes())?;
        out.write_all(&object.to_le_bytes())?;
    }
    for triangle in shared.indices.chunks(3) {
        out.write_all(&[3])?;
        for index in triangle {
            out.write_all(&index.to_le_bytes())?;
        }
    }
    Ok(())
}

fn put(out: &mut impl Write, vector: Vec3) -> io::Result<()> {
    let [x, y, z] = vector.to_array();
    [x, y, z]
        .iter()
        .try_for_each(|x| out.write_all(&x.to_le_bytes()))
}
