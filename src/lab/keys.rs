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
    /// The atlas's charts: none, under the trail, alone.
    NextCharts,
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
    /// Closes the window.
    Quit,
}

/// What is held, keys, how they are written, what they do, and in words.
pub const KEYS: &[(Modifiers, &[Key], &str, KeyAction, &str)] = &[
    (
        Modifiers::NONE,
        &[Key::Space],
        "Space",
        KeyAction::Pause,
        "run or pause",
    ),
    (
        Modifiers::NONE,
        &[Key::S, Key::Period],
        "S  .",
        KeyAction::SingleStep,
        "one step",
    ),
    (
        Modifiers::NONE,
        &[Key::R],
        "R",
        KeyAction::Reset,
        "restart from step 0",
    ),
    (
        Modifiers::NONE,
        &[Key::Num1],
        "1",
        KeyAction::ShowSurface,
        "lit surface",
    ),
    (
        Modifiers::NONE,
        &[Key::Num2],
        "2",
        KeyAction::ShowParticles,
        "particles",
    ),
    (
        Modifiers::NONE,
        &[Key::Num3],
        "3",
        KeyAction::ShowAtlas,
        "atlas, unwrapped",
    ),
    (
        Modifiers::NONE,
        &[Key::X],
        "X",
        KeyAction::NextCharts,
        "charts: none, under the trail, alone",
    ),
    (
        Modifiers::NONE,
        &[Key::C],
        "C",
        KeyAction::NextColors,
        "next colour map",
    ),
    (
        Modifiers::NONE,
        &[Key::F, Key::Home],
        "F",
        KeyAction::Fit,
        "fit the scene into the picture",
    ),
    (
        Modifiers::NONE,
        &[Key::F12],
        "F12",
        KeyAction::Screenshot,
        "save a screenshot",
    ),
    (
        Modifiers::NONE,
        &[Key::P],
        "P",
        KeyAction::Panel,
        "hide or show the panel",
    ),
    (
        Modifiers::NONE,
        &[Key::H, Key::F1],
        "H",
        KeyAction::Help,
        "hide or show this list",
    ),
    (
        Modifiers::COMMAND,
        &[Key::Q],
        "Ctrl Q",
        KeyAction::Quit,
        "close the window",
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

/// What the keys pressed in this frame do; nothing while text is being typed.
pub fn pressed(ctx: &egui::Context) -> Vec<KeyAction> {
    if ctx.text_edit_focused() {
        return Vec::new();
    }
    ctx.input_mut(|input| {
        KEYS.iter()
            .filter(|(modifiers, keys, ..)| {
                keys.iter().any(|key| input.consume_key(*modifiers, *key))
            })
            .map(|(_, _, _, action, _)| *action)
            .collect()
    })
}
