//! Video: raw frames through a pipe to `ffmpeg`, which encodes them as H.264 in an MP4.

use std::ffi::OsString;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus};
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use image::RgbaImage;

use super::OutputError;
use super::encoder::{Encoder, Patience, Stop};
use crate::whole_file::WholeFile;

/// The longest side of a picture that the encoder accepts.
pub(super) const LARGEST_SIDE: u32 = 16384;

/// How long to wait for an encoder to exit that takes no more frames.
const PATIENCE: Duration = Duration::from_secs(2);

/// The time limit for encoding a small picture, including loading the encoder from a slow disk.
const PATIENCE_AT_FIRST: Duration = Duration::from_secs(20);

/// A video that is being written.
#[derive(Debug)]
pub(super) struct Video {
    encoder: Encoder,
    file: WholeFile,
    frames: u64,
    /// The encoder.
    program: PathBuf,
    patience: Patience,
}

impl Video {
    pub(super) fn create(
        path: &Path,
        size: (u32, u32),
        frames_per_second: f64,
        program: &Path,
    ) -> Result<Self, OutputError> {
        let file = WholeFile::create(path).map_err(OutputError::file(path))?;
        let mut command = Command::new(program);
        command.args(input_arguments(size, frames_per_second));
        command.args(output_arguments(size));
        command.arg(in_files(file.hidden_path()));

        let encoder = Encoder::start(command).map_err(|source| OutputError::NoEncoder {
            path: path.to_owned(),
            program: program.to_owned(),
            source,
        })?;
        Ok(Self {
            encoder,
            file,
            frames: 0,
            program: program.to_owned(),
            patience: Patience::of(size),
        })
    }

    pub(super) fn frame(&mut self, image: &RgbaImage) -> Result<(), OutputError> {
        if let Err(stop) = self.encoder.feed(image.as_raw(), &self.patience) {
            let ended = match stop {
                Stop::Ended => self.encoder.wait_at_most(PATIENCE).ok_or(Stop::Ended),
                idle @ Stop::Idle(_) => Err(idle),
            };
            return Err(self.failure(ended));
        }
        self.frames += 1;
        Ok(())
    }

    /// Waits until all frames are encoded.
    pub(super) fn end(&mut self) -> Result<(), OutputError> {
        let ended = (self.encoder).wait(self.file.hidden_path(), &self.patience);
        // On a full disk ffmpeg prints an error, but its exit status is success.
        let is_whole = self.is_whole_in(self.file.hidden_path());
        if !ended.as_ref().is_ok_and(ExitStatus::success) || !is_whole {
            return Err(self.failure(ended));
        }
        Ok(())
    }

    /// Gives the video its name, with its index at the beginning, as players want it; or with an index in parts, which they also accept, if
    /// there is no room for a second copy.
    pub(super) fn finish(self) -> Result<PathBuf, OutputError> {
        let path = self.file.path().to_owned();
        let file = self.with_index_in_front().unwrap_or(self.file);
        file.finish().map_err(OutputError::file(&path))?;
        Ok(path)
    }

    fn with_index_in_front(&self) -> Option<WholeFile> {
        let file = WholeFile::create(self.file.path()).ok()?;
        let mut command = Command::new(&self.program);
        command.args("-hide_banner -nostdin -loglevel error -y -i".split(' '));
        command.arg(in_files(self.file.hidden_path()));
        command.args("-c copy -movflags +faststart -f mp4".split(' '));
        command.arg(in_files(file.hidden_path()));
        let mut encoder = Encoder::start(command).ok()?;
        let status = encoder.wait(file.hidden_path(), &self.patience).ok()?;
        (status.success() && self.is_whole_in(file.hidden_path())).then_some(file)
    }

    /// Does a file have every frame?
    fn is_whole_in(&self, file: &Path) -> bool {
        Whole::of(file).is_ok_and(|whole| whole.is_all && whole.frames == self.frames)
    }

