//! What keys do: in one table, which the help reads too, and done.

use egui::{Event, Key, Modifiers};
use myxo::scene::settings::Show;

use super::command::Command;
use super::command::Out;
use super::facts::Facts;
use super::interface::Interface;
use super::opening::EVERYTHING;

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
    Frame,
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
    SaveAs,
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
    /// Puts the picked object into the scene once more.
    Duplicate,
    /// Takes the picked object out of the scene.
    Remove,
    /// Leaves what lies on top.
    Back,
    /// Closes the window.
    Quit,
}

impl KeyAction {
    /// Works while text is being typed.
    fn is_for_typists(self) -> bool {
        matches!(
            self,
            Self::Save
                | Self::SaveAs
                | Self::Open
                | Self::Screenshot
                | Self::Record
                | Self::FullScreen
                | Self::Quit
        )
    }

    /// Writes the scene to a file, or may.
    fn keeps_the_scene(self) -> bool {
        matches!(self, Self::Save | Self::SaveAs | Self::Quit)
    }
}

/// What is held, keys, how they are written, what they do, and in words.
type Row = (
    Modifiers,
    &'static [Key],
    &'static str,
    KeyAction,
    &'static str,
);

/// Keys that the list has above those of views, which are in the table of views ([`Show::key`]).
const RUN_KEYS: &[Row] = &[
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
];

