//! The network's lines on a display.

use image::{Rgb, RgbImage};
use myxo::render::network_lines::LINES;

use super::can_open_a_window;
use crate::Lab;
use crate::network::GROWN;

/// The display, once nothing moves any more.
#[track_caller]
fn shown(lab: &Lab) -> RgbImage {
    lab.wait("it rests", |seen| seen["rests"] == true);
    let taken = lab.display(|display, _| display.picture());
    let file = taken.strip_prefix("; the display: ");
    let file = file.unwrap_or_else(|| panic!("ffmpeg takes pictures of the display{taken}"));
    image::open(file).expect("it is a picture").into_rgb8()
}

/// Pixels that have nearly the colour of lines.
fn like_lines(picture: &RgbImage) -> usize {
    let is_like = |pixel: &&Rgb<u8>| {
        let mut pairs = pixel.0.iter().zip(LINES);
        pairs.all(|(a, b)| a.abs_diff(b) < 24)
    };
    picture.pixels().filter(is_like).count()
}

/// Would catch: lines that are found and not drawn, and lines that stay.
#[test]
fn lines_are_drawn_over_the_picture_while_they_are_asked_for() {
    if !can_open_a_window() {
        return;
    }
    let lab = Lab::open_on_display(&GROWN);
    lab.grows_beyond(60);
    lab.hold();
    let before = like_lines(&shown(&lab));
    lab.click_until("network", "network", true);
    lab.wait("they are found", |seen| {
        seen["values"]["network"].is_string()
    });
    let with = like_lines(&shown(&lab));
    assert!(with > before + 300, "{with} pixels, and {before} before");
    lab.key_until("n", "they go", "network", false);
    let after = like_lines(&shown(&lab));
    assert!(after < before + 100, "{after} pixels, and {before} before");
    lab.quit();
}
