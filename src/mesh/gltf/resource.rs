//! Where the bytes of a glTF buffer come from: the GLB's own chunk, a data URI, or a file beside the model.
//!
//! A model may name only regular files in its own folder or below, wherever links and `..` lead, and gets no more bytes
//! of them than it says it needs.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use gltf::json::Root;

use super::{damaged, get};
use crate::mesh::error::MeshProblem;
use crate::mesh::load::MOST_BYTES;

/// The buffers of one file, each read when it is first needed.
pub(super) struct Buffers<'a> {
    pub(super) root: &'a Root,
    blob: Option<&'a [u8]>,
    folder: PathBuf,
    read: Vec<Option<Vec<u8>>>,
}

impl<'a> Buffers<'a> {
    pub(super) fn new(root: &'a Root, blob: Option<&'a [u8]>, folder: &Path) -> Self {
        Self {
            root,
            blob,
            folder: folder.to_owned(),
            read: root.buffers.iter().map(|_| None).collect(),
        }
    }

    /// All bytes of a buffer: as many as the file says, and they are there.
    pub(super) fn bytes(&mut self, index: usize) -> Result<&[u8], MeshProblem> {
        let buffer = get(&self.root.buffers, index, "buffer")?;
        let length = buffer.byte_length.0;
        let bytes = match &buffer.uri {
            None => self
                .blob
                .filter(|_| index == 0)
                .ok_or_else(|| damaged(format!("buffer {index} has no data")))?,
            Some(uri) => {
                let slot = &mut self.read[index];
                if slot.is_none() {
                    *slot = Some(resolve(uri, &self.folder, length)?);
                }
                slot.as_deref().unwrap_or_default()
            }
        };
        // A GLB's chunk may be padded; what lies beyond the buffer's length is not the buffer.
        usize::try_from(length)
            .ok()
            .and_then(|length| bytes.get(..length))
            .ok_or_else(|| {
                let there = bytes.len();
                damaged(format!(
                    "buffer {index} should have {length} bytes, and has {there}"
                ))
            })
    }
}

fn resolve(uri: &str, folder: &Path, length: u64) -> Result<Vec<u8>, MeshProblem> {
    let refuse = |why: &str| MeshProblem::Reference {
        uri: uri.chars().take(80).collect(),
        why: why.to_owned(),
    };
    if let Some(data) = uri.strip_prefix("data:") {
        let Some((_, text)) = data.split_once(";base64,") else {
            return Err(refuse("which is not base64: export the model as GLB"));
        };
        return base64(text)
            .ok_or_else(|| refuse("which is damaged base64: export the model anew"));
    }
    if length > MOST_BYTES {
        return Err(refuse("which is too large to be read: simplify the model"));
    }
    if has_scheme(uri) {
        return Err(refuse(
            "which is no file beside it: export the model as GLB, or put the file into its folder",
        ));
    }
    let Some(relative) = percent_decode(uri) else {
        return Err(refuse(
            "which is no valid name of a file: export the model as GLB",
        ));
    };
    let missing = |error: std::io::Error| {
        refuse(&format!(
            "which cannot be read ({error}): put the file beside the model"
        ))
    };
    let folder = if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    };
    let folder = folder.canonicalize().map_err(missing)?;
    let path = folder.join(relative).canonicalize().map_err(missing)?;
    if !path.starts_with(&folder) {
        return Err(refuse(
            "which lies outside of its folder: copy the file into the folder and name it there",
        ));
    }
    if !path.is_file() {
        return Err(refuse("which is no regular file: export the model as GLB"));
    }
    let mut bytes = Vec::new();
    File::open(&path)
        .and_then(|file| file.take(length).read_to_end(&mut bytes))
        .map_err(missing)?;
    Ok(bytes)
}

/// Whether a URI begins with `scheme:`.
fn has_scheme(uri: &str) -> bool {
    uri.split_once(':').is_some_and(|(scheme, _)| {
        scheme.starts_with(|c: char| c.is_ascii_alphabetic())
            && scheme
                .chars()
                .all(|c| c.is_ascii_alphanumeric() || "+-.".contains(c))
    })
}

/// A URI's path as it is written in the file system. `None` if it is not UTF-8, or has a NUL in it.
fn percent_decode(uri: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.bytes();
    while let Some(byte) = rest.next() {
        if byte == b'%' {
            let high = char::from(rest.next()?).to_digit(16)?;
            let low = char::from(rest.next()?).to_digit(16)?;
            bytes.push((16 * high + low) as u8);
        } else {
            bytes.push(byte);
        }
    }
    String::from_utf8(bytes)
        .ok()
        .filter(|path| !path.contains('\0'))
}

/// The bytes of a base64 text (RFC 4648), with or without padding.
fn base64(text: &str) -> Option<Vec<u8>> {
    let digits = text.trim_end_matches('=').as_bytes();
    let mut bytes = Vec::with_capacity(digits.len() / 4 * 3 + 2);
    for group in digits.chunks(4) {
        let mut word = 0_u32;
        for &digit in group {
            let value = match digit {
                b'A'..=b'Z' => digit - b'A',
                b'a'..=b'z' => digit - b'a' + 26,
                b'0'..=b'9' => digit - b'0' + 52,
                b'+' | b'-' => 62,
                b'/' | b'_' => 63,
                _ => return None,
            };
            word = word << 6 | u32::from(value);
        }
        match group.len() {
            4 => bytes.extend_from_slice(&word.to_be_bytes()[1..]),
            3 => bytes.extend_from_slice(&(word >> 2).to_be_bytes()[2..]),
            2 => bytes.push((word >> 4) as u8),
            _ => return None,
        }
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_is_read_with_and_without_padding() {
        for (text, bytes) in [
            ("", &b""[..]),
            ("Zg==", b"f"),
            ("Zm8=", b"fo"),
            ("Zm8", b"fo"),
            ("Zm9vYmFy", b"foobar"),
            ("+/8A", &[0xfb, 0xff, 0x00]),
        ] {
            assert_eq!(base64(text).as_deref(), Some(bytes), "{text}");
        }
        for text in ["Z", "Zm9vY", "Zm 9", "Zm=9"] {
            assert_eq!(base64(text), None, "{text}");
        }
    }

    #[test]
    fn percent_escapes_are_bytes_of_utf8() {
        assert_eq!(
            percent_decode("a%20b%C3%A9.bin").as_deref(),
            Some("a bé.bin")
        );
        for uri in ["%", "%2", "%zz", "%ff", "a%00b"] {
            assert_eq!(percent_decode(uri), None, "{uri}");
        }
    }
}
