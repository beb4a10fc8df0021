//! The folder of a sweep: what the study is, a row for each run that is done, and the table of them.

use std::collections::HashMap;
use std::fs::{self, File, TryLockError};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use image::{ImageFormat, RgbImage};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::identity::with_plain_numbers;
use super::row::Row;
use super::table::Table;
use crate::error::{Error, Result};
use crate::plain_text::Shown as _;
use crate::whole_file::write_whole;

/// Held by a whole sweep alone, and by shards together.
const LOCK: &str = ".lock";
/// Held while the table is written.
const TABLE_LOCK: &str = ".table-lock";
const STUDY: &str = "study.json";
const RUNS: &str = "runs";
const FIELDS: &str = "fields";
const PICTURES: &str = "pictures";
/// The pictures of a grid, side by side.
const SHEET: &str = "sheet.png";

/// A part of a sweep: each `of`-th job from the `number`-th on, counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Which part.
    pub number: usize,
    /// Of so many.
    pub of: usize,
}

impl Shard {
    /// All jobs.
    pub const WHOLE: Self = Self { number: 0, of: 1 };

    /// A part of a sweep.
    ///
    /// # Errors
    /// When there is no such part.
    pub fn new(number: usize, of: usize) -> Result<Self> {
        if number >= of {
            return Err(Error::Invalid(format!(
                "there is no shard {number} of {of}: they are counted from 0"
            )));
        }
        Ok(Self { number, of })
    }

    /// Its part of all jobs.
    pub fn part<T>(self, jobs: Vec<T>) -> Vec<T> {
        jobs.into_iter()
            .skip(self.number)
            .step_by(self.of)
            .collect()
    }
}

/// What stands in a folder in place of a picture that could not be drawn.
#[derive(Debug, Serialize, Deserialize)]
struct Undrawn {
    /// Of the picture, pixels.
    size: [u32; 2],
    error: String,
}

/// The folder of a sweep. As long as this is kept, no other process can claim it for the same shard, or, if this is a whole sweep, at all.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    _locks: Vec<File>,
}

impl Folder {
    /// Makes the folder, or checks that it is of this study. `fixed` is what all runs of the study have in common.
    ///
    /// # Errors
    /// When the folder holds another study, another process writes into it ([`Error::Busy`]), or it cannot be written.
    pub fn claim(path: &Path, fixed: &Value, shard: Shard) -> Result<Self> {
        let runs = path.join(RUNS);
        fs::create_dir_all(&runs).map_err(Error::io("create", &runs))?;
        let mut locks = vec![lock(path, LOCK, shard != Shard::WHOLE)?];
        if shard != Shard::WHOLE {
            let own = format!("{LOCK}-{}-of-{}", shard.number, shard.of);
            locks.push(lock(path, &own, false)?);
        }
        let folder = Self {
            path: path.to_owned(),
            _locks: locks,
        };
        folder.check_study(fixed)?;
        Ok(folder)
    }

    fn check_study(&self, fixed: &Value) -> Result<()> {
        let file = self.path.join(STUDY);
        // In this order: another shard may begin at the same time, which writes the study before its first row.
        let has_runs = self.row_files()?.next().is_some();
        if !file.exists() {
            if has_runs {
                return Err(Error::Invalid(format!(
                    "{} has runs, and no {STUDY} that says of which study: choose another folder",
                    self.path.shown()
                )));
            }
            let text = format!("{fixed:#}\n");
            return write_whole(&file, text).map_err(Error::io("write", &file));
        }
        let text = fs::read(&file).map_err(Error::io("read", &file))?;
        let before: Value = serde_json::from_slice(&text).map_err(|error| {
            Error::Invalid(format!(
                "{} is damaged ({error}): choose another folder",
                file.shown()
            ))
        })?;
        match difference(&with_plain_numbers(&before), &with_plain_numbers(fixed)) {
            None => Ok(()),
            Some((key, old, now)) => Err(Error::Invalid(format!(
                "{} holds another study: its {key} is {old}, and here it is {now}: choose another folder",
                self.path.shown()
            ))),
        }
    }

