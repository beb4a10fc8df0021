//! What a result depends on, as a short text: equal texts, equal results.

use std::collections::HashMap;
use std::path::Path;

use serde_json::{Map, Number, Value};
use sha2::{Digest as _, Sha256};

use super::row::Row;
use crate::error::{Error, Result};
use crate::mesh::{Mesh, RigidTrack};
use crate::scene::parameters::{Form, Kind, OBJECT_PARAMETERS, find, form_of};
use crate::scene::{BUILTIN, Scene};

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
        add_mesh(&mut digest, mesh);
    }
    Ok(format!("{} {}", scene.name, hex(&digest.finalize()[..8])))
}

fn add_mesh(digest: &mut Sha256, mesh: &Mesh) {
    digest.update(format!("{:?} {}", mesh.origin, mesh.positions.len()));
    digest.update(bytemuck::cast_slice::<_, u8>(&mesh.positions));
    digest.update(bytemuck::cast_slice::<_, u8>(&mesh.corners));
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

/// What the files have that points name. Each is read once.
#[derive(Debug, Default)]
pub struct Contents {
    /// By the path, and whether it is that of a mesh.
    digests: HashMap<(String, bool), Option<String>>,
}

impl Contents {
    /// A digest of each file that a value of a point names, by the value's key; empty if there is none. Paths begin in the present folder,
    /// as they do in a run. A file that cannot be read is left out: its run fails, and its row says why.
    #[must_use]
    pub fn of(&mut self, point: &Row) -> Map<String, Value> {
        let mut found = Map::new();
        for (key, value) in &point.0 {
            self.add(key, value, &mut found);
        }
        found
    }

    fn add(&mut self, key: &str, value: &Value, found: &mut Map<String, Value>) {
        match value {
            Value::String(path) => {
                let is_mesh = of_object(key) == Some("mesh");
                if !(is_mesh || is_of_file(key)) {
                    return;
                }
                let place = (path.clone(), is_mesh);
                let digest = (self.digests.entry(place)).or_insert_with(|| content(path, is_mesh));
                if let Some(digest) = digest {
                    found.insert(key.to_owned(), digest.as_str().into());
                }
            }
            // Points of Python may have `object.0` as a table.
            Value::Object(table) => {
                for (own, value) in table {
                    self.add(&format!("{key}.{own}"), value, found);
                }
            }
            _ => {}
        }
    }
}

/// The part of an object's key after its number.
fn of_object(key: &str) -> Option<&str> {
    let (_, own) = key.trim().strip_prefix("object.")?.split_once('.')?;
    Some(own)
}

/// Is the value of this key a path? Those of meshes are not in the tables.
fn is_of_file(key: &str) -> bool {
    match of_object(key) {
        Some(own) => (OBJECT_PARAMETERS.iter())
            .any(|parameter| parameter.key == own && is_path(&parameter.kind)),
        None => find(key.trim()).is_some_and(|parameter| is_path(&parameter.kind)),
    }
}

fn is_path<T>(kind: &Kind<T>) -> bool {
    matches!(kind, Kind::Text { is_path: true, .. })
}

/// Below this, whole numbers are the same in double precision.
const MOST_WHOLE: f64 = 9e15;

/// How a glTF model names other files, of which it may consist.
const NAMES_FILES: &[u8] = b"\"uri\"";

/// A digest of what a file has; none if it is none or cannot be read.
fn content(path: &str, is_mesh: bool) -> Option<String> {
    if path.starts_with(BUILTIN) || !Path::new(path).is_file() {
        return None;
    }
    let bytes = std::fs::read(path).ok()?;
    let mut digest = Sha256::new();
    digest.update(&bytes);
    let mut parts = bytes.windows(NAMES_FILES.len());
    if is_mesh && parts.any(|part| part == NAMES_FILES) {
        let here = Path::new("");
        if let Ok(mesh) = Mesh::open(path, here) {
            add_mesh(&mut digest, &mesh);
        }
        digest.update(format!("{:?}", RigidTrack::open(path, here).ok()));
    }
    Some(hex(&digest.finalize()))
}

/// A name of 16 hexadecimal digits for a value; equal values have the same. Parameters, in `point` and `settings`, may have their numbers
/// written in several ways.
#[must_use]
pub fn key_of(value: &Value) -> String {
    let plain = sorted(&with_plain_numbers(value));
    let digest = Sha256::digest(plain.to_string().as_bytes());
    hex(&digest[..8])
}

/// The same value, in which the numbers of parameters, in `point` and `settings`, are whole or not as their parameters are: 15 becomes 15.0
/// where it is an angle, and 500.0 becomes 500 where it is a count.
pub(super) fn with_plain_numbers(value: &Value) -> Value {
    let mut plain = value.clone();
    for part in ["point", "settings"] {
        if let Some(Value::Object(parameters)) = plain.get_mut(part) {
            for (key, value) in parameters {
                if let Some(form) = form_of(key.trim()) {
                    make_plain(form, value);
                }
            }
        }
    }
    plain
}

fn make_plain(form: Form, value: &mut Value) {
    match value {
        Value::Array(items) => items.iter_mut().for_each(|item| make_plain(form, item)),
        Value::Number(number) => {
            let Some(size) = number.as_f64() else { return };
            let plain = match form {
                Form::Whole if size.fract() == 0.0 && size.abs() < MOST_WHOLE => {
                    Some(Number::from(size as i64))
                }
                Form::Other => Number::from_f64(size),
                _ => None,
            };
            if let Some(plain) = plain {
                *number = plain;
            }
        }
        _ => {}
    }
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

    /// Would catch: one run under two names because of the way in which its numbers are written, and another name than before for one whose
    /// numbers are written as its parameters are.
    #[test]
    fn numbers_of_parameters_may_be_written_in_several_ways() {
        let of = |text: &str| key_of(&serde_json::from_str(text).expect("it is JSON"));
        let plain = r#"{"point":{"object.0.position":[0.0,1.0,0.5],"particles.count":500,"trail.decay":1.0},"steps":5}"#;
        let as_before = hex(&Sha256::digest(plain.as_bytes())[..8]);
        let other = r#"{"point":{"object.0.position":[0,1,0.5],"particles.count":5e2,"trail.decay":1},"steps":5}"#;
        assert_eq!([of(plain), of(other)], [as_before.clone(), as_before]);
        assert_eq!(
            of(r#"{"settings":{"trail.decay":1}}"#),
            of(r#"{"settings":{"trail.decay":1.0}}"#)
        );
        for (one, another) in [
            (r#"{"steps":5}"#, r#"{"steps":5.0}"#),
            (r#"{"point":{"none":5}}"#, r#"{"point":{"none":5.0}}"#),
            (
                r#"{"point":{"particles.count":5.5}}"#,
                r#"{"point":{"particles.count":5}}"#,
            ),
        ] {
            assert_ne!(of(one), of(another), "{one}");
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

    /// Digests of the files that a point with one value names.
    fn files(key: &str, value: Value) -> Map<String, Value> {
        let mut point = Row::default();
        point.set(key, value);
        Contents::default().of(&point)
    }

    /// Would catch: runs that count as done although a file that their point names has changed, and other texts that are taken for files.
    #[test]
    fn files_of_points_are_known_by_what_they_have() {
        let folder = tempfile::tempdir().expect("there is room");
        let file = folder.path().join("file");
        let path = file.to_str().expect("it is plain");
        let write = |text: &str| std::fs::write(&file, text).expect("there is room");
        for key in [
            "areas.map",
            "particles.start_mask",
            "second_look.map",
            "object.0.mesh",
            "object.1.start.mask",
        ] {
            write("one");
            let before = files(key, path.into());
            assert!(before.len() == 1 && before.contains_key(key), "{before:?}");
            write("two");
            let after = files(key, path.into());
            assert_ne!(after[key], before[key], "{key}");
        }
        let table = serde_json::json!({"start": {"mask": path}, "scale": 2});
        let found = files("object.0", table);
        assert!(found.len() == 1 && found.contains_key("object.0.start.mask"));
        for (key, value) in [
            ("picture.show", path.into()),
            ("object.0.name", path.into()),
            ("areas.map", "no such file".into()),
            ("areas.map", "".into()),
            ("object.0.mesh", "builtin:cube".into()),
            ("trail.decay", Value::from(0.9)),
        ] {
            assert_eq!(files(key, value), Map::new(), "{key}");
        }
    }

    /// Would catch: a model that counts as the same although the file with its vertices has changed.
    #[test]
    fn files_that_a_model_names_are_a_part_of_it() {
        const MODEL: &str = r#"{
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
            "bufferViews": [{"buffer": 0, "byteLength": 36}],
            "buffers": [{"uri": "places.bin", "byteLength": 36}]
        }"#;
        let folder = tempfile::tempdir().expect("there is room");
        let model = folder.path().join("model.gltf");
        std::fs::write(&model, MODEL).expect("there is room");
        let with_height = |height: f32| {
            let places = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, height];
            let bytes = bytemuck::cast_slice::<f32, u8>(&places).to_vec();
            std::fs::write(folder.path().join("places.bin"), bytes).expect("there is room");
            files("object.0.mesh", model.to_str().into())
        };
        let before = with_height(0.0);
        assert_eq!(before.len(), 1);
        assert_ne!(with_height(1.0), before);
        assert_eq!(with_height(0.0), before);
    }
}
