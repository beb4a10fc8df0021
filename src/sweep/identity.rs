//! What a result depends on, as a short text: equal texts, equal results.

use std::path::Path;

use serde_json::{Map, Value};
use sha2::{Digest as _, Sha256};

use crate::error::{Error, Result};
use crate::scene::Scene;

/// A scene's name, and a digest of all that it has: its parameters but for the seed, its meshes, and the content of its masks and maps. It
/// does not depend on where they lie.
///
/// # Errors
/// When a mask or a map cannot be read.
pub fn identity(scene: &Scene) -> Result<String> {
    let mut settings = scene.settings.clone();
    settings.seed = 0;
    for object in &mut settings.objects {
        // What it has follows.
        object.mesh.clear();
        by_content(&mut object.start.mask, &scene.folder)?;
    }
    let second = &mut settings.second_look;
    for file in [
        &mut settings.particles.start_mask,
        &mut settings.areas.map,
        &mut second.map,
        &mut second.preset,
    ] {
        by_content(file, &scene.folder)?;
    }
    let mut digest = Sha256::new();
    digest.update(format!("{settings:?} {:?}", scene.tracks));
    for mesh in &scene.meshes {
        digest.update(format!("{:?} {}", mesh.origin, mesh.positions.len()));
        digest.update(bytemuck::cast_slice::<_, u8>(&mesh.positions));
        digest.update(bytemuck::cast_slice::<_, u8>(&mesh.corners));
    }
    Ok(format!("{} {}", scene.name, hex(&digest.finalize()[..8])))
}

/// Replaces the path of a file by its digest.
fn by_content(file: &mut String, folder: &Path) -> Result<()> {
    let path = folder.join(&*file);
    if !file.is_empty() && path.is_file() {
        let content = std::fs::read(&path).map_err(Error::io("read", &path))?;
        *file = hex(&Sha256::digest(content));
    }
    Ok(())
}

/// A name of 16 hexadecimal digits for a value; equal values have the same.
#[must_use]
pub fn key_of(value: &Value) -> String {
    let digest = Sha256::digest(sorted(value).to_string().as_bytes());
    hex(&digest[..8])
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The same value with the keys of each object in alphabetical order.
fn sorted(value: &Value) -> Value {
    match value {
        Value::Object(map) => {
            let mut entries: Vec<_> = map.iter().collect();
            entries.sort_unstable_by_key(|(key, _)| *key);
            let entries = entries
                .into_iter()
                .map(|(key, value)| (key.clone(), sorted(value)));
            Value::Object(entries.collect::<Map<_, _>>())
        }
        Value::Array(items) => Value::Array(items.iter().map(sorted).collect()),
        other => other.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Overrides;

    /// Catches numbers that are read with another last digit than they were written, by which a folder would be of another study.
    #[test]
    fn equal_values_have_equal_keys() {
        let of = |text: &str| key_of(&serde_json::from_str(text).expect("it is JSON"));
        assert_eq!(
            of(r#"{"a": 1e-5, "b": [true]}"#),
            of(r#"{"b":[true],"a":0.00001}"#)
        );
        assert_ne!(of(r#"{"a": 1}"#), of(r#"{"a": 2}"#));
        for number in [0.009_125_373_295_837_779, 0.1 + 0.2, 1.0 / 3.0] {
            assert_eq!(
                of(&format!("[{number}]")),
                key_of(&serde_json::json!([number]))
            );
        }
    }

    /// Catches results that count as done though a file of their scene has changed.
    #[test]
    fn a_scene_is_known_by_its_files_and_not_by_their_place() {
        let folders = [(); 2].map(|()| tempfile::tempdir().expect("there is room"));
        let of = |folder: usize, points: &str, preset: &str| {
            let folder = folders[folder].path();
            let write = |name: &str, text: &str| {
                std::fs::write(folder.join(name), text).expect("there is room")
            };
            write("a.obj", &format!("{points}v 1 0 0\nv 0 1 0\nf 1 2 3\n"));
            write("a.toml", "[[object]]\nmesh = \"a.obj\"\n");
            let overrides = Overrides {
                preset: Some(preset.to_owned()),
                ..Overrides::default()
            };
            let scene = Scene::load(&folder.join("a.toml"), &overrides).expect("it loads");
            identity(&scene).expect("its files are read")
        };
        let first = of(0, "v 0 0 0\n", "network");
        assert!(first.starts_with("a ") && first.len() == 18, "{first}");
        assert_eq!(first, of(1, "v 0 0 0\n", "network"));
        assert_ne!(first, of(1, "v 0 0 1\n", "network"), "another mesh");
        assert_ne!(first, of(1, "v 0 0 0\n", "lace"), "another preset");
    }
}
