//! Exports under way when the window closes: all that can be are finished, and the terminal shows the outcome of each.

use std::path::Path;
use std::time::{Duration, Instant};

use myxo::plain_text::Shown as _;
use myxo::render::output::{OutputError, Written};
use myxo::{Error, Result};

use crate::console;
use crate::lab::command::{Command, ExportRequest, ToolRequest};
use crate::lab::export::Exports;
use crate::lab::export::making::Export;
use crate::lab::loading::Origin;
use crate::lab::saving::whole;
use crate::lab::waiting::Waiting;
use crate::lab::window::Lab;

/// A window that closes waits no longer for a picture to be drawn.
const LAST_PICTURE: Duration = Duration::from_secs(10);

/// A second request to leave within this time is a double press, made before the notice of what is being finished could be
/// read.
const ASKED_TWICE: Duration = Duration::from_secs(1);

impl Lab {
    /// The user asks to leave. Returns true if the window may close at once. If not, it continues until the files under way are
    /// whole; a further request gives up all that is not being recorded.
    pub(in super::super) fn ask_to_close(&mut self) -> bool {
        match self.jobs.exports.ends {
            Some(since) if since.elapsed() < ASKED_TWICE => return self.has_closed(),
            Some(_) => {
                if let Some(job) = &mut self.jobs.exports.job {
                    job.cancel();
                }
                self.jobs.exports.gives_up = true;
            }
            None => {
                self.closing = true;
                self.begin_to_end();
                // The user cannot see its progress, and hidden windows may not be drawn any more.
                self.jobs.exports.gives_up |= self.is_hidden();
            }
        }
        self.has_closed()
    }

    fn is_hidden(&self) -> bool {
        self.host.is_hidden() || self.host.size().contains(&0)
    }

    /// Has the user asked to leave, and does nothing hold the window any more?
    pub(in super::super) fn has_closed(&self) -> bool {
        self.closing && (self.jobs.exports.gives_up || !self.jobs.exports.is_busy())
    }

    /// From now on the window only finishes what is being made: recordings and films have the pictures that they have.
    pub(in super::super) fn begin_to_end(&mut self) {
        if self.jobs.exports.ends.is_some() {
            return;
        }
        self.jobs.exports.ends = Some(Instant::now());
        if let Some(recording) = &mut self.jobs.exports.recording {
            say(&finishing(recording.path()));
            if !recording.is_ending() {
                // If this fails, the next frame reports it.
                let _ = self.runner.frames.wait_idle();
                recording.stop();
            }
        }
        if let Some(job) = &mut self.jobs.exports.job {
            say(&finishing(job.path()));
            if let Export::Film(film) = job {
                film.stop();
            }
        }
    }

    /// The window closes: recordings, films and files being written become whole files, and so does a picture that does not
    /// take long. The terminal shows the outcome of each.
    pub(in super::super) fn end_exports(&mut self) {
        self.jobs.exports.end_recording();
        self.finish_job();
    }

    /// The window closes while commands wait for steps: those that write files are obeyed, in their order. The terminal names
    /// the others, which are dropped.
    pub(in super::super) fn obey_what_writes(&mut self) {
        if let Some(text) = self.was_on_its_way() {
            say(&text);
        }
        let left = std::mem::take(&mut self.waiting);
        let left: Vec<_> = (left.into_iter().map(|left| (end_of(&left), left))).collect();
        let any_writes = (left.iter()).any(|(end, _)| *end == AtTheEnd::Writes);
        if any_writes && self.runner.is_within_slices() {
            say("finishing the steps that are under way ...");
            if let Err(error) = self.finish_steps() {
                say(&error.to_string());
            }
        }
        for (end, left) in left {
            match end {
                AtTheEnd::GivenUp(text) => {
                    say(&text);
                    continue;
                }
                AtTheEnd::Forgotten => continue,
                AtTheEnd::Helps if !any_writes => continue,
                AtTheEnd::Helps => {}
                // One thing at a time.
                AtTheEnd::Writes => self.finish_job(),
            }
            let Waiting::Command(command, size) = left else {
                continue;
            };
            self.interface.notices = Default::default();
            if let Err(error) = self.obey(command, size) {
                say(&error.to_string());
            }
            if let Some(text) = self.interface.notices.text() {
                say(&text);
            }
        }
    }

