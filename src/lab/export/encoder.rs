//! A film that another thread writes while the window continues.

use std::collections::VecDeque;
use std::path::Path;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use image::RgbaImage;
use image::imageops::{self, FilterType};
use myxo::Result;
use myxo::render::offscreen::unmultiply;
use myxo::render::output::{Output, OutputError, Written};

use crate::lab::job::Job;
use crate::lab::names::Reserved;

/// The most memory of waiting pictures, bytes, except for the first few.
const MOST_WAITING: usize = 256 << 20;
/// The number of pictures that may wait, however large they are.
const FEWEST: usize = 3;

/// A picture as it lies on the device.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Its place in the film, from 0; a missing picture is replaced by the one before.
    pub number: u64,
    /// Width and height.
    pub size: [u32; 2],
    /// Four bytes a pixel, row by row.
    pub pixels: Vec<u8>,
    /// Is blue the first of them?
    pub is_blue_first: bool,
    /// Has it no background? Then its light is multiplied by its alpha.
    pub is_transparent: bool,
}

impl Frame {
    /// As files have it.
    pub fn into_picture(self) -> RgbaImage {
        let Self {
            size: [width, height],
            mut pixels,
            is_blue_first,
            is_transparent,
            ..
        } = self;
        if is_blue_first {
            pixels
                .chunks_exact_mut(4)
                .for_each(|pixel| pixel.swap(0, 2));
        }
        let mut picture = RgbaImage::from_raw(width, height, pixels).expect("four bytes a pixel");
        if is_transparent {
            unmultiply(&mut picture);
        }
        picture
    }
}

#[derive(Debug, Default)]
struct Queue {
    frames: VecDeque<Frame>,
    /// No more pictures will come: the film has this many frames.
    end: Option<u64>,
    /// The film was cancelled.
    cancelled: bool,
    /// Frames that the film has.
    written: u64,
    /// Bytes that wait.
    bytes: usize,
}

/// State shared by the window and the writer.
#[derive(Debug, Default)]
struct Shared {
    queue: Mutex<Queue>,
    changed: Condvar,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Queue> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A film on its way to a file. Dropped before its end, it leaves nothing.
pub struct Encoder {
    shared: Arc<Shared>,
    job: Option<Job<Written>>,
    /// The name is free for others once the film is written.
    name: Reserved,
}

impl Encoder {
    /// Begins to write; pictures of other sizes than `size` are brought to it.
    pub fn begin(output: Output, size: [u32; 2], name: Reserved) -> Self {
        let shared = Arc::new(Shared::default());
        let theirs = Arc::clone(&shared);
        let job = Job::begin("writing the film", move |_| {
            Ok(write(output, size, &theirs)?)
        });
        Self {
            shared,
            job: Some(job),
            name,
        }
    }

    /// The file, or the folder of files, that it writes.
    pub fn path(&self) -> &Path {
        self.name.path()
    }

    /// May another picture wait?
    pub fn has_room(&self) -> bool {
        let queue = self.shared.lock();
        queue.frames.len() < FEWEST || queue.bytes < MOST_WAITING
    }

    /// Takes a picture, if there is room for it.
    pub fn push(&self, frame: Frame) -> bool {
        if !self.has_room() {
            return false;
        }
        let mut queue = self.shared.lock();
        queue.bytes += frame.pixels.len();
        queue.frames.push_back(frame);
        self.shared.changed.notify_all();
        true
    }

    /// Frames that are in the film, and pictures that wait.
    pub fn facts(&self) -> (u64, usize) {
        let queue = self.shared.lock();
        (queue.written, queue.frames.len())
    }

    /// No more pictures will come; the film has this many frames, the last picture repeated if necessary.
    pub fn end(&self, frames: u64) {
        self.shared.lock().end = Some(frames);
        self.shared.changed.notify_all();
    }

    /// Cancels the film, which then leaves no file.
    pub fn cancel(&self) {
        self.shared.lock().cancelled = true;
        self.shared.changed.notify_all();
    }

    /// Was it cancelled?
    pub fn is_cancelled(&self) -> bool {
        self.shared.lock().cancelled
    }

    /// The result, once, when it has ended: no files if it was cancelled.
    pub fn take(&mut self) -> Option<Result<Written>> {
        self.job.as_mut()?.take()
    }

