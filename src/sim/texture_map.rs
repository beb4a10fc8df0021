//! Pictures of the whole texture (masks and area maps), read from PNG files of any origin: the kind of
//! file, its length and the size that its header declares are checked before any pixel is decoded. And fields by such pictures.

use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use image::codecs::png::PngDecoder;
use image::{DynamicImage, Limits};
use rayon::prelude::*;

use super::field::fill_gutters;
use crate::error::{Error, Result};
use crate::mesh::atlas::Atlas;
use crate::mesh::surface::NONE;
use crate::plain_text::Shown as _;
use crate::regular_file;
use crate::scene::parameters::grouped;
use crate::strict::settled;

/// Pictures may always have so many pixels a side; for a larger atlas, as many as it has texels.
const MOST_SIDE: u32 = 8192;
/// RGBA with 16 bits each.
const LARGEST_PIXEL: u64 = 8;
/// Bytes of texts and colour profiles that a PNG file may have in addition.
const OTHER_PARTS: u64 = 16 << 20;

/// Reads a PNG file. `what` is its name in messages, such as `start mask`; `atlas_size` is that of the scene.
pub(super) fn read(path: &Path, what: &str, atlas_size: u32) -> Result<DynamicImage> {
    let bytes = regular_file::read(path, most_bytes(most_side(atlas_size)));
    let bytes = bytes.map_err(Error::io("read", path))?;
    decode(path, what, &bytes, atlas_size)
}

/// Decodes a picture in memory.
pub(super) fn decode(
    path: &Path,
    what: &str,
    bytes: &[u8],
    atlas_size: u32,
) -> Result<DynamicImage> {
    let no_picture = |problem: String| {
        Error::Invalid(format!(
            "{}: the {what} must be a PNG: {problem}",
            path.shown()
        ))
    };
    let most = most_side(atlas_size);
    let (width, height) = declared(bytes).unwrap_or_default();
    if width.max(height) > most {
        let [width, height, most, size] =
            [width, height, most, atlas_size].map(|count| grouped(count.into()));
        return Err(Error::Invalid(format!(
            "{}: the {what} has {width} x {height} pixels, and at most {most} x {most} are read with atlas.size = {size}: \
             scale it down",
            path.shown()
        )));
    }
    if !has_whole_colors(bytes) {
        return Err(no_picture("its palette ends within a colour".to_owned()));
    }
    let mut limits = Limits::default();
    limits.max_alloc = Some(most_bytes(most));
    let decode = || {
        let decoder = PngDecoder::with_limits(Cursor::new(bytes), limits)?;
        DynamicImage::from_decoder(decoder)
    };
    // A second defence against malicious files, as for models.
    match catch_unwind(AssertUnwindSafe(decode)) {
        Ok(picture) => picture.map_err(|error| no_picture(error.to_string())),
        Err(_) => Err(no_picture(
            "the decoder failed on it; write it again with another program".to_owned(),
        )),
    }
}

/// A field by a picture of these sides, one value per texel, gutters filled: an owned texel has the value of the pixel at its centre.
pub(super) fn field_of(
    atlas: &Atlas,
    (width, height): (u32, u32),
    mut value_of: impl FnMut(u32, u32) -> f32,
) -> Vec<f32> {
    let at = |place: u32, side: u32| {
        let pixel = (2 * u64::from(place) + 1) * u64::from(side) / (2 * u64::from(atlas.size));
        (pixel as u32).min(side - 1)
    };
    let mut field = vec![0.0; atlas.owner.len()];
    for (texel, owner) in (0u32..).zip(&atlas.owner) {
        if *owner != NONE {
            let (column, row) = (texel % atlas.pitch, texel / atlas.pitch);
            field[texel as usize] = value_of(at(column, width), at(row, height));
        }
    }
    fill_gutters(&atlas.seams, &mut field);
    field
        .par_iter_mut()
        .for_each(|value| *value = settled(*value));
    field
}