    /// Messages on all waiting requests, for an end at which none is obeyed.
    pub(in super::super) fn what_does_not_come(&self) -> Vec<String> {
        let waits = self.waiting.iter().filter_map(|left| match end_of(left) {
            AtTheEnd::GivenUp(text) => Some(text),
            _ => None,
        });
        self.was_on_its_way().into_iter().chain(waits).collect()
    }

    /// The message on a scene on its way, or on an object that was to come or to go.
    fn was_on_its_way(&self) -> Option<String> {
        let coming = self.edits.coming.as_ref();
        let coming = coming.map(|coming| coming.what.clone());
        let loading = self.jobs.loading.as_ref();
        // Before there is a scene, nothing but the first one can be.
        let loading = loading.filter(|loading| {
            let is_other = loading.origin != Origin::Shown;
            self.runner.scene().is_some() && is_other && !loading.is_cancelled()
        });
        let what = coming.or_else(|| loading.map(|loading| loading.name.clone()));
        let what = what.filter(|_| self.jobs.loading.is_some())?;
        Some(format!("{what} was on its way, and was given up"))
    }

    fn finish_job(&mut self) {
        let Some(job) = &self.jobs.exports.job else {
            return;
        };
        if self.jobs.exports.ends.is_none() {
            say(&finishing(job.path()));
        }
        let ready = self.make_ready();
        let saves = match &mut self.jobs.exports.job {
            Some(Export::File(export)) => export.saves.take(),
            _ => None,
        };
        let is_whole = self.jobs.exports.end_job(ready);
        if saves.is_some() && is_whole {
            self.interface.document.saved(saves);
        }
    }

    /// Does what needs the device.
    fn make_ready(&mut self) -> Result<()> {
        let needs_state = |job: &Export| match job {
            Export::File(export) => export.is_asked(),
            job => job.draws(),
        };
        if self.jobs.exports.job.as_ref().is_some_and(needs_state) {
            let mut rec = self.runner.frames.begin()?;
            // Earlier painting is part of it.
            self.record_tools(&mut rec)?;
            self.record_asked(&mut rec)?;
            self.runner.frames.submit(rec)?;
            self.runner.frames.wait_idle()?;
        }
        let (Some(job), Some(stage)) = (&mut self.jobs.exports.job, &mut self.runner.stage) else {
            return Ok(());
        };
        let begun = Instant::now();
        while job.draws() && begun.elapsed() < LAST_PICTURE {
            job.advance(&mut self.runner.frames, stage, false)?;
        }
        Ok(())
    }
}

impl Exports {
    /// Ends without a device, which [`Exports::leave_device`] has left: waits for what is being written.
    pub fn close(mut self) {
        self.end_recording();
        if let Some(job) = &self.job {
            say(&finishing(job.path()));
            self.end_job(Ok(()));
        }
    }

    fn end_recording(&mut self) {
        let Some(mut recording) = self.recording.take() else {
            return;
        };
        if !recording.is_ending() {
            recording.stop();
        }
        let path = recording.path().to_owned();
        if self.ends.is_none() {
            say(&finishing(&path));
        }
        let remarks = recording.facts().remarks();
        if let Some(ended) = recording.wait() {
            say(&outcome_of_recording(&path, &ended, &remarks));
        }
    }

    /// Waits for the export, if the device has done its part. Returns true if the file is whole.
    fn end_job(&mut self, ready: Result<()>) -> bool {
        let Some(job) = self.job.take() else {
            return false;
        };
        let (path, is_cancelled) = (job.path().to_owned(), job.is_cancelled());
        let nothing = || {
            Ok(Written {
                files: Vec::new(),
                frames: 0,
            })
        };
        let ended = match ready {
            Ok(()) => job.close(),
            Err(error) => Some(Err(error)),
        };
        let is_whole = ended.as_ref().is_some_and(Result::is_ok);
        say(&outcome_of(
            &path,
            &ended.unwrap_or_else(nothing),
            is_cancelled,
        ));
        is_whole
    }
}

/// The outcome of a waiting request when the window closes.
#[derive(Clone, Debug, PartialEq, Eq)]
enum AtTheEnd {
    /// It writes a file, and is obeyed.
    Writes,
    /// It changes what is written after it.
    Helps,
    /// There is no time for it; this is the message.
    GivenUp(String),
    /// It means nothing without a window.
    Forgotten,
}

