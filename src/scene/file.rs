//! Reading and writing scene files, and the changes of the command line, all by the parameter table. Keys and values that are unknown, of
//! the wrong type or out of range are collected, so that one error lists all problems.

use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue};

use super::keyframes;
use super::parameters::{
    FOOD_PARAMETERS, Kind, OBJECT_PARAMETERS, OutOfRange, PARAMETERS, PULSE_PARAMETERS, Parameter,
    any_of, grouped, inside, out_of_range,
};
use super::presets::{PARTS, foreign};
use super::problems::{Problem, Problems};
use super::settings::{
    FoodSettings, MOST_FOODS, MOST_OBJECTS, MOST_PULSE_ENTRIES, ObjectSettings, Preference,
    PulseSettings, Settings, Turning,
};
use super::suggest::{first_of, is_section, nearest, nearest_key};

/// Reads scene text into settings, step by step, and collects all problems.
#[derive(Debug)]
pub struct Reader {
    /// The settings so far; wrong values were not applied.
    pub settings: Settings,
    /// The problems so far.
    pub problems: Problems,
    place: Place,
    /// Were objects left out, because there are so many?
    too_many_objects: bool,
}

#[derive(Debug)]
enum Place {
    /// Text with lines; spans are offsets into it.
    Text {
        prefix: String,
        line_ends: Vec<usize>,
    },
    /// An argument of the command line, as typed.
    Argument(String),
}

impl Reader {
    /// Begins with `settings`.
    #[must_use]
    pub fn new(settings: Settings) -> Self {
        Self {
            settings,
            problems: Problems::default(),
            place: Place::Argument(String::new()),
            too_many_objects: false,
        }
    }

    /// Reads TOML text. `prefix` goes before the line numbers of problems; empty for the scene file itself.
    pub fn text(&mut self, prefix: &str, text: &str) {
        if let Some(table) = self.parse(prefix, text) {
            self.table("", table.get_ref());
        }
    }

    /// Reads the TOML text of a preset: the sections of a look, and nothing else. Without the keys, no food is scattered, and
    /// preference, turning, random turn and sensitivity have their defaults.
    pub fn preset(&mut self, prefix: &str, text: &str) {
        let Some(table) = self.parse(prefix, text) else {
            return;
        };
        if let Some((at, key)) = foreign(table.get_ref()) {
            let message = format!("{key} is no part of a look: a preset has {PARTS} only");
            self.problem(at, message);
        } else if table.get_ref().is_empty() {
            self.problem(0, format!("it has nothing of a look: {PARTS}"));
        } else {
            // Most looks have no scattered food, and older ones say neither a preference nor rules of turning and sensing.
            self.settings.feeding.scattered = 0;
            let physarum = &mut self.settings.physarum;
            physarum.preference = Preference::Auto;
            physarum.turning = Turning::Model;
            physarum.random_turn = 0.0;
            physarum.sensitivity = 0.0;
            self.table("", table.get_ref());
        }
    }

