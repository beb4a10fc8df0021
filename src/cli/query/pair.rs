//! Two meshes and their transforms, as JSON: the input of questions about two objects.

use std::path::{Path, PathBuf};

use clap::Args;
use glam::{DAffine3, DMat4};
use myxo::mesh::Mesh;
use myxo::plain_text::Shown as _;
use myxo::{Error, Result, regular_file};
use serde::Deserialize;

use super::table::Table;
use super::{Sign, open_mesh};
use crate::cli::options::DeviceOptions;

/// How far a transform may be off from a rigid one, in the entries of its matrix.
const RIGID: f64 = 1e-4;

/// The largest translation of a transform: differences of places must still be finite.
const FARTHEST: f64 = 1e300;

/// The options of questions about two objects.
#[derive(Clone, Debug, Args)]
pub struct PairOptions {
    /// Two meshes and their transforms
    #[arg(long, value_name = "FILE")]
    pub scene: PathBuf,
    /// The questions; - for the standard input
    #[arg(long = "in", value_name = "FILE", default_value = "-")]
    input: PathBuf,
    /// The file for the answers; - for the standard output
    #[arg(long, value_name = "FILE", default_value = "-")]
    pub out: PathBuf,
    /// How to decide whether a place is inside of a mesh
    #[arg(long, value_name = "RULE", default_value = "pseudonormal")]
    pub sign: Sign,
    #[command(flatten)]
    pub device: DeviceOptions,
}

impl PairOptions {
    /// Reads the questions, which have these columns.
    pub fn questions(&self, columns: &'static [&'static str]) -> Result<Table> {
        Table::read(&self.input, columns)
    }
}

#[derive(Deserialize)]
struct File {
    mesh_a: Option<PathBuf>,
    a_transform_row_major: Option<[f64; 16]>,
    mesh_b: PathBuf,
    b_transform_row_major: [f64; 16],
}

/// A mesh in its own coordinates, and its rigid pose.
#[derive(Debug)]
pub struct PlacedMesh {
    /// As in its file.
    pub mesh: Mesh,
    /// World from its coordinates.
    pub world_from_mesh: DAffine3,
}

impl PlacedMesh {
    /// Reads mesh B from a JSON file, with paths relative to it. A may be missing.
    pub fn read_b(path: &Path) -> Result<Self> {
        let file = File::read(path)?;
        file.b(path)
    }

    /// Reads both meshes, A and B.
    pub fn read_both(path: &Path) -> Result<[Self; 2]> {
        let file = File::read(path)?;
        let missing = |key: &str| Error::Invalid(format!("{}: {key} is missing", path.shown()));
        let a = Self::new(
            path,
            "a",
            file.mesh_a.as_deref().ok_or_else(|| missing("mesh_a"))?,
            file.a_transform_row_major
                .as_ref()
                .ok_or_else(|| missing("a_transform_row_major"))?,
        )?;
        Ok([a, file.b(path)?])
    }

    fn new(path: &Path, which: &str, name: &Path, rows: &[f64; 16]) -> Result<Self> {
        let folder = path.parent().unwrap_or(Path::new(""));
        let mesh = match name.to_str() {
            Some(builtin) if builtin.starts_with("builtin:") => open_mesh(name),
            _ => open_mesh(&folder.join(name)),
        };
        let pose = rigid(rows).ok_or_else(|| {
            Error::Invalid(format!(
                "{}: {which}_transform_row_major is not a rotation and a translation",
                path.shown()
            ))
        });
        Ok(Self {
            mesh: mesh?,
            world_from_mesh: pose?,
        })
    }
}

impl File {
    fn read(path: &Path) -> Result<Self> {
        let text = regular_file::read_text(path).map_err(Error::io("read", path))?;
        serde_json::from_str(&text)
            .map_err(|error| Error::Invalid(format!("{}: {error}", path.shown())))
    }

    fn b(&self, path: &Path) -> Result<PlacedMesh> {
        PlacedMesh::new(path, "b", &self.mesh_b, &self.b_transform_row_major)
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
        && transform.translation.is_finite()
        && transform.translation.abs().max_element() < FARTHEST;
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
