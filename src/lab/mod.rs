//! The lab: a window in which slime mold grows, with every parameter beside it.

mod app;
mod back;
mod checks;
mod clocks;
mod commands;
mod facts;
mod feeding;
mod fitting;
mod flying;
mod foods;
mod gallery;
mod hands;
mod history;
mod host;
mod interface;
mod keys;
mod left;
mod loading;
mod looks;
mod lost;
mod navigation;
mod notices;
mod opening;
mod order;
mod out;
mod overlays;
mod pacing;
mod panel;
mod pasting;
mod performing;
mod place;
mod places;
mod plot;
mod preferences;
mod presets;
mod recent;
mod renewal;
mod rows;
mod saving;
mod scene_text;
mod screen;
mod show;
mod split;
mod stage;
mod theme;
mod told;
mod under_way;
mod undo;
mod view_rows;
mod views;
#[cfg(target_os = "linux")]
mod wayland;
mod widgets;
mod window;
mod windowless;
mod worker;

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

use myxo::{Error, Result};
use winit::event_loop::EventLoop;

pub use left::LeftScenes;
pub use loading::Opened;
pub use preferences::Preferences;
pub use saving::SceneFile;

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
    /// Where layouts are kept that take long to make.
    pub atlases: Option<PathBuf>,
    /// The file that tells tests where controls are.
    pub places: Option<PathBuf>,
    /// No window is opened: what would come from it comes as lines of the standard input, for tests.
    pub windowless: bool,
    /// Close after so many pictures; `None` waits for the user.
    pub frames: Option<u32>,
    /// Behave as if the device were lost after so many pictures while something goes on; then the one that takes its place,
    /// and so on.
    pub lose_device: Vec<u32>,
    /// Becomes true with Ctrl-C: then programs that make films are not waited for long.
    pub interrupt: &'static AtomicBool,
}

/// Opens the window and runs until it is closed. `listen` is given what closes it from any thread, as the user would.
pub fn run(
    opened: Opened,
    options: LabOptions,
    listen: impl FnOnce(Box<dyn Fn() + Send>) -> Result<()>,
) -> Result<()> {
    if options.windowless {
        return windowless::run(opened, options, listen);
    }
    let mut builder = EventLoop::<app::Close>::with_user_event();
    #[cfg(target_os = "linux")]
    wayland::choose(&mut builder);
    let events = builder.build().map_err(|source| host::no_window(&source))?;
    let proxy = events.create_proxy();
    // Where the loop has ended there is nothing left to close.
    listen(Box::new(move || {
        let _ = proxy.send_event(app::Close);
    }))?;
    let mut app = app::App::new(opened, options);
    let ended = events.run_app(&mut app);
    if let Some(error) = app.error {
        return Err(error);
    }
    ended.map_err(|source| Error::Invalid(format!("the window's events ended: {source}")))
}
