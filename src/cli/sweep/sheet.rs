//! The sheet of a grid's pictures: side by side, with the values of two of its parameters.

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder as _, RgbImage, imageops};
use myxo::sweep::{Axis, Folder, Job, Study};
use myxo::{Error, Result};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};
use serde_json::Value;

use crate::cli::letters::{PALE, style};
use crate::cli::pixels::Pixels;

/// The longest side of a sheet, pixels.
const LONGEST_SIDE: u64 = 8192;
/// Pixels between pictures, and round the sheet.
const GAP: u64 = 4;
/// Height of a line of text, its letters, and the width that a letter takes at most in the mean.
const LINE: u64 = 24;
const LETTERS: i32 = 16;
const LETTER: u64 = 9;
/// Longer labels end in dots.
const LONGEST_LABEL: usize = 32;

/// Which pictures there are, and where. Of a grid of more than two parameters with several values, those between the first and the last
/// have their first value; and all runs have the first seed. A line below says so.
#[derive(Clone, Debug, PartialEq)]
pub struct Sheet {
    /// Of a picture, pixels.
    size: [u32; 2],
    /// The first parameter, from row to row; none if only one has several values.
    rows: Option<Labels>,
    /// The last parameter, from column to column.
    columns: Labels,
    /// What all pictures have in common of what the study varies: `trail.decay = 0.9, seed 0`; empty if there is nothing.
    slice: String,
    /// The keys of the runs, row by row.
    runs: Vec<String>,
}

/// A parameter and its values, as texts.
#[derive(Clone, Debug, PartialEq)]
struct Labels {
    name: String,
    values: Vec<String>,
}

impl Sheet {
    /// The sheet of a study whose points are a grid, and whose runs have pictures. `jobs` are all of its jobs.
    pub fn of(study: &Study, jobs: &[Job]) -> Option<Self> {
        let size = study.picture?;
        let axes = &study.axes;
        let last = axes.len().checked_sub(1)?;
        // How many points lie between two neighbours along each axis.
        let mut apart = vec![1; axes.len()];
        for i in (1..axes.len()).rev() {
            apart[i - 1] = apart[i] * axes[i].values.len();
        }
        let several: Vec<usize> = (0..axes.len())
            .filter(|&i| axes[i].values.len() > 1)
            .collect();
        let column = several.last().copied().unwrap_or(last);
        let row = several.first().copied().filter(|&row| row != column);
        let mut runs = Vec::new();
        for r in 0..row.map_or(1, |row| axes[row].values.len()) {
            for c in 0..axes[column].values.len() {
                let point = row.map_or(0, |row| r * apart[row]) + c * apart[column];
                runs.push(jobs[point * study.seeds.len()].key.clone());
            }
        }
        let between = several.iter().filter(|&&i| i != column && Some(i) != row);
        let mut slice: Vec<String> = between
            .map(|&i| format!("{} = {}", axes[i].key, text_of(&axes[i].values[0])))
            .collect();
        if study.seeds.len() > 1 {
            slice.push(format!("seed {}", study.seeds[0]));
        }
        Some(Self {
            size,
            slice: slice.join(", "),
            rows: row.map(|row| Labels::of(&axes[row])),
            columns: Labels::of(&axes[column]),
            runs,
        })
    }

    /// Why it is not drawn, if it would be too large.
    pub fn too_large(&self) -> Option<String> {
        let Layout { width, height, .. } = self.layout();
        (width.max(height) > LONGEST_SIDE).then(|| {
            format!(
                "no sheet.png will be drawn: it would have {width} x {height} pixels, and has at most {LONGEST_SIDE} a side; \
                 for one, choose a smaller `picture`"
            )
        })
    }

