//! A video of what the window shows, as it shows it: copies of its pictures go through a ring, and another thread writes
//! them. The simulation waits for neither.

use std::collections::VecDeque;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use myxo::Result;
use myxo::gpu::{Context, Format, Image, ReadbackImage, Recorder};
use myxo::render::output::{Output, Written};

use crate::lab::export::encoder::{Encoder, Frame};
use crate::lab::facts::Recorded;
use crate::lab::names::Reserved;

/// Pictures that may be on their way from the device.
const UNDER_WAY: usize = 4;

/// Counts the pictures of a recording that differ from the one before.
#[derive(Debug, Default)]
struct Different {
    /// The picture that was copied last.
    last: Option<u64>,
    /// The places of those that are on their way from the device.
    under_way: VecDeque<u64>,
    count: u64,
}

impl Different {
    /// A picture is on its way to its place.
    fn copied(&mut self, place: u64, picture: u64) {
        if self.last.replace(picture) != Some(picture) {
            self.under_way.push_back(place);
        }
    }

    /// The picture of a place is there, and is written or not.
    fn arrived(&mut self, place: u64, is_written: bool) {
        if self
            .under_way
            .pop_front_if(|first| *first <= place)
            .is_none()
        {
            return;
        }
        if is_written {
            self.count += 1;
        } else if self.under_way.is_empty() {
            // It counts as another picture when it is shown again.
            self.last = None;
        }
    }
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
    different: Different,
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
            different: Different::default(),
            end: None,
        }
    }

    fn place(&self) -> u64 {
        (self.begun.elapsed().as_secs_f64() * f64::from(self.fps)) as u64
    }

    /// Takes the picture that is shown now, if one is due; `drawn` is another number for another picture.
    pub fn look(&mut self, rec: &mut Recorder, picture: &Image, drawn: u64) -> Result<()> {
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
        if ring.record(rec, picture, number)? {
            self.different.copied(number, drawn);
        } else {
            self.dropped += 1;
        }
        self.next = place + 1;
        Ok(())
    }

    /// Passes the pictures that have arrived to the encoder.
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
                is_transparent: false,
            };
            let is_written = self.encoder.push(frame);
            self.different.arrived(number, is_written);
            self.dropped += u64::from(!is_written);
        }
    }

    /// Ends it with the pictures that have arrived: all of them, if all recorded work was submitted and waited for. It uses the
    /// device no longer, and the file is whole some time later.
    pub fn stop(&mut self) {
        self.collect();
        self.ring = None;
        self.different.under_way.clear();
        let end = self.place().max(self.next);
        self.end = Some(end);
        self.encoder.end(end);
    }

    /// Was it stopped?
    pub fn is_ending(&self) -> bool {
        self.end.is_some()
    }

    /// For the interface.
    pub fn facts(&self) -> Recorded {
        let frames = self.end.unwrap_or(self.next);
        Recorded {
            seconds: match self.end {
                Some(end) => end as f64 / f64::from(self.fps),
                None => self.begun.elapsed().as_secs_f64(),
            },
            frames,
            different: self.different.count + self.different.under_way.len() as u64,
            dropped: self.dropped,
            is_ending: self.end.is_some(),
        }
    }

    /// The result, once, when the recording has ended. A recording that was not stopped ends only on an error.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_counted_once_however_long_they_stay() {
        let mut different = Different::default();
        for (place, picture) in [(0, 7), (1, 7), (2, 8), (3, 8), (4, 9)] {
            different.copied(place, picture);
        }
        for place in 0..4 {
            different.arrived(place, true);
        }
        assert_eq!(different.count, 2);
        // For want of time the third one is not in it, until it is shown again.
        different.arrived(4, false);
        different.copied(5, 9);
        different.copied(6, 9);
        different.arrived(5, true);
        different.arrived(6, true);
        assert_eq!(different.count, 3);
        // If another one is under way when one is lost, that one counts once.
        for (place, picture) in [(7, 10), (8, 11)] {
            different.copied(place, picture);
        }
        different.arrived(7, false);
        different.copied(9, 11);
        different.arrived(8, true);
        different.arrived(9, true);
        assert_eq!(different.count, 4);
    }

    #[test]
    fn remarks_on_a_recording_say_how_much_is_repeated() {
        let recorded = |frames, different, dropped| Recorded {
            frames,
            different,
            dropped,
            ..Recorded::default()
        };
        assert_eq!(recorded(90, 90, 0).remarks(), "");
        let few = recorded(90, 80, 2).remarks();
        assert_eq!(
            few,
            "; 2 pictures came too fast and were left out; 80 different pictures, 10 repeated"
        );
        let many = recorded(158, 12, 0).remarks();
        assert!(many.starts_with("; 12 different pictures, 146 repeated. "));
        assert!(many.contains("Film") && !few.contains("Film"), "{many}");
    }
}
