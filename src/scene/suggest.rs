//! Suggestions for mistyped names.

use super::parameters::{FOOD_PARAMETERS, OBJECT_PARAMETERS, PARAMETERS, PULSE_PARAMETERS};

/// The key that was probably meant: the same word in another section, or nearly the same key, or nearly the same word,
/// or nearly a section.
pub(super) fn nearest_key(unknown: &str) -> Option<String> {
    let of_food = unknown.strip_prefix("food.");
    if let Some((index, field)) = of_food.and_then(|rest| rest.split_once('.')) {
        let keys = FOOD_PARAMETERS.iter().map(|parameter| parameter.key);
        return nearest(field, keys).map(|key| format!("food.{index}.{key}"));
    }
    let of_pulse = unknown.strip_prefix("pulse.");
    if let Some((index, field)) = of_pulse.and_then(|rest| rest.split_once('.')) {
        let keys = PULSE_PARAMETERS.iter().map(|parameter| parameter.key);
        return nearest(field, keys).map(|key| format!("pulse.{index}.{key}"));
    }
    let prefix = match unknown
        .strip_prefix("object.")
        .and_then(|rest| rest.split_once('.'))
    {
        Some((index, _)) => format!("object.{index}."),
        None => "object.0.".to_owned(),
    };
    let objects = OBJECT_PARAMETERS.iter().map(|parameter| parameter.key);
    let mut keys: Vec<String> = ["name", "mesh", "distance_to", "glue"]
        .into_iter()
        .chain(objects)
        .map(|key| format!("{prefix}{key}"))
        .collect();
    let scene = PARAMETERS.iter().map(|parameter| parameter.key.to_owned());
    // A mistyped key of an object is more likely an object's.
    if unknown.starts_with("object.") {
        keys.extend(scene);
    } else {
        keys.splice(0..0, scene);
    }
    let leaf = |key: &str| {
        key.rsplit_once('.')
            .map_or(key, |(_, leaf)| leaf)
            .to_owned()
    };
    let with_leaf = |wanted: &str| keys.iter().find(|key| leaf(key) == wanted).cloned();
    with_leaf(&leaf(unknown))
        .or_else(|| nearest(unknown, keys.iter().map(String::as_str)).map(str::to_owned))
        .or_else(|| {
            let leaves: Vec<String> = keys.iter().map(|key| leaf(key)).collect();
            with_leaf(nearest(&leaf(unknown), leaves.iter().map(String::as_str))?)
        })
        .or_else(|| {
            let sections = PARAMETERS.iter().map(|parameter| parameter.section());
            let lists = ["object", "food", "pulse"];
            let sections = sections.chain(lists).filter(|s| !s.is_empty());
            nearest(unknown, sections).map(str::to_owned)
        })
}

/// The candidate nearest to a mistyped word, if it is similar enough.
pub fn nearest<'a>(word: &str, candidates: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let length = word.chars().count();
    let limit = (length / 3).clamp(1, 4);
    candidates
        // Words whose lengths differ by more are farther apart: a distance to a word of a million letters takes seconds.
        .filter(|candidate| candidate.chars().count().abs_diff(length) <= limit)
        .map(|candidate| (strsim::damerau_levenshtein(word, candidate), candidate))
        .filter(|&(distance, _)| distance <= limit)
        .min_by_key(|&(distance, _)| distance)
        .map(|(_, candidate)| candidate)
}

/// Is it a section of the scene file, such as `trail`?
pub(super) fn is_section(key: &str) -> bool {
    PARAMETERS
        .iter()
        .any(|parameter| parameter.section() == key)
}

/// The first key of a section, as an example.
pub(super) fn first_of(section: &str) -> &'static str {
    PARAMETERS
        .iter()
        .find(|parameter| parameter.section() == section)
        .map_or("", |parameter| parameter.key)
}
