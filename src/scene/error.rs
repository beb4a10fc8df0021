//! What can be wrong with a scene, said so that its owner can mend it.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::file::Problem;
use super::suggest::nearest;
use super::{builtin, parameters};
use crate::mesh::MeshError;

/// Problems that a message lists.
const MOST_LISTED: usize = 20;

/// Why there is no scene.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// No built-in scene has this name, and no file either.
    #[error(
        "there is no scene `{name}`{suggestion}: the built-in ones are {known}; a scene can also be a .toml file or a model (.obj, .stl, .ply, .glb, .gltf)"
    )]
    UnknownScene {
        /// What was asked for.
        name: String,
        /// `, did you mean ...?`, or nothing.
        suggestion: String,
        /// All names.
        known: String,
    },
    /// A file of another kind, by its ending.
    #[error(
        "{path}: neither a scene nor a model by the ending of its name: models are .obj, .stl, .ply, .glb, .gltf, scenes .toml",
        path = path.display()
    )]
    OtherFile {
        /// The file.
        path: PathBuf,
    },
    /// No preset has this name.
    #[error(
        "there is no preset `{name}`{suggestion}: the presets are {known}; a preset can also be a .toml file"
    )]
    UnknownPreset {
        /// What was asked for.
        name: String,
        /// `, did you mean ...?`, or nothing.
        suggestion: String,
        /// All names.
        known: String,
    },
    /// The file of a preset could not be read.
    #[error("cannot read the preset {path}: {source}", path = path.display())]
    ReadPreset {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The scene file could not be read.
    #[error("cannot read the scene {path}: {source}", path = path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// Keys or values are wrong; the message lists the first of them, and says how many there are.
    #[error("{}", listed(scene, problems))]
    Problems {
        /// The scene that was asked for.
        scene: PathBuf,
        /// Everything that is wrong.
        problems: Vec<Problem>,
    },
    /// An object's mesh cannot be used.
    #[error("object `{object}`: {source}")]
    Object {
        /// The object's name, or its place in the file.
        object: String,
        /// What is wrong with its mesh.
        source: MeshError,
    },
    /// The objects are too small or too large to measure lengths by.
    #[error(
        "the scene radius comes to {radius:e} world units, which lengths cannot be multiplied by: set `radius`, or scale the objects"
    )]
    Radius {
        /// What was measured or set.
        radius: f32,
    },
    /// The objects are too far from the origin.
    #[error(
        "the objects reach {farthest:e} world units from the origin, and 4e12 is the most: move them nearer, or scale them down"
    )]
    TooFar {
        /// The greatest coordinate.
        farthest: f64,
    },
    /// A model's path is not Unicode, which scene files are written in.
    #[error("{path}: the path is not Unicode, and scene files are: rename it", path = path.display())]
    NotUnicode {
        /// The path.
        path: PathBuf,
    },
}

impl SceneError {
    pub(super) fn unknown_scene(scene: &Path) -> Self {
        let name = scene.to_string_lossy().into_owned();
        let names: Vec<_> = builtin::SCENES.iter().map(|scene| scene.name).collect();
        let (suggestion, known) = suggest(&name, &names);
        Self::UnknownScene {
            name: brief(&name),
            suggestion,
            known,
        }
    }

    pub(super) fn unknown_preset(name: &str) -> Self {
        let names: Vec<_> = builtin::PRESETS.iter().map(|preset| preset.name).collect();
        let (suggestion, known) = suggest(name, &names);
        Self::UnknownPreset {
            name: brief(name),
            suggestion,
            known,
        }
    }
}

fn suggest(name: &str, names: &[&str]) -> (String, String) {
    let suggestion =
        nearest(name, names.iter().copied()).map(|near| format!(", did you mean `{near}`?"));
    (suggestion.unwrap_or_default(), parameters::all_of(names))
}

fn listed(scene: &Path, problems: &[Problem]) -> String {
    let scene = scene.display();
    match problems {
        [only] => format!("{scene}: {}", brief(&only.to_string())),
        many => {
            let mut text = format!("{scene}: {} things are wrong:", many.len());
            for problem in &many[..many.len().min(MOST_LISTED)] {
                let _ = write!(text, "\n  {}", brief(&problem.to_string()));
            }
            if many.len() > MOST_LISTED {
                let _ = write!(text, "\n  and {} more", many.len() - MOST_LISTED);
            }
            text
        }
    }
}

/// Letters of a word that messages quote whole: longer than any file name.
const LONGEST_WORD: usize = 300;

/// Shortens very long words in a message to their beginning.
fn brief(text: &str) -> String {
    let short = |word: &str| match word.char_indices().nth(LONGEST_WORD) {
        None => word.to_owned(),
        Some(_) => {
            let (kept, rest) = word.split_at(word.char_indices().nth(60).map_or(0, |(at, _)| at));
            format!("{kept}... ({} letters more)", rest.chars().count())
        }
    };
    let words = text.split_inclusive(char::is_whitespace);
    words
        .map(|word| {
            let bare = word.trim_end_matches(char::is_whitespace);
            short(bare) + &word[bare.len()..]
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::brief;

    #[test]
    fn long_words_are_quoted_by_their_beginning() {
        let text = "scene.toml: line 3:\n  there is no key `radios`, did you mean `radius`?";
        assert_eq!(brief(text), text);
        let long = format!("there is no key `{}é`: see below\n", "x".repeat(100_000));
        let expected = format!(
            "there is no key `{}... (99944 letters more) see below\n",
            "x".repeat(59)
        );
        assert_eq!(brief(&long), expected);
    }
}
