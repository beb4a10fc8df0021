//! The second look, which places can have besides the scene's own.

use std::sync::LazyLock;

use serde::Serialize;

use super::{ColorMap, PhysarumSettings, Settings, TrailSettings};
use crate::scene::builtin::preset;
use crate::scene::file::Reader;

/// The names that a second look can have: none, and the built-in presets that turn and sense by the usual rules, because those rules are
/// the scene's everywhere.
pub const SECOND_LOOKS: [&str; 17] = [
    NONE, "network", "cells", "ribbons", "spots", "felt", "sparse", "rings", "pores", "lace",
    "bands", "waves", "mist", "streams", "feeding", "shy", "meeting",
];
/// No second look.
const NONE: &str = "none";

/// `[second_look]`
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SecondLookSettings {
    /// The built-in preset that particles follow where it is painted; `none` for no second look.
    pub preset: String,
    /// A picture of the texture that says where; a path relative to the scene file, empty for nowhere.
    pub map: String,
}

impl Default for SecondLookSettings {
    fn default() -> Self {
        Self {
            preset: NONE.to_owned(),
            map: String::new(),
        }
    }
}

/// What a preset says about particles, and about the trail in whose units it says it.
#[derive(Clone, Debug)]
pub struct SecondLook {
    /// Its particles.
    pub physarum: PhysarumSettings,
    /// Its trail.
    pub trail: TrailSettings,
    /// Its colours.
    pub color_map: ColorMap,
}

impl SecondLookSettings {
    /// Is there a second look?
    #[must_use]
    pub fn is_some(&self) -> bool {
        self.index() > 0
    }

    /// Its index in [`SECOND_LOOKS`].
    pub(in crate::scene) fn index(&self) -> usize {
        let mut names = SECOND_LOOKS.iter();
        names.position(|name| *name == self.preset).unwrap_or(0)
    }

    /// The look, if there is one.
    #[must_use]
    pub fn look(&self) -> Option<&'static SecondLook> {
        static LOOKS: LazyLock<Vec<Option<SecondLook>>> =
            LazyLock::new(|| SECOND_LOOKS.iter().map(|name| read(name)).collect());
        LOOKS[self.index()].as_ref()
    }
}

fn read(name: &str) -> Option<SecondLook> {
    let mut reader = Reader::new(Settings::default());
    reader.preset("", preset(name)?.text);
    let Settings {
        physarum,
        trail,
        picture,
        ..
    } = reader.finish().ok()?;
    Some(SecondLook {
        physarum,
        trail,
        color_map: picture.color_map,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::builtin::PRESETS;

    /// Would catch: a preset that is added and cannot be a second look, one that cannot be read, and one whose rules would be missing.
    #[test]
    fn every_preset_without_rules_can_be_a_second_look() {
        let has_no_rules = |name: &str| {
            let own = read(name).expect("it is right").physarum;
            let plain = PhysarumSettings::default();
            (own.turning, own.random_turn, own.sensitivity)
                == (plain.turning, plain.random_turn, plain.sensitivity)
        };
        let names = PRESETS.iter().map(|preset| preset.name);
        let (names, others): (Vec<&str>, Vec<&str>) = names.partition(|name| has_no_rules(name));
        assert_eq!(others, ["bone", "cords", "haze"], "the guide lists them");
        assert!([NONE].into_iter().chain(names).eq(SECOND_LOOKS));
        for (i, name) in SECOND_LOOKS.into_iter().enumerate() {
            let look = SecondLookSettings {
                preset: name.to_owned(),
                ..SecondLookSettings::default()
            };
            assert_eq!(look.look().is_some(), i > 0, "{name}");
        }
        let cells = SecondLookSettings {
            preset: "cells".to_owned(),
            ..SecondLookSettings::default()
        };
        assert_ne!(cells.look().unwrap().physarum, PhysarumSettings::default());
        assert_eq!(cells.look().unwrap().color_map, ColorMap::Viridis);
    }
}
