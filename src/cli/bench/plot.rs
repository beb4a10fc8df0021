//! Plots of measurements: lines over an axis, either of them logarithmic, with the spread of each point as a bar. The same
//! drawing becomes an SVG and a PNG.

use myxo::scene::parameters::grouped;
use myxo::{Error, Result};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

use crate::cli::letters::{INK, PALE, style};
use crate::cli::pixels::Pixels;

/// Pixels.
const SIZE: (u32, u32) = (960, 560);
/// Margins around the plot; names of lines stand in the right one.
const LEFT: i32 = 92;
const RIGHT: i32 = 232;
const TOP: i32 = 52;
const BOTTOM: i32 = 64;

/// Colours that stay apart for the colour-blind (Okabe and Ito, "Color Universal Design", 2008), darkest first.
const COLORS: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    RGBColor(0, 0, 0),
    RGBColor(140, 140, 140),
];

/// One picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Plot {
    /// Name of the files, without ending.
    pub name: String,
    pub title: String,
    pub x: Axis,
    pub y: Axis,
    pub lines: Vec<Line>,
}

/// An axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// The label, with the unit.
    pub label: String,
    pub is_log: bool,
}

impl Axis {
    pub fn linear(label: &str) -> Self {
        Self {
            label: label.to_owned(),
            is_log: false,
        }
    }

    pub fn log(label: &str) -> Self {
        Self {
            label: label.to_owned(),
            is_log: true,
        }
    }
}

/// Points in the order in which they are joined.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    pub name: String,
    pub points: Vec<Dot>,
}

/// A point and the interval of its height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dot {
    pub x: f64,
    pub y: f64,
    pub low: f64,
    pub high: f64,
}

impl Plot {
    /// As an SVG text.
    pub fn svg(&self) -> Result<String> {
        let mut text = String::new();
        let area = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        self.draw(&area).map_err(|error| self.failure(&error))?;
        drop(area);
        Ok(text)
    }

    /// As a PNG file.
    pub fn png(&self) -> Result<Vec<u8>> {
        let mut picture = image::RgbImage::new(SIZE.0, SIZE.1);
        let area = Pixels::new(&mut picture).into_drawing_area();
        self.draw(&area).map_err(|error| self.failure(&error))?;
        drop(area);
        let mut file = std::io::Cursor::new(Vec::new());
        picture
            .write_to(&mut file, image::ImageFormat::Png)
            .map_err(|error| self.failure(&error))?;
        Ok(file.into_inner())
    }

    fn failure(&self, error: &dyn std::fmt::Display) -> Error {
        Error::Invalid(format!("cannot draw the plot `{}`: {error}", self.name))
    }

    /// The points that the axes can show.
    fn shown(&self, line: &Line) -> Vec<Dot> {
        let fits = |axis: &Axis, value: f64| value.is_finite() && (!axis.is_log || value > 0.0);
        let dots = line.points.iter().copied();
        dots.filter(|dot| fits(&self.x, dot.x) && fits(&self.y, dot.y))
            .collect()
    }

    /// Is there nothing to show?
    pub fn is_empty(&self) -> bool {
        self.lines.iter().all(|line| self.shown(line).is_empty())
    }

    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Drawn<DB> {
        area.fill(&WHITE)?;
        let dots: Vec<Dot> = self
            .lines
            .iter()
            .flat_map(|line| self.shown(line))
            .collect();
        let (right, bottom) = (SIZE.0 as i32 - RIGHT, SIZE.1 as i32 - BOTTOM);
        let x = Scale::of(&self.x, dots.iter().map(|dot| dot.x), (LEFT, right))
            .at_values(dots.iter().map(|dot| dot.x));
        let ends = dots.iter().flat_map(|dot| [dot.low, dot.y, dot.high]);
        let y = Scale::of(&self.y, ends, (bottom, TOP));
        draw_axes(area, &x, &y)?;
        let title = style(20, HPos::Left, VPos::Center);
        area.draw(&Text::new(self.title.clone(), (LEFT, TOP / 2), title))?;
        let label = style(16, HPos::Center, VPos::Center);
        let middle = (LEFT + right) / 2;
        area.draw(&Text::new(
            self.x.label.clone(),
            (middle, SIZE.1 as i32 - 20),
            label.clone(),
        ))?;
        let upright = label.transform(FontTransform::Rotate270);
        let middle = (TOP + bottom) / 2;
        area.draw(&Text::new(self.y.label.clone(), (18, middle), upright))?;
        self.draw_lines(area, &x, &y)
    }