    fn parse<'t>(&mut self, prefix: &str, text: &'t str) -> Option<Spanned<DeTable<'t>>> {
        self.place = Place::Text {
            prefix: prefix.to_owned(),
            line_ends: text.match_indices('\n').map(|(i, _)| i).collect(),
        };
        match DeTable::parse(text) {
            Ok(table) => Some(table),
            Err(error) => {
                let at = error.span().map_or(0, |span| span.start);
                self.problem(at, format!("not valid TOML: {}", one_line(error.message())));
                None
            }
        }
    }

    /// Applies one `KEY=VALUE`. The value is read as TOML; if it is not TOML, it is a bare word.
    pub fn assignment(&mut self, assignment: &str) {
        self.place = Place::Argument(format!("--set {assignment}"));
        let pair = assignment
            .split_once('=')
            .filter(|(key, _)| !key.trim().is_empty());
        let Some((key, raw)) = pair else {
            self.problem(
                0,
                "KEY=VALUE is expected, such as trail.decay=0.9".to_owned(),
            );
            return;
        };
        let (key, raw) = (key.trim(), raw.trim());
        let value = DeValue::parse(raw).unwrap_or_else(|_| {
            Spanned::new(0..0, DeValue::String(std::borrow::Cow::Borrowed(raw)))
        });
        self.value(key, &value, 0);
    }

    /// Sets the seed, as `--seed` does.
    pub fn seed(&mut self, seed: u64) {
        self.place = Place::Argument(format!("--seed {seed}"));
        let raw = seed.to_string();
        if let Ok(value) = DeValue::parse(&raw) {
            self.value("seed", &value, 0);
        }
    }

    /// The settings, if nothing was wrong with them.
    ///
    /// # Errors
    /// All problems so far, and all values that are out of range.
    pub fn finish(mut self) -> Result<Settings, Problems> {
        self.problems
            .extend(out_of_range(&self.settings).into_iter().map(Problem::from));
        if self.settings.objects.is_empty() && !self.too_many_objects {
            let message = "the scene has no objects: add an [[object]] with a mesh".to_owned();
            self.problems.push(Problem {
                place: String::new(),
                message,
            });
        }
        if self.problems.is_empty() {
            Ok(self.settings)
        } else {
            Err(self.problems)
        }
    }

    fn problem(&mut self, at: usize, message: String) {
        self.problem_with(at, || message);
    }

    /// A problem whose message is made only if it is listed.
    fn problem_with(&mut self, at: usize, message: impl FnOnce() -> String) {
        let place = || match &self.place {
            Place::Text { prefix, line_ends } => {
                let line = line_ends.partition_point(|&end| end < at) + 1;
                let space = if prefix.is_empty() { "" } else { " " };
                format!("{prefix}{space}line {line}")
            }
            Place::Argument(typed) => typed.clone(),
        };
        self.problems.push_with(|| Problem {
            place: place(),
            message: message(),
        });
    }

    fn table(&mut self, section: &str, table: &DeTable<'_>) {
        // The map is sorted by key, but problems are listed in the order of the file.
        let mut entries: Vec<_> = table.iter().collect();
        entries.sort_by_key(|(key, _)| key.span().start);
        for (key, value) in entries {
            let dotted = if section.is_empty() {
                key.get_ref().to_string()
            } else {
                format!("{section}.{}", key.get_ref())
            };
            self.value(&dotted, value, key.span().start);
        }
    }

    /// Applies the value of one dotted key at offset `at`.
    fn value(&mut self, key: &str, value: &Spanned<DeValue<'_>>, at: usize) {
        if key == "object" {
            return self.objects(value, at);
        }
        if let Some(rest) = key.strip_prefix("object.") {
            return self.object_key(key, rest, value, at);
        }
        if key == "food" {
            return self.foods(value, at);
        }
        if let Some(rest) = key.strip_prefix("food.") {
            return self.food_key(key, rest, value, at);
        }
        if key == "pulse" {
            return self.pulses(value, at);
        }
        if let Some(rest) = key.strip_prefix("pulse.") {
            return self.pulse_key(key, rest, value, at);
        }
        let typed = matches!(self.place, Place::Argument(_));
        let outcome = set(
            PARAMETERS,
            &mut self.settings,
            key,
            key,
            value.get_ref(),
            typed,
        );
        if let Some(message) = outcome {
            match message {
                Refusal::Wrong(message) => self.problem(at, message),
                Refusal::Unknown => match value.get_ref() {
                    DeValue::Table(table) if is_section(key) => self.table(key, table),
                    DeValue::Table(_) => self.unknown_section(key, at),
                    _ => self.unknown(key, at),
                },
            }
        }
    }

    fn unknown(&mut self, key: &str, at: usize) {
        self.problem_with(at, || {
            if is_section(key) {
                format!("{key} is a section, with keys such as {}", first_of(key))
            } else if let Some(nearest) = nearest_key(key) {
                format!("{key}: no such key; did you mean {nearest}?")
            } else {
                format!("{key}: no such key; `myxo scenes --keys` lists all of them")
            }
        });
    }

    fn unknown_section(&mut self, key: &str, at: usize) {
        self.problem_with(at, || {
            let sections = PARAMETERS
                .iter()
                .map(Parameter::section)
                .filter(|section| !section.is_empty());
            match nearest(key, sections.chain(["object", "food", "pulse"])) {
                // There may be several of these.
                Some(nearest @ ("object" | "food" | "pulse")) => {
                    format!("[{key}]: no such section; did you mean [[{nearest}]]?")
                }
                Some(nearest) => format!("[{key}]: no such section; did you mean [{nearest}]?"),
                None => {
                    format!("[{key}]: no such section; `myxo scenes --keys` lists all keys")
                }
            }
        });
    }

    fn objects(&mut self, value: &Spanned<DeValue<'_>>, at: usize) {
        let Some(tables) = tables(value) else {
            return self.problem(
                at,
                "object: [[object]] is expected, once for each object".to_owned(),
            );
        };
        if tables.len() > MOST_OBJECTS {
            self.too_many_objects = true;
            let count = grouped(tables.len() as f64);
            return self.problem(
                at,
                format!(
                    "object: the scene has {count} objects, and there may be {}: join those that move together into one model",
                    grouped(MOST_OBJECTS as f64)
                ),
            );
        }
        self.settings.objects = vec![ObjectSettings::default(); tables.len()];
        for (i, table) in tables.into_iter().enumerate() {
            self.table(&format!("object.{i}"), table);
        }
    }

    fn foods(&mut self, value: &Spanned<DeValue<'_>>, at: usize) {
        let Some(tables) = tables(value) else {
            return self.problem(
                at,
                "food: [[food]] is expected, once for each food or marker".to_owned(),
            );
        };
        if tables.len() > MOST_FOODS {
            let count = grouped(tables.len() as f64);
            return self.problem(
                at,
                format!(
                    "food: the scene has {count} foods and markers, and there may be {MOST_FOODS}"
                ),
            );
        }
        self.settings.foods = vec![FoodSettings::default(); tables.len()];
        for (i, table) in tables.into_iter().enumerate() {
            self.table(&format!("food.{i}"), table);
        }
    }

    fn food_key(&mut self, key: &str, rest: &str, value: &Spanned<DeValue<'_>>, at: usize) {
        let (index, field) = rest.split_once('.').unwrap_or((rest, ""));
        let count = self.settings.foods.len();
        let index: Option<usize> = index.parse().ok();
        let Some(food) = index.and_then(|i| self.settings.foods.get_mut(i)) else {
            let message = match count {
                0 => format!("{key}: the scene has no food: add a [[food]]"),
                _ => format!("{key}: the scene has {count} foods, counted from food.0"),
            };
            return self.problem(at, message);
        };
        let typed = matches!(self.place, Place::Argument(_));
        let outcome = match (field, value.get_ref()) {
            ("", DeValue::Table(table)) => return self.table(key, table),
            (_, value) => set(FOOD_PARAMETERS, food, field, key, value, typed),
        };
        match outcome {
            None => {}
            Some(Refusal::Wrong(message)) => self.problem(at, message),
            Some(Refusal::Unknown) => self.unknown(key, at),
        }
    }

    fn pulses(&mut self, value: &Spanned<DeValue<'_>>, at: usize) {
        let Some(tables) = tables(value) else {
            return self.problem(
                at,
                "pulse: [[pulse]] is expected, once for each pulse".to_owned(),
            );
        };
        if tables.len() > MOST_PULSE_ENTRIES {
            let count = grouped(tables.len() as f64);
            return self.problem(
                at,
                format!(
                    "pulse: the scene has {count} pulses, and there may be {MOST_PULSE_ENTRIES}: one with `every` begins again and again"
                ),
            );
        }
        self.settings.pulses = vec![PulseSettings::default(); tables.len()];
        for (i, table) in tables.into_iter().enumerate() {
            self.table(&format!("pulse.{i}"), table);
        }
    }

    fn pulse_key(&mut self, key: &str, rest: &str, value: &Spanned<DeValue<'_>>, at: usize) {
        let (index, field) = rest.split_once('.').unwrap_or((rest, ""));
        let count = self.settings.pulses.len();
        let index: Option<usize> = index.parse().ok();
        let Some(pulse) = index.and_then(|i| self.settings.pulses.get_mut(i)) else {
            let message = match count {
                0 => format!("{key}: the scene has no pulse: add a [[pulse]]"),
                _ => format!("{key}: the scene has {count} pulses, counted from pulse.0"),
            };
            return self.problem(at, message);
        };
        let typed = matches!(self.place, Place::Argument(_));
        let outcome = match (field, value.get_ref()) {
            ("", DeValue::Table(table)) => return self.table(key, table),
            (_, value) => set(PULSE_PARAMETERS, pulse, field, key, value, typed),
        };
        match outcome {
            None => {}
            Some(Refusal::Wrong(message)) => self.problem(at, message),
            Some(Refusal::Unknown) => self.unknown(key, at),
        }
    }

    fn object_key(&mut self, key: &str, rest: &str, value: &Spanned<DeValue<'_>>, at: usize) {
        let (index, field) = rest.split_once('.').unwrap_or((rest, ""));
        let count = self.settings.objects.len();
        let Some(object) = index
            .parse()
            .ok()
            .and_then(|i: usize| self.settings.objects.get_mut(i))
        else {
            let message = match count {
                0 => format!("{key}: the scene has no objects"),
                1 => format!("{key}: the scene has one object, object.0"),
                _ => format!(
                    "{key}: the scene has {count} objects, object.0 to object.{}",
                    count - 1
                ),
            };
            return self.problem(at, message);
        };
        let value = value.get_ref();
        let outcome = match (field, value) {
            ("" | "motion" | "physarum" | "start" | "trail", DeValue::Table(table)) => {
                return self.table(key, table);
            }
            ("motion" | "physarum" | "start" | "trail", other) => {
                Some(wrong_type(key, "a table of keys", other))
            }
            ("motion.keyframes", value) => match keyframes::read(key, value) {
                Ok(frames) => {
                    object.motion.keyframes = frames;
                    None
                }
                Err(message) => Some(Refusal::Wrong(message)),
            },
            ("name", DeValue::String(text)) => {
                object.name = text.to_string();
                None
            }
            ("mesh", DeValue::String(text)) => {
                object.mesh = match self.place {
                    Place::Text { .. } => text.to_string(),
                    Place::Argument(_) => from_here(text),
                };
                None
            }
            ("distance_to", DeValue::Array(names)) => {
                let names: Option<Vec<String>> = names
                    .iter()
                    .map(|name| name.get_ref().as_str().map(str::to_owned))
                    .collect();
                match names {
                    Some(names) => {
                        object.distance_to = names;
                        None
                    }
                    None => Some(wrong_type(key, "a list of names", value)),
                }
            }
            ("distance_to", other) => Some(wrong_type(key, "a list of names", other)),
            ("glue", value) => match glue(value) {
                Some(pairs) => {
                    object.glue = pairs;
                    None
                }
                None => {
                    let expected = "a list of pairs of edges, each [face, edge, other face, other edge] in whole numbers,";
                    Some(wrong_type(key, expected, value))
                }
            },
            ("name" | "mesh", other) => Some(wrong_type(key, "a text", other)),
            _ => {
                let typed = matches!(self.place, Place::Argument(_));
                set(OBJECT_PARAMETERS, object, field, key, value, typed)
            }
        };
        match outcome {
            None => {}
            Some(Refusal::Wrong(message)) => self.problem(at, message),
            Some(Refusal::Unknown) => self.unknown(key, at),
        }
    }
}