    /// Waits for it.
    pub fn wait(mut self) -> Option<Result<Written>> {
        self.job.take()?.wait()
    }
}

impl Drop for Encoder {
    fn drop(&mut self) {
        if let Some(mut job) = self.job.take() {
            self.cancel();
            // Its unfinished file is gone when it ends.
            drop(job.wait());
        }
    }
}

fn write(mut output: Output, size: [u32; 2], shared: &Shared) -> Result<Written, OutputError> {
    let mut last: Option<RgbaImage> = None;
    // Until the place of the next picture, or the end, the last one stays.
    let repeat = |output: &mut Output, last: &Option<RgbaImage>, to: u64| {
        while let Some(picture) = last.as_ref().filter(|_| output.frames() < to) {
            if shared.lock().cancelled {
                break;
            }
            output.frame(picture)?;
            shared.lock().written = output.frames();
        }
        Ok::<(), OutputError>(())
    };
    loop {
        let mut queue = shared.lock();
        let frame = loop {
            if queue.cancelled {
                return Ok(Written {
                    files: Vec::new(),
                    frames: 0,
                });
            }
            if let Some(frame) = queue.frames.pop_front() {
                queue.bytes -= frame.pixels.len();
                break Some(frame);
            }
            if queue.end.is_some() {
                break None;
            }
            queue = shared
                .changed
                .wait(queue)
                .unwrap_or_else(PoisonError::into_inner);
        };
        let end = queue.end;
        drop(queue);
        let Some(frame) = frame else {
            if let Err(error) = repeat(&mut output, &last, end.unwrap_or_default()) {
                return Err(output.cut(error));
            }
            if shared.lock().cancelled {
                continue;
            }
            return output.finish();
        };
        let number = frame.number;
        let picture = fitted(frame.into_picture(), size);
        let taken = repeat(&mut output, &last, number).and_then(|()| output.frame(&picture));
        if let Err(error) = taken {
            return Err(output.cut(error));
        }
        shared.lock().written = output.frames();
        last = Some(picture);
    }
}

/// A picture in the middle of one of another size, as large as it can be.
fn fitted(picture: RgbaImage, size: [u32; 2]) -> RgbaImage {
    let (width, height) = picture.dimensions();
    if [width, height] == size {
        return picture;
    }
    let scale = f64::min(
        f64::from(size[0]) / f64::from(width),
        f64::from(size[1]) / f64::from(height),
    );
    let scaled = [width, height].map(|side| (f64::from(side) * scale).round().max(1.0) as u32);
    let inner = imageops::resize(&picture, scaled[0], scaled[1], FilterType::Triangle);
    let behind = *picture.get_pixel(0, 0);
    let mut whole = RgbaImage::from_pixel(size[0], size[1], behind);
    let [x, y] = [0, 1].map(|k| i64::from(size[k].saturating_sub(scaled[k]) / 2));
    imageops::replace(&mut whole, &inner, x, y);
    whole
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::thread;
    use std::time::{Duration, Instant};

    fn frame(number: u64, size: [u32; 2], red: u8) -> Frame {
        let count = size[0] as usize * size[1] as usize;
        Frame {
            number,
            size,
            pixels: [0, 0, red, 255].repeat(count),
            is_blue_first: true,
            is_transparent: false,
        }
    }

    fn begin(folder: &Path, size: [u32; 2]) -> Encoder {
        let name = Reserved::next(folder, "film", "").unwrap();
        let output = Output::create(&name.as_folder(), size.into(), 30.0).unwrap();
        Encoder::begin(output, size, name)
    }

    #[test]
    fn gaps_show_the_picture_before_and_sizes_are_brought_to_one() {
        let folder = tempfile::tempdir().unwrap();
        let encoder = begin(folder.path(), [8, 4]);
        assert!(encoder.push(frame(0, [8, 4], 10)));
        assert!(encoder.push(frame(3, [16, 16], 20)));
        encoder.end(6);
        let written = encoder.wait().unwrap().unwrap();
        assert_eq!((written.frames, written.files.len()), (6, 6));
        let reds: Vec<u8> = written
            .files
            .iter()
            .map(|file| {
                let picture = image::open(file).unwrap().into_rgba8();
                assert_eq!(picture.dimensions(), (8, 4));
                assert_eq!(picture.get_pixel(4, 2).0[1..], [0, 0, 255]);
                picture.get_pixel(4, 2).0[0]
            })
            .collect();
        assert_eq!(reds, [10, 10, 10, 20, 20, 20]);
        let picture = fitted(
            RgbaImage::from_pixel(100, 50, image::Rgba([9; 4])),
            [40, 40],
        );
        assert_eq!(picture.dimensions(), (40, 40));
    }

    #[test]
    fn a_cancelled_or_dropped_film_leaves_no_file() {
        let folder = tempfile::tempdir().unwrap();
        for ends in [true, false] {
            let name = Reserved::next(folder.path(), "film", "gif").unwrap();
            let output = Output::create(name.path(), (8, 4), 30.0).unwrap();
            let encoder = Encoder::begin(output, [8, 4], name);
            assert!(encoder.push(frame(0, [8, 4], 10)));
            if ends {
                encoder.cancel();
                assert_eq!(encoder.wait().unwrap().unwrap().files.len(), 0);
            } else {
                drop(encoder);
            }
            assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        }
    }

    #[test]
    fn a_panic_of_the_writer_is_an_error_and_leaves_no_file() {
        let folder = tempfile::tempdir().unwrap();
        let encoder = begin(folder.path(), [8, 4]);
        let torn = Frame {
            pixels: vec![0; 5],
            ..frame(0, [8, 4], 10)
        };
        assert!(encoder.push(torn));
        encoder.end(1);
        let error = encoder.wait().unwrap().unwrap_err();
        assert!(error.to_string().contains("four bytes a pixel"), "{error}");
    }

    #[test]
    fn a_writer_that_fails_says_why_and_a_full_queue_takes_no_more() {
        let folder = tempfile::tempdir().unwrap();
        let mut encoder = begin(folder.path(), [8, 4]);
        // A file takes the place of its folder.
        std::fs::remove_dir_all(folder.path()).unwrap();
        std::fs::write(folder.path(), "").unwrap();
        encoder.push(frame(0, [8, 4], 10));
        let begun = Instant::now();
        let error = loop {
            if let Some(result) = encoder.take() {
                break result.unwrap_err();
            }
            assert!(begun.elapsed() < Duration::from_secs(60), "it still runs");
            thread::sleep(Duration::from_millis(5));
        };
        std::fs::remove_file(folder.path()).unwrap();
        assert!(error.to_string().contains("cannot write"), "{error}");
        let mut taken = 0;
        while encoder.push(frame(taken, [4096, 4096], 1)) {
            taken += 1;
        }
        assert_eq!(taken, 4, "64 MiB each, and room for 256");
    }
}
