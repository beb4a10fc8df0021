//! Meshes that are in memory, as PLY files beside a scene file: in double precision, and with faces and their corners in the order in which
//! they came, so that whatever names a face of theirs, such as `glue` of an object, still names the same one.

use std::fs::File;
use std::io::{self, BufWriter, Read as _, Write};
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};
use crate::mesh::Mesh;
use crate::plain_text::Shown as _;
use crate::scene::settings::Settings;
use crate::scene::{Scene, in_memory};
use crate::whole_file::WholeFile;

/// So many bytes of an object's name stand in that of its file, at the most.
const LONGEST: usize = 60;

/// Stands at the beginning of files that are written here.
const SIGNED: &str = concat!("comment myxo ", env!("CARGO_PKG_VERSION"));

/// A file for the mesh of an object.
#[derive(Debug)]
pub(super) struct MeshFile {
    /// The object's number.
    object: usize,
    /// The name by which the scene file beside it has it.
    name: String,
    /// The file.
    pub path: PathBuf,
}

/// A file for each mesh of a scene that is in memory: `NAME_OBJECT.ply` beside the scene file or, if that is another scene's file, with the
/// next free number.
pub(super) fn beside(scene_file: &Path, settings: &Settings) -> Result<Vec<MeshFile>> {
    let before = std::fs::read_to_string(scene_file).unwrap_or_default();
    let mut files: Vec<MeshFile> = Vec::new();
    for (number, object) in settings.objects.iter().enumerate() {
        if in_memory(&object.mesh).is_none() {
            continue;
        }
        let Some(stem) = scene_file.file_stem().and_then(|stem| stem.to_str()) else {
            return Err(Error::Invalid(format!(
                "{}: meshes that are in memory become files named after the scene file, which cannot say this name, because it is not \
                 Unicode: choose another name for the scene",
                scene_file.shown()
            )));
        };
        let letters = object.name.char_indices();
        let letters = letters.take_while(|(at, c)| at + c.len_utf8() <= LONGEST);
        let plain = |c: char| c.is_alphanumeric() || matches!(c, '-' | '.');
        let word: String = letters
            .map(|(_, c)| if plain(c) { c } else { '_' })
            .collect();
        let is_ours = |name: &String| {
            let path = scene_file.with_file_name(name);
            let is_earlier = || before.contains(&format!("\"{name}\"")) && is_signed(&path);
            // Some file systems take letters for their capitals.
            let is_same = |other: &str| other.to_lowercase() == name.to_lowercase();
            let is_taken = files.iter().any(|file| is_same(&file.name))
                || (settings.objects.iter()).any(|object| {
                    let file = Path::new(&object.mesh).file_name();
                    file.is_some_and(|file| is_same(&file.to_string_lossy()))
                });
            !is_taken && (!path.exists() || is_earlier())
        };
        let others = (2..).map(|number| format!("{stem}_{word}_{number}.ply"));
        let mut names = std::iter::once(format!("{stem}_{word}.ply")).chain(others);
        let name = names.find(is_ours).expect("there is always another number");
        files.push(MeshFile {
            object: number,
            path: scene_file.with_file_name(&name),
            name,
        });
    }
    Ok(files)
}

/// Was this file written here?
fn is_signed(path: &Path) -> bool {
    let mut start = Vec::new();
    let read = File::open(path).and_then(|file| file.take(256).read_to_end(&mut start));
    read.is_ok() && String::from_utf8_lossy(&start).contains("\ncomment myxo ")
}

impl MeshFile {
    /// The object's number, and the file's name for the scene file.
    pub(super) fn named(&self) -> (usize, String) {
        (self.object, self.name.clone())
    }

    /// Writes the file.
    ///
    /// # Errors
    /// When the disk is full.
    pub(super) fn write(&self, scene: &Scene) -> Result<()> {
        let whole = || -> io::Result<()> {
            let file = WholeFile::create(&self.path)?;
            let mut out = BufWriter::with_capacity(1 << 20, file);
            write(&scene.meshes[self.object], &mut out)?;
            out.into_inner()?.finish()?;
            Ok(())
        };
        whole().map_err(Error::io("write", &self.path))
    }
}

