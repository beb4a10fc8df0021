//! Requests of the interface to the window.

use std::path::PathBuf;

use glam::{Vec2, Vec3};
use myxo::scene::settings::PulseSettings;
use myxo::sim::paint::Brush;

use crate::lab::kept_scenes::KeptScene;

/// Something that the window must do.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// Settings changed that the running simulation can take over.
    Apply,
    /// Restart at step 0, with the settings as they are edited.
    Restart,
    /// Continue from what had grown before a reset, or in another scene.
    GoBack,
    /// Keep the present state in memory.
    KeepState,
    /// Continue from the kept state of this number.
    ToState(u64),
    /// Undo or redo continues from the kept state of this number.
    ReturnToState(u64),
    /// Take one step.
    Step,
    /// Restart the measurement of times.
    ClearTimes,
    /// Keep the times as they are shown, or show those that come again.
    FreezeTimes(bool),
    /// Write the times that are shown to files.
    SaveTimes,
    /// Write the picture to a file.
    Screenshot,
    /// Put the surface point that this pixel of the picture shows in its middle.
    Refocus(Vec2),
    /// Put the scene with its settings and camera into the clipboard.
    Copy,
    /// Put the look alone into the clipboard.
    CopyLook,
    /// Keep the look as a preset of this name.
    SavePreset(String),
    /// Remove a preset of one's own.
    RemovePreset(String),
    /// Close the window.
    Quit,
    /// Take over a scene or a look from the clipboard.
    Paste(String),
    /// Write the scene as it is edited and looked at to a file.
    Save,
    /// Opens the dialog that asks where.
    AskWhereToSave,
    /// Opens the dialog that asks for the folder of exports.
    AskForFolder,
    /// Saves the scene in this file, in the place of what is there.
    SaveAs(PathBuf),
    /// Show another scene that comes with the program.
    Open(&'static str),
    /// Show another scene that comes with the program, with the present look.
    OpenWithLook(&'static str),
    /// Show a scene as it was left.
    OpenKept(KeptScene),
    /// Open a file like a dropped one.
    TakeFile(PathBuf),
    /// Open a mesh as a scene of its own.
    OpenAlone(PathBuf),
    /// Give up the scene that is on its way.
    CancelLoading,
    /// The window over the whole screen, or no longer.
    FullScreen,
    /// The user acts on the scene with a tool.
    Tool(ToolRequest),
    /// Take something out.
    Export(ExportRequest),
}

impl Command {
    /// Does it write down what the scene looks like?
    pub fn writes_the_look(&self) -> bool {
        match self {
            Self::Copy | Self::CopyLook | Self::Save | Self::SaveAs(_) | Self::SavePreset(_) => {
                true
            }
            Self::Export(ExportRequest::Export(model)) => {
                matches!(model, Model::Scene | Model::Checkpoint)
            }
            _ => false,
        }
    }
}

/// Work for a tool that needs the simulation.
#[derive(Clone, Debug, PartialEq)]
pub enum ToolRequest {
    /// A brush was drawn from one pixel of the picture to another.
    Stroke {
        /// The previous position.
        from: Vec2,
        /// The present position.
        to: Vec2,
        /// The effect of a single dab.
        brush: Brush,
        /// Scene radii.
        radius: f32,
    },
    /// A pulse begins.
    Pulse {
        /// In the world.
        center: Vec3,
        /// Its place and step are not used.
        pulse: PulseSettings,
    },
    /// The button was released after a stroke that may have changed what attracts, repels or forbids.
    EndStroke,
    /// Undo, or redo with `again`, whose turn comes after strokes that had no end yet.
    Undo {
        /// Redo.
        again: bool,
    },
    /// Undo or redo has reached a state with this stroke as the last one.
    ToStroke(u64),
    /// All particles restart on the areas that are painted to attract.
    StartOnPainted,
    /// Takes an object out of the scene.
    Remove(Which),
    /// Puts a mesh into the scene: `builtin:NAME`, or a file.
    Add(String, Ticket),
    /// Duplicates an object.
    Duplicate(Which, Ticket),
    /// Multiplies an object's scale.
    Scale(usize, f32),
    /// Undo or redo has brought other objects than those that run: they take over what has grown.
    Renew,
}

/// Distinguishes objects that were asked for before they have names.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Ticket(pub u64);

/// An object that something is to be done with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Which {
    /// An edited object, by its index.
    Object(usize),
    /// A requested object, whether it has come or not.
    Asked(Ticket),
}

/// Identifies a request of the interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExportRequest {
    /// Begin to record the window, or end it.
    Record,
    /// A film at a fixed step.
    Film,
    /// A file of the present state.
    Export(Model),
    /// Give up what is being made.
    Cancel,
    /// End the film that is being made with the pictures that it has.
    Finish,
}

/// The format in which a state is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Model {
    /// A model with the trail on it.
    Glb,
    /// A mesh with colours.
    Ply,
    /// All data for NumPy.
    Npz,
    /// A scene file.
    Scene,
    /// The whole state, to continue from.
    Checkpoint,
}

impl Model {
    /// Every one, in the order of the panel.
    pub const ALL: [Self; 5] = [
        Self::Glb,
        Self::Ply,
        Self::Npz,
        Self::Scene,
        Self::Checkpoint,
    ];

    /// The ending of its files.
    pub fn ending(self) -> &'static str {
        match self {
            Self::Glb => "glb",
            Self::Ply => "ply",
            Self::Npz => "npz",
            Self::Scene => "toml",
            Self::Checkpoint => "ckpt",
        }
    }
}
