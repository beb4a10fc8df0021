//! A screen that is twice as dense: what is pressed and painted is where it is shown.

use super::*;
use crate::lab::command::{ExportRequest, ToolRequest};
use crate::lab::place::Place;
use crate::lab::tools::Tool;

#[test]
fn on_a_dense_screen_controls_and_pictures_are_met_where_they_are_shown() {
    let mut harness = Harness::new();
    let before = harness.frame(vec![]).picture;
    harness.scale = 2.0;
    harness.interface.layout.toggle(Card::Exports);
    for _ in 0..3 {
        harness.frame(vec![]);
    }
    assert_eq!(harness.ctx.pixels_per_point(), 2.0);
    let picture = harness.frame(vec![]).picture;
    assert_eq!(picture, before, "points are what they were");
    let record = harness.places_of("⏺ Record")[0];
    assert_eq!(
        harness.click(record),
        [Command::Export(ExportRequest::Record)]
    );
    harness.interface.layout.close(Card::Exports);

    // The picture has twice as many pixels each way, and strokes are in pixels of it.
    let place = Place::of(picture, 2.0, [2400, 1600]);
    let at = (IN_PICTURE - picture.min) * 2.0;
    let wanted = Vec2::new(at.x, at.y);
    assert!(wanted.x < place.size[0] as f32 && wanted.y < place.size[1] as f32);
    harness.interface.tools.take(Tool::Attract);
    let commands = harness.click(IN_PICTURE);
    let strokes = commands.iter().filter_map(|command| match command {
        Command::Tool(ToolRequest::Stroke { from, to, .. }) => Some([*from, *to]),
        _ => None,
    });
    let strokes: Vec<_> = strokes.flatten().collect();
    assert!(!strokes.is_empty(), "{commands:?}");
    for pixel in strokes {
        assert!(pixel.distance(wanted) < 1e-3, "{pixel}, not {wanted}");
    }
}
