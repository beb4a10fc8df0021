//! One table of the actions in the window, which keys, the help, buttons and the search read.

use egui::{Event, Key, Modifiers};
use myxo::scene::settings::Show;

use crate::lab::document::Document;

/// Why tools rest in a view that is flat.
pub const FLAT: &str =
    "Tools work on the surface, and the atlas is flat: choose another view first";
/// Why a view that is flat has no lines of the network.
pub const NO_LINES: &str =
    "The network's lines lie on the surface, and the atlas is flat: choose another view first";
/// Why nothing can be done with an object.
pub const PICK_FIRST: &str = "Pick an object first: click on it";

/// Something that a key, a button or the search does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// Runs or holds the simulation.
    Pause,
    /// Takes one step, and holds.
    SingleStep,
    /// Restarts at step 0.
    Restart,
    /// Shows this view.
    Show(Show),
    /// Shows the atlas beside the picture, or no longer.
    Split,
    /// Shows the network's lines over the picture, or no longer.
    Network,
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
    /// A random look.
    ByChance,
    /// The random look before.
    EarlierThrow,
    /// The random look after.
    LaterThrow,
    /// Brings the camera to where the scene's file puts it.
    Home,
    /// Brings the selected object into the picture, or the whole scene.
    Fit,
    /// Writes the picture to a file.
    Screenshot,
    /// Begins to record the window, or ends it.
    Record,
    /// Hides or shows the exports.
    Export,
    /// Chooses a file to open.
    Open,
    /// Writes the scene to its file.
    Save,
    /// Writes the scene to a file that is asked for.
    SaveAs,
    /// Takes back a change.
    Undo,
    /// Brings it back.
    Redo,
    /// Hides or shows the panel.
    Panel,
    /// Shows the picture alone.
    PictureAlone,
    /// Drifts from look to look, and round the scene.
    Autopilot,
    /// Fills the screen with the window.
    FullScreen,
    /// Changes between the light interface and the dark one.
    Theme,
    /// Hides or shows scenes and presets.
    Gallery,
    /// Hides or shows the list of controls.
    Help,
    /// Takes the brush used last, or none.
    Brush,
    /// Takes the tool for food, or none.
    Food,
    /// Takes the tool for pulses, or none.
    Pulse,
    /// Shows or hides what lies under the pointer.
    Probe,
    /// Puts a copy of the selected object into the scene.
    Duplicate,
    /// Takes the selected object or food out of the scene.
    Remove,
    /// Hides the selected object in the picture.
    Hide,
    /// Shows all hidden objects again.
    ShowAll,
    /// Leaves what lies on top.
    Back,
    /// Closes the window.
    Quit,
}

impl Action {
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

    /// The reason why it cannot be done now; none if it can. `has_picked` says whether an object or food is selected.
    pub fn why_not(self, document: &Document, has_picked: bool) -> Option<String> {
        let view = document.view.show;
        let why = match self {
            Self::Show(show) => return show.why_not(&document.running).map(str::to_owned),
            Self::Undo if !document.undo.can_undo() => "Nothing was changed",
            Self::Redo if !document.undo.can_redo() => "Nothing was undone",
            Self::Split if view.is_flat() => "The picture is the atlas already",
            Self::Network if view.is_flat() => NO_LINES,
            Self::Brush | Self::Food | Self::Pulse | Self::Probe if view.is_flat() => FLAT,
            Self::Duplicate | Self::Remove | Self::Hide if !has_picked => PICK_FIRST,
            Self::ShowAll if !document.marks.any_is_hidden() => "No object is hidden",
            _ => return None,
        };
        Some(why.to_owned())
    }

    /// Writes the scene to a file, or may.
    pub fn keeps_the_scene(self) -> bool {
        matches!(self, Self::Save | Self::SaveAs | Self::Quit)
    }

    /// How its keys are written; empty where it has none.
    pub fn keys(self) -> String {
        match self {
            Self::Show(show) => show.key().map_or(String::new(), |(key, _)| key.to_owned()),
            _ => ROWS
                .iter()
                .find(|row| row.action == self)
                .map_or(String::new(), |row| row.written.to_owned()),
        }
    }

    /// A tooltip with its keys behind it.
    pub fn hint(self, text: &str) -> String {
        format!("{text} ({})", self.keys())
    }
}

/// Groups of actions in the help.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    /// The simulation.
    Run,
    /// Views of the picture.
    View,
    /// From where.
    Camera,
    /// Presets and colours.
    Looks,
    /// Objects, brushes, food.
    Scene,
    /// Files, pictures, undo.
    Files,
    /// The window itself.
    Window,
}

