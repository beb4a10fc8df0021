//! Sources of a glTF buffer's bytes: the GLB's own chunk, a data URI, or a file beside the model.
//!
//! A model may name only regular files in its own folder or below, after resolving links and `..`, and gets no more bytes of them than it
//! declares.

use std::io::{Error, Read};
use std::path::{Path, PathBuf};

use super::json::{Json, Part};
use super::{damaged, shortened};
use crate::mesh::error::MeshProblem;
use crate::mesh::load::MOST_BYTES;
use crate::regular_file;

/// The most work that one file may cost, in numbers decoded. A small file can name the same data any number of times.
/// No model that fits a surface needs as much.
const MOST_WORK: u64 = 1 << 31;

/// Cost of a look-up in the JSON of a file, in numbers decoded.
pub(super) const LOOKUP: u64 = 256;

/// The buffers of one file, each read when it is first needed, and what reading the file may still cost.
pub(super) struct Buffers<'a> {
    pub(super) root: Part<'a>,
    blob: Option<&'a [u8]>,
    folder: PathBuf,
    read: Vec<Option<Result<Vec<u8>, MeshProblem>>>,
    /// The rest of [`MOST_WORK`].
    pub(super) work_left: u64,
    /// How many more bytes of buffers may be read; all stay in memory.
    pub(super) bytes_left: u64,
}

/// The bytes of a buffer, at most as many as it declares.
pub(super) struct Bytes<'b> {
    pub(super) bytes: &'b [u8],
    /// Its place in the file.
    pub(super) place: String,
    /// How many bytes it declares.
    pub(super) length: u64,
}

impl<'a> Buffers<'a> {
    pub(super) fn new(json: &'a Json, blob: Option<&'a [u8]>, folder: &Path) -> Self {
        Self {
            root: Part::root(json),
            blob,
            folder: folder.to_owned(),
            read: Vec::new(),
            work_left: MOST_WORK,
            bytes_left: MOST_BYTES,
        }
    }

    /// Counts work, and fails when there was too much.
    pub(super) fn spend(&mut self, work: u64) -> Result<(), MeshProblem> {
        spend(&mut self.work_left, work)
    }