    /// After a failure: keeps the whole frames, and returns their number; `None` if there are none.
    pub(super) fn cut(mut self) -> Option<(PathBuf, u64)> {
        self.encoder.end();
        let whole = Whole::of(self.file.hidden_path()).ok()?;
        if whole.frames == 0 {
            return None;
        }
        self.file.cut(whole.bytes).ok()?;
        Some((self.file.finish_beside().ok()?, whole.frames))
    }

    /// Once the flag is set, ends an encoder without progress soon.
    pub(super) fn set_interrupt(&mut self, flag: &'static AtomicBool) {
        self.patience.interrupt = Some(flag);
    }

    /// How long an encoder may make no progress.
    #[cfg(test)]
    pub(super) fn patience(&mut self) -> &mut Patience {
        &mut self.patience
    }

    fn failure(&mut self, ended: Result<ExitStatus, Stop>) -> OutputError {
        OutputError::Encoder {
            path: self.file.path().to_owned(),
            frames: self.frames,
            status: match ended {
                Ok(status) if status.success() => "the file is not whole".to_owned(),
                Ok(status) => status.to_string(),
                Err(Stop::Ended) => "it did not answer".to_owned(),
                Err(Stop::Idle(time)) => {
                    format!(
                        "it did nothing for {:.0} s and was ended",
                        time.as_secs_f64()
                    )
                }
            },
            last_words: self.encoder.last_words(),
        }
    }
}

/// Encodes a small picture with the options of videos and discards it, so that a problem of the encoder is found before a run.
///
/// # Errors
/// If it does not start or fails; with the last lines of its output.
pub(super) fn try_encoder(program: &Path) -> io::Result<()> {
    // Odd sides need more filters than even ones.
    let size = (17, 17);
    let mut command = Command::new(program);
    command.args(input_arguments(size, 30.0));
    command.args(output_arguments(size));
    // Standard output, which is ignored.
    command.arg("pipe:1");
    let mut encoder = Encoder::start(command)?;
    // A failed write means that the encoder has ended; its status is the error.
    let _ = encoder.feed(&[0; 4 * 17 * 17], &Patience::of(size));
    match encoder.wait_at_most(PATIENCE_AT_FIRST) {
        Some(status) if status.success() => Ok(()),
        status => {
            let ended = status.map_or("it did not answer".to_owned(), |s| s.to_string());
            let words = encoder.last_words();
            let words = words.lines().map(str::trim).find(|line| !line.is_empty());
            Err(io::Error::other(words.map_or(ended, str::to_owned)))
        }
    }
}

/// The part of an MP4 that is complete: a chain of boxes (ISO/IEC 14496-12), with the index, which players need, or with an
/// index for each part.
#[derive(Debug, Default, PartialEq)]
struct Whole {
    /// The last box is whole, too, and there is an index. Further parts may be missing.
    is_all: bool,
    /// Bytes up to the end of the last whole part.
    bytes: u64,
    /// Frames of whole parts. A video with its index in front is one part.
    frames: u64,
}

impl Whole {
    fn of(path: &Path) -> io::Result<Self> {
        let mut file = File::open(path)?;
        let end = file.metadata()?.len();
        let mut whole = Self::default();
        let (mut at, mut has_index) = (0, false);
        // The frames of the index or part whose pictures come next.
        let mut frames = 0;
        while at < end {
            let mut head = [0; 16];
            file.seek(SeekFrom::Start(at))?;
            // Fewer bytes than a head are no box.
            if file.read_exact(&mut head[..8]).is_err() {
                return Ok(whole);
            }
            let [a, b, c, d, name @ ..] = *head.first_chunk::<8>().expect("it is longer");
            let size = u32::from_be_bytes([a, b, c, d]);
            let next = match size {
                // To the end of the file.
                0 => end,
                1 => {
                    if file.read_exact(&mut head[8..]).is_err() {
                        return Ok(whole);
                    }
                    let [.., a, b, c, d, e, f, g, h] = head;
                    at.saturating_add(u64::from_be_bytes([a, b, c, d, e, f, g, h]).max(16))
                }
                size => at + u64::from(size.max(8)),
            };
            if next > end {
                return Ok(whole);
            }
            match &name {
                b"moov" | b"moof" => {
                    has_index |= name == *b"moov";
                    let mut part = vec![0; usize::try_from(next - at).unwrap_or(usize::MAX) - 8];
                    file.read_exact(&mut part)?;
                    frames = frames_of(&part);
                }
                b"mdat" if has_index && frames > 0 => {
                    whole.frames += std::mem::take(&mut frames);
                    whole.bytes = next;
                }
                _ => {}
            }
            at = next;
        }
        whole.is_all = has_index;
        Ok(whole)
    }
}