/// The same of what the list has below the keys of views.
const OTHER_KEYS: &[Row] = &[
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
        &[Key::Home],
        "Home",
        KeyAction::Fit,
        "fit the scene into the picture",
    ),
    (
        Modifiers::NONE,
        &[Key::F],
        "F",
        KeyAction::Frame,
        "the same, or the picked object",
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
        "export: pictures, films, models, data",
    ),
    (
        Modifiers::COMMAND,
        &[Key::O],
        "Ctrl O",
        KeyAction::Open,
        "open a file: scene, preset, mesh, checkpoint",
    ),
    (
        Modifiers::COMMAND.plus(Modifiers::SHIFT),
        &[Key::S],
        "Ctrl Shift S",
        KeyAction::SaveAs,
        "save it by a name of your own",
    ),
    (
        Modifiers::COMMAND,
        &[Key::S],
        "Ctrl S",
        KeyAction::Save,
        "save the scene, in the same file as before",
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
        &[Key::Y],
        "Ctrl Y",
        KeyAction::Redo,
        "redo, too",
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
        Modifiers::COMMAND,
        &[Key::D],
        "Ctrl D",
        KeyAction::Duplicate,
        "copy the picked object",
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
        "H, F1",
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

/// Every key as it is written, and what it does.
pub fn keys() -> impl Iterator<Item = (&'static str, &'static str)> {
    let mut views: Vec<_> = Show::ALL.iter().filter_map(|show| show.key()).collect();
    // As they lie on the keyboard; letters come last.
    views.sort_by_key(|(key, _)| "1234567890".find(key).unwrap_or(usize::MAX));
    let written = |rows: &'static [Row]| rows.iter().map(|(_, _, keys, _, what)| (*keys, *what));
    written(RUN_KEYS).chain(views).chain(written(OTHER_KEYS))
}

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
    (
        "Drag a handle, Ctrl",
        "in steps, with Ctrl; Esc puts the object back",
    ),
    ("Drag food with its tool", "move it over the surfaces"),
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

/// What the keys pressed in this frame do, in the order in which they were pressed. While text is being typed, only those do
/// something that write no letters and lead nowhere in a text.
pub fn pressed(ctx: &egui::Context) -> Vec<KeyAction> {
    let is_typing = ctx.text_edit_focused();
    let mut pressed = Vec::new();
    ctx.input_mut(|input| {
        input.events.retain(|event| {
            let Event::Key {
                key,
                pressed: true,
                repeat,
                modifiers,
                ..
            } = event
            else {
                return true;
            };
            let action = action_of(*modifiers, *key);
            let Some(action) = action.filter(|action| !is_typing || action.is_for_typists()) else {
                return true;
            };
            // A key that is held does in a slow frame what it would in a quick one.
            if !(*repeat && pressed.contains(&action)) {
                pressed.push(action);
            }
            false
        });
    });
    pressed
}

/// What a key does with these held. Letters mean one thing alone and another with Shift or Alt, as in other programs; signs
/// may need Shift to be written.
fn action_of(held: Modifiers, key: Key) -> Option<KeyAction> {
    let is_letter = (Key::A..=Key::Z).contains(&key);
    let is_held = |modifiers: Modifiers| match is_letter {
        true => held.matches_exact(modifiers),
        false => held.matches_logically(modifiers),
    };
    let mut rows = RUN_KEYS.iter().chain(OTHER_KEYS);
    let row = rows.find(|(modifiers, keys, ..)| keys.contains(&key) && is_held(*modifiers));
    row.map(|(_, _, _, action, _)| *action).or_else(|| {
        let view = view_of(key).filter(|_| is_held(Modifiers::NONE));
        view.map(KeyAction::Show)
    })
}

/// The view with this key.
fn view_of(key: Key) -> Option<Show> {
    let mut views = Show::ALL.iter().copied();
    views.find(|show| { show.key() }.is_some_and(|(name, _)| Key::from_name(name) == Some(key)))
}

/// A number that is being typed counts as it stands: its field takes it when it loses the keyboard.
fn take_what_is_typed(ctx: &egui::Context) {
    ctx.memory_mut(|memory| {
        if let Some(field) = memory.focused() {
            memory.surrender_focus(field);
        }
    });
}

impl Interface {
    pub(super) fn handle_keys(
        &mut self,
        ctx: &egui::Context,
        facts: &Facts,
        commands: &mut Vec<Command>,
    ) {
        self.navigation.keep_keys(ctx);
        for action in pressed(ctx) {
            if action.keeps_the_scene() {
                take_what_is_typed(ctx);
            }
            match action {
                KeyAction::Pause => self.playing = !self.playing,
                KeyAction::SingleStep => {
                    self.playing = false;
                    commands.push(Command::Step);
                }
                KeyAction::Reset => commands.push(Command::Restart),
                KeyAction::Show(show) => self.choose_view(ctx, show),
                KeyAction::Split => self.split = !self.split,
                KeyAction::Fly => self.toggle_flight(ctx),
                KeyAction::NextCharts => self.next_charts(ctx),
                KeyAction::NextColors => {
                    self.document.view.color_map = self.document.view.color_map.next()
                }
                KeyAction::NextPreset | KeyAction::PreviousPreset => {
                    let (looks, mut desk) = self.looks_at(facts, commands);
                    looks.step_preset(ctx, action == KeyAction::NextPreset, &mut desk);
                }
                KeyAction::ByChance => {
                    let (looks, mut desk) = self.looks_at(facts, commands);
                    looks.by_chance(ctx, &mut desk);
                }
                KeyAction::Fit => self.document.fit(),
                KeyAction::Frame => {
                    let is_flat = self.document.view.show.is_flat();
                    if is_flat || !self.hands.frame_picked(&facts.hand.poses) {
                        self.document.fit();
                    }
                }
                KeyAction::Screenshot => commands.push(Command::Screenshot),
                KeyAction::Record => commands.push(Command::TakeOut(Out::Record)),
                KeyAction::TakeOut => self.out.open = !self.out.open,
                KeyAction::Open => self.begin_to_open(ctx, EVERYTHING),
                KeyAction::Save => commands.push(Command::Save),
                KeyAction::SaveAs => commands.push(Command::AskWhereToSave),
                KeyAction::Undo => self.undo_by_hand(ctx, commands),
                KeyAction::Redo => self.redo(commands),
                KeyAction::Panel => self.panel = !self.panel,
                KeyAction::Perform => self.perform(ctx),
                KeyAction::FullScreen => commands.push(Command::FullScreen),
                KeyAction::Theme => self.set_light(ctx, !self.light),
                KeyAction::Gallery => self.gallery.open = !self.gallery.open,
                KeyAction::Help => self.help = !self.help,
                KeyAction::Brush | KeyAction::Food | KeyAction::Probe
                    if self.document.view.show.is_flat() =>
                {
                    self.tell_flat(ctx);
                }
                KeyAction::Brush => self.hands.toggle_brush(),
                KeyAction::Food => self.hands.toggle_food(),
                KeyAction::Probe => self.hands.probe = !self.hands.probe,
                KeyAction::Duplicate => self.duplicate_selected(ctx, commands),
                KeyAction::Remove => self.remove_selected(ctx, commands),
                KeyAction::Back => self.back(ctx, commands),
                KeyAction::Quit => commands.push(Command::Quit),
            }
        }
    }

    /// Leaves what lies on top: a list, the field for a search with what is in it, the gallery, the picture alone, a tool, a scene that is awaited.
    fn back(&mut self, ctx: &egui::Context, commands: &mut Vec<Command>) {
        if egui::Popup::is_any_open(ctx) {
            egui::Popup::close_all(ctx);
        } else if std::mem::take(&mut self.is_searching) {
            self.filter.clear();
        } else if self.help || self.gallery.open || self.out.open {
            self.help = false;
            self.gallery.open = false;
            self.out.open = false;
        } else if self.performing {
            self.perform(ctx);
        } else if self.give_up_grab(commands) {
            // What was moved is back.
        } else if self.hands.back() {
            // A tool was left, or an object.
        } else if self.navigation.is_flying() {
            self.toggle_flight(ctx);
        } else {
            commands.push(Command::CancelLoading);
        }
    }

    /// Nothing, under the trail, nothing else, and so on; where the picture has no charts, that is said.
    fn next_charts(&mut self, ctx: &egui::Context) {
        let show = self.document.view.show;
        if !show.has_charts() {
            let text = format!(
                "{} has no charts of X: {} show them",
                show.title(),
                Show::titles(Show::has_charts)
            );
            return self.notices.say(ctx, text, false);
        }
        self.document.view.charts = match self.document.view.charts {
            charts if charts < 0.5 => 0.5,
            charts if charts < 1.0 => 1.0,
            _ => 0.0,
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_of_views_do_nothing_else() {
        for &show in Show::ALL {
            let Some((name, _)) = show.key() else {
                continue;
            };
            let key = Key::from_name(name).expect(name);
            let action = action_of(Modifiers::NONE, key);
            assert_eq!(action, Some(KeyAction::Show(show)), "{name}");
        }
    }
}
