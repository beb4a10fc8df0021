//! Loading a mesh from a path: the choice of the reader, limits of sizes, and handling of failures.

use std::any::Any;
use std::io::Read;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use glam::DVec3;

use super::error::MeshProblem;
use super::soup::{MOST_TRIANGLES, Soup};
use super::trees::self_crossings;
use super::{Mesh, MeshError, RigidTrack, gltf, obj, ply, stl};
use crate::plain_text::Shown as _;
use crate::regular_file;

/// The largest model, or file that a model names.
pub(crate) const MOST_BYTES: u64 = 2 << 30;

/// The part of a model that is loaded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Extent {
    /// All triangles of the default scene, with the transforms of its nodes.
    Scene,
    /// The first primitive of the first mesh, as it is.
    FirstPrimitive,
}

impl Mesh {
    /// Loads an OBJ, STL, PLY, glTF or GLB file: everything in it as one mesh. For a glTF file, that is the content of its default scene at
    /// rest, with morph targets, skins and instances applied.
    ///
    /// # Errors
    /// When the file cannot be read, is damaged, or has nothing to walk on; the message says where and what to do.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, MeshError> {
        load(path.as_ref(), Extent::Scene, MOST_TRIANGLES as u64)
    }

    /// Loads a model without any transform: of a glTF file the first primitive of the first mesh, with its positions as
    /// they are stored; of other files everything. Morph targets are not applied, not even with default weights.
    ///
    /// # Errors
    /// As [`Mesh::load`].
    pub fn load_raw(path: impl AsRef<Path>) -> Result<Self, MeshError> {
        load(path.as_ref(), Extent::FirstPrimitive, MOST_TRIANGLES as u64)
    }

    /// Reads a model that is in memory. The ending of `path` says of what kind it is, and its folder has the files that a glTF model names;
    /// `path` itself is not read.
    ///
    /// # Errors
    /// As [`Mesh::load`].
    pub fn from_bytes(path: &Path, bytes: &[u8]) -> Result<Self, MeshError> {
        from_bytes(
            &name_of(path),
            path,
            bytes,
            Extent::Scene,
            MOST_TRIANGLES as u64,
        )
    }

    /// A mesh of triangles that are in memory: vertices, and three of them for each triangle.
    ///
    /// # Errors
    /// When a vertex is missing or no number, or no triangle is left.
    pub fn from_triangles(
        name: &str,
        positions: Vec<DVec3>,
        triangles: Vec<[u32; 3]>,
    ) -> Result<Self, MeshError> {
        let bad = |problem| MeshError::Bad {
            place: name.to_owned(),
            problem,
        };
        let count = positions.len();
        if triangles.is_empty() {
            let found = format!("{count} vertices, and no faces");
            return Err(bad(MeshProblem::NoTriangles { found }));
        }
        let missing = triangles
            .as_flattened()
            .iter()
            .find(|&&corner| corner as usize >= count);
        if let Some(corner) = missing {
            let vertex = *corner;
            return Err(bad(MeshProblem::MissingVertex { vertex, count }));
        }
        check_count(triangles.len() as u64, MOST_TRIANGLES as u64).map_err(bad)?;
        let soup = Soup {
            positions,
            triangles,
            ..Soup::default()
        };
        Self::from_soup(name, soup).map_err(bad)
    }

    /// A built-in mesh (`builtin:NAME`) or a file, relative to a folder.
    ///
    /// # Errors
    /// As [`Mesh::builtin`] and [`Mesh::load`].
    pub fn open(name_or_path: &str, folder: &Path) -> Result<Self, MeshError> {
        Self::open_within(name_or_path, folder, MOST_TRIANGLES as u64)
    }

    /// As [`open`](Self::open), if the mesh has no more triangles than `most`. Larger meshes are refused before their triangles are
    /// made or joined, which takes most of the time and memory.
    ///
    /// # Errors
    /// As [`Mesh::open`], and when it has more triangles.
    pub fn open_within(name_or_path: &str, folder: &Path, most: u64) -> Result<Self, MeshError> {
        match name_or_path.strip_prefix("builtin:") {
            Some(name) => Self::builtin_within(name, most),
            None => load(&folder.join(name_or_path), Extent::Scene, most),
        }
    }
}

impl RigidTrack {
    /// The first animation of a glTF or GLB file that moves a node, as the motion of the whole model. The path is
    /// relative to a folder.
    ///
    /// # Errors
    /// When the model has none, or it does not move the model as a whole and rigidly.
    pub fn open(name_or_path: &str, folder: &Path) -> Result<Self, MeshError> {
        let path = folder.join(name_or_path);
        let bad = |problem| MeshError::Bad {
            place: name_or_path.to_owned(),
            problem,
        };
        let is_gltf = |path: &Path| {
            let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
            ending == "glb" || ending == "gltf"
        };
        if name_or_path.starts_with("builtin:") || !is_gltf(&path) {
            let problem = "only glTF models (.glb, .gltf) have animations to follow".to_owned();
            return Err(bad(MeshProblem::Animation(problem)));
        }
        Self::from_bytes(&path, &read(&path)?).map_err(bad)
    }

