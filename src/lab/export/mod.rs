//! Taking out: pictures of any size, recordings of the window, films at a fixed step, models and data; all beside what
//! runs.

mod encoder;
pub mod making;
pub mod recording;
pub mod shot;
pub mod times;

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use glam::Vec2;
use myxo::render::View;
use myxo::render::output::Written;
use myxo::scene::settings::Settings;
use myxo::{Error, Result};

use crate::lab::document::put_look;
use crate::lab::facts::ExportFacts;
use crate::lab::stage::Stage;
use making::Export;
use recording::Recording;
pub use shot::{Care, Shot};

/// The largest picture of a film, pixels a side.
pub const LARGEST_FILM: u32 = 4096;

/// Recordings and exports under way.
#[derive(Default)]
pub struct Exports {
    pub recording: Option<Recording>,
    pub job: Option<Export>,
    /// Since when all of it is only finished, because the window is to close then.
    pub ends: Option<Instant>,
    /// The window waits for none of it.
    pub gives_up: bool,
    /// Becomes true with Ctrl-C.
    pub interrupt: Option<&'static AtomicBool>,
}

impl Exports {
    /// Nothing yet; `interrupt` becomes true with Ctrl-C.
    pub fn new(interrupt: &'static AtomicBool) -> Self {
        Self {
            interrupt: Some(interrupt),
            ..Self::default()
        }
    }

    /// For the interface.
    pub fn facts(&self) -> ExportFacts {
        ExportFacts {
            recording: self.recording.as_ref().map(Recording::facts),
            making: self.job.as_ref().map(Export::facts),
            filmed: self.job.as_ref().and_then(Export::filmed),
            ends: self.ends.is_some(),
        }
    }

    /// The export that has ended, and its outcome.
    pub fn take_export(&mut self) -> Option<(Export, Result<Written>)> {
        let written = self.job.as_mut()?.take()?;
        Some((self.job.take()?, written))
    }

    /// The recording that has ended, and its outcome.
    pub fn take_recording(&mut self) -> Option<(Recording, Result<Written>)> {
        let written = self.recording.as_mut()?.take()?;
        Some((self.recording.take()?, written))
    }

    /// Does the simulation stop, or step only when a film asks for it?
    pub fn holds(&self) -> bool {
        self.job.as_ref().is_some_and(Export::holds)
    }

    /// Is there work to do, or progress to show?
    pub fn is_busy(&self) -> bool {
        self.job.is_some() || self.recording.is_some()
    }

    /// Another scene comes, or another state: films end with what they have, pictures that are not drawn are given up, and exports that
    /// have no state yet.
    pub fn leave_stage(&mut self) {
        match &mut self.job {
            Some(Export::Film(film)) => film.stop(),
            Some(job @ Export::Picture(_)) if job.draws() => job.cancel(),
            Some(Export::File(export)) => {
                // The file holds what is left, so what comes must not count as saved.
                export.saves = None;
                if export.is_asked() {
                    export.cancel();
                }
            }
            _ => {}
        }
    }

    /// The device goes: a recording, too, ends with what it has. The rest is written without a device.
    pub fn leave_device(&mut self) {
        if let Some(recording) = &mut self.recording
            && !recording.is_ending()
        {
            recording.stop();
        }
        self.leave_stage();
    }
}

/// A folder as the user types it; `~` is the home folder, as in a shell.
pub fn typed_folder(text: &str, home: Option<&Path>) -> PathBuf {
    let text = Path::new(text.trim());
    match (text.strip_prefix("~"), home) {
        (Ok(below), Some(home)) => home.join(below),
        _ => text.to_owned(),
    }
}

/// The view for a picture of another size: it has all that the window shows, also where it is narrower, and points of particles
/// keep their share of it.
pub fn scaled(view: &View, from: [u32; 2], to: [u32; 2]) -> View {
    let mut view = *view;
    if from.contains(&0) || to.contains(&0) {
        return view;
    }
    let aspect = |[width, height]: [u32; 2]| width as f32 / height as f32;
    let narrower = (aspect(from) / aspect(to)).max(1.0);
    let fov = &mut view.camera.vertical_fov;
    *fov = 2.0 * (narrower * (0.5 * *fov).tan()).atan();
    // What the window shows is in the middle.
    let wider = narrower * aspect(to) / aspect(from);
    view.camera.shift /= Vec2::new(wider, narrower);
    view.particle_size *= to[1] as f32 / from[1] as f32 / narrower;
    view
}

pub fn check_size(size: [u32; 2], most: u32) -> Result<()> {
    if size.iter().all(|side| (1..=most).contains(side)) {
        return Ok(());
    }
    let [width, height] = size;
    Err(Error::Invalid(format!(
        "a picture of {width} x {height} cannot be made: each side must be 1 to {most}"
    )))
}

pub fn too_large([width, height]: [u32; 2], error: Error) -> Error {
    match error {
        error @ Error::Gpu(_) => Error::Invalid(format!(
            "there is no room for a picture of {width} x {height}: {error}: choose a smaller size"
        )),
        error => error,
    }
}

impl Stage {
    /// The settings that run, with a look.
    fn settings_as_seen(&self, view: &View) -> Settings {
        let mut settings = self.simulation.settings().clone();
        put_look(view, self.scene.center, &mut settings);
        settings
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;
    use myxo::scene::{Overrides, Scene};

    #[test]
    fn folders_are_typed_as_in_a_shell() {
        let home = Some(Path::new("/home/user"));
        for (typed, wanted) in [
            ("", ""),
            (" films ", "films"),
            ("~", "/home/user"),
            ("~/Pictures", "/home/user/Pictures"),
            ("~other/films", "~other/films"),
            ("/a/~/b", "/a/~/b"),
        ] {
            assert_eq!(typed_folder(typed, home), Path::new(wanted));
        }
        assert_eq!(typed_folder("~/films", None), Path::new("~/films"));
    }

    #[test]
    fn what_the_window_shows_is_in_pictures_of_any_shape() {
        let scene = Scene::load("cube".as_ref(), &Overrides::default()).unwrap();
        let from = [1104, 876];
        let mut view = View::of(&scene, Vec2::new(1104.0, 876.0));
        view.camera.shift = Vec2::new(-0.3, 0.2);
        // Lengths at a distance of 1: half of the picture's width and height, and of a pixel.
        let half = |view: &View, [width, height]: [u32; 2]| {
            let up = (0.5 * view.camera.vertical_fov).tan();
            let aspect = width as f32 / height as f32;
            [up * aspect, up, up / height as f32]
        };
        let [across, up, pixel] = half(&view, from);
        for to in [from, [2048, 2048], [1080, 1920], [3840, 2160], [1, 900]] {
            let other = scaled(&view, from, to);
            let [its_across, its_up, its_pixel] = half(&other, to);
            let seen = [its_across / across, its_up / up];
            assert!(seen.iter().all(|share| *share > 0.9999), "{to:?}: {seen:?}");
            assert!(seen.iter().any(|share| *share < 1.0001), "{to:?}: {seen:?}");
            // The target is as far beside the middle as in the window.
            let beside = view.camera.shift * Vec2::new(across, up);
            let its_beside = other.camera.shift * Vec2::new(its_across, its_up);
            assert!(
                beside.distance(its_beside) < 1e-5,
                "{to:?}: {its_beside}, not {beside}"
            );
            let size = other.particle_size * its_pixel / (view.particle_size * pixel);
            assert!((size - 1.0).abs() < 1e-3, "{to:?}: {size}");
        }
    }
}