    /// Is there a row of this run? With `retry`, one without an error?
    ///
    /// # Errors
    /// When a row cannot be read.
    pub fn has(&self, key: &str, retry: bool) -> Result<bool> {
        let file = self.row_file(key);
        Ok(file.exists() && !(retry && read_row(&file)?.failed()))
    }

    /// As [`has`](Self::has), and if runs have pictures of this size: is there that of this run, too, or, without `retry`, a note that it
    /// could not be drawn? A run with an error needs none. A run without its picture is not done: it is run again, and its row is written
    /// again, unless it fails then.
    ///
    /// # Errors
    /// When a row or a note cannot be read.
    pub fn is_done(&self, key: &str, picture: Option<[u32; 2]>, retry: bool) -> Result<bool> {
        if !self.has(key, retry)? {
            return Ok(false);
        }
        let Some(size) = picture else { return Ok(true) };
        Ok(self.has_picture(key, size)
            || (!retry && self.undrawn(key, size)?)
            || read_row(&self.row_file(key))?.failed())
    }

    /// Is there a note that the picture of a run could not be drawn in this size?
    ///
    /// # Errors
    /// When the note cannot be read.
    pub fn undrawn(&self, key: &str, size: [u32; 2]) -> Result<bool> {
        let file = self.note_file(key);
        if !file.exists() {
            return Ok(false);
        }
        Ok(read_json::<Undrawn>(&file)?.size == size)
    }

    /// Is there a picture of this run, of this size?
    #[must_use]
    pub fn has_picture(&self, key: &str, size: [u32; 2]) -> bool {
        image::image_dimensions(self.picture_file(key))
            .is_ok_and(|found| found == (size[0], size[1]))
    }

    /// The picture of a run, if there is one of this size.
    ///
    /// # Errors
    /// When it cannot be read.
    pub fn picture(&self, key: &str, size: [u32; 2]) -> Result<Option<RgbImage>> {
        if !self.has_picture(key, size) {
            return Ok(None);
        }
        let file = self.picture_file(key);
        let bytes = fs::read(&file).map_err(Error::io("read", &file))?;
        let picture = image::load_from_memory_with_format(&bytes, ImageFormat::Png);
        let picture = picture.map_err(|error| {
            Error::Invalid(format!(
                "{} is damaged ({error}): remove it, and its run is done again",
                file.shown()
            ))
        })?;
        Ok(Some(picture.into_rgb8()))
    }

    /// Writes the picture of a run, a PNG; before its row, so that a run that counts as done has both.
    ///
    /// # Errors
    /// When the file cannot be written; then the run counts as not done.
    pub fn keep_picture(&self, key: &str, png: &[u8]) -> Result<()> {
        let file = self.picture_file(key);
        write_whole(&file, png).map_err(Error::io("write", &file))?;
        remove(&self.note_file(key))
    }

    /// Writes that the picture of a run could not be drawn in this size, and why; before its row, as a picture.
    ///
    /// # Errors
    /// When the file cannot be written; then the run counts as not done.
    pub fn keep_undrawn(&self, key: &str, size: [u32; 2], error: &str) -> Result<()> {
        let file = self.note_file(key);
        let error = error.to_owned();
        let text = serde_json::to_string(&Undrawn { size, error }).expect("it is plain");
        write_whole(&file, text).map_err(Error::io("write", &file))
    }