    fn draw_lines<DB: DrawingBackend>(
        &self,
        area: &DrawingArea<DB, Shift>,
        x: &Scale,
        y: &Scale,
    ) -> Drawn<DB> {
        // Names stand in the order in which the lines end.
        let mut order: Vec<(f64, usize)> = Vec::new();
        for (number, line) in self.lines.iter().enumerate() {
            let dots = self.shown(line);
            let Some(last) = dots.last() else { continue };
            order.push((last.y, number));
            let color = COLORS[number % COLORS.len()];
            let path: Vec<(i32, i32)> = dots
                .iter()
                .map(|dot| (x.place(dot.x), y.place(dot.y)))
                .collect();
            area.draw(&PathElement::new(path.clone(), color.stroke_width(2)))?;
            for (dot, &(across, up)) in dots.iter().zip(&path) {
                let (low, high) = (y.place(dot.low), y.place(dot.high));
                if low != high {
                    for bar in [
                        [(across, low), (across, high)],
                        [(across - 4, low), (across + 4, low)],
                        [(across - 4, high), (across + 4, high)],
                    ] {
                        area.draw(&PathElement::new(bar, color.stroke_width(1)))?;
                    }
                }
                mark(area, number, (across, up), color)?;
            }
        }
        order.sort_by(|a, b| b.0.total_cmp(&a.0));
        let left = SIZE.0 as i32 - RIGHT + 16;
        for (row, (_, number)) in order.into_iter().enumerate() {
            let height = TOP + 14 + 24 * row as i32;
            let color = COLORS[number % COLORS.len()];
            let stroke = [(left, height), (left + 26, height)];
            area.draw(&PathElement::new(stroke, color.stroke_width(2)))?;
            mark(area, number, (left + 13, height), color)?;
            let name = style(15, HPos::Left, VPos::Center);
            area.draw(&Text::new(
                self.lines[number].name.clone(),
                (left + 34, height),
                name,
            ))?;
        }
        Ok(())
    }
}

pub type Drawn<DB> = Result<(), DrawingAreaErrorKind<<DB as DrawingBackend>::ErrorType>>;

/// Shapes differ, for readers who cannot distinguish the colours: a disc, a square, a ring, and again.
fn mark<DB: DrawingBackend>(
    area: &DrawingArea<DB, Shift>,
    number: usize,
    (x, y): (i32, i32),
    color: RGBColor,
) -> Drawn<DB> {
    match number % 3 {
        0 => area.draw(&Circle::new((x, y), 4, color.filled())),
        1 => area.draw(&Rectangle::new(
            [(x - 4, y - 4), (x + 4, y + 4)],
            color.filled(),
        )),
        _ => {
            area.draw(&Circle::new((x, y), 4, WHITE.filled()))?;
            area.draw(&Circle::new((x, y), 4, color.stroke_width(2)))
        }
    }
}

fn draw_axes<DB: DrawingBackend>(area: &DrawingArea<DB, Shift>, x: &Scale, y: &Scale) -> Drawn<DB> {
    let (left, right) = x.pixels;
    let (bottom, top) = y.pixels;
    for &value in &x.ticks {
        let place = x.place(value);
        area.draw(&PathElement::new([(place, bottom), (place, top)], PALE))?;
        let number = style(14, HPos::Center, VPos::Top);
        area.draw(&Text::new(tick_text(value), (place, bottom + 8), number))?;
    }
    for &value in &y.ticks {
        let place = y.place(value);
        area.draw(&PathElement::new([(left, place), (right, place)], PALE))?;
        let number = style(14, HPos::Right, VPos::Center);
        area.draw(&Text::new(tick_text(value), (left - 8, place), number))?;
    }
    let frame = [(left, top), (left, bottom), (right, bottom)];
    area.draw(&PathElement::new(frame, INK.stroke_width(1)))
}

