//! Study files: a scene, and the points of its parameters at which it is run.

use std::collections::HashSet;
use std::ffi::OsStr;
use std::ops::Range;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::identity::{Contents, identity, key_of, with_plain_numbers};
use super::job::Job;
use super::picture::{LONGEST_SIDE, picture_size};
use super::row::Row;
use super::sample::{Method, sample};
use crate::error::{Error, Result};
use crate::plain_text::{Shown as _, escaped};
use crate::regular_file;
use crate::scene::parameters::{Form, Kind, find, form_of};
use crate::scene::suggest::nearest;
use crate::sim::arithmetic;

/// The most runs of a study.
const MOST_RUNS: usize = 10_000_000;
/// Steps of a run, if the study has none.
const STEPS: u64 = 400;

const KEYS: &[&str] = &[
    "scene", "steps", "seeds", "preset", "picture", "network", "set", "grid", "sample", "point",
];
const SAMPLE_KEYS: &[&str] = &["count", "method", "seed", "ranges"];

/// What is run: a scene at points of its parameters, each with several seeds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Study {
    /// A built-in name or a path.
    pub scene: String,
    /// Steps of each run.
    pub steps: u64,
    /// The seeds of each point.
    pub seeds: Vec<u64>,
    /// A preset's name or file.
    pub preset: Option<String>,
    /// Parameters of all runs; a point's values lie over them.
    pub settings: Row,
    /// Values of parameters, for each point.
    pub points: Vec<Row>,
    /// Width and height of the picture of each run, pixels; none without pictures. No result depends on it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub picture: Option<[u32; 2]>,
    /// Do rows have measures of the network as a graph?
    #[serde(default)]
    pub network: bool,
    /// The parameters of a grid, the slowest first; empty where the points are no grid.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub axes: Vec<Axis>,
}

/// A parameter of a grid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Axis {
    /// Its key.
    pub key: String,
    /// Its values, one or more.
    pub values: Vec<Value>,
}

impl Study {
    /// Reads a study file.
    ///
    /// # Errors
    /// When it cannot be read, has an unknown key or a value of a wrong type, or has no points.
    pub fn read(path: &Path) -> Result<Self> {
        let text = regular_file::read_text(path).map_err(Error::io("read", path))?;
        let folder = path.parent().unwrap_or(Path::new(""));
        Text { path, text: &text }.study(folder)
    }

    /// What all runs have in common, for [`Folder::claim`](super::Folder::claim), and the jobs, point by point and seed by seed.
    ///
    /// # Errors
    /// When the scene cannot be loaded.
    pub fn jobs(&self) -> Result<(Value, Vec<Job>)> {
        let job = |number, point: &Row, seed| Job {
            number,
            key: String::new(),
            scene: self.scene.clone(),
            steps: self.steps,
            preset: self.preset.clone(),
            settings: self.settings.clone(),
            point: point.clone(),
            seed,
            picture: self.picture,
            network: self.network,
        };
        let fixed = json!({
            "scene": identity(&job(0, &Row::default(), 0).scene()?)?,
            "steps": self.steps,
            // Studies are the same wherever their files lie. What a preset says is in the identity of the scene.
            "preset": self.preset.as_deref().map(file_name),
            "settings": &self.settings,
            "run": null,
            "version": env!("CARGO_PKG_VERSION"),
            "arithmetic": arithmetic::VERSION,
        });
        let mut jobs = Vec::with_capacity(self.points.len() * self.seeds.len());
        let mut contents = Contents::default();
        for (number, point) in self.points.iter().enumerate() {
            let files = contents.of(point);
            for &seed in &self.seeds {
                let mut key = fixed.clone();
                key["point"] = json!(point);
                key["seed"] = json!(seed);
                key["fields"] = json!([]);
                if !files.is_empty() {
                    key["files"] = json!(files);
                }
                // Runs without it keep the names that they have.
                if self.network {
                    key["network"] = json!(true);
                }
                jobs.push(Job {
                    key: key_of(&key),
                    ..job(number, point, seed)
                });
            }
        }
        Ok((fixed, jobs))
    }
}