fn end_of(waiting: &Waiting) -> AtTheEnd {
    match waiting {
        Waiting::Command(command, _) => at_the_end(command),
        Waiting::File(path) => not_opened(path),
        Waiting::Copy(object, _) => AtTheEnd::GivenUp(format!(
            "{} was not duplicated: the window closed before its turn",
            object.name
        )),
        Waiting::Removal(object) => AtTheEnd::GivenUp(format!(
            "{} was not taken out of the scene: the window closed before its turn",
            object.name
        )),
    }
}

fn not_opened(path: &Path) -> AtTheEnd {
    let path = path.shown();
    AtTheEnd::GivenUp(format!(
        "{path} was not opened: the window closed before its turn"
    ))
}

fn at_the_end(command: &Command) -> AtTheEnd {
    let given_up = |text: &str| AtTheEnd::GivenUp(text.to_owned());
    match command {
        Command::TakeFile(path) => not_opened(path),
        Command::Open(name) | Command::OpenWithLook(name) => not_opened(Path::new(name)),
        Command::OpenKept(left) => not_opened(Path::new(&left.name)),
        Command::Tool(ToolRequest::Remove(_)) => {
            given_up("an object was not taken out of the scene: the window closed before its turn")
        }
        Command::Tool(ToolRequest::Duplicate(..)) => {
            given_up("an object was not duplicated: the window closed before its turn")
        }
        Command::Tool(ToolRequest::Add(mesh, _)) => AtTheEnd::GivenUp(format!(
            "{mesh} was not added to the scene: the window closed before its turn"
        )),
        Command::OpenAlone(path) => not_opened(path),
        Command::Screenshot
        | Command::SaveTimes
        | Command::Save
        | Command::SaveAs(_)
        | Command::SavePreset(_)
        | Command::RemovePreset(_)
        | Command::Export(ExportRequest::Export(_)) => AtTheEnd::Writes,
        // Undo changes the result of the strokes before it.
        Command::Apply
        | Command::Export(ExportRequest::Cancel | ExportRequest::Finish)
        | Command::Tool(
            ToolRequest::Stroke { .. }
            | ToolRequest::EndStroke
            | ToolRequest::ToStroke(_)
            | ToolRequest::Undo { .. },
        ) => AtTheEnd::Helps,
        Command::Export(ExportRequest::Film) => {
            given_up("a film was given up: the window closed before it began")
        }
        Command::Export(ExportRequest::Record) => {
            given_up("a recording was given up: the window closed before it began")
        }
        _ => AtTheEnd::Forgotten,
    }
}

/// A line on the terminal.
pub(in super::super) fn say(text: &str) {
    console::message(text);
}

/// The message before the wait for a file.
fn finishing(path: &Path) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str());
    format!("finishing {} ...", Path::new(name).shown())
}

/// The outcome of a recording, in a line.
pub(super) fn outcome_of_recording(path: &Path, ended: &Result<Written>, remarks: &str) -> String {
    let is_whole = matches!(ended, Ok(written) if !written.files.is_empty());
    let text = outcome_of(path, ended, false);
    if is_whole { text + remarks } else { text }
}

/// The written files with absolute paths.
pub(super) fn found_again(written: &Written) -> Written {
    Written {
        files: written.files.iter().map(|file| whole(file)).collect(),
        ..*written
    }
}

