//! Recovery of the window from a lost device: the scene is kept, another device is opened, and the scene restarts on it.

use crate::lab::lost::*;
use crate::lab::names::unnumbered;
use crate::lab::options::LabOptions;
use crate::lab::runner::Runner;
use crate::lab::saving::{save_scene, whole};
use crate::lab::screen::Screen;
use crate::lab::window::closing::say;
use crate::lab::window::{Lab, log_messages};
use egui::TextureId;
use egui::epaint::{ImageDelta, TextureAtlas};
use myxo::gpu::{Context, GpuError};
use myxo::plain_text::Shown as _;
use myxo::{Error, Result};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Other threads release a lost device as soon as they check it; one that does not within this time has failed.
const RELEASED_WITHIN: Duration = Duration::from_secs(20);
/// Advice if a scene is too large for the device.
const ADVICE: &str = "if it happens again, take fewer particles or a smaller atlas";

impl Lab {
    /// Can the lab continue with another device after this error?
    pub fn can_change_device(&self, error: &Error) -> bool {
        self.runner.can_change_device(error)
    }

    /// The error that ended the lab, with what was kept: the scene's settings, because its state is lost with the device.
    pub fn rescue(&mut self, error: &Error) -> Error {
        let lacking = self.scene_text().map(|scene| scene.lacking());
        let kept = match self.keep_scene() {
            None => return Error::Invalid(error.to_string()),
            Some(Ok(path)) => format!(
                "the scene as it was set is kept in {}{}",
                path.shown(),
                lacking.unwrap_or_default()
            ),
            Some(Err(error)) => format!("the scene as it was set is not kept, either: {error}"),
        };
        let mut text = format!("{error}; what had grown is lost, {kept}");
        if is_loss(error) {
            text += &format!("; {ADVICE}");
        }
        Error::Invalid(text)
    }

    /// Keeps the scene as it is set in a file, once as long as nothing changes.
    fn keep_scene(&mut self) -> Option<Result<PathBuf>> {
        let scene = self.scene_text()?;
        let has_all = scene.has_all();
        let text = scene.text;
        let kept = self.runner.lost.as_ref().and_then(|lost| lost.kept.clone());
        if let Some((_, path)) = kept.filter(|(kept, path)| *kept == text && path.exists()) {
            return Some(Ok(path));
        }
        let saved = save_scene(
            &self.export_folder(),
            unnumbered(&self.interface.document.name),
            |file| Ok(self.scene_text_at(file)?.text),
        );
        let saved = saved.or_else(|error| Ok(self.keep_as_left().or(Err(error))?.0));
        Some(saved.map(|path| {
            if has_all {
                self.interface
                    .document
                    .saved(Some(self.interface.document.state_to_save()));
            }
            let path = whole(&path);
            self.runner.lost.get_or_insert_default().kept = Some((text, path.clone()));
            path
        }))
    }

    /// Gives up the lost device, opens another one, and restarts the scene on it. If there is none, everything is kept that can
    /// be, and the error says so.
    pub fn change_device(mut self, error: &Error, options: &LabOptions) -> Result<Self> {
        self.interface.document.end_morph();
        let ended = self.rescue(error);
        self.keep_preferences();
        let was_painted = self.has_painted();
        let was_on = self.runner.ctx.info().name.clone();
        let not_coming = self.what_does_not_come();
        self.leave_device();
        let Self {
            gui, front, runner, ..
        } = self;
        drop((gui, front));
        let (device, lost) = runner.end();
        let (messages, screen) = match end(device) {
            Ok(messages) => (messages, Screen::open(&self.host, options)),
            Err(held) => (Vec::new(), Err(held)),
        };
        let screen = match screen {
            Ok(screen) => screen,
            Err(refused) => {
                log_messages(&messages);
                for text in &not_coming {
                    say(text);
                }
                self.jobs.exports.close();
                return Err(Error::Invalid(format!(
                    "{ended}; no device takes its place: {refused}"
                )));
            }
        };
        let Screen {
            gui,
            front,
            mut frames,
            answers,
            format,
            ctx,
        } = screen;
        self.host
            .set_max_texture_side(ctx.info().max_image_side as usize);
        let clocks = self.clocks.on(&ctx, &mut frames);
        let mut runner = Runner::new(ctx, format, [frames, answers], options.validation);
        runner.lost = lost;
        let mut lab = Self {
            gui,
            front,
            runner,
            clocks,
            ..self
        };
        if was_painted {
            // What was painted is gone, and the file may have it.
            lab.interface.document.file = None;
        }
        lab.pass_on_messages(&messages);
        let kept = lab.runner.lost.as_ref().and_then(|lost| lost.kept.as_ref());
        let kept = kept.map(|(_, path)| path.as_path());
        let on = &lab.runner.ctx.info().name;
        let text = notice(error, was_painted, (*on != was_on).then_some(on), kept);
        lab.notify(text, true);
        if let (settings, Some(error)) = lab.settings_that_work() {
            lab.interface.document.edited = settings;
            let text =
                format!("What waited for a restart would not work, and is taken back: {error}");
            lab.notify(text, true);
        }
        lab.restart();
        Ok(lab)
    }

