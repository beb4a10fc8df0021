//! The kind of output by a file's name: the last frame, every frame, a GIF or a video.

use std::path::{Path, PathBuf};

/// The kind of output.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Kind {
    /// `NAME.png`: the last frame.
    Picture,
    /// `NAME_%05d.png`, or a folder: every frame in a file of its own.
    Sequence(Numbering),
    /// `NAME.gif`.
    Gif,
    /// `NAME.mp4`.
    Video,
}

/// The names of a sequence's files: the frame's number between two fixed parts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Numbering {
    folder: PathBuf,
    before: String,
    digits: usize,
    after: String,
}

impl Numbering {
    /// The file of frame `index`, the first of which is 0.
    pub(super) fn path(&self, index: u64) -> PathBuf {
        let Self {
            before,
            digits,
            after,
            ..
        } = self;
        self.folder.join(format!("{before}{index:0digits$}{after}"))
    }

    /// The files of the first `count` frames that are there already, in any order. The folder is listed, because there may be billions of
    /// frames.
    pub(super) fn existing(&self, count: u64) -> Vec<PathBuf> {
        let folder: &Path = match self.folder.as_os_str().is_empty() {
            true => Path::new("."),
            false => &self.folder,
        };
        let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let names = entries.filter_map(|entry| entry.file_name().into_string().ok());
        let indices = names.filter_map(|name| self.index_of(&name));
        let frames = indices.filter(|index| *index < count);
        frames.map(|index| self.path(index)).collect()
    }

    /// The frame whose file has this name.
    fn index_of(&self, name: &str) -> Option<u64> {
        let rest = name.strip_prefix(self.before.as_str())?;
        let number = rest.strip_suffix(self.after.as_str())?;
        let index: u64 = number.parse().ok()?;
        (self.path(index).file_name()? == name).then_some(index)
    }
}

impl Kind {
    /// The kind of output for `path`; `None` if its name has no known ending.
    pub(super) fn of(path: &Path) -> Option<Self> {
        let ends_as_folder = path.to_string_lossy().ends_with(std::path::is_separator);
        if ends_as_folder || path.is_dir() {
            return Some(Self::Sequence(Numbering {
                folder: path.to_owned(),
                before: "frame_".to_owned(),
                digits: 5,
                after: ".png".to_owned(),
            }));
        }
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "png" => Some(match numbering(path) {
                Some(numbering) => Self::Sequence(numbering),
                None => Self::Picture,
            }),
            "gif" => Some(Self::Gif),
            "mp4" => Some(Self::Video),
            _ => None,
        }
    }
}

/// The numbering by `%d` or `%05d` in the file name; any other `%` is an ordinary character.
fn numbering(path: &Path) -> Option<Numbering> {
    let name = path.file_name()?.to_str()?;
    name.match_indices('%').find_map(|(start, _)| {
        let rest = &name[start + 1..];
        let end = rest.find('d')?;
        let width = &rest[..end];
        let padded = width.starts_with('0') && width.len() == 2;
        if !(width.is_empty() || padded && width.bytes().all(|byte| byte.is_ascii_digit())) {
            return None;
        }
        Some(Numbering {
            folder: path.parent()?.to_owned(),
            before: name[..start].to_owned(),
            digits: width.parse().unwrap_or(0),
            after: rest[end + 1..].to_owned(),
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn third_file(path: &str) -> Option<PathBuf> {
        match Kind::of(Path::new(path))? {
            Kind::Sequence(numbering) => Some(numbering.path(2)),
            _ => None,
        }
    }

    #[test]
    fn names_say_what_is_written() {
        for (path, kind) in [
            ("torus.png", Some(Kind::Picture)),
            ("out/Torus.PNG", Some(Kind::Picture)),
            ("out.d/50%.png", Some(Kind::Picture)),
            ("%x_%5d_%0d_%123d.png", Some(Kind::Picture)),
            ("%.png", Some(Kind::Picture)),
            ("torus.gif", Some(Kind::Gif)),
            ("torus_%05d.mp4", Some(Kind::Video)),
            ("torus", None),
            ("torus.avi", None),
            (".png", None),
            ("", None),
        ] {
            assert_eq!(Kind::of(Path::new(path)), kind, "{path:?}");
        }
    }

    #[test]
    fn sequences_are_numbered_as_their_names_ask() {
        for (path, third) in [
            ("frames/", "frames/frame_00002.png"),
            ("a/torus_%05d.png", "a/torus_00002.png"),
            ("%d.png", "2.png"),
            ("100%_%03d.png", "100%_002.png"),
            ("%02d_%02d.png", "02_%02d.png"),
        ] {
            assert_eq!(third_file(path), Some(PathBuf::from(third)), "{path:?}");
        }
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(
            third_file(folder.path().to_str().unwrap()),
            Some(folder.path().join("frame_00002.png"))
        );
    }

    /// Would catch: a file that a frame replaces and that is not found, and a file that is, though no frame has its name.
    #[test]
    fn files_that_frames_replace_are_found() {
        let folder = tempfile::tempdir().unwrap();
        for name in [
            "a_002.png",
            "a_000.png",
            "a_003.png",
            "a_1000.png",
            "a_1.png",
            "a_+01.png",
            "a_.png",
            "b_001.png",
        ] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        let kind = Kind::of(&folder.path().join("a_%03d.png"));
        let Some(Kind::Sequence(numbering)) = kind else {
            panic!("a sequence");
        };
        let found = |count: u64| {
            let mut files = numbering.existing(count);
            files.sort();
            files
        };
        let [first, third, last] = [0, 2, 1000].map(|index| numbering.path(index));
        assert_eq!(found(3), [first, third]);
        assert_eq!(found(1000).len(), 3);
        assert_eq!(found(u64::MAX).last(), Some(&last));
        let elsewhere = Kind::of(Path::new("nowhere/a_%d.png"));
        let Some(Kind::Sequence(numbering)) = elsewhere else {
            panic!("a sequence");
        };
        assert!(numbering.existing(3).is_empty());
    }

    #[test]
    fn numbers_grow_beyond_their_digits() {
        let Some(Kind::Sequence(numbering)) = Kind::of(Path::new("%02d.png")) else {
            panic!("a sequence");
        };
        assert_eq!(numbering.path(12345), PathBuf::from("12345.png"));
    }
}
