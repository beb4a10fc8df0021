//! What keys do, in one table: the handler and the help read the same.

use egui::{Key, Modifiers};
use myxo::scene::settings::Show;

/// Something that a key does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeyAction {
    /// Runs or holds the simulation.
    Pause,
    /// One step, held.
    SingleStep,
    /// Back to step 0.
    Reset,
    /// What the picture shows.
    Show(Show),
    /// The atlas beside the picture, or no longer.
    Split,
    /// Flies, or turns about the scene.
    Fly,
    /// The atlas's charts: none, under the trail, alone.
    NextCharts,
    /// The next colour map.
    NextColors,
    /// The look of the next preset.
    NextPreset,
    /// The look of the preset before.
    PreviousPreset,
    /// A look by chance.
    ByChance,
    /// The whole scene in the picture.
    Fit,
    /// Writes the picture to a file.
    Screenshot,
    /// Begins to record the window, or ends it.
    Record,
    /// Hides or shows what there is for taking out.
    TakeOut,
    /// Chooses a file to open.
    Open,
    /// Writes the scene to a file.
    Save,
    /// Takes back a change.
    Undo,
    /// Brings it back.
    Redo,
    /// Hides or shows the panel.
    Panel,
    /// The picture alone.
    Perform,
    /// The window over the whole screen.
    FullScreen,
    /// A light interface or a dark one.
    Theme,
    /// Hides or shows scenes and presets.
    Gallery,
    /// Hides or shows the list of controls.
    Help,
    /// The brush used last, or none.
    Brush,
    /// The tool for food, or none.
    Food,
    /// Shows or hides what lies under the pointer.
    Probe,
    /// Takes the picked object out of the scene.
    Remove,
    /// Leaves what lies on top.
    Back,
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
        KeyAction::Show(Show::Surface),
        "trail on the lit surface",
    ),
    (
        Modifiers::NONE,
        &[Key::Num2],
        "2",
        KeyAction::Show(Show::Particles),
        "particles",
    ),
    (
        Modifiers::NONE,
        &[Key::Num3],
        "3",
        KeyAction::Show(Show::Atlas),
        "atlas, unwrapped",
    ),
    (
        Modifiers::NONE,
        &[Key::Num4],
        "4",
        KeyAction::Show(Show::Relief),
        "relief",
    ),
    (
        Modifiers::NONE,
        &[Key::Num5],
        "5",
        KeyAction::Show(Show::Glow),
        "glow",
    ),
    (
        Modifiers::NONE,
        &[Key::Num6],
        "6",
        KeyAction::Show(Show::Headings),
        "headings",
    ),
    (
        Modifiers::NONE,
        &[Key::Num7],
        "7",
        KeyAction::Show(Show::Density),
        "density of particles",
    ),
    (
        Modifiers::NONE,
        &[Key::Num8],
        "8",
        KeyAction::Show(Show::Wireframe),
        "wireframe",
    ),
    (
        Modifiers::NONE,
        &[Key::Num9],
        "9",
        KeyAction::Show(Show::Distance),
        "signed distance",
    ),
    (
        Modifiers::NONE,
        &[Key::Num0],
        "0",
        KeyAction::Show(Show::Nearest),
        "nearest object",
    ),
    (
        Modifiers::NONE,
        &[Key::U],
        "U",
        KeyAction::Split,
        "atlas beside the picture",
    ),
    (
        Modifiers::NONE,
        &[Key::V],
        "V",
        KeyAction::Fly,
        "fly: W A S D, E up, Q down",
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
        &[Key::CloseBracket],
        "]",
        KeyAction::NextPreset,
        "next preset",
    ),
    (
        Modifiers::NONE,
        &[Key::OpenBracket],
        "[",
        KeyAction::PreviousPreset,
        "preset before",
    ),
    (
        Modifiers::NONE,
        &[Key::D],
        "D",
        KeyAction::ByChance,
        "a look by chance (dice)",
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
        &[Key::F9],
        "F9",
        KeyAction::Record,
        "record the window, or end it",
    ),
    (
        Modifiers::COMMAND,
        &[Key::E],
        "Ctrl E",
        KeyAction::TakeOut,
        "take it out: pictures, films, models, data",
    ),
    (
        Modifiers::COMMAND,
        &[Key::O],
        "Ctrl O",
        KeyAction::Open,
        "open a file: scene, preset, mesh, checkpoint",
    ),
    (
        Modifiers::COMMAND,
        &[Key::S],
        "Ctrl S",
        KeyAction::Save,
        "save the scene as a file",
    ),
    (
        Modifiers::COMMAND.plus(Modifiers::SHIFT),
        &[Key::Z],
        "Ctrl Shift Z",
        KeyAction::Redo,
        "redo",
    ),
    (
        Modifiers::COMMAND,
        &[Key::Z],
        "Ctrl Z",
        KeyAction::Undo,
        "undo",
    ),
    (
        Modifiers::NONE,
        &[Key::G],
        "G",
        KeyAction::Gallery,
        "scenes and presets",
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
        &[Key::F10],
        "F10",
        KeyAction::Perform,
        "the picture alone",
    ),
    (
        Modifiers::NONE,
        &[Key::F11],
        "F11",
        KeyAction::FullScreen,
        "full screen, or window",
    ),
    (
        Modifiers::NONE,
        &[Key::T],
        "T",
        KeyAction::Theme,
        "light or dark interface",
    ),
    (
        Modifiers::NONE,
        &[Key::B],
        "B",
        KeyAction::Brush,
        "the brush used last, or none",
    ),
    (
        Modifiers::NONE,
        &[Key::O],
        "O",
        KeyAction::Food,
        "the tool for food, or none",
    ),
    (
        Modifiers::NONE,
        &[Key::I],
        "I",
        KeyAction::Probe,
        "what lies under the pointer",
    ),
    (
        Modifiers::NONE,
        &[Key::Delete],
        "Delete",
        KeyAction::Remove,
        "take the picked object or food out",
    ),
    (
        Modifiers::NONE,
        &[Key::H, Key::F1],
        "H",
        KeyAction::Help,
        "hide or show this list",
    ),
    (
        Modifiers::NONE,
        &[Key::Escape],
        "Esc",
        KeyAction::Back,
        "leave what lies on top",
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
    ("L and drag", "move the light"),
    ("Flying: wheel, Shift", "speed, four times as fast"),
    (
        "Click",
        "pick an object; its handles move, turn and scale it",
    ),
    ("Drag with a brush", "paint; right drag still pans"),
    ("Shift wheel", "size of the brush"),
    (
        "Ctrl C, Ctrl V",
        "copy and paste the scene and the view as text",
    ),
    (
        "Ctrl Shift C",
        "copy the look alone; Ctrl V takes looks, too",
    ),
    ("Ctrl +, Ctrl -, Ctrl 0", "larger, smaller, usual letters"),
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