    /// As [`open`](Self::open), for a glTF or GLB model in memory; `path` is as for [`Mesh::from_bytes`].
    ///
    /// # Errors
    /// As [`RigidTrack::open`].
    pub fn from_bytes(path: &Path, bytes: &[u8]) -> Result<Self, MeshProblem> {
        let folder = path.parent().unwrap_or(Path::new(""));
        // A second protection against untrusted files, as for triangles.
        catch_unwind(AssertUnwindSafe(|| gltf::read_track(bytes, folder)))
            .unwrap_or_else(|panic| Err(MeshProblem::Panicked(panic_text(panic.as_ref()))))
    }
}

fn load(path: &Path, extent: Extent, most: u64) -> Result<Mesh, MeshError> {
    let bytes = read(path)?;
    let mut mesh = from_bytes(&name_of(path), path, &bytes, extent, most)?;
    mesh.report.self_crossings = self_crossings(&mesh);
    Ok(mesh)
}

/// The name of a model: that of its file without its ending.
fn name_of(path: &Path) -> String {
    path.file_stem().map_or_else(
        || "mesh".to_owned(),
        |stem| stem.to_string_lossy().into_owned(),
    )
}

/// Makes a mesh of a model whose bytes are given; `path` is as for [`parse`].
pub(crate) fn from_bytes(
    name: &str,
    path: &Path,
    bytes: &[u8],
    extent: Extent,
    most: u64,
) -> Result<Mesh, MeshError> {
    // The readers are written not to panic; catching panics is a second protection, because models are untrusted.
    let parsed = catch_unwind(AssertUnwindSafe(|| {
        if let Some(count) = stl::declared_triangles(bytes) {
            check_count(count, most)?;
        }
        let soup = parse_within(path, bytes, extent, most)?;
        check_count(soup.triangles.len() as u64, most)?;
        Mesh::from_soup(name, soup)
    }));
    let problem = match parsed {
        Ok(Ok(mesh)) => return Ok(mesh),
        Ok(Err(problem)) => problem,
        Err(panic) => MeshProblem::Panicked(panic_text(panic.as_ref())),
    };
    Err(MeshError::Bad {
        place: path.shown().into_owned(),
        problem,
    })
}

fn check_count(count: u64, most: u64) -> Result<(), MeshProblem> {
    if count <= most {
        return Ok(());
    }
    Err(MeshProblem::NoRoom { count, most })
}

/// Reads the triangles of a model whose bytes are given; `path` has the ending that selects the format, and the folder of files that the
/// model names.
#[cfg(test)]
pub(crate) fn parse(path: &Path, bytes: &[u8], extent: Extent) -> Result<Soup, MeshProblem> {
    parse_within(path, bytes, extent, u64::MAX)
}

/// Reads the triangles of a model. If it is known early that there are more than `most`, they are counted and not kept.
fn parse_within(path: &Path, bytes: &[u8], extent: Extent, most: u64) -> Result<Soup, MeshProblem> {
    let ending = path
        .extension()
        .map(|ending| ending.to_string_lossy().to_lowercase())
        .unwrap_or_default();
    let folder = path.parent().unwrap_or(Path::new(""));
    match ending.as_str() {
        _ if gltf::is_glb(bytes) => gltf::read(bytes, folder, extent, most),
        _ if ply::is_ply(bytes) => ply::read(bytes),
        "obj" => obj::read(bytes),
        "ply" => ply::read(bytes),
        "stl" => stl::read(bytes),
        "glb" | "gltf" => gltf::read(bytes, folder, extent, most),
        "" => Err(MeshProblem::UnknownKind {
            found: "its name has no ending".to_owned(),
        }),
        other => Err(MeshProblem::UnknownKind {
            found: format!("its name ends in `.{other}`"),
        }),
    }
}

/// Reads a regular file of a sensible size.
pub(crate) fn read(path: &Path) -> Result<Vec<u8>, MeshError> {
    let failed = |source| MeshError::Read {
        path: path.to_owned(),
        source,
    };
    let not_a_file = |problem: String| MeshError::Bad {
        place: path.shown().into_owned(),
        problem: MeshProblem::NotAFile(problem),
    };
    let metadata = std::fs::metadata(path).map_err(failed)?;
    if metadata.is_dir() {
        return Err(not_a_file(
            "this is a folder: name a model in it".to_owned(),
        ));
    }
    if !metadata.is_file() {
        return Err(not_a_file("this is not a regular file".to_owned()));
    }
    if metadata.len() > MOST_BYTES {
        return Err(not_a_file(format!(
            "{} bytes, and models of up to {MOST_BYTES} are read: simplify it",
            metadata.len()
        )));
    }
    let mut bytes = Vec::with_capacity(metadata.len() as usize);
    let (file, _) = regular_file::open(path).map_err(failed)?;
    file.take(MOST_BYTES)
        .read_to_end(&mut bytes)
        .map_err(failed)?;
    Ok(bytes)
}

fn panic_text(panic: &(dyn Any + Send)) -> String {
    panic
        .downcast_ref::<String>()
        .cloned()
        .or_else(|| panic.downcast_ref::<&str>().map(|text| (*text).to_owned()))
        .unwrap_or_else(|| "no message".to_owned())
}