/// Writes a mesh as it was before it was loaded, but for vertices that became one. A face that was dropped has no area here, so that it is
/// dropped again and those after it keep their numbers.
fn write(mesh: &Mesh, out: &mut impl Write) -> io::Result<()> {
    let faces = mesh.report.file_triangles;
    write!(
        out,
        "ply\n\
         format binary_little_endian 1.0\n\
         {SIGNED}\n\
         element vertex {vertices}\n\
         property double x\nproperty double y\nproperty double z\n\
         element face {faces}\n\
         property list uchar int vertex_indices\n\
         end_header\n",
        vertices = mesh.positions.len(),
    )?;
    for position in &mesh.positions {
        for x in (position.as_dvec3() + mesh.origin).to_array() {
            out.write_all(&x.to_le_bytes())?;
        }
    }
    let triangles = mesh.corners.iter().zip(&mesh.file_corners);
    let mut kept = mesh.file_triangle.iter().zip(triangles).peekable();
    for face in 0..faces as u32 {
        let mut corners = [0_u32; 3];
        if let Some((_, (own, places))) = kept.next_if(|(number, _)| **number == face) {
            for (corner, place) in own.iter().zip(places) {
                corners[usize::from(*place)] = *corner;
            }
        }
        out.write_all(&[3])?;
        for corner in corners {
            out.write_all(&corner.to_le_bytes())?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    /// A tetrahedron whose first face is none and whose last is wound against the others, near and far from the origin.
    fn mesh(place: DVec3) -> Mesh {
        let corners = [DVec3::ZERO, DVec3::X, 2.0 * DVec3::Y, 3.0 * DVec3::Z];
        let positions = corners.map(|corner| corner + place).to_vec();
        let triangles = vec![[1, 1, 2], [0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 2, 3]];
        Mesh::from_triangles("corner", positions, triangles).unwrap()
    }

    /// Would catch: coordinates that lose digits, and faces with other numbers or corners, by which a glued edge would be another one.
    #[test]
    fn what_is_written_is_the_mesh_that_was_in_memory() {
        for place in [DVec3::ZERO, DVec3::new(5e6, -3e6, 7.0)] {
            let mesh = mesh(place);
            assert_eq!(mesh.file_triangle, [1, 2, 3, 4]);
            let mut bytes = Vec::new();
            write(&mesh, &mut bytes).unwrap();
            let again = Mesh::from_bytes(Path::new("corner.ply"), &bytes).unwrap();
            assert_eq!(again.origin, mesh.origin);
            assert_eq!(again.positions, mesh.positions);
            assert_eq!(again.corners, mesh.corners);
            assert_eq!(again.file_triangle, mesh.file_triangle);
            assert_eq!(again.file_corners, mesh.file_corners);
        }
    }

    /// Would catch: two meshes in one file, and one that takes the place of another scene's file, of a model that was not written here, or
    /// of another object's.
    #[test]
    fn each_mesh_has_a_file_of_its_own() {
        let folder = tempfile::tempdir().unwrap();
        let scene_file = folder.path().join("a.toml");
        let mut settings = Settings::default();
        let object = settings.objects[0].clone();
        settings.objects = ["x y", "x/y", "z", "bump"]
            .map(|name| {
                let mut object = object.clone();
                object.name = name.to_owned();
                object.mesh = format!("memory:{name}");
                object
            })
            .to_vec();
        settings.objects[2].mesh = "builtin:cube".to_owned();
        let names = || {
            let files = beside(&scene_file, &settings).unwrap();
            files.iter().map(MeshFile::named).collect::<Vec<_>>()
        };
        let named = |names: [&str; 3]| {
            [0_usize, 1, 3]
                .into_iter()
                .zip(names.map(str::to_owned))
                .collect::<Vec<_>>()
        };
        assert_eq!(names(), named(["a_x_y.ply", "a_x_y_2.ply", "a_bump.ply"]));
        std::fs::write(folder.path().join("a_bump.ply"), "ply").unwrap();
        assert_eq!(names()[2].1, "a_bump_2.ply");
        std::fs::write(&scene_file, "mesh = \"a_bump.ply\"").unwrap();
        assert_eq!(names()[2].1, "a_bump_2.ply");
        let ours = File::create(folder.path().join("a_bump.ply")).unwrap();
        write(&mesh(DVec3::ZERO), &mut BufWriter::new(ours)).unwrap();
        assert_eq!(names()[2].1, "a_bump.ply");
        settings.objects[2].mesh = "A_Bump.ply".to_owned();
        let files = beside(&scene_file, &settings).unwrap();
        assert_eq!(files[2].name, "a_bump_2.ply");
    }
}
