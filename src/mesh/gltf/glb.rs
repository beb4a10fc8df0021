//! The GLB container: a header of twelve bytes, then chunks, each with its length and its type.

use super::damaged;
use crate::mesh::error::MeshProblem;

const MAGIC: &[u8] = b"glTF";
const JSON: u32 = u32::from_le_bytes(*b"JSON");
const BIN: u32 = u32::from_le_bytes(*b"BIN\0");

/// Whether a file begins as a GLB does.
pub(crate) fn is_glb(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// The JSON of a file and its binary chunk, if it has one. What does not begin as a GLB is all JSON.
pub(super) fn split(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), MeshProblem> {
    if !is_glb(bytes) {
        return Ok((bytes, None));
    }
    let (Some(version), Some(length)) = (word(bytes, 4), word(bytes, 8)) else {
        return Err(damaged("the GLB header is cut off".to_owned()));
    };
    if version != 2 {
        return Err(MeshProblem::Unsupported(format!(
            "this is GLB version {version}, and version 2 is read: export the model anew"
        )));
    }
    if length as usize > bytes.len() {
        return Err(damaged(format!(
            "the GLB header says {length} bytes, and the file has {}",
            bytes.len()
        )));
    }
    let bytes = &bytes[..length as usize];
    let mut json = None;
    let mut binary = None;
    let mut at = 12;
    while at < bytes.len() {
        let (Some(length), Some(kind)) = (word(bytes, at), word(bytes, at + 4)) else {
            return Err(damaged(format!("the GLB chunk at byte {at} is cut off")));
        };
        let begin = at + 8;
        let chunk = begin
            .checked_add(length as usize)
            .and_then(|end| bytes.get(begin..end));
        let Some(chunk) = chunk else {
            let rest = bytes.len() - begin;
            return Err(damaged(format!(
                "the GLB chunk at byte {at} says {length} bytes, and {rest} follow"
            )));
        };
        match kind {
            JSON if json.is_none() => json = Some(chunk),
            BIN if binary.is_none() => binary = Some(chunk),
            // Other kinds belong to extensions.
            _ => {}
        }
        at = begin + chunk.len();
    }
    match json {
        Some(json) => Ok((json, binary)),
        None => Err(damaged("the GLB file has no JSON chunk".to_owned())),
    }
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    let word = bytes.get(at..)?.first_chunk()?;
    Some(u32::from_le_bytes(*word))
}