/// The text of a study file.
#[derive(Clone, Copy)]
struct Text<'a> {
    path: &'a Path,
    text: &'a str,
}

impl Text<'_> {
    fn error(self, at: &Range<usize>, problem: &str) -> Error {
        let before = self.text.get(..at.start).unwrap_or_default();
        let line = 1 + before.matches('\n').count();
        Error::Invalid(format!("{}:{line}: {problem}", self.path.shown()))
    }

    fn study(self, folder: &Path) -> Result<Study> {
        let table = DeTable::parse(self.text).map_err(|error| {
            let at = error.span().unwrap_or(0..0);
            self.error(&at, error.message())
        })?;
        let whole = table.span();
        let entries = self.entries(table.get_ref(), KEYS, "a study")?;
        let mut study = Study {
            scene: "torus".to_owned(),
            steps: STEPS,
            seeds: vec![0],
            preset: None,
            settings: Row::default(),
            points: Vec::new(),
            picture: None,
            network: false,
            axes: Vec::new(),
        };
        let mut ways = 0;
        for (key, value) in &entries {
            let at = value.span();
            match (*key, value.get_ref()) {
                ("scene", DeValue::String(text)) => study.scene = beside(folder, text),
                ("preset", DeValue::String(text)) => study.preset = Some(beside(folder, text)),
                ("picture", DeValue::String(text)) => study.picture = Some(self.size(text, &at)?),
                ("network", DeValue::Boolean(is_measured)) => study.network = *is_measured,
                ("steps", DeValue::Integer(_)) => study.steps = self.whole(value)?,
                ("seeds", DeValue::Integer(_)) => {
                    let count = self.whole(value)?;
                    if count > MOST_RUNS as u64 {
                        let problem = format!("a study has at most {MOST_RUNS} runs");
                        return Err(self.error(&at, &problem));
                    }
                    study.seeds = (0..count).collect();
                }
                ("seeds", DeValue::Array(items)) => {
                    study.seeds = (items.iter())
                        .map(|item| self.seed(item))
                        .collect::<Result<_>>()?;
                }
                ("set", DeValue::Table(table)) => study.settings = self.row(table)?,
                ("grid", DeValue::Table(table)) => {
                    (study.axes, study.points) = self.grid(table, &at)?;
                }
                ("sample", DeValue::Table(table)) => study.points = self.sample(table, &at)?,
                ("point", DeValue::Array(items)) => {
                    let points = items.iter().map(|item| match item.get_ref() {
                        DeValue::Table(table) => self.row(table),
                        _ => Err(self.error(&item.span(), "a [[point]] is a table of parameters")),
                    });
                    study.points = points.collect::<Result<_>>()?;
                }
                (key, _) => {
                    let needed = match key {
                        "scene" | "preset" => "a text",
                        "picture" => "a text, such as \"240x240\"",
                        "network" => "true or false",
                        "steps" => "a whole number",
                        "seeds" => "a whole number or a list of them",
                        "point" => "one or more [[point]]",
                        _ => "a table of parameters",
                    };
                    return Err(self.error(&at, &format!("`{key}` is {needed}")));
                }
            }
            ways += usize::from(matches!(*key, "grid" | "sample" | "point"));
        }
        if ways != 1 {
            let problem = format!("a study has one of [grid], [sample] and [[point]], not {ways}");
            return Err(self.error(&whole, &problem));
        }
        let runs = study.points.len().saturating_mul(study.seeds.len());
        if !(1..=MOST_RUNS).contains(&runs) {
            let problem = format!("a study has from 1 to {MOST_RUNS} runs, not {runs}");
            return Err(self.error(&whole, &problem));
        }
        let is_twice = |texts: Vec<String>| {
            let all = texts.len();
            texts.into_iter().collect::<HashSet<_>>().len() < all
        };
        if is_twice(
            study
                .points
                .iter()
                .map(|point| with_plain_numbers(&json!({"point": point})).to_string())
                .collect(),
        ) {
            return Err(self.error(&whole, "two points of the study are equal"));
        }
        if is_twice(study.seeds.iter().map(u64::to_string).collect()) {
            return Err(self.error(&whole, "two of the `seeds` are equal"));
        }
        Ok(study)
    }

    /// The entries of a table in the order of the file, of these keys only.
    fn entries<'b, 'c>(
        self,
        table: &'b DeTable<'c>,
        known: &[&str],
        of: &str,
    ) -> Result<Vec<(&'b str, &'b Spanned<DeValue<'c>>)>> {
        let mut entries: Vec<_> = table.iter().collect();
        entries.sort_by_key(|(key, _)| key.span().start);
        for (key, _) in &entries {
            let name = key.get_ref().as_ref();
            if !known.contains(&name) {
                let hint = match nearest(name, known.iter().copied()) {
                    Some(near) => format!("; do you mean `{near}`?"),
                    None => format!(": {}", known.join(", ")),
                };
                let problem = format!("there is no key `{}` in {of}{hint}", escaped(name));
                return Err(self.error(&key.span(), &problem));
            }
        }
        Ok(entries
            .into_iter()
            .map(|(key, value)| (key.get_ref().as_ref(), value))
            .collect())
    }

    /// Parameters of a table; `a.b = 1`, `"a.b" = 1` and `[a] b = 1` are the same.
    fn row(self, table: &DeTable<'_>) -> Result<Row> {
        let mut row = Row::default();
        for (key, value) in self.flat("", table) {
            row.set(&key, self.json(value)?);
        }
        Ok(row)
    }

    /// The leaves of a table in the order of the file.
    fn flat<'b, 'c>(
        self,
        prefix: &str,
        table: &'b DeTable<'c>,
    ) -> Vec<(String, &'b Spanned<DeValue<'c>>)> {
        let mut entries: Vec<_> = table.iter().collect();
        entries.sort_by_key(|(key, _)| key.span().start);
        let mut leaves = Vec::new();
        for (key, value) in entries {
            let key = format!("{prefix}{}", key.get_ref());
            match value.get_ref() {
                DeValue::Table(inner) => leaves.extend(self.flat(&format!("{key}."), inner)),
                _ => leaves.push((key, value)),
            }
        }
        leaves
    }

    /// The parameters of a grid, and its points.
    fn grid(self, table: &DeTable<'_>, at: &Range<usize>) -> Result<(Vec<Axis>, Vec<Row>)> {
        let mut axes = Vec::new();
        let mut points = vec![Row::default()];
        for (key, values) in self.flat("", table) {
            let DeValue::Array(values) = values.get_ref() else {
                let problem = format!("`{}` is a list of values in [grid]", escaped(&key));
                return Err(self.error(&values.span(), &problem));
            };
            let values: Vec<Value> = values
                .iter()
                .map(|value| self.json(value))
                .collect::<Result<_>>()?;
            if points.len().saturating_mul(values.len()) > MOST_RUNS {
                return Err(self.error(at, &format!("the grid has more than {MOST_RUNS} points")));
            }
            let with = |point: &Row, value: &Value| {
                let mut point = point.clone();
                point.set(&key, value.clone());
                point
            };
            points = points
                .iter()
                .flat_map(|point| values.iter().map(move |value| with(point, value)))
                .collect();
            axes.push(Axis { key, values });
        }
        Ok((axes, points))
    }

    fn sample(self, table: &DeTable<'_>, at: &Range<usize>) -> Result<Vec<Row>> {
        let (mut count, mut method, mut seed, mut ranges) =
            (None, Method::default(), 0, Vec::new());
        for (key, value) in self.entries(table, SAMPLE_KEYS, "[sample]")? {
            let error = |problem: &str| self.error(&value.span(), problem);
            match (key, value.get_ref()) {
                ("count", DeValue::Integer(_)) => count = Some(self.whole(value)?),
                ("seed", DeValue::Integer(_)) => seed = self.whole(value)?,
                ("method", DeValue::String(word)) => {
                    method = serde_json::from_value(json!(word)).map_err(|_| {
                        let word = escaped(word);
                        error(&format!(
                            "there is no way of sampling `{word}`: latin, sobol or random"
                        ))
                    })?;
                }
                ("ranges", DeValue::Table(table)) => {
                    for (key, range) in self.flat("", table) {
                        ranges.push((self.range(&key, range)?, key));
                    }
                }
                (key, _) => {
                    let needed = match key {
                        "method" => "latin, sobol or random",
                        "ranges" => "a table: low and high for each parameter",
                        _ => "a whole number",
                    };
                    return Err(error(&format!("`{key}` is {needed}")));
                }
            }
        }
        let count = count.filter(|count| (1..=MOST_RUNS as u64).contains(count));
        let Some(count) = count.filter(|_| !ranges.is_empty()) else {
            let problem = format!(
                "a [sample] has a `count` from 1 to {MOST_RUNS}, and `ranges` of parameters"
            );
            return Err(self.error(at, &problem));
        };
        let shares = sample(method, count as usize, ranges.len(), seed)
            .map_err(|error| self.error(at, &error.to_string()))?;
        let point = |shares: Vec<f64>| {
            let values = ranges.iter().zip(shares);
            Row(values
                .map(|((range, key), share)| (key.clone(), range.value(share)))
                .collect())
        };
        let mut seen = HashSet::new();
        // Of few whole numbers some come twice.
        let mut points: Vec<Row> = shares.into_iter().map(point).collect();
        points.retain(|point| seen.insert(json!(point).to_string()));
        Ok(points)
    }

    fn range(self, key: &str, range: &Spanned<DeValue<'_>>) -> Result<Limits> {
        let limits = self.json(range)?;
        let limits = limits.as_array().map_or(&[][..], Vec::as_slice);
        let limits: Vec<_> = limits.iter().map(Value::as_f64).collect();
        let is_whole = form_of(key) == Some(Form::Whole);
        let problem = match limits[..] {
            [Some(low), Some(high)] if low < high => match is_whole {
                true if low.ceil() > high.floor() => "has no whole number",
                true => return Ok(Limits::Whole(low.ceil(), high.floor())),
                false => return Ok(Limits::Real(low, high)),
            },
            _ => "is [low, high], the first below the second",
        };
        let problem = format!("the range of `{}` {problem}", escaped(key));
        Err(self.error(&range.span(), &problem))
    }

    /// A whole number that is not negative.
    fn whole(self, value: &Spanned<DeValue<'_>>) -> Result<u64> {
        let number = match value.get_ref() {
            DeValue::Integer(number) => u64::from_str_radix(number.as_str(), number.radix()).ok(),
            _ => None,
        };
        number.ok_or_else(|| self.error(&value.span(), "a whole number is needed, 0 or more"))
    }

    /// Width and height of pictures.
    fn size(self, text: &str, at: &Range<usize>) -> Result<[u32; 2]> {
        picture_size(text).ok_or_else(|| {
            let problem = format!(
                "`picture` is WIDTHxHEIGHT, such as \"240x240\", each side from 1 to {LONGEST_SIDE} pixels, not \"{}\"",
                escaped(text)
            );
            self.error(at, &problem)
        })
    }

    /// A seed.
    fn seed(self, value: &Spanned<DeValue<'_>>) -> Result<u64> {
        let seed = self.whole(value)?;
        let parameter = find("seed").expect("there is one");
        let is_allowed =
            matches!(&parameter.kind, Kind::Number(number) if number.allows(seed as f64));
        if !is_allowed {
            let problem = format!("a seed is one of the {}", parameter.allowed());
            return Err(self.error(&value.span(), &problem));
        }
        Ok(seed)
    }

    /// A value of a parameter.
    fn json(self, value: &Spanned<DeValue<'_>>) -> Result<Value> {
        let found = match value.get_ref() {
            DeValue::String(text) => Some(json!(text)),
            DeValue::Boolean(truth) => Some(json!(truth)),
            DeValue::Integer(number) => i64::from_str_radix(number.as_str(), number.radix())
                .ok()
                .map(Value::from),
            // Infinite numbers are none of JSON's.
            DeValue::Float(number) => (number.as_str().parse::<f64>().ok())
                .filter(|number| number.is_finite())
                .map(Value::from),
            DeValue::Array(items) => {
                let items = items.iter().map(|item| self.json(item));
                return Ok(Value::Array(items.collect::<Result<_>>()?));
            }
            DeValue::Datetime(_) | DeValue::Table(_) => None,
        };
        found.ok_or_else(|| {
            let problem = "a value is a finite number, a text, true or false, or a list of these";
            self.error(&value.span(), problem)
        })
    }
}