/// The decoder panics if a palette is no whole number of colours.
fn has_whole_colors(bytes: &[u8]) -> bool {
    let mut rest = bytes.get(8..).unwrap_or_default();
    while let Some((length, chunk)) = rest.split_first_chunk() {
        let length = u32::from_be_bytes(*length) as usize;
        if chunk.starts_with(b"PLTE") && !length.is_multiple_of(3) {
            return false;
        }
        // After its kind and its data there is a checksum.
        let end = length.saturating_add(8);
        rest = chunk.get(end..).unwrap_or_default();
    }
    true
}

/// The sides that the header of a PNG declares, which is its first chunk.
fn declared(bytes: &[u8]) -> Option<(u32, u32)> {
    let header = bytes.strip_prefix(b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR")?;
    let (width, rest) = header.split_first_chunk()?;
    let (height, _) = rest.split_first_chunk()?;
    Some((u32::from_be_bytes(*width), u32::from_be_bytes(*height)))
}

fn most_side(atlas_size: u32) -> u32 {
    atlas_size.max(MOST_SIDE)
}

/// Bytes of a picture with `side` pixels per side, in memory and, nearly uncompressed, in its file.
fn most_bytes(side: u32) -> u64 {
    u64::from(side).pow(2) * LARGEST_PIXEL + OTHER_PARTS
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A PNG file of one grey channel whose header declares these sides; it holds no pixels.
    fn declaring(width: u32, height: u32) -> Vec<u8> {
        let mut bytes = b"\x89PNG\r\n\x1a\n".to_vec();
        let mut chunk = |kind: &[u8], data: &[u8]| {
            bytes.extend((data.len() as u32).to_be_bytes());
            let content = [kind, data].concat();
            bytes.extend(&content);
            bytes.extend(crc32fast::hash(&content).to_be_bytes());
        };
        let sides = [width, height].map(u32::to_be_bytes);
        chunk(b"IHDR", &[sides.as_flattened(), &[8, 0, 0, 0, 0]].concat());
        chunk(b"IDAT", &[]);
        chunk(b"IEND", &[]);
        bytes
    }

    /// Without the comparison of the declared sides, these files of 60 bytes allocate up to 16 EiB or are refused by a message
    /// of the decoder that does not say what to do.
    #[test]
    fn a_picture_that_declares_too_many_pixels_is_refused_by_its_header() {
        for (width, height, size, words) in [
            (
                65_535,
                65_535,
                1024,
                "65,535 x 65,535 pixels, and at most 8192 x 8192",
            ),
            (0x7fff_ffff, 1, 1024, "scale it down"),
            (1, 8193, 64, "at most 8192"),
            (
                32_769,
                9,
                32_768,
                "at most 32,768 x 32,768 are read with atlas.size = 32,768",
            ),
            // The size is allowed, and pixels are missing.
            (8192, 8192, 64, "the start mask must be a PNG"),
            (0, 4, 64, "the start mask must be a PNG"),
        ] {
            let bytes = declaring(width, height);
            let error = decode("a.png".as_ref(), "start mask", &bytes, size).unwrap_err();
            let text = error.to_string();
            assert!(
                text.starts_with("a.png: ") && text.contains(words),
                "{text}"
            );
        }
    }

    /// Without the check the decoder panics, as a run of the fuzz target found.
    #[test]
    fn a_palette_that_ends_within_a_color_is_refused() {
        let mut bytes = declaring(8, 2);
        // Of one bit, with a palette.
        bytes[24..26].copy_from_slice(&[1, 3]);
        let end = bytes.len() - 12;
        bytes.splice(end..end, *b"\0\0\0\x08PLTEabcdefghCRC!");
        let error = decode("a.png".as_ref(), "start mask", &bytes, 64).unwrap_err();
        assert!(
            error
                .to_string()
                .contains("its palette ends within a colour"),
            "{error}"
        );
    }

    /// The largest picture that the program writes has 48 bits per pixel; such a map of a large atlas exceeds the decoder's default limit
    /// of 512 MiB.
    #[test]
    fn the_limit_on_memory_has_room_for_the_map_of_every_atlas() {
        for size in [16, 8192, 32_768] {
            assert!(most_bytes(most_side(size)) > u64::from(size).pow(2) * 6);
        }
    }
}
