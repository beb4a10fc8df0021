//! Bars: what ways to do the same take, side by side, as an SVG and a PNG.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

use super::plot::{
    BOTTOM, COLORS, Drawn, GRID, INK, Picture, SIZE, TOP, linear_ticks, style, tick_text,
};

/// Where bars begin and how far they may reach, pixels; names stand on the left, notes on the right.
const FROM: i32 = 340;
const TO: i32 = 700;
/// The most that a row is high, pixels.
const ROW: i32 = 34;

/// One picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Bars {
    /// Of the files, without ending.
    pub name: String,
    pub title: String,
    /// What lengths are, with the unit.
    pub label: String,
    pub bars: Vec<Bar>,
}

/// A way, and what it takes.
#[derive(Clone, Debug, PartialEq)]
pub struct Bar {
    pub name: String,
    /// Bars of a colour are of the same way.
    pub color: usize,
    pub value: f64,
    /// How sure the value is.
    pub low: f64,
    pub high: f64,
    /// What else there is to say; stands behind the bar.
    pub note: String,
}

impl Picture for Bars {
    fn name(&self) -> &str {
        &self.name
    }

    fn is_empty(&self) -> bool {
        self.bars.is_empty()
    }

    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Drawn<DB> {
        area.fill(&WHITE)?;
        let title = style(20, HPos::Left, VPos::Center);
        area.draw(&Text::new(self.title.clone(), (24, TOP / 2), title))?;
        let most = self
            .bars
            .iter()
            .map(|bar| bar.high.max(bar.value))
            .fold(0.0, f64::max);
        let most = if most > 0.0 { most } else { 1.0 };
        let place = |value: f64| FROM + (value / most * f64::from(TO - FROM)).round() as i32;
        let room = SIZE.1 as i32 - TOP - BOTTOM;
        let row = (room / (self.bars.len() as i32).max(1)).min(ROW);
        let bottom = TOP + row * self.bars.len() as i32;
        for tick in linear_ticks(most) {
            let across = place(tick);
            area.draw(&PathElement::new([(across, TOP), (across, bottom)], GRID))?;
            let number = style(14, HPos::Center, VPos::Top);
            area.draw(&Text::new(tick_text(tick), (across, bottom + 8), number))?;
        }
        for (number, bar) in self.bars.iter().enumerate() {
            let top = TOP + row * number as i32;
            let middle = top + row / 2;
            let name = style(15, HPos::Right, VPos::Center);
            area.draw(&Text::new(bar.name.clone(), (FROM - 10, middle), name))?;
            let color = COLORS[bar.color % COLORS.len()];
            let corners = [(FROM, top + 3), (place(bar.value), top + row - 3)];
            area.draw(&Rectangle::new(corners, color.filled()))?;
            let ends = [place(bar.low), place(bar.high)];
            if ends[0] != ends[1] {
                let between = [(ends[0], middle), (ends[1], middle)];
                area.draw(&PathElement::new(between, INK.stroke_width(1)))?;
                for end in ends {
                    let stop = [(end, middle - 4), (end, middle + 4)];
                    area.draw(&PathElement::new(stop, INK.stroke_width(1)))?;
                }
            }
            let note = style(14, HPos::Left, VPos::Center);
            let behind = place(bar.high.max(bar.value)) + 8;
            area.draw(&Text::new(bar.note.clone(), (behind, middle), note))?;
        }
        let axis = [(FROM, TOP), (FROM, bottom), (TO, bottom)];
        area.draw(&PathElement::new(axis, INK.stroke_width(1)))?;
        let label = style(16, HPos::Center, VPos::Center);
        let under = ((FROM + TO) / 2, bottom + 44);
        area.draw(&Text::new(self.label.clone(), under, label))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bars_are_as_long_as_their_values() {
        let bar = |name: &str, color, value: f64| Bar {
            name: name.to_owned(),
            color,
            value,
            low: 0.9 * value,
            high: 1.1 * value,
            note: format!("{value} of them"),
        };
        let bars = Bars {
            name: "test".to_owned(),
            title: "A title".to_owned(),
            label: "ns a particle".to_owned(),
            bars: vec![bar("first", 0, 10.0), bar("second", 1, 20.0)],
        };
        let svg = bars.svg().expect("it is drawn");
        for text in ["A title", "ns a particle", "first", "second", "20 of them"] {
            assert!(svg.contains(text), "{text}");
        }
        let png = bars.png().expect("it is drawn");
        let picture = image::load_from_memory(&png)
            .expect("it is a PNG")
            .to_rgb8();
        let [first, second] = [0, 1].map(|color: usize| {
            let RGBColor(red, green, blue) = COLORS[color];
            let found = picture.pixels().filter(|p| p.0 == [red, green, blue]);
            found.count() as f64
        });
        assert!((second / first - 2.0).abs() < 0.1, "{first} and {second}");
        let nothing = Bars {
            bars: Vec::new(),
            ..bars
        };
        assert!(nothing.is_empty() && nothing.svg().is_ok());
    }
}
