//! Animated GIF: 255 colours chosen for each frame, and one for unchanged pixels.

use std::collections::HashMap;
use std::fmt;
use std::io::{self, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

use color_quant::NeuQuant;
use gif::{DisposalMethod, Encoder, EncodingError, Frame, Repeat};
use image::RgbaImage;

use super::OutputError;
use crate::whole_file::WholeFile;

/// The colour index of a pixel that does not change from the frame before.
const UNCHANGED: u8 = 255;

/// Viewers slow down frames that are shorter than this; in hundredths of a second.
const SHORTEST_FRAME: u64 = 2;

/// The end of every GIF. It is written after every frame and overwritten by the next one, so that its space is already taken when the disk
/// gets full.
const TRAILER: [u8; 1] = [0x3b];

/// A GIF that is being written.
pub(super) struct Gif {
    file: WholeFile,
    /// Encodes into memory, so that if a frame does not fit on the disk, only the end of that frame is missing.
    encoder: Encoder<Vec<u8>>,
    frames_per_second: f64,
    frames: u64,
    /// Bytes of the file that are whole, up to its end, and how many frames they show.
    whole: (u64, u64),
    /// The last frame, and when it begins. Its length is known when the next one begins.
    waiting: Option<(Frame<'static>, u64)>,
    shown: Option<RgbaImage>,
}

impl fmt::Debug for Gif {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Gif")
            .field("path", &self.file.path())
            .finish_non_exhaustive()
    }
}

impl Gif {
    pub(super) fn create(
        path: &Path,
        (width, height): (u32, u32),
        frames_per_second: f64,
    ) -> Result<Self, OutputError> {
        let begin = || {
            let file = WholeFile::create(path)?;
            // `Output` has checked the size.
            let mut encoder =
                Encoder::new(Vec::new(), width as u16, height as u16, &[]).map_err(io_error)?;
            encoder.set_repeat(Repeat::Infinite).map_err(io_error)?;
            Ok((file, encoder))
        };
        let (file, encoder) = begin().map_err(OutputError::file(path))?;
        Ok(Self {
            file,
            encoder,
            frames_per_second,
            frames: 0,
            whole: (0, 0),
            waiting: None,
            shown: None,
        })
    }

    pub(super) fn frame(&mut self, image: &RgbaImage) -> Result<(), OutputError> {
        let (begins, before) = (self.now(), self.frames);
        self.frames += 1;
        if let Some((_, before)) = self.waiting
            && begins < before + SHORTEST_FRAME
        {
            return Ok(());
        }
        let Some(frame) = indexed_frame(image, self.shown.as_ref()) else {
            return Ok(());
        };
        self.write_waiting(begins, before)?;
        self.waiting = Some((frame, begins));
        self.shown = Some(image.clone());
        Ok(())
    }

    /// Writes the pending frame.
    pub(super) fn end(&mut self) -> Result<(), OutputError> {
        self.write_waiting(self.now(), self.frames)
    }

    pub(super) fn finish(self) -> Result<PathBuf, OutputError> {
        let path = self.file.path().to_owned();
        self.file.finish().map_err(OutputError::file(&path))?;
        Ok(path)
    }

    /// After a failure: keeps the whole frames, and returns their number; `None` if there are none.
    pub(super) fn cut(mut self) -> Option<(PathBuf, u64)> {
        let (bytes, frames) = self.whole;
        if frames == 0 {
            return None;
        }
        // A frame that was cut short may have overwritten the end.
        self.file.cut(bytes + TRAILER.len() as u64).ok()?;
        self.write(&TRAILER).ok()?;
        Some((self.file.finish_beside().ok()?, frames))
    }

    /// When the next frame begins, in hundredths of a second, the unit of GIF.
    fn now(&self) -> u64 {
        (self.frames as f64 * 100.0 / self.frames_per_second).round() as u64
    }

    /// Writes the pending frame. With it, the file shows so many frames.
    fn write_waiting(&mut self, until: u64, frames: u64) -> Result<(), OutputError> {
        let Some((mut frame, since)) = self.waiting.take() else {
            return Ok(());
        };
        let duration = (until - since).max(SHORTEST_FRAME);
        frame.delay = u16::try_from(duration).unwrap_or(u16::MAX);
        let encoded = self.encoder.write_frame(&frame).map_err(io_error);
        encoded.map_err(OutputError::file(self.file.path()))?;
        let mut bytes = std::mem::take(self.encoder.get_mut());
        let whole = self.whole.0 + bytes.len() as u64;
        bytes.extend(TRAILER);
        self.write(&bytes)?;
        self.whole = (whole, frames);
        Ok(())
    }

    /// A writer that fails in the middle of a frame, as on a full disk.
    #[cfg(test)]
    pub(super) fn write_half(&mut self) {
        self.write(b"half a frame").unwrap();
    }

    /// After the whole frames.
    fn write(&mut self, bytes: &[u8]) -> Result<(), OutputError> {
        let found = self.file.seek(SeekFrom::Start(self.whole.0));
        let written = found.and_then(|_| self.file.write_all(bytes));
        written.map_err(OutputError::file(self.file.path()))
    }
}

/// The frame in colour indices; nothing when it is the same as the one `before`.
fn indexed_frame(image: &RgbaImage, before: Option<&RgbaImage>) -> Option<Frame<'static>> {
    let (width, height) = image.dimensions();
    let pixels = || image.as_raw().as_chunks::<4>().0.iter();
    let changed: Vec<bool> = match before {
        Some(before) => {
            let before = before.as_raw().as_chunks::<4>().0;
            let rgb = |pixel: &[u8; 4]| [pixel[0], pixel[1], pixel[2]];
            pixels()
                .zip(before)
                .map(|(a, b)| rgb(a) != rgb(b))
                .collect()
        }
        None => vec![true; width as usize * height as usize],
    };
    let new_pixels = || {
        pixels()
            .zip(&changed)
            .filter_map(|(pixel, &new)| new.then_some(pixel))
    };
    new_pixels().next()?;

    let mut palette = Palette::of(new_pixels());
    let indices: Vec<u8> = pixels()
        .zip(&changed)
        .map(|(pixel, &new)| {
            if new {
                palette.index_of(pixel)
            } else {
                UNCHANGED
            }
        })
        .collect();
    Some(Frame {
        width: width as u16,
        height: height as u16,
        dispose: DisposalMethod::Keep,
        transparent: Some(UNCHANGED),
        palette: Some(palette.into_bytes()),
        buffer: indices.into(),
        ..Frame::default()
    })
}