impl Group {
    /// In the order of the help.
    pub const ALL: [Self; 7] = [
        Self::Run,
        Self::View,
        Self::Camera,
        Self::Looks,
        Self::Scene,
        Self::Files,
        Self::Window,
    ];

    /// Its heading.
    pub fn title(self) -> &'static str {
        match self {
            Self::Run => "Simulation",
            Self::View => "View",
            Self::Camera => "Camera",
            Self::Looks => "Looks",
            Self::Scene => "Objects, brushes, food",
            Self::Files => "Files and undo",
            Self::Window => "Window",
        }
    }
}

/// An action and its keys.
struct Row {
    action: Action,
    group: Group,
    held: Modifiers,
    keys: &'static [Key],
    /// The keys as they are written.
    written: &'static str,
    /// Its description.
    what: &'static str,
}

/// Rows, one a line: the action, its group, the held modifiers, the keys, how they are written, and the description.
macro_rules! rows {
    ($($action:ident, $group:ident, $held:ident, [$($key:ident),*], $written:literal, $what:literal;)*) => {
        &[$(Row {
            action: Action::$action,
            group: Group::$group,
            held: $held,
            keys: &[$(Key::$key),*],
            written: $written,
            what: $what,
        }),*]
    };
}

const NONE: Modifiers = Modifiers::NONE;
const CTRL: Modifiers = Modifiers::COMMAND;
const CTRL_SHIFT: Modifiers = CTRL.plus(Modifiers::SHIFT);

/// Every action but the views, which have a table of their own ([`Show::key`]). Of actions that share a key, the first that
/// fits the held modifiers counts.
const ROWS: &[Row] = rows! {
    Pause,          Run,    NONE,       [Space],        "Space",        "run or pause the simulation";
    SingleStep,     Run,    NONE,       [S, Period],    "S  .",         "take one step";
    Restart,        Run,    NONE,       [R],            "R",            "reset: restart from step 0";
    Split,          View,   NONE,       [U],            "U",            "show the atlas beside the picture";
    Network,        View,   NONE,       [N],            "N",            "show the network's lines over the picture";
    Fly,            Camera, NONE,       [V],            "V",            "fly: W A S D, E up, Q down";
    NextCharts,     View,   NONE,       [X],            "X",            "show charts: none, under the trail, alone";
    NextColors,     Looks,  NONE,       [C],            "C",            "next colour map";
    NextPreset,     Looks,  NONE,       [CloseBracket], "]",            "next preset";
    PreviousPreset, Looks,  NONE,       [OpenBracket],  "[",            "previous preset";
    ByChance,       Looks,  NONE,       [D],            "D",            "a random look";
    EarlierThrow,   Looks,  NONE,       [J],            "J",            "the random look before";
    LaterThrow,     Looks,  NONE,       [K],            "K",            "the random look after";
    Home,           Camera, NONE,       [Home],         "Home",         "home: the camera as the scene's file has it";
    Fit,            Camera, NONE,       [F],            "F",            "fit the selected object or the scene into the picture";
    Screenshot,     Files,  NONE,       [F12],          "F12",          "save a screenshot";
    Record,         Files,  NONE,       [F9],           "F9",           "start or stop recording the window";
    Export,         Files,  CTRL,       [E],            "Ctrl E",       "export pictures, films, models, data";
    Open,           Files,  CTRL,       [O],            "Ctrl O",       "open a scene, preset, mesh or checkpoint";
    SaveAs,         Files,  CTRL_SHIFT, [S],            "Ctrl Shift S", "save the scene under a new name";
    Save,           Files,  CTRL,       [S],            "Ctrl S",       "save the scene in its file";
    Redo,           Files,  CTRL_SHIFT, [Z],            "Ctrl Shift Z", "redo";
    Redo,           Files,  CTRL,       [Y],            "Ctrl Y",       "redo by another key";
    Undo,           Files,  CTRL,       [Z],            "Ctrl Z",       "undo";
    Gallery,        Looks,  NONE,       [G],            "G",            "gallery: looks and scenes, beside the picture";
    Panel,          Window, NONE,       [P],            "P",            "hide or show the panel";
    PictureAlone,   Window, NONE,       [F10],          "F10",          "show the picture alone";
    Autopilot,      Window, NONE,       [A],            "A",            "autopilot: drift from look to look, until any input";
    FullScreen,     Window, NONE,       [F11],          "F11",          "full screen";
    Theme,          Window, NONE,       [T],            "T",            "light or dark interface";
    Brush,          Scene,  NONE,       [B],            "B",            "take the brush used last, or none";
    Food,           Scene,  NONE,       [O],            "O",            "take the food tool, or none";
    Pulse,          Scene,  NONE,       [M],            "M",            "take the pulse tool, or none";
    Probe,          Scene,  NONE,       [I],            "I",            "show what lies under the pointer";
    Duplicate,      Scene,  CTRL,       [D],            "Ctrl D",       "duplicate the selected object";
    Remove,         Scene,  NONE,       [Delete],       "Delete",       "remove the selected object or food";
    ShowAll,        Scene,  CTRL_SHIFT, [H],            "Ctrl Shift H", "show all hidden objects";
    Hide,           Scene,  CTRL,       [H],            "Ctrl H",       "hide the selected object in the picture";
    Help,           Window, NONE,       [H, F1],        "H, F1",        "help: keys and mouse";
    Back,           Window, NONE,       [Escape],       "Esc",          "back: leave what lies on top";
    Quit,           Window, CTRL,       [Q],            "Ctrl Q",       "quit: close the window";
};