    /// Are all of its runs done, each with its picture, an error, or a note that it could not be drawn?
    pub fn is_ready(&self, folder: &Folder) -> Result<bool> {
        for run in &self.runs {
            if !folder.is_done(run, Some(self.size), false)? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// As a PNG. Runs without a picture are grey, and say whether they have an error.
    pub fn png(&self, folder: &Folder) -> Result<Vec<u8>> {
        let failure = |error: &dyn std::fmt::Display| {
            Error::Invalid(format!("cannot draw the sheet of pictures: {error}"))
        };
        let layout = self.layout();
        let mut empty = Vec::new();
        for (number, run) in self.runs.iter().enumerate() {
            if !folder.has_picture(run, self.size) {
                let is_good = folder.has(run, true)?;
                empty.push((number, if is_good { "no picture" } else { "error" }));
            }
        }
        let mut sheet = RgbImage::new(layout.width as u32, layout.height as u32);
        let area = Pixels::new(&mut sheet).into_drawing_area();
        self.draw_labels(&area, &layout)
            .and_then(|()| self.draw_empty(&area, &layout, &empty))
            .map_err(|error| failure(&error))?;
        drop(area);
        for (number, run) in self.runs.iter().enumerate() {
            if let Some(picture) = folder.picture(run, self.size)? {
                let (x, y) = self.place(&layout, number);
                imageops::replace(&mut sheet, &picture, x.into(), y.into());
            }
        }
        let mut bytes = Vec::new();
        // It is written once and looked at often.
        PngEncoder::new_with_quality(&mut bytes, CompressionType::Best, FilterType::Adaptive)
            .write_image(
                sheet.as_raw(),
                sheet.width(),
                sheet.height(),
                ExtendedColorType::Rgb8,
            )
            .map_err(|error| failure(&error))?;
        Ok(bytes)
    }

    fn layout(&self) -> Layout {
        let [width, height] = self.size.map(u64::from);
        let across = width.max(self.columns.width()) + GAP;
        let down = height.max(LINE) + GAP;
        let row_count = self.rows.as_ref().map_or(1, |rows| rows.values.len());
        let pictures = [
            self.columns.values.len() as u64 * across - GAP,
            row_count as u64 * down - GAP,
        ];
        // Names may be longer than all pictures together.
        let row_name = self.rows.as_ref().map_or(0, |rows| width_of(&rows.name));
        let room = [
            pictures[0].max(width_of(&self.columns.name)),
            pictures[1].max(row_name),
        ];
        let left = match &self.rows {
            Some(rows) => LINE + rows.width() + 2 * GAP,
            None => GAP,
        };
        let top = 2 * LINE + GAP;
        let below = if self.slice.is_empty() { GAP } else { LINE };
        Layout {
            first: [
                left + (room[0] - pictures[0]) / 2,
                top + (room[1] - pictures[1]) / 2,
            ],
            apart: [across, down],
            middle: [left + room[0] / 2, top + room[1] / 2],
            width: (left + room[0]).max(GAP + width_of(&self.slice)) + GAP,
            height: top + room[1] + below,
        }
    }

    /// The upper left corner of a picture.
    fn place(&self, layout: &Layout, number: usize) -> (i32, i32) {
        let column_count = self.columns.values.len();
        let [x, y] = layout.cell(number % column_count, number / column_count);
        let [width, height] = self.size.map(u64::from);
        let x = x + (layout.apart[0] - GAP - width) / 2;
        let y = y + (layout.apart[1] - GAP - height) / 2;
        (x as i32, y as i32)
    }

    fn draw_labels<DB: DrawingBackend>(
        &self,
        area: &DrawingArea<DB, Shift>,
        layout: &Layout,
    ) -> Drawn<DB> {
        area.fill(&WHITE)?;
        let centred = style(LETTERS, HPos::Center, VPos::Center);
        let line = LINE as i32;
        let [middle, half_way] = layout.middle.map(|pixels| pixels as i32);
        let name = self.columns.name.clone();
        area.draw(&Text::new(name, (middle, line / 2), centred.clone()))?;
        let above = layout.first[1] as i32 - line / 2;
        for (column, value) in self.columns.values.iter().enumerate() {
            let [x, _] = layout.cell(column, 0);
            let x = x + (layout.apart[0] - GAP) / 2;
            let place = (x as i32, above);
            area.draw(&Text::new(value.clone(), place, centred.clone()))?;
        }
        if !self.slice.is_empty() {
            let place = (GAP as i32, layout.height as i32 - line / 2);
            area.draw(&Text::new(
                self.slice.clone(),
                place,
                style(LETTERS, HPos::Left, VPos::Center),
            ))?;
        }
        let Some(rows) = &self.rows else {
            return Ok(());
        };
        let upright = centred.transform(FontTransform::Rotate270);
        area.draw(&Text::new(rows.name.clone(), (line / 2, half_way), upright))?;
        let beside = layout.first[0] - GAP;
        for (row, value) in rows.values.iter().enumerate() {
            let [_, y] = layout.cell(0, row);
            let y = y + (layout.apart[1] - GAP) / 2;
            let place = (beside as i32, y as i32);
            area.draw(&Text::new(
                value.clone(),
                place,
                style(LETTERS, HPos::Right, VPos::Center),
            ))?;
        }
        Ok(())
    }

    /// Words in place of pictures that there are not.
    fn draw_empty<DB: DrawingBackend>(
        &self,
        area: &DrawingArea<DB, Shift>,
        layout: &Layout,
        empty: &[(usize, &str)],
    ) -> Drawn<DB> {
        let [width, height] = self.size.map(|side| side as i32);
        for &(number, word) in empty {
            let has_room =
                u64::from(self.size[0]) >= width_of(word) && u64::from(self.size[1]) >= LINE;
            let (x, y) = self.place(layout, number);
            let corners = [(x, y), (x + width - 1, y + height - 1)];
            area.draw(&Rectangle::new(corners, PALE.filled()))?;
            if has_room {
                let place = (x + width / 2, y + height / 2);
                area.draw(&Text::new(
                    word,
                    place,
                    style(LETTERS, HPos::Center, VPos::Center),
                ))?;
            }
        }
        Ok(())
    }
}

type Drawn<DB> = Result<(), DrawingAreaErrorKind<<DB as DrawingBackend>::ErrorType>>;

/// Where everything lies, in pixels, across and down.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Layout {
    /// The upper left corner of the first picture's cell.
    first: [u64; 2],
    /// From cell to cell.
    apart: [u64; 2],
    /// The middle of the names.
    middle: [u64; 2],
    width: u64,
    height: u64,
}

impl Layout {
    /// The upper left corner of a cell.
    fn cell(&self, column: usize, row: usize) -> [u64; 2] {
        [
            self.first[0] + column as u64 * self.apart[0],
            self.first[1] + row as u64 * self.apart[1],
        ]
    }
}

impl Labels {
    fn of(axis: &Axis) -> Self {
        Self {
            name: shortened(&axis.key),
            values: axis.values.iter().map(text_of).collect(),
        }
    }

