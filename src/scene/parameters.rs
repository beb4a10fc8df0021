//! The table of all parameters of a scene: name, allowed values, and whether a change needs a restart. Validation, the panel, `--set` and
//! the manual all read this table and no other.

#[macro_use]
mod macros;
mod food;
mod idle;
mod objects;
mod population;
mod pulse;
mod table;
mod values;

use super::keyframes;
use super::settings::Settings;
use crate::plain_text::with_commas;

pub use food::FOOD_PARAMETERS;
pub use idle::{why_idle, why_object_idle};
pub use objects::OBJECT_PARAMETERS;
pub use pulse::PULSE_PARAMETERS;
pub use table::{MOST_RADIUS, PARAMETERS};
pub use values::{Form, form_of, value_of};

/// One key of the scene file. `T` is what the accessors work on: [`Settings`], or [`ObjectSettings`](super::settings::ObjectSettings),
/// [`FoodSettings`](super::settings::FoodSettings) and [`PulseSettings`](super::settings::PulseSettings) for the keys of one `[[object]]`,
/// `[[food]]` or `[[pulse]]`.
#[derive(Debug)]
pub struct Parameter<T: 'static = Settings> {
    /// Dotted, as in the file: `trail.decay`. Keys of an object lack the `object.N.` in front, those of a food `food.N.`, those of a pulse
    /// `pulse.N.`.
    pub key: &'static str,
    /// The name in the panel.
    pub name: &'static str,
    /// Unit of the value; empty if it has none.
    pub unit: &'static str,
    /// One or two sentences: its effect, and the meaning of special values.
    pub help: &'static str,
    /// When a change takes effect.
    pub effect: Effect,
    /// The value itself.
    pub kind: Kind<T>,
}

/// Rows in one table.
const fn one_table<const N: usize, const P: usize, T>(
    parts: [&[Parameter<T>]; P],
) -> [Parameter<T>; N] {
    let mut all = [parts[0][0]; N];
    let (mut next, mut part) = (0, 0);
    while part < parts.len() {
        let mut row = 0;
        while row < parts[part].len() {
            all[next] = parts[part][row];
            next += 1;
            row += 1;
        }
        part += 1;
    }
    all
}

// They hold references and functions alone, whatever `T` is.
macro_rules! copied {
    ($($type:ident),*) => {
        $(impl<T> Copy for $type<T> {}

        impl<T> Clone for $type<T> {
            fn clone(&self) -> Self {
                *self
            }
        })*
    };
}

copied!(Parameter, Kind, Own, Number);

/// When a changed parameter takes effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// With the next step or picture.
    Live,
    /// Restarts the simulation from step 0.
    Restart,
}

/// The type of a parameter, its allowed values, and its accessors.
#[derive(Debug)]
pub enum Kind<T: 'static> {
    /// A number.
    Number(Number<T>),
    /// One word of a list.
    Choice {
        /// The words, in the order of the indices.
        words: &'static [&'static str],
        /// The index of the word that is set.
        get: fn(&T) -> usize,
        /// Sets the word by its index, which must be below `words.len()`.
        set: fn(&mut T, usize),
    },
    /// Three numbers with one range.
    Vector {
        /// The range that each component must lie in, ends included.
        range: (f64, f64),
        /// Are they kept in double precision? Else in single precision.
        is_double: bool,
        /// The components.
        get: fn(&T) -> [f64; 3],
        /// Sets the components.
        set: fn(&mut T, [f64; 3]),
    },
    /// A number that an object has of its own, or shares with the scene.
    Own(Own<T>),
    /// A text.
    Text {
        /// Its meaning: `the name of an object`.
        what: &'static str,
        /// A path, relative to the scene file?
        is_path: bool,
        /// The text.
        get: fn(&T) -> &str,
        /// Sets it.
        set: fn(&mut T, String),
    },
}

/// A number that an object may have of its own.
#[derive(Debug)]
pub struct Own<T: 'static> {
    /// The allowed range, ends included.
    pub range: (f64, f64),
    /// The slider's range.
    pub slider: (f64, f64),
    /// How a slider spreads it.
    pub scale: Scale,
    /// Only whole numbers.
    pub integer: bool,
    /// Reads the value; `None` if it is the scene's.
    pub get: fn(&T) -> Option<f64>,
    /// Reads the scene's.
    pub shared: fn(&Settings) -> f64,
    /// Writes the value.
    pub set: fn(&mut T, Option<f64>),
}