/// Every action, its keys as they are written, what it does, and what it has to do with.
pub fn all() -> impl Iterator<Item = (Action, &'static str, String, Group)> {
    let mut views: Vec<Show> = Show::ALL.to_vec();
    // As their keys lie on the keyboard; letters come last.
    let place = |show: &Show| show.key().and_then(|(key, _)| "1234567890".find(key));
    views.sort_by_key(|show| place(show).unwrap_or(usize::MAX));
    let views = views.into_iter().filter_map(|show| {
        let (key, what) = show.key()?;
        Some((Action::Show(show), key, what.to_owned(), Group::View))
    });
    let rows = ROWS.iter();
    let rows = rows.map(|row| (row.action, row.written, row.what.to_owned(), row.group));
    views.chain(rows)
}

/// The uses of the mouse, for the help.
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

/// The actions whose keys were pressed in this frame, in the order in which they were pressed. While text is being typed, only those
/// count that write no letters and lead nowhere in a text. If Escape `leaves_field`, text was being typed until then, and that is all
/// that this Escape does.
pub fn pressed(ctx: &egui::Context, mut leaves_field: bool) -> Vec<Action> {
    let is_typing = ctx.text_edit_focused();
    let has_keyboard = ctx.memory(|memory| memory.focused().is_some());
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
            // A button that has the keyboard is pressed by it.
            if *key == Key::Space && has_keyboard {
                return true;
            }
            // The field still has to see it.
            if leaves_field && *key == Key::Escape {
                leaves_field = false;
                return true;
            }
            let is_typing = is_typing || leaves_field;
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

/// The action of a key with these modifiers. A letter alone differs from the letter with Shift or Alt, as in other programs;
/// signs may need Shift to be written.
fn action_of(held: Modifiers, key: Key) -> Option<Action> {
    let is_letter = (Key::A..=Key::Z).contains(&key);
    let is_held = |modifiers: Modifiers| match is_letter {
        true => held.matches_exact(modifiers),
        false => held.matches_logically(modifiers),
    };
    let row = ROWS
        .iter()
        .find(|row| row.keys.contains(&key) && is_held(row.held));
    row.map(|row| row.action).or_else(|| {
        let view = view_of(key).filter(|_| is_held(NONE));
        view.map(Action::Show)
    })
}

/// The view with this key.
fn view_of(key: Key) -> Option<Show> {
    let mut views = Show::ALL.iter().copied();
    views.find(|show| { show.key() }.is_some_and(|(name, _)| Key::from_name(name) == Some(key)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_action_has_one_line_and_every_key_one_action() {
        let written: Vec<&str> = all().map(|(_, keys, ..)| keys).collect();
        for (i, keys) in written.iter().enumerate() {
            assert!(!written[..i].contains(keys), "{keys} stands twice");
        }
        for row in ROWS {
            for key in row.keys {
                assert_eq!(
                    action_of(row.held, *key),
                    Some(row.action),
                    "{}",
                    row.written
                );
            }
        }
        for group in Group::ALL {
            assert!(all().any(|(.., own)| own == group), "{}", group.title());
        }
    }

    #[test]
    fn keys_of_views_do_nothing_else() {
        for &show in Show::ALL {
            let Some((name, _)) = show.key() else {
                continue;
            };
            let key = Key::from_name(name).expect(name);
            let action = action_of(Modifiers::NONE, key);
            assert_eq!(action, Some(Action::Show(show)), "{name}");
        }
    }
}