    /// Pixels that its longest value takes at most.
    fn width(&self) -> u64 {
        let widths = self.values.iter().map(|value| width_of(value));
        widths.max().unwrap_or(0)
    }
}

/// Pixels that a text takes at most.
fn width_of(text: &str) -> u64 {
    text.chars().count() as u64 * LETTER
}

/// A value as a label: `45`, `0.5`, `walk`, `[0,1,0]`.
fn text_of(value: &Value) -> String {
    let text = match value {
        Value::String(text) if text.is_empty() => "\"\"".to_owned(),
        Value::String(text) => text.clone(),
        // Without the point of a whole number.
        Value::Number(number) => number
            .as_f64()
            .map_or_else(|| number.to_string(), |number| number.to_string()),
        other => other.to_string(),
    };
    shortened(&text)
}

fn shortened(text: &str) -> String {
    if text.chars().count() <= LONGEST_LABEL {
        return text.to_owned();
    }
    let begin: String = text.chars().take(LONGEST_LABEL - 3).collect();
    format!("{begin}...")
}

#[cfg(test)]
mod tests {
    use myxo::sweep::{Row, Shard};

    use super::*;

    fn read(text: &str) -> (Study, Vec<Job>) {
        let folder = tempfile::tempdir().expect("there is room");
        let file = folder.path().join("study.toml");
        let text = format!("scene = \"cube\"\npicture = \"40x30\"\nseeds = 2\n{text}");
        std::fs::write(&file, text).expect("there is room");
        let study = Study::read(&file).expect("it is right");
        let (_, jobs) = study.jobs().expect("they are made");
        (study, jobs)
    }

