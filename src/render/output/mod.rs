//! Files of pictures: a PNG, a sequence of PNGs, a GIF or a video, by the file's name.
//!
//! **Invariant:** no half-written file ever has a final name. A file is written under a temporary name in its own folder and renamed when
//! it is whole; unfinished files are removed.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::sync::atomic::AtomicBool;
use std::{fmt, io};

use image::RgbaImage;

use crate::error::advice;
use crate::plain_text::Shown as _;

mod encoder;
mod gif;
mod name;
mod png;
mod video;

pub use png::write_png;

use name::Kind;

/// The program that makes videos.
const ENCODER: &str = "ffmpeg";

/// An output that is being written, frame by frame.
///
/// ```
/// use myxo::render::output::Output;
///
/// let folder = tempfile::tempdir()?;
/// let mut output = Output::create(&folder.path().join("frames/%03d.png"), (4, 3), 30.0)?;
/// for brightness in [0, 128, 255] {
///     output.frame(&image::RgbaImage::from_pixel(4, 3, image::Rgba([brightness, 0, 0, 255])))?;
/// }
/// let written = output.finish()?;
/// assert_eq!(written.files[2], folder.path().join("frames/002.png"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Output {
    path: PathBuf,
    size: (u32, u32),
    frames: u64,
    writer: Writer,
}

#[derive(Debug)]
enum Writer {
    Picture(png::Picture),
    Sequence(png::Sequence),
    Gif(Box<gif::Gif>),
    Video(video::Video),
}

impl Output {
    /// Begins an output; its name decides the format.
    ///
    /// | name | content |
    /// | --- | --- |
    /// | `NAME.png` | the last frame |
    /// | `NAME_%05d.png`, `FOLDER/` | every frame, numbered from 0 |
    /// | `NAME.gif` | every frame, at most 50 a second |
    /// | `NAME.mp4` | every frame, as H.264 by the program `ffmpeg` |
    ///
    /// `size` is in pixels, width first; `frames_per_second` is the speed at which it will be played.
    ///
    /// # Errors
    /// Errors that do not depend on frames: an unknown ending, a folder that cannot be created or written, a size that the format cannot
    /// hold, no `ffmpeg` with libx264.
    pub fn create(
        path: &Path,
        size: (u32, u32),
        frames_per_second: f64,
    ) -> Result<Self, OutputError> {
        // This does not change while the program runs.
        static ENCODES: OnceLock<()> = OnceLock::new();
        let encoder = Path::new(ENCODER);
        let kind = checked(path, size, frames_per_second)?;
        if kind == Kind::Video && ENCODES.get().is_none() {
            video::try_encoder(encoder).map_err(|source| OutputError::NoEncoder {
                path: path.to_owned(),
                program: encoder.to_owned(),
                source,
            })?;
            let _ = ENCODES.set(());
        }
        Self::create_with_encoder(path, size, frames_per_second, encoder)
    }

    /// Checks that videos can be written: encodes a small picture and discards it.
    ///
    /// # Errors
    /// The encoder's problem: the system's error if it does not start, or its own.
    pub fn try_videos() -> io::Result<()> {
        video::try_encoder(Path::new(ENCODER))
    }

    /// As [`create`](Self::create), with another program in the place of `ffmpeg`, without checking it.
    fn create_with_encoder(
        path: &Path,
        size: (u32, u32),
        frames_per_second: f64,
        encoder: &Path,
    ) -> Result<Self, OutputError> {
        let writer = match checked(path, size, frames_per_second)? {
            Kind::Picture => Writer::Picture(png::Picture::create(path)?),
            Kind::Sequence(numbering) => Writer::Sequence(png::Sequence::create(numbering)?),
            Kind::Gif => Writer::Gif(Box::new(gif::Gif::create(path, size, frames_per_second)?)),
            Kind::Video => Writer::Video(video::Video::create(
                path,
                size,
                frames_per_second,
                encoder,
            )?),
        };
        Ok(Self {
            path: path.to_owned(),
            size,
            frames: 0,
            writer,
        })
    }

    /// Is each frame kept? Otherwise only the last one is, and the others need not be drawn.
    pub fn wants_every_frame(&self) -> bool {
        !matches!(self.writer, Writer::Picture(_))
    }

