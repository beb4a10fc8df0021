//! Two meshes and how they stand, as JSON: what questions about two objects are asked of. Where A stands does not matter
//! to distances, whose places are the world's.

use std::path::{Path, PathBuf};

use glam::{DAffine3, DMat4};
use myxo::mesh::Mesh;
use myxo::{Error, Result};
use serde::Deserialize;

use super::open_mesh;

/// How far a transform may be off from a rigid one, in the entries of its matrix.
const RIGID: f64 = 1e-6;

#[derive(Deserialize)]
struct File {
    mesh_b: PathBuf,
    b_transform_row_major: [f64; 16],
}

/// What is needed of the two: the meshes in their own coordinates, and their rigid poses.
#[derive(Debug)]
pub struct MeshPair {
    /// The mesh B.
    pub b: Mesh,
    /// World from B.
    pub world_from_b: DAffine3,
}

impl MeshPair {
    /// Reads the JSON file; its paths are relative to it.
    pub fn read(path: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(path).map_err(|source| Error::Io {
            action: "read",
            path: path.to_owned(),
            source,
        })?;
        let place = path.display();
        let file: File = serde_json::from_str(&text)
            .map_err(|error| Error::Invalid(format!("{place}: {error}")))?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let mesh = |name: &Path| match name.to_str() {
            Some(builtin) if builtin.starts_with("builtin:") => open_mesh(name),
            _ => open_mesh(&folder.join(name)),
        };
        let pose = |which: &str, rows: &[f64; 16]| {
            rigid(rows).ok_or_else(|| {
                Error::Invalid(format!(
                    "{place}: {which}_transform_row_major is not a rotation and a translation"
                ))
            })
        };
        Ok(Self {
            b: mesh(&file.mesh_b)?,
            world_from_b: pose("b", &file.b_transform_row_major)?,
        })
    }
}

fn rigid(rows: &[f64; 16]) -> Option<DAffine3> {
    let matrix = DMat4::from_cols_array(rows).transpose();
    let transform = DAffine3::from_mat4(matrix);
    let rotation = transform.matrix3;
    let last = matrix.row(3);
    let is_rigid = (rotation.transpose() * rotation).abs_diff_eq(glam::DMat3::IDENTITY, RIGID)
        && rotation.determinant() > 0.0
        && last.abs_diff_eq(glam::DVec4::W, RIGID)
        && transform.translation.is_finite();
    is_rigid.then_some(transform)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_rigid_transforms_are_taken() {
        let turned = [
            0.0, -1.0, 0.0, 5.0, 1.0, 0.0, 0.0, 6.0, 0.0, 0.0, 1.0, 7.0, 0.0, 0.0, 0.0, 1.0,
        ];
        let transform = rigid(&turned).expect("it is rigid");
        let place = transform.transform_point3(glam::DVec3::new(1.0, 0.0, 0.0));
        assert_eq!(place.to_array(), [5.0, 7.0, 7.0]);
        for (entry, value) in [(0, 0.1), (10, -1.0), (12, 1.0), (15, 2.0), (3, f64::NAN)] {
            let mut rows = turned;
            rows[entry] = value;
            assert!(rigid(&rows).is_none(), "entry {entry}");
        }
    }
}