/// Pairs of edges, each as four whole numbers.
fn glue(value: &DeValue<'_>) -> Option<Vec<[u32; 4]>> {
    let whole = |item: &Spanned<DeValue<'_>>| {
        let number = number(item.get_ref())?;
        let is_id = number.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&number);
        is_id.then_some(number as u32)
    };
    let pair = |item: &Spanned<DeValue<'_>>| -> Option<[u32; 4]> {
        let numbers: Option<Vec<u32>> = item.get_ref().as_array()?.iter().map(whole).collect();
        numbers?.try_into().ok()
    };
    value.as_array()?.iter().map(pair).collect()
}

/// The tables of a list of tables, if it is one.
fn tables<'a, 'b>(value: &'a Spanned<DeValue<'b>>) -> Option<Vec<&'a DeTable<'b>>> {
    match value.get_ref() {
        DeValue::Array(array) => array.iter().map(|item| item.get_ref().as_table()).collect(),
        _ => None,
    }
}

/// A path typed on the command line is relative to the folder that it was typed in, not to the scene file's.
fn from_here(mesh: &str) -> String {
    if mesh.is_empty() || mesh.starts_with("builtin:") {
        return mesh.to_owned();
    }
    std::path::absolute(mesh)
        .ok()
        .and_then(|path| path.into_os_string().into_string().ok())
        .unwrap_or(mesh.to_owned())
}