/// A number, its range and its slider.
#[derive(Debug)]
pub struct Number<T: 'static> {
    /// The allowed range, ends included.
    pub range: (f64, f64),
    /// The slider's range: the interesting part of `range`.
    pub slider: (f64, f64),
    /// How a slider spreads it.
    pub scale: Scale,
    /// Only whole numbers.
    pub integer: bool,
    /// Is it kept in double precision? Else, unless it is whole, in single precision.
    pub is_double: bool,
    /// Reads the value.
    pub get: fn(&T) -> f64,
    /// Writes the value; whole numbers are rounded.
    pub set: fn(&mut T, f64),
}

impl<T> Number<T> {
    /// May the parameter have this value?
    #[must_use]
    pub fn allows(&self, value: f64) -> bool {
        allows(self.integer, self.range, value)
    }
}

impl<T> Own<T> {
    /// May an object have this value?
    #[must_use]
    pub fn allows(&self, value: f64) -> bool {
        allows(self.integer, self.range, value)
    }
}

fn allows(integer: bool, range: (f64, f64), value: f64) -> bool {
    if integer {
        value.fract() == 0.0 && value >= range.0 && value <= range.1
    } else {
        inside(value, range)
    }
}

/// Does the value lie in the range, ends included? Compared as f32, because most settings are stored so. NaN lies in
/// no range.
pub(super) fn inside(value: f64, (low, high): (f64, f64)) -> bool {
    value as f32 >= low as f32 && value as f32 <= high as f32
}

/// How a slider spreads its range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Evenly.
    Linear,
    /// Logarithmically; the left end of a slider that begins at 0 is 0.
    Logarithmic,
}

/// A value that its parameter does not allow.
#[derive(Clone, Debug, PartialEq)]
pub struct OutOfRange {
    /// Dotted key, with `object.N.` where it belongs to an object.
    pub key: String,
    /// The value as text.
    pub value: String,
    /// The allowed values, with the unit.
    pub allowed: String,
}

impl<T> Parameter<T> {
    /// The section that the key stands in, `trail` for `trail.decay`; empty for top-level keys.
    #[must_use]
    pub fn section(&self) -> &'static str {
        self.key.rsplit_once('.').map_or("", |(section, _)| section)
    }

    /// Does a change from `old` to `new` restart a simulation?
    #[must_use]
    pub fn restarts(&self, old: &T, new: &T) -> bool {
        self.effect == Effect::Restart && self.differs(old, new)
    }

    /// Is the value different in the two?
    #[must_use]
    pub fn differs(&self, a: &T, b: &T) -> bool {
        match &self.kind {
            Kind::Number(number) => (number.get)(a) != (number.get)(b),
            Kind::Choice { get, .. } => get(a) != get(b),
            Kind::Vector { get, .. } => get(a) != get(b),
            Kind::Own(own) => (own.get)(a) != (own.get)(b),
            Kind::Text { get, .. } => get(a) != get(b),
        }
    }

    /// Copies the value of `from` to `to`.
    pub fn copy(&self, from: &T, to: &mut T) {
        match &self.kind {
            Kind::Number(number) => (number.set)(to, (number.get)(from)),
            Kind::Choice { get, set, .. } => set(to, get(from)),
            Kind::Vector { get, set, .. } => set(to, get(from)),
            Kind::Own(own) => (own.set)(to, (own.get)(from)),
            Kind::Text { get, set, .. } => set(to, get(from).to_owned()),
        }
    }

    /// The allowed values as text: `0 to 1`, `reflect or stop`.
    #[must_use]
    pub fn allowed(&self) -> String {
        let unit = if self.unit.is_empty() {
            String::new()
        } else {
            format!(" {}", self.unit)
        };
        match &self.kind {
            Kind::Number(Number { range, integer, .. }) | Kind::Own(Own { range, integer, .. }) => {
                let whole = if *integer { "whole numbers " } else { "" };
                let (low, high) = *range;
                format!("{whole}{} to {}{unit}", grouped(low), grouped(high))
            }
            Kind::Choice { words, .. } => any_of(words),
            Kind::Text { what, .. } => (*what).to_owned(),
            Kind::Vector {
                range: (low, high), ..
            } => {
                format!(
                    "three numbers from {} to {}{unit}",
                    grouped(*low),
                    grouped(*high)
                )
            }
        }
    }

    /// The value that `settings` hold, as the scene file writes it.
    #[must_use]
    pub fn value(&self, settings: &T) -> String {
        match &self.kind {
            Kind::Number(number) => {
                let value = (number.get)(settings);
                if number.integer || number.is_double {
                    format!("{value}")
                } else {
                    format!("{}", value as f32)
                }
            }
            Kind::Choice { words, get, .. } => words[get(settings)].to_owned(),
            Kind::Vector { is_double, get, .. } => {
                let [x, y, z] = get(settings).map(|value| match is_double {
                    true => format!("{value}"),
                    false => format!("{}", value as f32),
                });
                format!("[{x}, {y}, {z}]")
            }
            Kind::Own(own) => match (own.get)(settings) {
                Some(value) => format!("{}", value as f32),
                None => "the scene's".to_owned(),
            },
            Kind::Text { get, .. } => get(settings).to_owned(),
        }
    }

    fn check(&self, prefix: &str, settings: &T, problems: &mut Vec<OutOfRange>) {
        let fits = match &self.kind {
            Kind::Number(number) => number.allows((number.get)(settings)),
            Kind::Choice { .. } | Kind::Text { .. } => true,
            Kind::Vector { range, get, .. } => get(settings).iter().all(|&c| inside(c, *range)),
            Kind::Own(own) => (own.get)(settings).is_none_or(|value| own.allows(value)),
        };
        if !fits {
            problems.push(OutOfRange {
                key: format!("{prefix}{}", self.key),
                value: self.value(settings),
                allowed: self.allowed(),
            });
        }
    }
}