    /// Writes the sheet of pictures, a PNG, unless it is there as it would be written; its path.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn keep_sheet(&self, png: &[u8]) -> Result<PathBuf> {
        let file = self.path.join(SHEET);
        if !fs::read(&file).is_ok_and(|before| before == png) {
            write_whole(&file, png).map_err(Error::io("write", &file))?;
        }
        Ok(file)
    }

    /// Removes a sheet of pictures that would not be drawn as it is.
    ///
    /// # Errors
    /// When it cannot be removed.
    pub fn remove_sheet(&self) -> Result<()> {
        remove(&self.path.join(SHEET))
    }

    /// Writes the row of a run, after its fields, which are a file of arrays.
    ///
    /// # Errors
    /// When a file cannot be written; then the run counts as not done.
    pub fn keep(&self, key: &str, row: &Row, fields: Option<&[u8]>) -> Result<()> {
        if let Some(fields) = fields {
            let file = self.path.join(FIELDS).join(format!("{key}.npz"));
            write_whole(&file, fields).map_err(Error::io("write", &file))?;
        }
        let file = self.row_file(key);
        let text = serde_json::to_string(row).expect("its names are texts");
        write_whole(&file, text).map_err(Error::io("write", &file))
    }

    /// The rows of those runs of a study that are done, by the number of their point and their seed. `runs` has the key of each run
    /// and the number of its point, which changes as the study grows.
    ///
    /// # Errors
    /// When one cannot be read.
    pub fn rows(&self, runs: &HashMap<String, usize>) -> Result<Vec<Row>> {
        let mut rows = Vec::new();
        for file in self.row_files()? {
            let number = file.file_stem().and_then(|key| runs.get(key.to_str()?));
            if let Some(&number) = number {
                let mut row = read_row(&file)?;
                row.set("run", number);
                rows.push(row);
            }
        }
        let place = |row: &Row| ["run", "seed"].map(|name| row.get(name).and_then(Value::as_u64));
        rows.sort_by_key(place);
        Ok(rows)
    }

    /// Writes the table of [`rows`](Self::rows), as `table.csv` and `table.parquet`; their paths.
    ///
    /// # Errors
    /// When a row cannot be read, or a file cannot be written.
    pub fn write_table(&self, runs: &HashMap<String, usize>) -> Result<[PathBuf; 2]> {
        // Of two shards that end together, the later one has the rows of both.
        let path = self.path.join(TABLE_LOCK);
        let locked = lock_file(&path)?;
        // As for rows, there may be no locks.
        let _ = locked.lock();
        let table = Table::of(&self.rows(runs)?);
        let files = ["table.csv", "table.parquet"].map(|name| self.path.join(name));
        let contents = [table.csv()?, table.parquet()?];
        for (file, content) in files.iter().zip(contents) {
            write_whole(file, content).map_err(Error::io("write", file))?;
        }
        Ok(files)
    }

    fn row_file(&self, key: &str) -> PathBuf {
        self.path.join(RUNS).join(format!("{key}.json"))
    }

    fn picture_file(&self, key: &str) -> PathBuf {
        self.path.join(PICTURES).join(format!("{key}.png"))
    }

    fn note_file(&self, key: &str) -> PathBuf {
        self.path.join(PICTURES).join(format!("{key}.json"))
    }

    fn row_files(&self) -> Result<impl Iterator<Item = PathBuf> + use<>> {
        let runs = self.path.join(RUNS);
        let entries = fs::read_dir(&runs).map_err(Error::io("read", &runs))?;
        let is_row = |file: &PathBuf| {
            let is_hidden = file
                .file_name()
                .is_some_and(|name| name.as_encoded_bytes().starts_with(b"."));
            !is_hidden && file.extension().is_some_and(|ending| ending == "json")
        };
        Ok(entries.flatten().map(|entry| entry.path()).filter(is_row))
    }
}

fn read_row(file: &Path) -> Result<Row> {
    read_json(file)
}

fn read_json<T: DeserializeOwned>(file: &Path) -> Result<T> {
    let text = fs::read(file).map_err(Error::io("read", file))?;
    serde_json::from_slice(&text).map_err(|error| {
        Error::Invalid(format!(
            "{} is damaged ({error}): remove it, and its run is done again",
            file.shown()
        ))
    })
}

/// Removes a file, if it is there.
fn remove(file: &Path) -> Result<()> {
    match fs::remove_file(file) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(Error::io("remove", file)(error)),
        _ => Ok(()),
    }
}

