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
///
/// The header's total length is not read: the chunks have their own lengths, and it is wrong in some files. A binary chunk
/// that is cut off is handed over as far as it goes; reading beyond it is an error.
pub(super) fn split(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), MeshProblem> {
    if !is_glb(bytes) {
        return Ok((bytes, None));
    }
    let Some(version) = word(bytes, 4).filter(|_| bytes.len() >= 12) else {
        return Err(damaged("the GLB header is cut off".to_owned()));
    };
    if version != 2 {
        return Err(MeshProblem::Unsupported(format!(
            "this is GLB version {version}, and only version 2 can be read: export the model again"
        )));
    }
    let mut json = None;
    let mut binary = None;
    let mut at = 12;
    while let (Some(length), Some(kind)) = (word(bytes, at), word(bytes, at.saturating_add(4))) {
        let begin = at + 8;
        let end = begin.saturating_add(length as usize);
        let chunk = &bytes[begin..end.min(bytes.len())];
        match kind {
            JSON if json.is_none() => {
                if end > bytes.len() {
                    let rest = chunk.len();
                    return Err(damaged(format!(
                        "the JSON chunk of the GLB should have {length} bytes, and {rest} follow"
                    )));
                }
                json = Some(chunk);
            }
            BIN if binary.is_none() => binary = Some(chunk),
            // Other kinds belong to extensions.
            _ => {}
        }
        // Lengths should be multiples of four; some writers leave the padding out of the length.
        let padded = end.saturating_add(3) & !3;
        let pads = word(bytes, end.saturating_add(4)) != Some(BIN)
            && word(bytes, padded.saturating_add(4)) == Some(BIN);
        at = if pads { padded } else { end };
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
