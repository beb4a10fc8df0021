//! The lab: a window in which slime mold grows, with every parameter beside it.

mod actions;
mod ahead;
mod answers;
mod app;
mod autopilot;
mod axes;
mod back;
mod back_button;
mod checks;
mod clocks;
mod command;
mod desk;
mod document;
mod easing;
mod edits;
mod export;
mod export_panel;
mod facts;
mod feeding;
mod fitting;
mod flying;
mod foods;
mod gallery;
mod history;
mod host;
mod interface;
mod job;
mod jobs;
mod kept_scenes;
#[cfg(test)]
mod key_list;
mod layout;
mod lines;
mod loading;
mod looks;
mod lost;
mod marks;
mod names;
mod navigation;
mod network_overlay;
mod networks;
mod notices;
mod objects;
mod observed;
#[cfg(test)]
mod on_device;
mod opening;
mod options;
mod order;
mod outliner;
mod overlays;
mod pacing;
mod panel;

mod place;
mod places;
mod plot;
mod preferences;
mod presets;
mod preview;
mod previewing;
mod profiling;
mod recent;
mod renewal;
mod rows;
mod runner;
mod saving;
mod screen;
mod show;

mod spin;
mod stage;
mod state_copy;
mod strip;
mod strokes;
mod theme;
mod throws;
mod timeline;
mod tools;
mod undo;
mod view_rows;
mod views;
mod waiting;
#[cfg(target_os = "linux")]
mod wayland;
mod wheel;
mod widgets;
mod window;
mod windowless;

use myxo::{Error, Result};
use winit::event_loop::EventLoop;

pub use loading::Opened;
pub use options::LabOptions;
pub use preferences::Preferences;
pub use saving::{SceneFile, kept_name};

/// Opens the window and runs until it is closed. `listen` is given what closes it from any thread, as the user would.
pub fn run(
    opened: Opened,
    options: LabOptions,
    listen: impl FnOnce(Box<dyn Fn() + Send>) -> Result<()>,
) -> Result<()> {
    if options.windowless {
        return lines::run(opened, options, listen);
    }
    let mut builder = EventLoop::<app::Close>::with_user_event();
    #[cfg(target_os = "linux")]
    wayland::choose(&mut builder);
    let events = builder.build().map_err(|source| host::no_window(&source))?;
    let proxy = events.create_proxy();
    // If the loop has ended, there is nothing left to close.
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