enum Refusal {
    Unknown,
    Wrong(String),
}

fn wrong_type(key: &str, expected: &str, found: &DeValue<'_>) -> Refusal {
    Refusal::Wrong(format!(
        "{key}: {expected} is expected, not {}",
        describe(found)
    ))
}

/// Sets one parameter of `target`. `key` is looked up, or with a component's index behind it; `full` is for messages.
/// `typed` values come from the command line.
fn set<T>(
    table: &[Parameter<T>],
    target: &mut T,
    key: &str,
    full: &str,
    value: &DeValue<'_>,
    typed: bool,
) -> Option<Refusal> {
    let Some(parameter) = table.iter().find(|parameter| parameter.key == key) else {
        return set_component(table, target, key, full, value);
    };
    match &parameter.kind {
        Kind::Number(number_kind) => match read_number(value, number_kind.integer) {
            Ok(x) if number_kind.allows(x) => (number_kind.set)(target, x),
            Ok(_) => return Some(out(full, value, parameter)),
            Err(expected) => return Some(wrong_type(full, expected, value)),
        },
        Kind::Choice { words, set, .. } => match value {
            DeValue::String(word) => match words.iter().position(|candidate| candidate == word) {
                Some(i) => set(target, i),
                None => return Some(wrong_word(full, word, words)),
            },
            other => {
                return Some(wrong_type(
                    full,
                    &format!("a word ({})", any_of(words)),
                    other,
                ));
            }
        },
        Kind::Vector { range, set, .. } => {
            let components = match value {
                DeValue::Array(array) => three(array),
                _ => None,
            };
            let Some(components) = components else {
                return Some(wrong_type(full, "a list of three numbers", value));
            };
            if !components.iter().all(|&c| inside(c, *range)) {
                return Some(out(full, value, parameter));
            }
            set(target, components);
        }
        Kind::Own(own) => match read_number(value, own.integer) {
            Ok(x) if own.allows(x) => (own.set)(target, Some(x)),
            Ok(_) => return Some(out(full, value, parameter)),
            Err(expected) => return Some(wrong_type(full, expected, value)),
        },
        Kind::Text {
            what, is_path, set, ..
        } => match value {
            DeValue::String(text) if *is_path && typed => set(target, from_here(text)),
            DeValue::String(text) => set(target, text.to_string()),
            other => return Some(wrong_type(full, &format!("a text ({what})"), other)),
        },
    }
    None
}