/// The name of a file without its folders; that of a preset which comes with the program as it is.
fn file_name(path: &str) -> &str {
    let name = Path::new(path).file_name().and_then(OsStr::to_str);
    name.unwrap_or(path)
}

/// Between which values of a parameter is sampled.
enum Limits {
    Real(f64, f64),
    /// Both are among the values.
    Whole(f64, f64),
}

impl Limits {
    /// The value at a share from 0 to below 1; each whole number has the same part of that.
    fn value(&self, share: f64) -> Value {
        match *self {
            Self::Real(low, high) => json!(low + share * (high - low)),
            Self::Whole(low, high) => {
                let value = low + (share * (high - low + 1.0)).floor();
                json!(value.min(high) as i64)
            }
        }
    }
}

/// A path beside the study, if there is a file; otherwise the name as it is.
fn beside(folder: &Path, name: &str) -> String {
    let path: PathBuf = folder.join(name);
    match path.to_str() {
        Some(text) if path.is_file() => text.to_owned(),
        _ => name.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Study> {
        let path = Path::new("study.toml");
        Text { path, text }.study(Path::new("no such folder"))
    }

    /// Catches points in alphabetical order, in which a table of TOML usually is, and keys with a dot that differ by how they are written.
    #[test]
    fn points_are_in_the_order_of_the_file() {
        let study = read(
            "scene = \"cube\"\nseeds = [3, 5]\nset.\"trail.decay\" = 0.9\n\
             [grid]\n\"physarum.speed\" = [1, 2.0]\nphysarum.sensor_angle = [3, 4]\n",
        )
        .expect("it is right");
        assert_eq!((study.steps, &study.seeds[..]), (STEPS, &[3, 5][..]));
        assert_eq!(study.settings.get("trail.decay"), Some(&json!(0.9)));
        let points = serde_json::to_string(&study.points).expect("it is plain");
        let point = |speed, angle| {
            format!("{{\"physarum.speed\":{speed},\"physarum.sensor_angle\":{angle}}}")
        };
        let expected = [
            point("1", 3),
            point("1", 4),
            point("2.0", 3),
            point("2.0", 4),
        ];
        assert_eq!(points, format!("[{}]", expected.join(",")));
        let (_, jobs) = study.jobs().expect("they are made");
        let seeds: Vec<_> = jobs.iter().map(|job| (job.number, job.seed)).collect();
        assert_eq!(seeds[..4], [(0, 3), (0, 5), (1, 3), (1, 5)]);
        let mut keys: Vec<_> = jobs.iter().map(|job| &job.key).collect();
        keys.sort_unstable();
        keys.dedup();
        assert_eq!(keys.len(), 8);
    }

    /// Catches pictures that make a study another one, by which its folder would be refused or its runs done again, and lists that are
    /// taken for grids.
    #[test]
    fn a_picture_changes_no_run() {
        let text =
            "scene = \"cube\"\n[grid]\n\"trail.decay\" = [0.9, 0.95]\n\"physarum.speed\" = [1]\n";
        let plain = read(text).expect("it is right");
        let seen = read(&format!("picture = \"40 x 30\"\n{text}")).expect("it is right");
        assert_eq!((plain.picture, seen.picture), (None, Some([40, 30])));
        let axes: Vec<_> = (seen.axes.iter())
            .map(|axis| (&*axis.key, axis.values.len()))
            .collect();
        assert_eq!(axes, [("trail.decay", 2), ("physarum.speed", 1)]);
        let (fixed, jobs) = plain.jobs().expect("they are made");
        let (fixed_seen, jobs_seen) = seen.jobs().expect("they are made");
        assert_eq!(fixed, fixed_seen);
        for (plain, seen) in jobs.iter().zip(&jobs_seen) {
            assert_eq!((&plain.key, plain.picture), (&seen.key, None));
            assert_eq!(seen.picture, Some([40, 30]));
        }
        let list = read("[[point]]\n\"trail.decay\" = 0.9\n").expect("it is right");
        assert!(list.axes.is_empty());
    }

    /// Would catch: rows without measures of the graph that count as done, and folders that are refused because these are asked for.
    #[test]
    fn runs_with_measures_of_the_graph_are_others_of_the_same_study() {
        let text = "scene = \"cube\"\n[grid]\n\"trail.decay\" = [0.9]\n";
        let jobs = |text: &str| {
            let study = read(text).expect("it is right");
            study.jobs().expect("they are made")
        };
        let (fixed, plain) = jobs(text);
        let (fixed_with, with) = jobs(&format!("network = true\n{text}"));
        assert_eq!(fixed, fixed_with);
        assert!(!plain[0].network && with[0].network);
        assert_ne!(plain[0].key, with[0].key);
        assert_eq!(jobs(&format!("network = false\n{text}")), (fixed, plain));
    }

    /// Would catch: runs that count as done although a file that their point names has changed, and folders of points without files whose
    /// runs are done once more.
    #[test]
    fn a_file_that_a_point_names_is_a_part_of_its_runs() {
        let folder = tempfile::tempdir().expect("there is room");
        let map = folder.path().join("map.png");
        let name = json!(map.to_str().expect("it is plain"));
        let text = format!("scene = \"cube\"\n[grid]\n\"areas.map\" = [{name}, \"\"]\n");
        let study = read(&text).expect("it is right");
        let jobs = |content: &str| {
            std::fs::write(&map, content).expect("there is room");
            study.jobs().expect("they are made")
        };
        let (fixed, before) = jobs("one");
        let (fixed_after, after) = jobs("two");
        assert_eq!(fixed, fixed_after);
        assert_ne!(before[0].key, after[0].key);
        assert_eq!(jobs("one").1, before);
        let mut without = fixed;
        without["point"] = json!({"areas.map": ""});
        without["seed"] = json!(0);
        without["fields"] = json!([]);
        let expected = key_of(&without);
        assert_eq!((&before[1].key, &after[1].key), (&expected, &expected));
    }

    /// Would catch: parts of whole numbers, which no run takes, limits that are never drawn, and points that come twice.
    #[test]
    fn samples_of_whole_numbers_are_whole() {
        for method in ["random", "latin"] {
            let text = format!("[sample]\ncount = 32\nmethod = \"{method}\"\n");
            let study = read(&format!("{text}ranges.\"particles.count\" = [4.5, 8]\n"));
            let points = study.expect("it is right").points;
            let counts = points.iter().map(|point| point.0[0].1.as_i64());
            let mut counts: Vec<i64> = counts.map(|count| count.expect("it is whole")).collect();
            counts.sort_unstable();
            assert_eq!(counts, [5, 6, 7, 8], "{method}");
            let error = read(&format!("{text}ranges.\"particles.count\" = [4.2, 4.8]\n"));
            let error = error.expect_err("there is none between").to_string();
            assert!(
                error.contains(":4: the range of `particles.count` has no whole number"),
                "{error}"
            );
        }
    }

    #[test]
    fn samples_lie_within_their_ranges() {
        let study = read("[sample]\ncount = 8\nranges.\"trail.decay\" = [0.8, 0.9]\n")
            .expect("it is right");
        let values = study.points.iter().map(|point| point.0[0].1.as_f64());
        let values: Vec<f64> = values.map(|value| value.expect("it is a number")).collect();
        assert_eq!(values.len(), 8);
        assert!(
            values.iter().all(|value| (0.8..0.9).contains(value)),
            "{values:?}"
        );
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line() {
        for (text, expected) in [
            (
                "scene = \"cube\"\n",
                ":1: a study has one of [grid], [sample] and [[point]], not 0",
            ),
            (
                "[grid]\na = [1]\n[[point]]\na = 1\n",
                "and [[point]], not 2",
            ),
            (
                "\nscenes = \"cube\"\n",
                ":2: there is no key `scenes` in a study; do you mean `scene`?",
            ),
            (
                "steps = -1\n[grid]\n",
                ":1: a whole number is needed, 0 or more",
            ),
            ("steps = \"many\"\n", ":1: `steps` is a whole number"),
            ("scene = 4\n", ":1: `scene` is a text"),
            (
                "picture = 240\n",
                ":1: `picture` is a text, such as \"240x240\"",
            ),
            (
                "picture = \"0x0\"\n",
                ":1: `picture` is WIDTHxHEIGHT, such as \"240x240\", each side from 1 to 16384 pixels, not \"0x0\"",
            ),
            ("picture = \"16385x1\"\n", "each side from 1 to 16384"),
            ("picture = \"large\"\n", "not \"large\""),
            ("network = 1\n", ":1: `network` is true or false"),
            (
                "seeds = []\n[grid]\na = [1]\n",
                "a study has from 1 to 10000000 runs, not 0",
            ),
            ("[grid]\na = 1\n", ":2: `a` is a list of values in [grid]"),
            (
                "[grid]\na = []\n",
                "a study has from 1 to 10000000 runs, not 0",
            ),
            (
                "seeds = 1000000000000\n[grid]\na = [1]\n",
                ":1: a study has at most 10000000 runs",
            ),
            (
                "seeds = [4294967296]\n",
                ":1: a seed is one of the whole numbers 0 to 4,294,967,295",
            ),
            (
                "seeds = [1, 1]\n[grid]\na = [1]\n",
                "two of the `seeds` are equal",
            ),
            (
                "[grid]\na = [1, 2, 1]\n",
                "two points of the study are equal",
            ),
            ("[grid]\na = [inf]\n", ":2: a value is a finite number"),
            (
                "[sample]\nranges.a = [0, 1]\n",
                ":1: a [sample] has a `count` from 1",
            ),
            (
                "[sample]\ncount = 0\nranges.a = [0, 1]\n",
                "a `count` from 1",
            ),
            ("[sample]\ncount = 4\n", "and `ranges`"),
            (
                "[sample]\ncount = 4\nranges.a = [1, 1]\n",
                ":3: the range of `a` is [low, high]",
            ),
            (
                "[sample]\ncount = 4\nmethod = \"dice\"\n",
                ":3: there is no way of sampling `dice`",
            ),
            (
                "[sample]\nmany = 4\n",
                ":2: there is no key `many` in [sample]",
            ),
            ("point = [1]\n", ":1: a [[point]] is a table"),
            ("scene = [\n", ":"),
        ] {
            let error = read(text).expect_err(text).to_string();
            assert!(
                error.starts_with("study.toml:") && error.contains(expected),
                "{error}"
            );
        }
    }
}
