//! The letters and the colours that plots and sheets of pictures share.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Files name a font; pictures are drawn with that of the window.
const FONT: &str = "sans-serif";
/// Of letters and axes.
pub const INK: RGBColor = RGBColor(40, 44, 52);
/// Of what stands behind: lines of a grid, empty places.
pub const PALE: RGBColor = RGBColor(222, 224, 228);

/// Letters of this size, which lie so beside their place.
pub fn style(size: i32, across: HPos, up: VPos) -> TextStyle<'static> {
    TextStyle::from((FONT, size).into_font())
        .color(&INK)
        .pos(Pos::new(across, up))
}