    /// Drops what is on the device but what the window itself is drawn with. Recordings and films end with what they have.
    fn leave_device(&mut self) {
        self.runner.leave_device();
        self.jobs.exports.leave_device();
        self.jobs.leave_device();
        // Measurements end when they look next, and their results are not waited for.
        self.jobs.food = Default::default();
        self.jobs.ahead = Default::default();
        self.edits.leave_device();
        self.clocks.facts.before = None;
        // One of them may be what the device was lost by.
        self.forget_states();
        self.report_messages();
        self.renew_textures();
    }

    /// The interface's textures go with the device: the next frame uploads the whole font texture, and small pictures are
    /// loaded again when they are shown.
    fn renew_textures(&mut self) {
        self.interface.gallery.forget_all_pictures();
        self.interface.strip.forget_pictures();
        let context = self.host.context();
        let letters = context.fonts(|fonts| fonts.image());
        let letters = ImageDelta::full(letters, TextureAtlas::texture_options());
        let textures = context.tex_manager();
        textures.write().set(TextureId::default(), letters);
    }
}

/// Ends a device of which the window has nothing any more, and gives what the validation layers have said last.
fn end(mut ctx: Arc<Context>) -> Result<Vec<String>> {
    let begun = Instant::now();
    loop {
        ctx = match ctx.end() {
            Ok(messages) => return Ok(messages),
            // A thread that exports is about to learn that its state does not come.
            Err(held) if begun.elapsed() < RELEASED_WITHIN => held,
            Err(_) => {
                return Err(Error::Invalid(format!(
                    "the one that was lost is still in use after {} s: start the program again",
                    RELEASED_WITHIN.as_secs()
                )));
            }
        };
        sleep(Duration::from_millis(2));
    }
}

/// The notice in the window.
fn notice(error: &Error, was_painted: bool, on: Option<&String>, kept: Option<&Path>) -> String {
    let why = match error {
        Error::Gpu(GpuError::DeviceLost { call, last }) => format!("{call}: {last}"),
        error => error.to_string(),
    };
    let painted = if was_painted { " and was painted" } else { "" };
    let on = on.map_or(String::new(), |name| format!(" on {name}"));
    let kept = kept.map_or(String::new(), |path| {
        format!(", which are kept in {}", path.shown())
    });
    format!(
        "The device was lost ({why}): what had grown{painted} is gone. The scene restarts{on} with all its \
         settings{kept}; {ADVICE}"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_window_says_what_was_lost_and_what_is_kept() {
        let error = Error::Gpu(GpuError::DeviceLost {
            call: "vkQueueSubmit",
            last: "the last kernel begun was `walk`, number 3 of 9 in its frame".to_owned(),
        });
        assert!(is_loss(&error) && !is_loss(&Error::Invalid(error.to_string())));
        let file = Path::new("/tmp/cube_000001.toml");
        assert_eq!(
            notice(&error, false, None, Some(file)),
            "The device was lost (vkQueueSubmit: the last kernel begun was `walk`, number 3 of 9 in its frame): what had \
             grown is gone. The scene restarts with all its settings, which are kept in /tmp/cube_000001.toml; \
             if it happens again, take fewer particles or a smaller atlas"
        );
        let other = "llvmpipe".to_owned();
        let text = notice(&error, true, Some(&other), None);
        let end = "what had grown and was painted is gone. The scene restarts on llvmpipe with all its settings";
        assert!(text.ends_with(&format!("{end}; {ADVICE}")), "{text}");
    }
}
