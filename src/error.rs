//! The library's error: one variant a layer, each with what failed, where, and what to do.

/// Anything that the caller could not foresee. Programmer mistakes panic instead.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file could not be read or written.
    #[error("cannot {action} {path}: {source}{}", advice(source), path = path.display())]
    Io {
        /// What was tried: `read`, `write`, `create`.
        action: &'static str,
        /// The file or folder.
        path: std::path::PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The device, or something on it, failed.
    #[error(transparent)]
    Gpu(#[from] crate::gpu::GpuError),
    /// A mesh cannot be used.
    #[error(transparent)]
    Mesh(#[from] crate::mesh::MeshError),
    /// The triangles have no room in the texture.
    #[error(transparent)]
    Atlas(#[from] crate::mesh::atlas::AtlasError),
    /// A scene cannot be used.
    #[error(transparent)]
    Scene(#[from] crate::scene::SceneError),
    /// A picture or a video could not be written.
    #[error(transparent)]
    Output(#[from] crate::render::output::OutputError),
    /// Something asked for cannot be done; the text says what and what to do.
    #[error("{0}")]
    Invalid(String),
}

/// The library's result.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// What to do about a file that cannot be read or written, to stand behind what the system said.
pub(crate) fn advice(source: &std::io::Error) -> &'static str {
    use std::io::ErrorKind;
    match source.kind() {
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
            "; choose a place where you may do that"
        }
        // The system says of a folder to be made that the file exists.
        ErrorKind::NotADirectory | ErrorKind::AlreadyExists => {
            "; a part of the path is a file and not a folder"
        }
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded | ErrorKind::FileTooLarge => {
            "; free some space, or choose another disk"
        }
        _ => "",
    }
}

/// Letters of a word that messages quote whole: more than the longest name of a file.
const LONGEST_WORD: usize = 300;

/// A message in which long words, such as a name that somebody pasted a file into, are quoted by their beginning.
pub(crate) fn brief(text: &str) -> String {
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
