//! Pictures for plotters to draw into, with the window's font.

use std::convert::Infallible;

use egui::epaint::FontColorTransferFunction;
use egui::epaint::text::{FontDefinitions, FontId, Fonts, TextOptions};
use image::RgbImage;
use plotters::prelude::DrawingBackend;
use plotters::style::text_anchor::{HPos, VPos};
use plotters_backend::{BackendColor, BackendCoord, BackendTextStyle, DrawingErrorKind};

/// Pixels of an em for each pixel of a text's size, which is measured from the top of the highest letter to the bottom of the lowest.
const EM: f64 = 0.89;

/// A backend of plotters that draws into a picture.
pub struct Pixels<'a> {
    picture: &'a mut RgbImage,
    fonts: Fonts,
}

impl<'a> Pixels<'a> {
    pub fn new(picture: &'a mut RgbImage) -> Self {
        let options = TextOptions {
            color_transfer_function: FontColorTransferFunction::LIGHT_MODE_DEFAULT,
            ..TextOptions::default()
        };
        let fonts = Fonts::new(options, FontDefinitions::default());
        Self { picture, fonts }
    }
}

type Drawn = Result<(), DrawingErrorKind<Infallible>>;

impl DrawingBackend for Pixels<'_> {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        self.picture.dimensions()
    }

    fn ensure_prepared(&mut self) -> Drawn {
        Ok(())
    }

    fn present(&mut self) -> Drawn {
        Ok(())
    }

    fn draw_pixel(&mut self, place: BackendCoord, color: BackendColor) -> Drawn {
        blend(self.picture, place, color);
        Ok(())
    }

    /// A text has the same distance from its anchor as in an SVG of plotters.
    fn draw_text<Style: BackendTextStyle>(
        &mut self,
        text: &str,
        style: &Style,
        (left, top): BackendCoord,
    ) -> Drawn {
        let font = FontId::proportional((EM * style.size()) as f32);
        let em = font.size;
        let mut layout = self.fonts.with_pixels_per_point(1.0);
        let galley = layout.layout_no_wrap(text.to_owned(), font, egui::Color32::WHITE);
        let letters = self.fonts.texture_atlas().image();
        let anchor = style.anchor();
        let start = match anchor.h_pos {
            HPos::Left => 0.0,
            HPos::Center => -galley.size().x / 2.0,
            HPos::Right => -galley.size().x,
        };
        let baseline = match anchor.v_pos {
            VPos::Top => 0.76 * em,
            VPos::Center => 0.26 * em,
            VPos::Bottom => -0.26 * em,
        };
        // One row is enough: no text of a plot has line breaks.
        for glyph in galley.rows.iter().flat_map(|row| &row.row.glyphs) {
            let area = glyph.uv_rect;
            let x = (start.round() + glyph.pos.x + area.offset.x).round() as i32;
            let y = (baseline + area.offset.y).round() as i32;
            for (down, row) in (area.min[1]..area.max[1]).enumerate() {
                for (across, column) in (area.min[0]..area.max[0]).enumerate() {
                    let covered = letters[(column.into(), row.into())].a();
                    let color = style.color().mix(f64::from(covered) / 255.0);
                    let (x, y) = (x + across as i32, y + down as i32);
                    let (x, y) = style.transform().transform(x, y);
                    blend(self.picture, (left + x, top + y), color);
                }
            }
        }
        Ok(())
    }
}

/// Blends a pixel; does nothing outside of the picture.
fn blend(picture: &mut RgbImage, (x, y): BackendCoord, color: BackendColor) {
    let place = u32::try_from(x).ok().zip(u32::try_from(y).ok());
    let Some(pixel) = place.and_then(|(x, y)| picture.get_pixel_mut_checked(x, y)) else {
        return;
    };
    let (red, green, blue) = color.rgb;
    for (below, above) in pixel.0.iter_mut().zip([red, green, blue]) {
        let (from, to) = (f64::from(*below), f64::from(above));
        *below = (from + color.alpha * (to - from)).round() as u8;
    }
}

#[cfg(test)]
mod tests {
    use plotters::style::text_anchor::Pos;
    use plotters::style::{FontTransform, IntoFont, TextStyle};

    use super::*;

    /// First and last column, first and last row with ink of a text that is anchored at (100, 50).
    fn ink(text: &str, across: HPos, up: VPos, transform: FontTransform) -> [i32; 4] {
        let mut picture = RgbImage::from_pixel(200, 100, image::Rgb([255; 3]));
        let style = TextStyle::from(("sans-serif", 16).into_font())
            .pos(Pos::new(across, up))
            .transform(transform);
        Pixels::new(&mut picture)
            .draw_text(text, &style, (100, 50))
            .expect("nothing fails");
        let dark = picture.enumerate_pixels().filter(|(_, _, p)| p.0[0] < 200);
        let places: Vec<(i32, i32)> = dark.map(|(x, y, _)| (x as i32, y as i32)).collect();
        assert!(places.len() > 20, "{text}: {} dark pixels", places.len());
        let columns = places.iter().map(|place| place.0);
        let rows = places.iter().map(|place| place.1);
        let ends = [
            columns.clone().min(),
            columns.max(),
            rows.clone().min(),
            rows.max(),
        ];
        ends.map(|end| end.expect("there is ink"))
    }

    #[test]
    fn texts_lie_at_their_anchors() {
        let near = |a: i32, b: i32| (a - b).abs() <= 2;
        let text = "300 ms";
        let [left, right, ..] = ink(text, HPos::Left, VPos::Center, FontTransform::None);
        assert!(near(left, 100) && right > 130, "{left} to {right}");
        let [left, right, ..] = ink(text, HPos::Right, VPos::Center, FontTransform::None);
        assert!(near(right, 100) && left < 70, "{left} to {right}");
        let [left, right, top, bottom] = ink(text, HPos::Center, VPos::Center, FontTransform::None);
        assert!(near((left + right) / 2, 100), "{left} to {right}");
        assert!(near((top + bottom) / 2, 50), "{top} to {bottom}");
        let [_, _, top, _] = ink(text, HPos::Left, VPos::Top, FontTransform::None);
        assert!(near(top, 50), "from {top}");
        let [left, right, top, bottom] =
            ink(text, HPos::Center, VPos::Center, FontTransform::Rotate270);
        assert!(near((left + right) / 2, 100) && right - left < 15);
        assert!(near((top + bottom) / 2, 50) && bottom - top > 30);
    }

    #[test]
    fn pixels_outside_the_picture_are_left_out() {
        let long = "a text of a hundred letters and more ".repeat(3);
        let [left, right, ..] = ink(&long, HPos::Center, VPos::Center, FontTransform::None);
        assert!(left < 5 && right > 195, "{left} to {right}");
    }
}