/// Everything in `settings` that its parameter does not allow, in the order of the table.
#[must_use]
pub fn out_of_range(settings: &Settings) -> Vec<OutOfRange> {
    let mut problems = Vec::new();
    for parameter in PARAMETERS {
        parameter.check("", settings, &mut problems);
    }
    for (i, object) in settings.objects.iter().enumerate() {
        for parameter in OBJECT_PARAMETERS {
            parameter.check(&format!("object.{i}."), object, &mut problems);
        }
        let frames = &object.motion.keyframes;
        keyframes::check(
            &format!("object.{i}.motion.keyframes"),
            frames,
            &mut problems,
        );
    }
    for (i, food) in settings.foods.iter().enumerate() {
        for parameter in FOOD_PARAMETERS {
            parameter.check(&format!("food.{i}."), food, &mut problems);
        }
    }
    for (i, pulse) in settings.pulses.iter().enumerate() {
        for parameter in PULSE_PARAMETERS {
            parameter.check(&format!("pulse.{i}."), pulse, &mut problems);
        }
    }
    problems
}

/// The parameter with this key.
#[must_use]
pub fn find(key: &str) -> Option<&'static Parameter> {
    PARAMETERS.iter().find(|parameter| parameter.key == key)
}

/// The parameters whose change from `old` to `new` restarts a simulation. Objects
/// that were added, removed, reshaped or renamed are not in the list; compare `objects` for that.
#[must_use]
pub fn restarting(old: &Settings, new: &Settings) -> Vec<&'static Parameter> {
    PARAMETERS
        .iter()
        .filter(|parameter| parameter.restarts(old, new))
        .collect()
}

/// `a, b or c`.
pub(super) fn any_of(words: &[&str]) -> String {
    joined(words, "or")
}

/// `a, b and c`.
pub(super) fn all_of(words: &[&str]) -> String {
    joined(words, "and")
}

fn joined(words: &[&str], conjunction: &str) -> String {
    match words {
        [] => String::new(),
        [only] => (*only).to_owned(),
        [rest @ .., last] => format!("{} {conjunction} {last}", rest.join(", ")),
    }
}

/// A number as text, with commas from 10,000 on.
#[must_use]
pub fn grouped(value: f64) -> String {
    if value.fract() != 0.0 || value.abs() < 10_000.0 {
        return format!("{value}");
    }
    with_commas(value)
}