/// Sets one component of a vector of `target`: `key` is the vector's, with the component's index behind it.
fn set_component<T>(
    table: &[Parameter<T>],
    target: &mut T,
    key: &str,
    full: &str,
    value: &DeValue<'_>,
) -> Option<Refusal> {
    let component = key
        .rsplit_once('.')
        .and_then(|(vector, i)| Some((vector, i.parse::<usize>().ok()?)));
    let Some((vector, i)) = component else {
        return Some(Refusal::Unknown);
    };
    let Some(parameter) = table.iter().find(|parameter| parameter.key == vector) else {
        return Some(Refusal::Unknown);
    };
    let Kind::Vector {
        range, get, set, ..
    } = &parameter.kind
    else {
        return Some(Refusal::Unknown);
    };
    let mut components = get(target);
    let Some(component) = components.get_mut(i) else {
        return Some(Refusal::Unknown);
    };
    let Some(number) = number(value) else {
        return Some(wrong_type(full, "a number", value));
    };
    if !inside(number, *range) {
        return Some(out(full, value, parameter));
    }
    *component = number;
    set(target, components);
    None
}

/// The problem that a parameter does not have a word.
fn wrong_word(full: &str, word: &str, words: &[&str]) -> Refusal {
    let nearest = nearest(word, words.iter().copied()).map_or(String::new(), |nearest| {
        format!("; did you mean {nearest}?")
    });
    Refusal::Wrong(format!(
        "{full} = \"{word}\": it can be {}{nearest}",
        any_of(words)
    ))
}