    /// Is transparency kept?
    pub fn keeps_alpha(&self) -> bool {
        matches!(self.writer, Writer::Picture(_) | Writer::Sequence(_))
    }

    /// Once the flag is set, an encoder without progress gets less time, because the user wants to quit.
    pub fn set_interrupt(&mut self, flag: &'static AtomicBool) {
        if let Writer::Video(video) = &mut self.writer {
            video.set_interrupt(flag);
        }
    }

    /// Ends all running encoders, before the program exits at once: otherwise one that hangs would outlive it.
    pub fn end_encoders() {
        encoder::end_all();
    }

    /// The requested name.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The numbered files that are there already and that the first `frames` frames will replace; none if it is one file.
    #[must_use]
    pub fn existing(&self, frames: u64) -> Vec<PathBuf> {
        match &self.writer {
            Writer::Sequence(sequence) => sequence.existing(frames),
            Writer::Picture(_) | Writer::Gif(_) | Writer::Video(_) => Vec::new(),
        }
    }

    /// How many frames have been taken without an error.
    pub fn frames(&self) -> u64 {
        self.frames
    }

    /// Takes the next frame: sRGB, the first row on top. A GIF and a video ignore its alpha.
    ///
    /// # Errors
    /// When the disk is full, or the encoder stops. The output takes no more frames then; [`cut`](Self::cut) keeps the whole frames, and
    /// dropping it keeps only those of a sequence.
    ///
    /// # Panics
    /// When the frame is of another size than the output.
    pub fn frame(&mut self, image: &RgbaImage) -> Result<(), OutputError> {
        assert_eq!(
            image.dimensions(),
            self.size,
            "a frame of {} has another size",
            self.path.shown()
        );
        match &mut self.writer {
            Writer::Picture(picture) => picture.frame(image)?,
            Writer::Sequence(sequence) => sequence.frame(image)?,
            Writer::Gif(gif) => gif.frame(image)?,
            Writer::Video(video) => video.frame(image)?,
        }
        self.frames += 1;
        Ok(())
    }

    /// Ends the output and gives the files their names. Without any frame there is no file.
    ///
    /// Call it for an interrupted run, too: the frames so far become a whole file.
    ///
    /// # Errors
    /// When the disk is full, or the encoder fails; the error says which part of the file is kept, if any.
    pub fn finish(mut self) -> Result<Written, OutputError> {
        if self.frames > 0 {
            let ended = match &mut self.writer {
                Writer::Picture(_) | Writer::Sequence(_) => Ok(()),
                Writer::Gif(gif) => gif.end(),
                Writer::Video(video) => video.end(),
            };
            if let Err(error) = ended {
                return Err(self.cut(error));
            }
        }
        let files = if self.frames == 0 {
            Vec::new()
        } else {
            match self.writer {
                Writer::Picture(picture) => vec![picture.finish()?],
                Writer::Sequence(sequence) => sequence.finish(),
                Writer::Gif(gif) => vec![gif.finish()?],
                Writer::Video(video) => vec![video.finish()?],
            }
        };
        Ok(Written {
            files,
            frames: self.frames,
        })
    }
}

impl Output {
    /// After an error, keeps the whole frames under the requested name: a GIF and a video end with their last whole
    /// frame. The error then says how many frames there are.
    #[must_use]
    pub fn cut(self, error: OutputError) -> OutputError {
        let kept = match self.writer {
            Writer::Picture(_) => None,
            Writer::Sequence(sequence) => {
                let files = sequence.finish();
                let frames = files.len() as u64;
                (frames > 0).then_some((files, frames))
            }
            Writer::Gif(gif) => gif.cut().map(|(file, frames)| (vec![file], frames)),
            Writer::Video(video) => video.cut().map(|(file, frames)| (vec![file], frames)),
        };
        match kept {
            Some((files, frames)) => OutputError::Cut {
                source: Box::new(error),
                kept: Written { files, frames },
            },
            None => error,
        }
    }
}

/// The result of a finished output.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Written {
    /// The files, in the order of their frames; none if there was no frame.
    pub files: Vec<PathBuf>,
    /// How many frames were given.
    pub frames: u64,
}

