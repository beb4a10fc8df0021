//! Every kind of output, read back.

use std::path::Path;
use std::process::Command;

use image::{Rgba, RgbaImage};

use super::Output;

pub(super) const RED: [u8; 4] = [200, 30, 20, 255];
const GREEN: [u8; 4] = [10, 180, 60, 255];
const BLUE: [u8; 4] = [30, 60, 220, 255];

pub(super) fn plain(size: (u32, u32), colour: [u8; 4]) -> RgbaImage {
    RgbaImage::from_pixel(size.0, size.1, Rgba(colour))
}

/// A picture of many more colours than a GIF's palette has.
fn gradient(size: (u32, u32), shift: u32) -> RgbaImage {
    RgbaImage::from_fn(size.0, size.1, |x, y| {
        let red = (x + shift) * 255 / (size.0 + shift);
        let green = y * 255 / size.1;
        Rgba([red as u8, green as u8, 255 - red as u8, 255])
    })
}

pub(super) fn names_in(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

fn mean_difference(a: &RgbaImage, b: &RgbaImage) -> f64 {
    assert_eq!(a.dimensions(), b.dimensions());
    let differences = a.as_raw().iter().zip(b.as_raw());
    let sum: f64 = differences.map(|(&a, &b)| f64::from(a.abs_diff(b))).sum();
    sum / a.as_raw().len() as f64
}

/// The frames of a GIF as a viewer shows them, each with its time in hundredths of a second.
pub(super) fn read_gif(path: &Path) -> Vec<(RgbaImage, u16)> {
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut decoder = options
        .read_info(std::fs::File::open(path).unwrap())
        .unwrap();
    assert_eq!(decoder.repeat(), gif::Repeat::Infinite);
    let mut shown = RgbaImage::new(decoder.width().into(), decoder.height().into());
    let mut frames = Vec::new();
    while let Some(frame) = decoder.read_next_frame().unwrap() {
        for (pixel, new) in shown.pixels_mut().zip(frame.buffer.chunks_exact(4)) {
            if new[3] != 0 {
                pixel.0.copy_from_slice(new);
            }
        }
        frames.push((shown.clone(), frame.delay));
    }
    frames
}

#[test]
fn picture_is_the_last_frame() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("new/torus.png");
    let mut output = Output::create(&path, (5, 3), 30.0).unwrap();
    assert!(!output.wants_every_frame());
    // The first file is longer than the second, which must replace it completely.
    output.frame(&gradient((5, 3), 1)).unwrap();
    output.frame(&plain((5, 3), GREEN)).unwrap();
    assert!(!path.exists(), "no final name before the end");

    let written = output.finish().unwrap();
    assert_eq!(
        (written.files.as_slice(), written.frames),
        ([path.clone()].as_slice(), 2)
    );
    let file = image::open(&path).unwrap();
    assert_eq!(file.color(), image::ColorType::Rgb8);
    assert_eq!(file.to_rgba8(), plain((5, 3), GREEN));
    assert_eq!(names_in(path.parent().unwrap()), ["torus.png"]);
}

#[test]
fn transparent_picture_keeps_its_alpha() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("glass.png");
    let mut output = Output::create(&path, (2, 2), 30.0).unwrap();
    output.frame(&plain((2, 2), [9, 8, 7, 100])).unwrap();
    output.finish().unwrap();
    let file = image::open(&path).unwrap().to_rgba8();
    assert_eq!(file, plain((2, 2), [9, 8, 7, 100]));
}

#[test]
fn sequence_has_every_frame() {
    let folder = tempfile::tempdir().unwrap();
    let mut output = Output::create(&folder.path().join("frames/"), (4, 4), 30.0).unwrap();
    assert!(output.wants_every_frame());
    for colour in [RED, GREEN, BLUE] {
        output.frame(&plain((4, 4), colour)).unwrap();
    }
    let written = output.finish().unwrap();
    assert_eq!(
        names_in(&folder.path().join("frames")),
        ["frame_00000.png", "frame_00001.png", "frame_00002.png"]
    );
    for (path, colour) in written.files.iter().zip([RED, GREEN, BLUE]) {
        assert_eq!(image::open(path).unwrap().to_rgba8(), plain((4, 4), colour));
    }
    let text = written.to_string();
    assert!(
        text.contains("frame_00000.png ... frame_00002.png (3 files"),
        "{text}"
    );
}

#[test]
fn gif_of_few_colours_is_exact() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("few.gif");
    let mut output = Output::create(&path, (8, 6), 10.0).unwrap();
    assert!(output.wants_every_frame());
    let mut half = plain((8, 6), RED);
    output.frame(&half).unwrap();
    for x in 0..4 {
        half.put_pixel(x, 2, Rgba(BLUE));
    }
    output.frame(&half).unwrap();
    output.frame(&plain((8, 6), GREEN)).unwrap();
    output.finish().unwrap();
    assert_eq!(
        read_gif(&path),
        [
            (plain((8, 6), RED), 10),
            (half, 10),
            (plain((8, 6), GREEN), 10)
        ]
    );
}