/// The first difference between two studies: what it is in, and its values; the scene last, which the others are a part of.
fn difference(before: &Value, now: &Value) -> Option<(String, Value, Value)> {
    let keys = [
        "steps",
        "preset",
        "run",
        "version",
        "arithmetic",
        "settings",
        "scene",
    ];
    let key = keys.into_iter().find(|&key| before[key] != now[key])?;
    let (old, new) = (&before[key], &now[key]);
    let settings = [old, new].into_iter().filter_map(Value::as_object);
    for (setting, _) in settings.flatten() {
        if old[setting] != new[setting] {
            return Some((setting.clone(), old[setting].clone(), new[setting].clone()));
        }
    }
    Some((key.to_owned(), old.clone(), new.clone()))
}

fn lock_file(path: &Path) -> Result<File> {
    let options = File::options().create(true).append(true).clone();
    options.open(path).map_err(Error::io("write", path))
}

/// Locks a file; the system frees it when the process ends, in whatever way.
fn lock(folder: &Path, name: &str, shared: bool) -> Result<File> {
    let file = lock_file(&folder.join(name))?;
    let locked = if shared {
        file.try_lock_shared()
    } else {
        file.try_lock()
    };
    match locked {
        Ok(()) => Ok(file),
        Err(TryLockError::WouldBlock) => Err(Error::Busy(format!(
            "another sweep writes into {}: wait for it, or choose another folder",
            folder.shown()
        ))),
        // Some network disks have no locks: two sweeps at once then do some runs twice, with equal results.
        Err(TryLockError::Error(_)) => Ok(file),
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn row(run: u64, error: Value) -> Row {
        let mut row = Row::default();
        row.set("run", run);
        row.set("seed", 0);
        row.set("error", error);
        row
    }

    /// Catches rows that are lost or run again, and failed ones that cannot be.
    #[test]
    fn rows_are_kept_and_failed_ones_can_be_run_again() {
        let place = tempfile::tempdir().expect("there is room");
        let fixed = json!({"steps": 5});
        let folder = Folder::claim(place.path(), &fixed, Shard::WHOLE).expect("it is new");
        assert!(!folder.has("a", false).expect("it is read"));
        folder
            .keep("b", &row(1, "too hot".into()), None)
            .expect("there is room");
        folder
            .keep("a", &row(0, Value::Null), Some(b"arrays"))
            .expect("there is room");
        assert_eq!(
            fs::read(place.path().join("fields/a.npz")).expect("it is there"),
            b"arrays"
        );
        let has = |key, retry| folder.has(key, retry).expect("it is read");
        assert!(has("a", false) && has("a", true) && has("b", false) && !has("b", true));
        // Rows of points that the study has no more are not in the table, and its numbers are those of now.
        folder
            .keep("c", &row(7, Value::Null), None)
            .expect("there is room");
        let runs = [("a", 0), ("b", 1)]
            .map(|(key, number)| (key.to_owned(), number))
            .into();
        folder
            .keep("b", &row(5, "too hot".into()), None)
            .expect("there is room");
        let [csv, _] = folder.write_table(&runs).expect("there is room");
        let text = fs::read_to_string(csv).expect("it is there");
        assert_eq!(text, "run,seed,error\n0,0,\n1,0,too hot\n");
        fs::write(place.path().join("runs/b.json"), "{").expect("there is room");
        let error = folder.rows(&runs).expect_err("it is damaged").to_string();
        assert!(error.contains("b.json is damaged"), "{error}");
    }

    /// Catches runs that count as done without their picture, or with one of another size, failed runs that are done for ever, and runs
    /// that are done again and again for a picture that cannot be drawn.
    #[test]
    fn a_run_is_done_with_its_picture_or_an_error() {
        let place = tempfile::tempdir().expect("there is room");
        let folder =
            Folder::claim(place.path(), &json!({}), Shard::WHOLE).expect("the folder is new");
        let is_done = |key, picture, retry| {
            let is_done = folder.is_done(key, picture, retry);
            is_done.expect("it is read")
        };
        folder
            .keep("a", &row(0, Value::Null), None)
            .expect("there is room");
        folder
            .keep("b", &row(1, "too hot".into()), None)
            .expect("there is room");
        let size = Some([30, 20]);
        assert!(is_done("a", None, false) && !is_done("a", size, false));
        assert!(is_done("b", size, false) && !is_done("b", size, true));
        folder
            .keep_undrawn("a", [30, 20], "no room")
            .expect("there is room");
        assert!(is_done("a", size, false) && !is_done("a", size, true));
        assert!(!is_done("a", Some([20, 30]), false));
        let noise = |x: u32, y: u32| {
            (x * 7919 + y * 104_729)
                .wrapping_mul(2_654_435_761)
                .to_le_bytes()
        };
        let picture =
            RgbImage::from_fn(30, 20, |x, y| image::Rgb([1, 2, 3].map(|i| noise(x, y)[i])));
        let mut png = std::io::Cursor::new(Vec::new());
        picture
            .write_to(&mut png, ImageFormat::Png)
            .expect("it is drawn");
        folder
            .keep_picture("a", png.get_ref())
            .expect("there is room");
        assert!(is_done("a", size, true) && !is_done("a", Some([20, 30]), false));
        assert!(!folder.undrawn("a", [30, 20]).expect("it is read"));
        let read = |key, size| folder.picture(key, size).expect("it is read");
        assert_eq!(read("a", [30, 20]), Some(picture));
        assert_eq!((read("a", [20, 30]), read("b", [30, 20])), (None, None));
        // Half of it still has its size.
        let file = place.path().join("pictures/a.png");
        let half = &png.get_ref()[..png.get_ref().len() / 2];
        fs::write(&file, half).expect("there is room");
        let error = folder
            .picture("a", [30, 20])
            .expect_err("it is damaged")
            .to_string();
        assert!(error.contains("a.png is damaged"), "{error}");
    }

    #[test]
    fn a_folder_is_of_one_study_and_one_process() {
        let place = tempfile::tempdir().expect("there is room");
        let claim = |steps: u32, number, of| {
            let shard = Shard::new(number, of).expect("there is one");
            Folder::claim(place.path(), &json!({"steps": steps}), shard)
        };
        let first = claim(5, 0, 3).expect("it is new");
        let second = claim(5, 2, 3).expect("shards share it");
        for (number, of) in [(2, 3), (0, 1)] {
            let error = claim(5, number, of).expect_err("it is in use");
            assert!(matches!(error, Error::Busy(_)), "{error}");
        }
        drop((first, second));
        let error = claim(6, 0, 1).expect_err("it is another study").to_string();
        assert!(
            error.contains("another study: its steps is 5, and here it is 6"),
            "{error}"
        );
        let study = |decay| json!({"scene": "a 7", "settings": {"trail.decay": decay}});
        let (key, old, now) = difference(&study(0.9), &study(0.95)).expect("they differ");
        assert_eq!((&*key, old, now), ("trail.decay", json!(0.9), json!(0.95)));
        assert_eq!(difference(&study(0.9), &study(0.9)), None);
        let whole = claim(5, 0, 1).expect("it is free again");
        assert!(claim(5, 0, 3).is_err(), "the whole is done by another");
        drop(whole);
        fs::write(place.path().join("runs/a.json"), "{}").expect("there is room");
        fs::remove_file(place.path().join(STUDY)).expect("it is there");
        let error = claim(5, 0, 1)
            .expect_err("it is not known of which study")
            .to_string();
        assert!(error.contains("has runs, and no study.json"), "{error}");
        Shard::new(3, 3).expect_err("the last is 2");
        let parts = Shard::new(1, 3)
            .expect("there is one")
            .part((0..8).collect());
        assert_eq!(parts, [1, 4, 7]);
    }
}
