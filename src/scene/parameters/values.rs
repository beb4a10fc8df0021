//! Values by their whole keys, also those of objects, foods and pulses.

use super::{FOOD_PARAMETERS, Kind, OBJECT_PARAMETERS, PULSE_PARAMETERS, Parameter, find};
use crate::scene::settings::Settings;

/// The value of a key as scene files write it; also of one with a number, such as `pulse.0.speed`. None if there is no such parameter, or
/// no object, food or pulse of that number.
#[must_use]
pub fn value_of(settings: &Settings, key: &str) -> Option<String> {
    if let Some(parameter) = find(key) {
        return Some(parameter.value(settings));
    }
    let (list, number, own) = parts(key)?;
    match list {
        "object" => own_value(OBJECT_PARAMETERS, &settings.objects, number, own),
        "food" => own_value(FOOD_PARAMETERS, &settings.foods, number, own),
        "pulse" => own_value(PULSE_PARAMETERS, &settings.pulses, number, own),
        _ => None,
    }
}

/// What the values of a parameter are, as far as programs that make values have to know.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Whole numbers.
    Whole,
    /// Any text.
    Text,
    /// Other numbers, several numbers, or words of a list.
    Other,
}

/// What the values of a key are; also of one with a number, such as `pulse.0.speed`. None if there is no such parameter.
#[must_use]
pub fn form_of(key: &str) -> Option<Form> {
    if let Some(parameter) = find(key) {
        return Some(form(parameter));
    }
    let (list, _, own) = parts(key)?;
    match list {
        "object" => own_form(OBJECT_PARAMETERS, own),
        "food" => own_form(FOOD_PARAMETERS, own),
        "pulse" => own_form(PULSE_PARAMETERS, own),
        _ => None,
    }
}

/// The list of a key with a number, the number, and the rest.
fn parts(key: &str) -> Option<(&str, usize, &str)> {
    let (list, rest) = key.split_once('.')?;
    let (number, own) = rest.split_once('.')?;
    Some((list, number.parse().ok()?, own))
}

fn form<T>(parameter: &Parameter<T>) -> Form {
    match &parameter.kind {
        Kind::Number(number) if number.integer => Form::Whole,
        Kind::Own(own) if own.integer => Form::Whole,
        Kind::Text { .. } => Form::Text,
        _ => Form::Other,
    }
}

fn own_form<T>(table: &[Parameter<T>], key: &str) -> Option<Form> {
    let parameter = table.iter().find(|parameter| parameter.key == key)?;
    Some(form(parameter))
}

fn own_value<T>(table: &[Parameter<T>], of: &[T], number: usize, key: &str) -> Option<String> {
    let parameter = table.iter().find(|parameter| parameter.key == key)?;
    Some(parameter.value(of.get(number)?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::settings::{FoodSettings, PulseSettings};

    /// Would catch: keys of a list, such as those of pulses, that scene files have and that have no value here.
    #[test]
    fn keys_of_every_list_have_a_value() {
        let mut settings = Settings::default();
        settings.foods.push(FoodSettings::default());
        settings.pulses.push(PulseSettings::default());
        settings.pulses.push(PulseSettings {
            speed: 0.02,
            ..PulseSettings::default()
        });
        let value = |key: &str| value_of(&settings, key);
        for (key, expected) in [
            ("object.0.scale", "1"),
            ("food.0.radius", "0.5"),
            ("pulse.0.speed", "0.01"),
            ("pulse.1.speed", "0.02"),
            ("pulse.0.at", "[0, 1, 0]"),
        ] {
            assert_eq!(value(key).as_deref(), Some(expected), "{key}");
        }
        assert!(value("trail.decay").is_some());
        for key in [
            "pulse.2.speed",
            "pulse.0.sped",
            "pulse.speed",
            "pulses.0.speed",
            "object.0",
            "",
        ] {
            assert_eq!(value(key), None, "{key}");
        }
    }

    /// Would catch: texts and whole numbers of a list of the scene that are taken for other values.
    #[test]
    fn keys_have_the_form_of_their_values() {
        for (key, form) in [
            ("particles.count", Some(Form::Whole)),
            ("trail.decay", Some(Form::Other)),
            ("transfer.strategy", Some(Form::Other)),
            ("particles.start_object", Some(Form::Text)),
            ("food.0.object", Some(Form::Text)),
            ("food.0.amount", Some(Form::Whole)),
            ("pulse.0.at", Some(Form::Other)),
            ("pulse.at", None),
            ("food.amount", None),
        ] {
            assert_eq!(form_of(key), form, "{key}");
        }
    }
}