    fn key(jobs: &[Job], values: [f64; 3]) -> &String {
        let is_meant = |job: &&Job| {
            let own = (job.point.0.iter()).map(|(_, value)| value.as_f64());
            job.seed == 0 && own.eq(values.map(Some))
        };
        &jobs.iter().find(is_meant).expect("there is one").key
    }

    /// Catches rows and columns that change places, values between them that are not the first, and a line that names others.
    #[test]
    fn rows_are_the_first_parameter_and_columns_the_last() {
        let (study, jobs) =
            read("[grid]\n\"a\" = [1, 2]\n\"b\" = [3, 4, 5]\n\"c\" = [6.0, 0.25, 7]\n");
        let sheet = Sheet::of(&study, &jobs).expect("it is a grid");
        let expected = [
            [1.0, 3.0, 6.0],
            [1.0, 3.0, 0.25],
            [1.0, 3.0, 7.0],
            [2.0, 3.0, 6.0],
            [2.0, 3.0, 0.25],
            [2.0, 3.0, 7.0],
        ];
        assert!(
            sheet
                .runs
                .iter()
                .eq(expected.map(|values| key(&jobs, values)))
        );
        let rows = sheet.rows.as_ref().expect("there are two");
        assert_eq!(
            (&*rows.name, &rows.values[..]),
            ("a", &["1", "2"].map(str::to_owned)[..])
        );
        assert_eq!(sheet.columns.name, "c");
        assert_eq!(sheet.columns.values, ["6", "0.25", "7"]);
        assert_eq!(sheet.slice, "b = 3, seed 0");
        // A parameter with one value is no side.
        let (study, jobs) = read("[grid]\n\"a\" = [1]\n\"b\" = [3, 4, 5]\n\"c\" = [6]\n");
        let sheet = Sheet::of(&study, &jobs).expect("it is a grid");
        assert_eq!((sheet.rows.is_none(), &*sheet.columns.name), (true, "b"));
        assert_eq!(sheet.slice, "seed 0");
        let expected = [3.0, 4.0, 5.0].map(|b| key(&jobs, [1.0, b, 6.0]));
        assert!(sheet.runs.iter().eq(expected));
        let (study, jobs) = read("[grid]\n\"a\" = [1]\n\"b\" = [2]\n\"c\" = [3]\n");
        let sheet = Sheet::of(&study, &jobs).expect("it is a grid");
        assert_eq!((sheet.runs.len(), &*sheet.columns.name), (1, "c"));
    }

    #[test]
    fn only_grids_with_pictures_have_a_sheet() {
        let (study, jobs) = read("[[point]]\n\"a\" = 1\n");
        assert_eq!(Sheet::of(&study, &jobs), None);
        let (study, jobs) = read("[sample]\ncount = 4\nranges.\"a\" = [0, 1]\n");
        assert_eq!(Sheet::of(&study, &jobs), None);
        let (mut study, jobs) = read("[grid]\n\"a\" = [1, 2]\n");
        assert!(Sheet::of(&study, &jobs).is_some());
        study.picture = None;
        assert_eq!(Sheet::of(&study, &jobs), None);
    }