/// A number, or what is expected in its place.
fn read_number(value: &DeValue<'_>, integer: bool) -> Result<f64, &'static str> {
    let expected = if integer {
        "a whole number"
    } else {
        "a number"
    };
    match number(value) {
        Some(x) if integer && x.is_finite() && x.fract() != 0.0 => Err(expected),
        Some(x) => Ok(x),
        None => Err(expected),
    }
}

fn out<T>(key: &str, value: &DeValue<'_>, parameter: &Parameter<T>) -> Refusal {
    let value = plain(value);
    Refusal::Wrong(
        Problem::from(OutOfRange {
            key: key.to_owned(),
            value,
            allowed: parameter.allowed(),
        })
        .message,
    )
}

pub(super) fn three(array: &DeArray<'_>) -> Option<[f64; 3]> {
    let numbers: Option<Vec<f64>> = array.iter().map(|item| number(item.get_ref())).collect();
    numbers?.try_into().ok()
}

pub(super) fn number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        // Numbers with more digits than an i64 holds are out of every range; they become floats.
        DeValue::Integer(integer) => match i64::from_str_radix(integer.as_str(), integer.radix()) {
            Ok(whole) => Some(whole as f64),
            Err(_) => integer.as_str().parse().ok().or(Some(f64::INFINITY)),
        },
        DeValue::Float(float) => float.as_str().parse().ok(),
        _ => None,
    }
}

fn plain(value: &DeValue<'_>) -> String {
    match value {
        DeValue::Integer(integer) => integer.to_string(),
        DeValue::Float(float) => float.as_str().to_owned(),
        DeValue::Array(array) => {
            let items: Vec<_> = array.iter().map(|item| plain(item.get_ref())).collect();
            format!("[{}]", items.join(", "))
        }
        other => describe(other),
    }
}

pub(super) fn describe(value: &DeValue<'_>) -> String {
    match value {
        DeValue::String(text) if text.chars().count() > 40 => "a text".to_owned(),
        DeValue::String(text) => format!("the text \"{text}\""),
        DeValue::Integer(_) | DeValue::Float(_) => plain(value),
        DeValue::Boolean(on) => on.to_string(),
        DeValue::Datetime(_) => "a date".to_owned(),
        DeValue::Array(array) => format!("a list of {}", array.len()),
        DeValue::Table(_) => "a table".to_owned(),
    }
}

fn one_line(message: &str) -> String {
    message.split_whitespace().collect::<Vec<_>>().join(" ")
}

impl Settings {
    /// The whole scene file, every key written out.
    ///
    /// # Panics
    /// Never: settings are plain numbers, words and lists, which TOML can hold.
    #[must_use]
    pub fn to_toml(&self) -> String {
        toml::to_string(self).expect("settings are plain numbers, words and lists")
    }
}