/// The outcome of a file, in a line.
pub(super) fn outcome_of(path: &Path, ended: &Result<Written>, is_cancelled: bool) -> String {
    let path = whole(path);
    match ended {
        Ok(written) if !written.files.is_empty() => format!("saved {}", found_again(written)),
        Err(error @ Error::Output(OutputError::Cut { .. })) => {
            format!("{} ends early: {error}", path.shown())
        }
        Err(error) if !is_cancelled => format!("{} was given up: {error}", path.shown()),
        _ => format!("{} was given up", path.shown()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lab::command::Model;
    use crate::lab::command::{Ticket, Which};
    use crate::lab::kept_scenes::KeptScene;
    use glam::Vec2;
    use myxo::scene::settings::ObjectSettings;
    use myxo::sim::paint::Brush;
    use std::time::SystemTime;

    #[test]
    fn commands_that_write_are_obeyed_at_the_end() {
        let export = Command::Export(ExportRequest::Export(Model::Glb));
        let named = Command::SaveAs("fern.toml".into());
        let times = Command::SaveTimes;
        for command in [Command::Screenshot, Command::Save, times, named, export] {
            assert_eq!(at_the_end(&command), AtTheEnd::Writes, "{command:?}");
        }
        let stroke = ToolRequest::Stroke {
            from: Vec2::ZERO,
            to: Vec2::ONE,
            brush: Brush::NoGo,
            radius: 0.1,
        };
        let undo = ToolRequest::Undo { again: false };
        let strokes = [
            stroke,
            ToolRequest::EndStroke,
            ToolRequest::ToStroke(0),
            undo,
        ]
        .map(Command::Tool);
        for command in [Command::Apply].into_iter().chain(strokes) {
            assert_eq!(at_the_end(&command), AtTheEnd::Helps, "{command:?}");
        }
        for out in [ExportRequest::Film, ExportRequest::Record] {
            let end = at_the_end(&Command::Export(out));
            assert!(matches!(end, AtTheEnd::GivenUp(_)), "{end:?}");
        }
        assert_eq!(at_the_end(&Command::Restart), AtTheEnd::Forgotten);
        let object = Box::new(ObjectSettings {
            name: "ball".to_owned(),
            ..ObjectSettings::default()
        });
        let (which, ticket) = (Which::Object(0), Ticket::default());
        let add = Command::Tool(ToolRequest::Add("builtin:cube".to_owned(), ticket));
        let duplicate = Command::Tool(ToolRequest::Duplicate(which, ticket));
        let remove = Command::Tool(ToolRequest::Remove(which));
        let as_left = Command::OpenKept(KeptScene {
            name: "knot".to_owned(),
            file: "left/knot_000001.toml".into(),
            since: SystemTime::UNIX_EPOCH,
        });
        for (left, wanted) in [
            (
                Waiting::File("a/tip.obj".into()),
                "a/tip.obj was not opened",
            ),
            (
                Waiting::Command(Command::TakeFile("b.toml".into()), [1, 1]),
                "b.toml was not opened",
            ),
            (Waiting::Command(add, [1, 1]), "builtin:cube was not added"),
            (
                Waiting::Command(duplicate, [1, 1]),
                "an object was not duplicated",
            ),
            (
                Waiting::Command(remove, [1, 1]),
                "an object was not taken out",
            ),
            (
                Waiting::Command(Command::Open("torus"), [1, 1]),
                "torus was not opened",
            ),
            (
                Waiting::Command(Command::OpenWithLook("torus"), [1, 1]),
                "torus was not opened",
            ),
            (Waiting::Command(as_left, [1, 1]), "knot was not opened"),
            (
                Waiting::Copy(object.clone(), ticket),
                "ball was not duplicated",
            ),
            (
                Waiting::Removal(object),
                "ball was not taken out of the scene",
            ),
        ] {
            let AtTheEnd::GivenUp(text) = end_of(&left) else {
                panic!("{wanted}")
            };
            assert!(text.starts_with(wanted), "{text}");
        }
        let text = finishing(Path::new("films/film_000001.gif"));
        assert_eq!(text, "finishing film_000001.gif ...");
    }

    #[test]
    fn each_outcome_names_the_path_of_its_file() {
        let folder = std::env::current_dir().expect("there is one");
        let path = Path::new("film_000001.gif");
        let whole = folder.join(path).display().to_string();
        let written = |files: &[&Path]| {
            let files = files.iter().map(|file| file.to_path_buf()).collect();
            Ok(Written { files, frames: 2 })
        };
        let failed = || Err(Error::Invalid("no room".to_owned()));
        let cut = || {
            let kept = Written {
                files: vec![path.to_path_buf()],
                frames: 2,
            };
            let source = Box::new(OutputError::FrameRate(0.0));
            Err(Error::Output(OutputError::Cut { source, kept }))
        };
        for (ended, is_cancelled, wanted) in [
            (cut(), false, format!("{whole} ends early: ")),
            (written(&[path]), false, format!("saved {whole} (2 frames")),
            (written(&[path]), true, format!("saved {whole} (2 frames")),
            (written(&[]), true, format!("{whole} was given up")),
            (failed(), false, format!("{whole} was given up: no room")),
            (failed(), true, format!("{whole} was given up")),
        ] {
            let text = outcome_of(path, &ended, is_cancelled);
            assert!(text.starts_with(&wanted), "{text}, not {wanted}");
            assert!(!is_cancelled || !text.contains("no room"), "{text}");
        }
    }
}