#[test]
fn gif_of_many_colours_is_close() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("many.gif");
    let mut output = Output::create(&path, (200, 150), 25.0).unwrap();
    for shift in 0..3 {
        output.frame(&gradient((200, 150), 40 * shift)).unwrap();
    }
    output.finish().unwrap();
    for ((frame, _), shift) in read_gif(&path).iter().zip(0..) {
        let difference = mean_difference(frame, &gradient((200, 150), 40 * shift));
        assert!(
            difference < 4.0,
            "frame {shift}: {difference} levels on average"
        );
    }
}

#[test]
fn gif_keeps_its_time_at_every_speed() {
    // At 1000 a second the last frame, begun at 0.50 s, gets the shortest time that viewers show.
    for (frames_per_second, frames, duration) in [
        (30.0, 30, 100),
        (60.0, 60, 100),
        (100.0, 50, 50),
        (1000.0, 500, 52),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("time.gif");
        let mut output = Output::create(&path, (2, 2), frames_per_second).unwrap();
        for frame in 0..frames {
            let level = (frame % 251) as u8;
            let colour = [level, level, 0, 255];
            output.frame(&plain((2, 2), colour)).unwrap();
        }
        let written = output.finish().unwrap();
        assert_eq!(written.frames, frames);
        let delays: Vec<u16> = read_gif(&path).iter().map(|frame| frame.1).collect();
        let sum: u16 = delays.iter().sum();
        assert_eq!(sum, duration, "{frames_per_second} a second");
        assert!(delays.iter().all(|&delay| delay >= 2), "{delays:?}");
    }
}

#[test]
fn gif_shows_a_still_picture_once() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("still.gif");
    let mut output = Output::create(&path, (3, 3), 10.0).unwrap();
    for colour in [RED, RED, RED, BLUE] {
        output.frame(&plain((3, 3), colour)).unwrap();
    }
    output.finish().unwrap();
    assert_eq!(
        read_gif(&path),
        [(plain((3, 3), RED), 30), (plain((3, 3), BLUE), 10)]
    );
}

/// What `ffprobe` says about the video's only stream, line by line.
fn probe(path: &Path, entries: &str) -> Vec<String> {
    let output = Command::new("ffprobe")
        .args(["-v", "error", "-of", "default=nokey=1:noprint_wrappers=1"])
        .args(["-show_entries", &format!("stream={entries}")])
        .arg(path)
        .output()
        .expect("ffprobe, of the package ffmpeg");
    let text = String::from_utf8(output.stdout).unwrap();
    text.lines().map(str::to_owned).collect()
}

pub(super) fn read_video(path: &Path, size: (u32, u32)) -> Vec<RgbaImage> {
    let output = Command::new("ffmpeg")
        .args(["-v", "error", "-i"])
        .arg(path)
        .args(["-f", "rawvideo", "-pix_fmt", "rgba", "-"])
        .output()
        .expect("ffmpeg");
    let frames = output
        .stdout
        .chunks_exact(size.0 as usize * size.1 as usize * 4);
    frames
        .map(|bytes| RgbaImage::from_raw(size.0, size.1, bytes.to_vec()).unwrap())
        .collect()
}

#[test]
fn video_shows_the_frames_in_their_colours() {
    let folder = tempfile::tempdir().unwrap();
    // A space, a colon and a percent sign are letters here, whatever they mean to the encoder.
    let path = folder.path().join("a b:%d.mp4");
    let size = (64, 48);
    let mut output = Output::create(&path, size, 25.0).unwrap();
    assert!(output.wants_every_frame());
    for colour in [RED, GREEN, BLUE] {
        for _ in 0..5 {
            output.frame(&plain(size, colour)).unwrap();
        }
    }
    assert!(!path.exists(), "no final name before the end");
    let written = output.finish().unwrap();
    assert!(written.to_string().contains("(15 frames, "), "{written}");
    assert_eq!(names_in(folder.path()), ["a b:%d.mp4"]);

    let frames = read_video(&path, size);
    assert_eq!(frames.len(), 15);
    for (frame, colour) in [(&frames[2], RED), (&frames[7], GREEN), (&frames[12], BLUE)] {
        let difference = mean_difference(frame, &plain(size, colour));
        assert!(difference < 2.5, "{colour:?} is off by {difference}");
    }
    assert_eq!(
        probe(
            &path,
            "codec_name,pix_fmt,color_range,color_space,color_transfer,color_primaries,avg_frame_rate"
        ),
        ["h264", "yuv420p", "tv", "bt709", "bt709", "bt709", "25/1"]
    );
    let bytes = std::fs::read(&path).unwrap();
    let position = |name: &[u8]| bytes.windows(4).position(|window| window == name).unwrap();
    assert!(
        position(b"moov") < position(b"mdat"),
        "plays while it loads"
    );
}

#[test]
fn video_of_odd_size_repeats_its_last_pixels() {
    let folder = tempfile::tempdir().unwrap();
    for (size, even) in [((33, 21), (34, 22)), ((32, 21), (32, 22)), ((1, 2), (2, 2))] {
        let path = folder.path().join("odd.mp4");
        let mut output = Output::create(&path, size, 30.0).unwrap();
        output.frame(&plain(size, [250, 250, 250, 255])).unwrap();
        output.finish().unwrap();
        let frames = read_video(&path, even);
        assert_eq!(frames.len(), 1, "{size:?}");
        let darkest = frames[0].pixels().map(|pixel| pixel.0[0]).min().unwrap();
        assert!(darkest > 230, "{size:?}: no dark edge, {darkest}");
    }
}
