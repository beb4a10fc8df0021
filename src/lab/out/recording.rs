//! A video of what the window shows, as it shows it: copies of its pictures go through a ring, and another thread writes
//! them. The simulation waits for neither.

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use myxo::Result;
use myxo::gpu::{Context, Format, Image, ReadbackImage, Recorder};
use myxo::render::output::{Output, Written};

use super::encoder::{Encoder, Frame};
use super::names::Reserved;

/// Pictures that may be on their way from the device.
const UNDER_WAY: usize = 4;

/// What is told of a recording.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Recorded {
    /// Its length.
    pub seconds: f64,
    /// Frames that it has by now.
    pub frames: u64,
    /// Pictures for which there was no time; those before them are shown in their places.
    pub dropped: u64,
    /// It was stopped, and what is left is being written.
    pub is_ending: bool,
}

/// A recording under way.
pub struct Recording {
    /// None once it was stopped.
    ring: Option<ReadbackImage>,
    encoder: Encoder,
    format: Format,
    fps: u32,
    begun: Instant,
    /// The next picture's place in the film.
    next: u64,
    dropped: u64,
    /// Frames, once it was stopped.
    end: Option<u64>,
}

impl Recording {
    /// Begins; pictures are of this format.
    pub fn begin(
        ctx: &Arc<Context>,
        output: Output,
        size: [u32; 2],
        name: Reserved,
        fps: u32,
        format: Format,
    ) -> Self {
        Self {
            ring: Some(ReadbackImage::new(ctx, "recording", UNDER_WAY)),
            encoder: Encoder::begin(output, size, name),
            format,
            fps,
            begun: Instant::now(),
            next: 0,
            dropped: 0,
            end: None,
        }
    }

    fn place(&self) -> u64 {
        (self.begun.elapsed().as_secs_f64() * f64::from(self.fps)) as u64
    }

    /// Takes the picture that is shown now, if one is due.
    pub fn look(&mut self, rec: &mut Recorder, picture: &Image) -> Result<()> {
        self.collect();
        let place = self.place();
        let Some(ring) = &mut self.ring else {
            return Ok(());
        };
        if self.next > 0 && place < self.next {
            return Ok(());
        }
        // The first picture is there from the beginning.
        let number = if self.next == 0 { 0 } else { place };
        if !ring.record(rec, picture, number)? {
            self.dropped += 1;
        }
        self.next = place + 1;
        Ok(())
    }

    /// Hands over what has arrived.
    fn collect(&mut self) {
        let Some(ring) = &mut self.ring else {
            return;
        };
        while let Some((number, size, pixels)) = ring.poll() {
            let frame = Frame {
                number,
                size,
                pixels,
                is_blue_first: self.format == Format::Bgra8Srgb,
            };
            if !self.encoder.push(frame) {
                self.dropped += 1;
            }
        }
    }

    /// Ends it with the pictures that have arrived: all of them, where all that was recorded has been submitted and waited
    /// for. It has nothing on the device any more, and the file is whole some time later.
    pub fn stop(&mut self) {
        self.collect();
        self.ring = None;
        let end = self.place().max(self.next);
        self.end = Some(end);
        self.encoder.end(end);
    }

    /// Was it stopped?
    pub fn is_ending(&self) -> bool {
        self.end.is_some()
    }

    /// For the interface.
    pub fn told(&self) -> Recorded {
        let frames = self.end.unwrap_or(self.next);
        Recorded {
            seconds: match self.end {
                Some(end) => end as f64 / f64::from(self.fps),
                None => self.begun.elapsed().as_secs_f64(),
            },
            frames,
            dropped: self.dropped,
            is_ending: self.end.is_some(),
        }
    }

    /// What came of it, once, when it has ended: by itself only if something is wrong.
    pub fn take(&mut self) -> Option<Result<Written>> {
        self.encoder.take()
    }

    /// The file, or the folder of files, that it becomes.
    pub fn path(&self) -> &Path {
        self.encoder.path()
    }

    /// Waits for the whole file.
    pub fn wait(self) -> Option<Result<Written>> {
        self.encoder.wait()
    }
}