    #[test]
    fn a_sheet_that_is_too_large_says_so() {
        let values: Vec<String> = (0..300).map(|value| value.to_string()).collect();
        let (study, jobs) = read(&format!("[grid]\n\"a\" = [{}]\n", values.join(", ")));
        let sheet = Sheet::of(&study, &jobs).expect("it is a grid");
        let why = sheet.too_large().expect("it is");
        assert!(why.contains("13204 x") && why.contains("8192"), "{why}");
        let (study, jobs) = read("[grid]\n\"a\" = [1, 2]\n");
        let sheet = Sheet::of(&study, &jobs).expect("it is a grid");
        assert_eq!(sheet.too_large(), None);
    }

    /// Catches pictures in wrong cells, labels that are missing or lie under pictures, and cells of failed runs that look like pictures.
    #[test]
    fn pictures_lie_in_their_cells_with_labels_around() {
        let (study, jobs) =
            read("[grid]\n\"physarum.speed\" = [1, 2]\n\"trail.decay\" = [0.5, 0.6]\n");
        let sheet = Sheet::of(&study, &jobs).expect("it is a grid");
        let place = tempfile::tempdir().expect("there is room");
        let folder = Folder::claim(place.path(), &Value::Null, Shard::WHOLE).expect("it is new");
        assert!(!sheet.is_ready(&folder).expect("it is read"));
        let colour = |number: usize| image::Rgb([10, 200, 60 * number as u8]);
        for (number, run) in sheet.runs.iter().enumerate() {
            let mut row = Row::default();
            row.set(
                "error",
                if number == 3 {
                    Value::from("too hot")
                } else {
                    Value::Null
                },
            );
            folder.keep(run, &row, None).expect("there is room");
            if number < 3 {
                let mut png = std::io::Cursor::new(Vec::new());
                RgbImage::from_pixel(40, 30, colour(number))
                    .write_to(&mut png, image::ImageFormat::Png)
                    .expect("it is drawn");
                folder
                    .keep_picture(run, png.get_ref())
                    .expect("there is room");
            }
        }
        assert!(sheet.is_ready(&folder).expect("it is read"));
        let png = sheet.png(&folder).expect("it is drawn");
        assert_eq!(png, sheet.png(&folder).expect("it is drawn again"));
        let drawn = image::load_from_memory(&png)
            .expect("it is a PNG")
            .into_rgb8();
        // Both names are longer than the pictures beside them.
        let left = 24 + 9 + 8;
        let top = 2 * 24 + 4;
        let names = [11 * 9, 14 * 9];
        assert_eq!(
            drawn.dimensions(),
            (left + names[0] + 4, top + names[1] + 24)
        );
        let first = [left + (names[0] - 84) / 2, top + (names[1] - 64) / 2];
        for number in 0..4 {
            let [x, y] = [first[0] + 44 * (number % 2), first[1] + 34 * (number / 2)];
            let of_cell = imageops::crop_imm(&drawn, x, y, 40, 30).to_image();
            if number < 3 {
                let expected = RgbImage::from_pixel(40, 30, colour(number as usize));
                assert!(of_cell == expected, "picture {number}");
            } else {
                assert_eq!(of_cell.get_pixel(0, 0).0, [222, 224, 228]);
                assert_eq!(of_cell.get_pixel(39, 29).0, [222, 224, 228]);
            }
        }
        let ink = |x: u32, y: u32, width: u32, height: u32| {
            let part = imageops::crop_imm(&drawn, x, y, width, height).to_image();
            part.pixels().filter(|pixel| pixel.0[0] < 200).count()
        };
        let width = drawn.width();
        assert!(
            ink(left, 0, width - left, 24) > 40,
            "the name of the columns"
        );
        for column in 0..2 {
            let x = first[0] + 44 * column;
            assert!(ink(x, first[1] - 24, 40, 24) > 10, "column {column}");
        }
        assert!(ink(0, top, 24, names[1]) > 40, "the name of the rows");
        assert!(ink(0, top + names[1], 100, 24) > 20, "the seed");
        for row in 0..2 {
            let y = first[1] + 34 * row;
            assert!(ink(24, y, first[0] - 24, 30) > 3, "row {row}");
        }
    }
}
