//! The JSON manifests in which the Vulkan loader finds drivers and layers. One damaged file makes the whole loader fail, with a
//! message that does not name the file: "a host memory allocation has failed".

use std::env::{split_paths, var_os};
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::plain_text::Shown as _;
use crate::regular_file;

/// Manifests have some hundred bytes; larger files are not read.
const MOST_BYTES: u64 = 1 << 20;

/// The variables that name drivers' manifests, the one that counts first.
const CHOSEN: [&str; 2] = ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"];

/// The variable that names drivers' manifests, and its value.
pub(super) fn chosen() -> Option<(&'static str, std::ffi::OsString)> {
    let values = CHOSEN.map(|name| Some((name, var_os(name)?)));
    let chosen = values.into_iter().flatten().next();
    chosen.filter(|(_, files)| !files.is_empty())
}

/// The problem of the first invalid manifest among those that the loader reads; `None` if all are valid.
pub(super) fn problem() -> Option<String> {
    let folders = folders();
    let in_folders = |name: &str| -> Vec<PathBuf> {
        let folders = folders
            .iter()
            .map(|folder| folder.join("vulkan").join(name));
        folders.flat_map(|folder| listed(&folder)).collect()
    };
    let drivers = match chosen() {
        Some((_, files)) => split_paths(&files)
            .flat_map(|path| match path.is_dir() {
                true => listed(&path),
                false => vec![path],
            })
            .collect(),
        None => in_folders("icd.d"),
    };
    let layers = ["implicit_layer.d", "explicit_layer.d"].map(in_folders);
    let drivers = drivers.iter().find_map(|path| problem_of(path, true));
    drivers.or_else(|| {
        layers
            .iter()
            .flatten()
            .find_map(|path| problem_of(path, false))
    })
}

/// The folders that the loader searches by default.
fn folders() -> Vec<PathBuf> {
    let home = |inside: &str| var_os("HOME").map(|home| Path::new(&home).join(inside));
    let one = |name: &str, otherwise: Option<PathBuf>| {
        let set = var_os(name).filter(|value| !value.is_empty());
        set.map(PathBuf::from).or(otherwise)
    };
    let several = |name: &str, otherwise: &str| -> Vec<PathBuf> {
        let set = var_os(name).filter(|value| !value.is_empty());
        split_paths(&set.unwrap_or_else(|| otherwise.into())).collect()
    };
    let own = [
        one("XDG_CONFIG_HOME", home(".config")),
        one("XDG_DATA_HOME", home(".local/share")),
    ];
    let mut folders: Vec<PathBuf> = own.into_iter().flatten().collect();
    folders.extend(several("XDG_CONFIG_DIRS", "/etc/xdg"));
    folders.extend(["/usr/local/etc", "/etc"].map(PathBuf::from));
    folders.extend(several("XDG_DATA_DIRS", "/usr/local/share:/usr/share"));
    folders
}

/// The manifests in a folder.
fn listed(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let files = entries.map(|entry| entry.path());
    let mut files: Vec<PathBuf> = files
        .filter(|path| path.extension().is_some_and(|ending| ending == "json"))
        .collect();
    files.sort();
    files
}

fn problem_of(path: &Path, is_driver: bool) -> Option<String> {
    let of = |problem: String| Some(format!("the manifest {} {problem}", path.shown()));
    let bytes = match regular_file::read(path, MOST_BYTES) {
        Ok(bytes) => bytes,
        // The loader ignores missing files.
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return None,
        Err(error) => return of(format!("cannot be read: {error}")),
    };
    match serde_json::from_slice::<Value>(&bytes) {
        Err(error) => of(format!("is damaged or cut short: {error}")),
        Ok(manifest) if is_driver && !manifest["ICD"]["library_path"].is_string() => {
            of("names no driver: it lacks `library_path` in `ICD`".to_owned())
        }
        Ok(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every proper prefix of a manifest is an error that names the file. The loader's own reaction depends on its version.
    #[test]
    fn a_manifest_that_is_cut_short_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("icd.json");
        let whole = r#"{"ICD": {"api_version": "1.1.230", "library_path": "/lib.so"}, "file_format_version": "1.0.0"}"#;
        for end in 0..whole.len() {
            std::fs::write(&path, &whole[..end]).unwrap();
            let problem = problem_of(&path, true).expect("it is cut short");
            assert!(
                problem.contains("icd.json is damaged or cut short: "),
                "{problem}"
            );
        }
        for (text, words) in [(whole, None), ("{}", Some("lacks `library_path` in `ICD`"))] {
            std::fs::write(&path, text).unwrap();
            let problem = problem_of(&path, true);
            assert_eq!(problem.is_some(), words.is_some());
            assert!(
                problem
                    .unwrap_or_default()
                    .contains(words.unwrap_or_default())
            );
        }
        assert_eq!(listed(folder.path()), [path]);
        assert_eq!(problem_of(&folder.path().join("none.json"), true), None);
        let device = problem_of(Path::new("/dev/null"), true).unwrap();
        assert!(
            device.contains("/dev/null cannot be read: it is not a regular file"),
            "{device}"
        );
    }
}