    /// The buffer that a buffer view lies in.
    pub(super) fn of_view(&mut self, view: &Part<'_>) -> Result<Bytes<'_>, MeshProblem> {
        let (index, buffer) = self.root.named("buffers", &view.needed("buffer")?)?;
        let length = buffer.whole("byteLength")?;
        let bytes = match buffer.get("uri") {
            None => match self.blob.filter(|_| index == 0) {
                Some(blob) => blob,
                None => return Err(without_data(view, &buffer)),
            },
            Some(uri) => {
                if index >= self.read.len() {
                    self.read.resize_with(index + 1, || None);
                }
                let uri = uri.as_text()?;
                let left = &mut self.bytes_left;
                let read = self.read[index].get_or_insert_with(|| {
                    let most = length.unwrap_or(MOST_BYTES).min(MOST_BYTES).min(*left + 1);
                    let bytes = resolve(uri, &self.folder, most)?;
                    spend(left, bytes.len() as u64)?;
                    Ok(bytes)
                });
                read.as_ref().map_err(MeshProblem::clone)?
            }
        };
        // A GLB's chunk may be padded; bytes beyond the buffer's length do not belong to it.
        let length = length.unwrap_or(bytes.len() as u64);
        let there = bytes
            .len()
            .min(usize::try_from(length).unwrap_or(usize::MAX));
        Ok(Bytes {
            bytes: &bytes[..there],
            place: buffer.place,
            length,
        })
    }
}

fn spend(left: &mut u64, amount: u64) -> Result<(), MeshProblem> {
    let rest = left.checked_sub(amount);
    *left = rest.unwrap_or(0);
    match rest {
        Some(_) => Ok(()),
        None => Err(MeshProblem::Unsupported(
            "the file names the same data too often: export the model with fewer parts and copies"
                .to_owned(),
        )),
    }
}

/// A buffer without data is for the decompressed data of an extension.
fn without_data(view: &Part<'_>, buffer: &Part<'_>) -> MeshProblem {
    let compression = view.get("extensions").and_then(|extensions| {
        let mut names = extensions.keys();
        names.find(|name| name.contains("meshopt"))
    });
    match compression {
        Some(name) => MeshProblem::Unsupported(format!(
            "{} is compressed with {}, which is not supported: export the model without compression",
            view.place,
            shortened(name, 60)
        )),
        None => damaged(format!("{} has no data", buffer.place)),
    }
}

/// The bytes that a URI refers to; of a file so many at most.
fn resolve(uri: &str, folder: &Path, most: u64) -> Result<Vec<u8>, MeshProblem> {
    let refuse = |why: &str| MeshProblem::Reference {
        uri: shortened(uri, 80),
        why: why.to_owned(),
    };
    if let Some(data) = uri.strip_prefix("data:") {
        return data_uri(data).ok_or_else(|| {
            refuse("which is a damaged data URI: export the model again, or as GLB")
        });
    }
    if has_scheme(uri) {
        return Err(refuse(
            "which is not the path of a file: export the model as GLB, or put the file into its folder",
        ));
    }
    let missing = |error: Error| {
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
    let file_named = |name: &str| -> Result<PathBuf, MeshProblem> {
        let path = folder.join(name).canonicalize().map_err(missing)?;
        if !path.starts_with(&folder) {
            return Err(refuse(
                "which is outside of its folder: copy the file into the folder and name it there",
            ));
        }
        // A pipe or a device may never end.
        if !path.is_file() {
            return Err(refuse("which is no regular file: export the model as GLB"));
        }
        Ok(path)
    };
    // Some writers do not escape the names of files; those are used unchanged.
    let path = match String::from_utf8(percent_decode(uri)) {
        Ok(decoded) => file_named(&decoded).or_else(|problem| file_named(uri).map_err(|_| problem)),
        Err(_) => file_named(uri),
    }?;
    let mut bytes = Vec::new();
    regular_file::open(&path)
        .and_then(|(file, _)| file.take(most).read_to_end(&mut bytes))
        .map_err(missing)?;
    Ok(bytes)
}

/// The bytes of a data URI (RFC 2397), without its `data:`.
fn data_uri(data: &str) -> Option<Vec<u8>> {
    let (kind, text) = data.split_once(',')?;
    let bytes = percent_decode(text);
    match kind.rsplit_once(';') {
        Some((_, "base64")) => base64(&bytes),
        _ => Some(bytes),
    }
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

/// The bytes that a URI's text stands for. A percent sign that begins no escape stands for itself.
fn percent_decode(text: &str) -> Vec<u8> {
    let digit = |byte: Option<&u8>| byte.and_then(|&byte| char::from(byte).to_digit(16));
    let text = text.as_bytes();
    let mut bytes = Vec::with_capacity(text.len());
    let mut at = 0;
    while let Some(&byte) = text.get(at) {
        let escape = (digit(text.get(at + 1)), digit(text.get(at + 2)));
        if let (b'%', (Some(high), Some(low))) = (byte, escape) {
            bytes.push((16 * high + low) as u8);
            at += 3;
        } else {
            bytes.push(byte);
            at += 1;
        }
    }
    bytes
}

/// The bytes of a base64 text (RFC 4648), with or without padding.
fn base64(text: &[u8]) -> Option<Vec<u8>> {
    let padding = text.iter().rev().take_while(|&&byte| byte == b'=').count();
    let digits = &text[..text.len() - padding];
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
            assert_eq!(base64(text.as_bytes()).as_deref(), Some(bytes), "{text}");
        }
        for text in ["Z", "Zm9vY", "Zm 9", "Zm=9"] {
            assert_eq!(base64(text.as_bytes()), None, "{text}");
        }
    }

    #[test]
    fn percent_escapes_are_bytes() {
        for (text, bytes) in [
            ("a%20b%C3%A9.bin", "a bé.bin".as_bytes()),
            ("part 10%.bin", b"part 10%.bin"),
            ("%zz%2%", b"%zz%2%"),
            ("%00%ff", &[0, 255]),
        ] {
            assert_eq!(percent_decode(text), bytes, "{text}");
        }
    }

    #[test]
    fn data_uris_are_base64_or_escaped_bytes() {
        for (uri, bytes) in [
            (";base64,Zm8%3D", Some(&b"fo"[..])),
            (
                "application/octet-stream;charset=utf-8;base64,Zg",
                Some(b"f"),
            ),
            ("application/octet-stream,%00a%ff", Some(&[0, b'a', 255])),
            (";base64", None),
            (";base64,A!", None),
        ] {
            assert_eq!(data_uri(uri).as_deref(), bytes, "{uri}");
        }
    }
}