/// At most 255 colours that stand for all colours of a frame.
enum Palette {
    /// A picture of few colours keeps them exactly.
    Exact(HashMap<[u8; 3], u8>),
    /// Many colours: the nearest one for each cell of 4 x 4 x 4 colours, searched once.
    Nearest {
        network: NeuQuant,
        cells: Vec<Option<u8>>,
    },
}

impl Palette {
    fn of<'a>(pixels: impl Iterator<Item = &'a [u8; 4]> + Clone) -> Self {
        let mut exact = HashMap::new();
        for &[red, green, blue, _] in pixels.clone() {
            let next = exact.len();
            exact.entry([red, green, blue]).or_insert(next as u8);
            if exact.len() > usize::from(UNCHANGED) {
                let opaque: Vec<u8> = pixels.flat_map(|&[r, g, b, _]| [r, g, b, 255]).collect();
                // Every tenth pixel is enough to train the network, except in small pictures.
                let stride = if opaque.len() > 1 << 18 { 10 } else { 1 };
                return Self::Nearest {
                    network: NeuQuant::new(stride, usize::from(UNCHANGED), &opaque),
                    cells: vec![None; 1 << 18],
                };
            }
        }
        Self::Exact(exact)
    }

    fn index_of(&mut self, &[red, green, blue, _]: &[u8; 4]) -> u8 {
        match self {
            Self::Exact(indices) => indices[&[red, green, blue]],
            Self::Nearest { network, cells } => {
                let cell = [red, green, blue].map(|channel| usize::from(channel >> 2));
                *cells[cell[0] << 12 | cell[1] << 6 | cell[2]].get_or_insert_with(|| {
                    let middle = cell.map(|channel| (channel << 2 | 2) as u8);
                    network.index_of(&[middle[0], middle[1], middle[2], 255]) as u8
                })
            }
        }
    }

    /// The colours in the order of their indices, up to and with `UNCHANGED`, as bytes.
    fn into_bytes(self) -> Vec<u8> {
        let mut bytes = match self {
            Self::Nearest { network, .. } => network.color_map_rgb(),
            Self::Exact(indices) => {
                let mut colours: Vec<_> = indices.into_iter().collect();
                colours.sort_unstable_by_key(|&(_, index)| index);
                colours.into_iter().flat_map(|(colour, _)| colour).collect()
            }
        };
        bytes.resize(3 * (usize::from(UNCHANGED) + 1), 0);
        bytes
    }
}

fn io_error(error: EncodingError) -> io::Error {
    match error {
        EncodingError::Io(error) => error,
        other => io::Error::other(other),
    }
}