/// Maps values to pixels; has the labelled values.
#[derive(Clone, Debug, PartialEq)]
struct Scale {
    is_log: bool,
    /// The ends; logarithms on a logarithmic axis.
    low: f64,
    high: f64,
    pixels: (i32, i32),
    ticks: Vec<f64>,
}

impl Scale {
    fn of(axis: &Axis, values: impl Iterator<Item = f64>, pixels: (i32, i32)) -> Self {
        let values = values.filter(|value| value.is_finite() && (!axis.is_log || *value > 0.0));
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        });
        let (low, high) = if low > high { (1.0, 2.0) } else { (low, high) };
        if axis.is_log {
            let (low, high) = (low.log10(), high.log10());
            let room = (0.05 * (high - low)).max(0.1);
            let (low, high) = (low - room, high + room);
            return Self {
                is_log: true,
                low,
                high,
                pixels,
                ticks: log_ticks(low, high),
            };
        }
        let high = if high > 0.0 { 1.06 * high } else { 1.0 };
        Self {
            is_log: false,
            low: 0.0,
            high,
            pixels,
            ticks: linear_ticks(high),
        }
    }

    /// Labels the measured values, if the labels do not overlap.
    fn at_values(mut self, values: impl Iterator<Item = f64>) -> Self {
        let mut own: Vec<f64> = values.collect();
        own.sort_by(f64::total_cmp);
        own.dedup();
        let places: Vec<i32> = own.iter().map(|value| self.place(*value)).collect();
        let has_room = places.windows(2).all(|pair| pair[1] - pair[0] >= 44);
        if has_room && !own.is_empty() {
            self.ticks = own;
        }
        self
    }

    fn place(&self, value: f64) -> i32 {
        let value = if self.is_log {
            value.max(1e-300).log10()
        } else {
            value
        };
        let part = ((value - self.low) / (self.high - self.low)).clamp(0.0, 1.0);
        let (from, to) = self.pixels;
        from + (part * f64::from(to - from)).round() as i32
    }
}

/// Powers of ten; if there are few, also 2 and 5 times these.
fn log_ticks(low: f64, high: f64) -> Vec<f64> {
    let steps: &[f64] = if high - low > 3.0 {
        &[1.0]
    } else {
        &[1.0, 2.0, 5.0]
    };
    let mut ticks = Vec::new();
    for power in low.floor() as i32..=high.ceil() as i32 {
        let of_power = steps.iter().map(|step| step * 10_f64.powi(power));
        ticks.extend(of_power.filter(|tick| (low..=high).contains(&tick.log10())));
    }
    ticks
}

/// About six ticks from 0 on, at multiples of 1, 2 or 5 times a power of ten.
fn linear_ticks(high: f64) -> Vec<f64> {
    let rough = high / 6.0;
    let power = 10_f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .map(|factor| factor * power)
        .find(|step| *step >= rough)
        .unwrap_or(power);
    (0..)
        .map(|i| f64::from(i) * step)
        .take_while(|tick| *tick <= high * (1.0 + 1e-9))
        .collect()
}

