//! Scene files that the lab writes: numbered and never over another, or by a name that the user chose.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use myxo::plain_text::Shown as _;
use myxo::whole_file::WholeFile;
use myxo::{Error, Result};

use crate::lab::names::Reserved;

/// The file that a scene has.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneFile {
    /// Its path.
    pub path: PathBuf,
    /// The window has written it. An opened file may have comments, so the user is asked first.
    pub may_be_replaced: bool,
}

impl SceneFile {
    /// An opened file, if it is the user's own scene file: no built-in name, model or checkpoint, and none of the scenes that
    /// were kept on leaving.
    pub fn opened(path: &Path) -> Option<Self> {
        if !(is_scene_file(path) && path.is_file()) || kept_name(path).is_some() {
            return None;
        }
        Some(Self {
            path: whole(path),
            may_be_replaced: false,
        })
    }

    /// The file that the scene was saved in.
    pub fn saved(path: &Path) -> Self {
        Self {
            path: whole(path),
            may_be_replaced: true,
        }
    }
}

/// A path from the root, which can be found again.
pub fn whole(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned())
}

fn is_scene_file(path: &Path) -> bool {
    path.extension()
        .is_some_and(|ending| ending.eq_ignore_ascii_case("toml"))
}

/// Saves a scene's text, named after the scene. `text` receives the file's path, and may put other files beside it.
pub fn save_scene(
    folder: &Path,
    name: &str,
    text: impl FnOnce(&Path) -> Result<String>,
) -> Result<PathBuf> {
    let name = Reserved::next(folder, name, "toml")?;
    write_scene(name.path(), text)
}

/// Saves a scene's text into this file, in the place of one that is there.
pub fn write_scene(path: &Path, text: impl FnOnce(&Path) -> Result<String>) -> Result<PathBuf> {
    let io = Error::io("write", path);
    // First, because `text` may write over the map of the scene that is there.
    let mut file = WholeFile::create(path).map_err(&io)?;
    let text = text(path)?;
    file.write_all(text.as_bytes()).map_err(&io)?;
    file.finish().map_err(&io)?;
    Ok(path.to_owned())
}

/// The path that the user chose, with the ending of scene files.
///
/// # Errors
/// When it had no such ending, and the file with it exists already: the dialog has not asked whether to replace that one.
pub fn chosen(path: PathBuf) -> Result<PathBuf> {
    if is_scene_file(&path) {
        return Ok(path);
    }
    let mut with = path.into_os_string();
    with.push(".toml");
    let with = PathBuf::from(with);
    if with.exists() {
        return Err(Error::Invalid(format!(
            "{} is there already: save by its whole name to replace it",
            with.shown()
        )));
    }
    Ok(with)
}

/// The folder of scenes that were left with changes; `None` if the user has no folder for data.
pub fn kept_folder() -> Option<PathBuf> {
    directories::ProjectDirs::from("", "", "myxo").map(|dirs| dirs.data_dir().join("left"))
}

/// The name of a scene in that folder.
pub fn kept_name(file: &Path) -> Option<String> {
    let folder = kept_folder()?.canonicalize().ok()?;
    let file = file.canonicalize().ok()?;
    (file.parent()? == folder).then(|| name_in(&file)).flatten()
}

/// The scene's name in that of a file, if it is one of ours: they are numbered.
pub fn name_in(file: &Path) -> Option<String> {
    let name = file.file_name()?.to_str()?.strip_suffix(".toml")?;
    let (name, number) = name.rsplit_once('_')?;
    let is_ours =
        !name.is_empty() && !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit());
    is_ours.then(|| name.to_owned())
}

/// How the files of meshes end.
pub const MESHES: &[&str] = &["obj", "stl", "ply", "glb", "gltf"];

/// A file that was dropped: a mesh joins the scene, everything else is opened.
pub fn is_mesh(path: &Path) -> bool {
    ends_so(path, &[MESHES])
}

/// Has a file one of these endings, in small letters or large ones?
pub fn ends_so(path: &Path, endings: &[&[&str]]) -> bool {
    let Some(ending) = path.extension() else {
        return false;
    };
    let mut known = endings.iter().copied().flatten();
    known.any(|known| ending.eq_ignore_ascii_case(known))
}

/// A path as scenes name meshes.
pub fn mesh_name(path: &Path) -> String {
    whole(path).to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_numbered_and_nothing_is_overwritten() {
        let folder = tempfile::tempdir().unwrap();
        let first = save_scene(folder.path(), "torus", |_| Ok("seed = 1\n".to_owned())).unwrap();
        let second = save_scene(folder.path(), "torus", |_| Ok("seed = 2\n".to_owned())).unwrap();
        assert!(first.ends_with("torus_000001.toml") && second.ends_with("torus_000002.toml"));
        assert_eq!(std::fs::read_to_string(&second).unwrap(), "seed = 2\n");
        let named = chosen(folder.path().join("fern.v2")).unwrap();
        assert!(named.ends_with("fern.v2.toml"));
        for text in ["seed = 3\n", "seed = 4\n"] {
            write_scene(&named, |file| {
                assert_eq!(file, named);
                Ok(text.to_owned())
            })
            .unwrap();
            assert_eq!(std::fs::read_to_string(&named).unwrap(), text);
        }
        assert_eq!(chosen(named.clone()).unwrap(), named, "it was asked for");
        let error = chosen(folder.path().join("fern.v2"))
            .unwrap_err()
            .to_string();
        assert!(error.contains("fern.v2.toml is there already"), "{error}");
        let error = save_scene(&second, "torus", |_| Ok("".to_owned())).unwrap_err();
        assert!(error.to_string().contains("torus_000002.toml"), "{error}");
    }

    /// Would catch: a map of areas that is written over although the scene beside it cannot be replaced.
    #[test]
    fn nothing_is_written_beside_a_scene_that_cannot_be() {
        let folder = tempfile::tempdir().unwrap();
        let taken = folder.path().join("taken.toml");
        std::fs::create_dir(&taken).unwrap();
        let error = write_scene(&taken, |_| panic!("the map would be another one")).unwrap_err();
        assert!(error.to_string().contains("taken.toml"), "{error}");
    }

    #[test]
    fn scene_files_that_were_opened_are_not_replaced_unasked() {
        let folder = tempfile::tempdir().unwrap();
        let with = |name: &str, text: &str| {
            let path = folder.path().join(name);
            std::fs::write(&path, text).unwrap();
            SceneFile::opened(&path)
        };
        for name in ["mine.toml", "MINE.TOML"] {
            let opened = with(name, "# Mine.\nseed = 1\n").expect("it is a scene file");
            assert_eq!(opened.path, folder.path().join(name));
            assert!(!opened.may_be_replaced);
            assert!(SceneFile::saved(&opened.path).may_be_replaced);
        }
        assert_eq!(with("ball.obj", "v 0 0 0\n"), None);
        for name in ["torus", "builtin:cube", "gone.toml"] {
            assert_eq!(SceneFile::opened(Path::new(name)), None, "{name}");
        }
    }
}
