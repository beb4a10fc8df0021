//! What keys do, in one table: the handler and the help read the same.

use egui::{Key, Modifiers};

/// Something that a key does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeyAction {
    /// Runs or holds the simulation.
    Pause,
    /// One step, held.
    SingleStep,
    /// Back to step 0.
    Reset,
    /// The lit surface.
    ShowSurface,
    /// Particles as points.
    ShowParticles,
    /// The unwrapped atlas.
    ShowAtlas,
    /// The next colour map.
    NextColors,
    /// The whole scene in the picture.
    Fit,
    /// Writes the picture to a file.
    Screenshot,
    /// Hides or shows the panel.
    Panel,
    /// Hides or shows the list of controls.
    Help,
}

/// Keys, how they are written, what they do, and in words.
pub const KEYS: &[(&[Key], &str, KeyAction, &str)] = &[
    (&[Key::Space], "Space", KeyAction::Pause, "run or pause"),
    (
        &[Key::S, Key::Period],
        "S  .",
        KeyAction::SingleStep,
        "one step",
    ),
    (&[Key::R], "R", KeyAction::Reset, "restart from step 0"),
    (&[Key::Num1], "1", KeyAction::ShowSurface, "lit surface"),
    (&[Key::Num2], "2", KeyAction::ShowParticles, "particles"),
    (&[Key::Num3], "3", KeyAction::ShowAtlas, "atlas, unwrapped"),
    (&[Key::C], "C", KeyAction::NextColors, "next colour map"),
    (
        &[Key::F, Key::Home],
        "F",
        KeyAction::Fit,
        "fit the scene into the picture",
    ),
    (
        &[Key::F12],
        "F12",
        KeyAction::Screenshot,
        "save a screenshot",
    ),
    (&[Key::P], "P", KeyAction::Panel, "hide or show the panel"),
    (
        &[Key::H, Key::F1],
        "H",
        KeyAction::Help,
        "hide or show this list",
    ),
];

/// What the mouse does, for the help.
pub const MOUSE: &[(&str, &str)] = &[
    ("Drag", "orbit"),
    ("Right drag, Shift drag", "pan"),
    ("Wheel", "zoom to the pointer"),
    ("Double click", "look at that point"),
    ("Ctrl C, Ctrl V", "copy and paste the whole scene as text"),
];

/// What the keys pressed in this frame do; nothing while text is being typed or a modifier is held.
pub fn pressed(ctx: &egui::Context) -> Vec<KeyAction> {
    if ctx.text_edit_focused() {
        return Vec::new();
    }
    ctx.input_mut(|input| {
        KEYS.iter()
            .filter(|(keys, ..)| {
                keys.iter()
                    .any(|key| input.consume_key(Modifiers::NONE, *key))
            })
            .map(|(_, _, action, _)| *action)
            .collect()
    })
}
