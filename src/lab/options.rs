//! How the lab is opened.

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

/// How the lab is opened.
#[derive(Clone, Debug)]
pub struct LabOptions {
    /// Index or part of the name of the device; `None` takes the best that can show pictures.
    pub device: Option<String>,
    /// Switches on the validation layers, and checks of the invariants now and then; what they say goes to the log or to
    /// the panel, and ends the lab with an error.
    pub validation: bool,
    /// Width and height of the window, pixels; `None` for those of last time.
    pub size: Option<[u32; 2]>,
    /// The file of what is kept from one time to the next; `None` keeps nothing.
    pub preferences: Option<PathBuf>,
    /// The folder for atlas layouts, which take long to compute.
    pub atlases: Option<PathBuf>,
    /// The file that gives tests the places of controls.
    pub places: Option<PathBuf>,
    /// No window is opened: what would come from it comes as lines of the standard input, for tests.
    pub windowless: bool,
    /// Close after this many pictures; `None` waits for the user.
    pub frames: Option<u32>,
    /// Behave as if the device were lost after this many pictures while the lab is busy; then its replacement, and so on.
    pub lose_device: Vec<u32>,
    /// Becomes true with Ctrl-C: then programs that make films are not waited for long.
    pub interrupt: &'static AtomicBool,
}