/// The frames of one part: of each run of samples (`trun`) of each track (`traf`), in the boxes of its index; or those that
/// an index of the whole video has itself, in the table of the samples' sizes (`stsz`) of each track (`trak`).
fn frames_of(mut boxes: &[u8]) -> u64 {
    let mut frames = 0;
    while let Some((head, _)) = boxes.split_first_chunk::<8>() {
        let size = u32::from_be_bytes([head[0], head[1], head[2], head[3]]) as usize;
        let Some(content) = boxes.get(8..size) else {
            break;
        };
        frames += match &head[4..] {
            b"traf" | b"trak" | b"mdia" | b"minf" | b"stbl" => frames_of(content),
            // Version and flags, then the count.
            b"trun" => number_at(content, 4),
            // Version and flags, the size that all have, then the count.
            b"stsz" => number_at(content, 8),
            _ => 0,
        };
        boxes = &boxes[size..];
    }
    frames
}

/// `None` if there are too few bytes.
fn number_at(bytes: &[u8], at: usize) -> u64 {
    let number = bytes.get(at..).and_then(|rest| rest.first_chunk::<4>());
    number.map_or(0, |&number| u32::from_be_bytes(number).into())
}

/// A path for ffmpeg: without the prefix, a colon in it would be taken for a protocol.
fn in_files(path: &Path) -> OsString {
    let mut target = OsString::from("file:");
    target.push(path);
    target
}

fn input_arguments((width, height): (u32, u32), frames_per_second: f64) -> Vec<String> {
    let text = "-hide_banner -nostdin -loglevel error -y -f rawvideo -pixel_format rgba";
    let mut arguments: Vec<String> = text.split(' ').map(str::to_owned).collect();
    arguments.push("-video_size".to_owned());
    arguments.push(format!("{width}x{height}"));
    arguments.push("-framerate".to_owned());
    arguments.push(frames_per_second.to_string());
    arguments.push("-i".to_owned());
    arguments.push("pipe:0".to_owned());
    arguments
}

/// H.264 for all players and browsers: 4:2:0 and tagged BT.709. It is written in parts of half a second, each with its index, so that a
/// file that is cut short can be played.
fn output_arguments((width, height): (u32, u32)) -> Vec<String> {
    // 4:2:0 needs even sides: an odd one repeats its last pixel.
    let (right, bottom) = (width % 2, height % 2);
    let even = match (right, bottom) {
        (0, 0) => String::new(),
        _ => format!(
            "pad=iw+{right}:ih+{bottom},fillborders=right={right}:bottom={bottom}:mode=smear,"
        ),
    };
    let filter = format!(
        "{even}scale=out_color_matrix=bt709:out_range=tv:flags=lanczos+accurate_rnd,format=yuv420p"
    );
    let text = "-an -c:v libx264 -preset fast -crf 18 \
                -colorspace bt709 -color_primaries bt709 -color_trc bt709 -color_range tv \
                -movflags +empty_moov+delay_moov+default_base_moof -frag_duration 500000 -f mp4";
    let mut arguments = vec!["-vf".to_owned(), filter];
    arguments.extend(text.split_whitespace().map(str::to_owned));
    arguments
}