/// `0.5`, `256`, `16,384`, `300 k`, `64 M`.
fn tick_text(value: f64) -> String {
    let is_whole_in = |unit: f64| value >= 10.0 * unit && (value / unit).fract() == 0.0;
    if value >= 1e6 && (value / 1e5).fract() == 0.0 {
        return format!("{} M", value / 1e6);
    }
    if is_whole_in(1e3) {
        return format!("{} k", value / 1e3);
    }
    if value >= 10.0 || value.fract() == 0.0 {
        return grouped(value.round());
    }
    let decimals = if value > 0.0 {
        (1.0 - value.log10()).ceil().max(0.0) as usize
    } else {
        0
    };
    let text = format!("{value:.decimals$}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_numbers_within_the_axis() {
        assert_eq!(linear_ticks(106.0), [0.0, 20.0, 40.0, 60.0, 80.0, 100.0]);
        assert_eq!(linear_ticks(0.3).len(), 7);
        let near = |ticks: Vec<f64>, expected: &[f64]| {
            let all = ticks.iter().zip(expected);
            assert!(
                ticks.len() == expected.len()
                    && all.clone().all(|(a, b)| (a / b - 1.0).abs() < 1e-9),
                "{ticks:?}"
            );
        };
        near(log_ticks(3.9, 6.1), &[1e4, 2e4, 5e4, 1e5, 2e5, 5e5, 1e6]);
        near(log_ticks(-1.1, 3.1), &[0.1, 1.0, 10.0, 100.0, 1000.0]);
    }

    #[test]
    fn numbers_at_axes_are_short() {
        let cases = [
            (0.0, "0"),
            (0.02, "0.02"),
            (0.5, "0.5"),
            (2.5, "2.5"),
            (256.0, "256"),
            (1024.0, "1024"),
            (16_384.0, "16,384"),
            (10_000.0, "10 k"),
            (300_000.0, "300 k"),
            (2_500_000.0, "2.5 M"),
            (64_000_000.0, "64 M"),
        ];
        for (value, text) in cases {
            assert_eq!(tick_text(value), text);
        }
    }

    #[test]
    fn scales_keep_order_and_ends() {
        for axis in [Axis::linear("x"), Axis::log("x")] {
            let values = [1.0, 3.0, 10.0, 1000.0];
            let scale = Scale::of(&axis, values.into_iter(), (100, 500));
            let places = values.map(|value| scale.place(value));
            assert!(places.is_sorted() && places[0] >= 100 && places[3] <= 500);
            assert!(
                places[0] < places[3] - 300,
                "they fill the axis: {places:?}"
            );
            let reversed = Scale::of(&axis, values.into_iter(), (500, 100));
            assert!(reversed.place(1000.0) < reversed.place(1.0), "up is more");
        }
    }

    #[test]
    fn both_files_are_drawn_and_hold_names_and_points() {
        let dot = |x, y| Dot {
            x,
            y,
            low: 0.9 * y,
            high: 1.1 * y,
        };
        let line = |name: &str, factor: f64| Line {
            name: name.to_owned(),
            points: vec![dot(10.0, factor), dot(100.0, 10.0 * factor), dot(0.0, 1.0)],
        };
        let plot = Plot {
            name: "test".to_owned(),
            title: "A title".to_owned(),
            x: Axis::log("particles"),
            y: Axis::log("ms a step"),
            lines: vec![line("first", 1.0), line("second", 3.0)],
        };
        assert!(!plot.is_empty());
        let svg = plot.svg().expect("it is drawn");
        for text in ["A title", "particles", "ms a step", "first", "second"] {
            assert!(svg.contains(text), "{text}");
        }
        // Values without a logarithm are left out: two points of each line, and two marks in the legend.
        assert_eq!(svg.matches("<circle").count(), 3, "{svg}");
        let png = plot.png().expect("it is drawn");
        let picture = image::load_from_memory(&png)
            .expect("it is a PNG")
            .to_rgb8();
        assert_eq!(picture.dimensions(), SIZE);
        for color in &COLORS[..2] {
            let RGBColor(red, green, blue) = *color;
            let found = picture.pixels().filter(|p| p.0 == [red, green, blue]);
            assert!(found.count() > 50, "{color:?}");
        }
        let nothing = Plot {
            lines: Vec::new(),
            ..plot
        };
        assert!(nothing.is_empty() && nothing.svg().is_ok());
    }
}
