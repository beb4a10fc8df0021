//! The built-in scenes and presets, the TOML texts in `assets/`.

/// A built-in scene or preset.
#[derive(Clone, Copy, Debug)]
pub struct Builtin {
    /// Its name for `SCENE` or `--preset`.
    pub name: &'static str,
    /// Its TOML text, which begins with a comment that describes it.
    pub text: &'static str,
}

impl Builtin {
    /// Its description: the comment at its beginning.
    #[must_use]
    pub fn summary(&self) -> &'static str {
        self.text
            .lines()
            .next()
            .unwrap_or("")
            .trim_start_matches('#')
            .trim()
    }
}

macro_rules! texts {
    ($folder:literal: $($name:literal),+ $(,)?) => {
        &[$(Builtin {
            name: $name,
            text: include_str!(concat!("../../assets/", $folder, "/", $name, ".toml")),
        }),+]
    };
}

/// The scene that opens when none is named.
pub const DEFAULT_SCENE: &str = "oats";

/// Every built-in scene. `cube` and `torus` are the reference cases for comparisons.
pub static SCENES: &[Builtin] = texts!("scenes": "torus", "cube", "sphere", "plane", "pair", "suzanne", "trefoil", "gyroid", "trio", "gears", "oats", "crowd", "maze", "jones", "steiner",
        "globe", "colony");

/// The area maps that built-in scenes have, by name: PNGs.
pub static MAPS: &[(&str, &[u8])] = &[("maze", include_bytes!("../../assets/maps/maze.png"))];

/// Every built-in preset: looks, that is, values for `[physarum]`, `[trail]` and `[feeding]`.
pub static PRESETS: &[Builtin] = texts!("presets": "network", "cells", "ribbons", "spots", "felt", "sparse", "rings", "pores", "lace", "bands", "waves", "mist",
        "streams", "feeding", "shy", "meeting", "bone", "cords", "haze");

/// The built-in scene with this name.
#[must_use]
pub fn scene(name: &str) -> Option<&'static Builtin> {
    SCENES.iter().find(|scene| scene.name == name)
}

/// The preset with this name.
#[must_use]
pub fn preset(name: &str) -> Option<&'static Builtin> {
    PRESETS.iter().find(|preset| preset.name == name)
}