impl fmt::Display for Written {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sizes = self.files.iter().map(std::fs::metadata);
        let bytes: u64 = sizes.map(|file| file.map_or(0, |file| file.len())).sum();
        let size = match bytes {
            0..1_000_000 => format!("{} kB", bytes.div_ceil(1000)),
            _ => format!("{:.1} MB", bytes as f64 / 1e6),
        };
        match self.files.as_slice() {
            [] => write!(f, "no file, because there was no frame"),
            [file] => match self.frames {
                1 => write!(f, "{} ({size})", file.shown()),
                _ if is_png(file) => write!(f, "{} ({size})", file.shown()),
                frames => write!(f, "{} ({frames} frames, {size})", file.shown()),
            },
            [first, .., last] => write!(
                f,
                "{} ... {} ({} files, {size})",
                first.shown(),
                Path::new(last.file_name().unwrap_or_default()).shown(),
                self.files.len()
            ),
        }
    }
}

/// The kind of output by its name, if its format allows this size and this speed.
fn checked(path: &Path, size: (u32, u32), frames_per_second: f64) -> Result<Kind, OutputError> {
    let kind = Kind::of(path).ok_or_else(|| OutputError::Name(path.to_owned()))?;
    let largest = match kind {
        Kind::Gif => u32::from(u16::MAX),
        Kind::Video => video::LARGEST_SIDE,
        Kind::Picture | Kind::Sequence(_) => i32::MAX as u32,
    };
    let (width, height) = size;
    if !(1..=largest).contains(&width) || !(1..=largest).contains(&height) {
        return Err(OutputError::Size {
            path: path.to_owned(),
            width,
            height,
            largest,
        });
    }
    if !(frames_per_second > 0.0 && frames_per_second <= 1000.0) {
        return Err(OutputError::FrameRate(frames_per_second));
    }
    Ok(kind)
}

fn is_png(path: &Path) -> bool {
    path.extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("png"))
}

/// Why an output cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// The name has no known ending.
    #[error(
        "{path}: unknown output format; call it NAME.png (the last frame), NAME_%05d.png or \
         FOLDER/ (every frame), NAME.gif or NAME.mp4",
        path = .0.shown()
    )]
    Name(PathBuf),
    /// The file, or the folder for it, cannot be written.
    #[error("cannot write {path}: {source}{}", advice(source), path = path.shown())]
    File {
        /// The output file.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// The format does not allow this size.
    #[error(
        "{path}: a picture of {width} x {height} pixels cannot be written; \
         each side must be 1 to {largest}",
        path = path.shown()
    )]
    Size {
        /// The output file.
        path: PathBuf,
        /// In pixels.
        width: u32,
        /// In pixels.
        height: u32,
        /// The format's longest side, in pixels.
        largest: u32,
    },
    /// The format does not allow this speed.
    #[error("{0} frames a second cannot be played; use a number above 0, up to 1000")]
    FrameRate(f64),
    /// The encoder is missing or cannot encode H.264.
    #[error(
        "cannot write {path}: videos need the program `{program}` with the encoder libx264, and that does not work here \
         ({source}); install the package ffmpeg (Debian, Ubuntu: apt-get install ffmpeg), \
         or write {sequence} or {gif} instead",
        path = path.shown(), program = program.shown(),
        sequence = path.with_extension("").shown().into_owned() + "_%05d.png",
        gif = path.with_extension("gif").shown()
    )]
    NoEncoder {
        /// The video file.
        path: PathBuf,
        /// The encoder's name.
        program: PathBuf,
        /// The system's error, or the encoder's.
        source: io::Error,
    },
    /// The end is missing.
    #[error("{source}; everything before it is complete: {kept}")]
    Cut {
        /// Why it could not be written.
        source: Box<OutputError>,
        /// The part that was written.
        kept: Written,
    },
    /// The encoder has failed.
    #[error(
        "cannot write {path}: the video encoder stopped after {frames} frames ({status}){}",
        if last_words.is_empty() { String::new() } else { format!(":\n{last_words}") },
        path = path.shown()
    )]
    Encoder {
        /// The video file.
        path: PathBuf,
        /// How many frames it had taken.
        frames: u64,
        /// How it ended.
        status: String,
        /// The last lines of its output.
        last_words: String,
    },
}

impl OutputError {
    /// For `map_err`: the file that an I/O error is about.
    fn file(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::File { path, source }
    }
}

#[cfg(test)]
mod failures;
#[cfg(test)]
mod tests;
