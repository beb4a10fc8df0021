//! Places of controls in the window, for tests that move a real pointer: `myxo lab --places FILE` keeps a file of them.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use egui::{Id, Rect, Response};
use myxo::whole_file::write_whole;
use serde::Serialize;

/// Places and values that were named in a frame.
#[derive(Default)]
struct Named {
    places: BTreeMap<String, Rect>,
    values: BTreeMap<String, String>,
}

type Found = Arc<Mutex<Named>>;

fn id() -> Id {
    Id::new("places")
}

/// Controls that can be found by a name.
pub trait Marked {
    /// Gives the control a name, if names are asked for.
    fn marked(self, name: &str) -> Self;
}

impl Marked for Response {
    fn marked(self, name: &str) -> Self {
        if let Some(found) = self.ctx.data(|data| data.get_temp::<Found>(id()))
            && self.interact_rect.is_positive()
        {
            let mut found = found.lock().unwrap_or_else(PoisonError::into_inner);
            found.places.insert(name.to_owned(), self.interact_rect);
        }
        self
    }
}

/// Are names asked for? Then it may cost something to find them.
pub fn are_asked_for(ctx: &egui::Context) -> bool {
    ctx.data(|data| data.get_temp::<Found>(id())).is_some()
}

/// Names the cross that closes a floating window with a title; egui does not give its position.
pub fn mark_cross<R>(shown: Option<egui::InnerResponse<R>>, name: &str) {
    const SIDE: f32 = 18.0;
    const MARGIN: f32 = 7.0;
    if let Some(shown) = shown {
        let corner = shown.response.rect.right_top() + egui::vec2(-MARGIN, MARGIN);
        let mut cross = shown.response;
        cross.interact_rect = Rect::from_two_pos(corner, corner + egui::vec2(-SIDE, SIDE));
        cross.marked(name);
    }
}

/// Notes the value of a control, if names are asked for.
pub fn note_value(ctx: &egui::Context, name: &str, value: impl FnOnce() -> String) {
    if let Some(found) = ctx.data(|data| data.get_temp::<Found>(id())) {
        let mut found = found.lock().unwrap_or_else(PoisonError::into_inner);
        found.values.insert(name.to_owned(), value());
    }
}

/// The report of a frame.
#[derive(Debug, PartialEq, Serialize)]
struct Seen<S> {
    /// No frame is due for a while, unless something comes in. First, for `stir` to find it.
    rests: bool,
    /// The number of frames that were reported so far.
    frames: u64,
    /// The state of the lab.
    state: S,
    /// Left, top, right and bottom of each control, in pixels of the window.
    places: BTreeMap<String, [f32; 4]>,
    /// Values of the controls that have one.
    values: BTreeMap<String, String>,
}

/// Reports where everything is, in a file if there is one.
pub struct Places {
    /// Without a file the report is in [`Places::last`] only.
    file: Option<PathBuf>,
    found: Found,
    /// The last report.
    last: String,
    frames: u64,
}

/// The beginnings of the file for a window at rest, and for one that may change.
const RESTS: &str = "{\"rests\":true";
const STIRS: &str = "{\"rests\":false";

impl Places {
    /// Begins to look for names.
    pub fn new(file: Option<PathBuf>, ctx: &egui::Context) -> Self {
        let found = Found::default();
        ctx.data_mut(|data| data.insert_temp(id(), Arc::clone(&found)));
        Self {
            file,
            found,
            last: String::new(),
            frames: 0,
        }
    }

    /// A frame begins, or will: what the file says may not be true for long. Has it said that all rests?
    pub fn stir(&mut self) -> std::io::Result<bool> {
        let Some(rest) = self.last.strip_prefix(RESTS) else {
            return Ok(false);
        };
        self.put([STIRS, rest].concat())?;
        Ok(true)
    }

    fn put(&mut self, text: String) -> std::io::Result<()> {
        if let Some(file) = &self.file {
            write_whole(file, &text)?;
        }
        self.last = text;
        Ok(())
    }

    /// The last report, and the number of frames that were reported.
    pub fn last(&self) -> (&str, u64) {
        (&self.last, self.frames)
    }

    /// Discards the names of a frame that was not shown.
    pub fn forget(&mut self) {
        let mut found = self.found.lock().unwrap_or_else(PoisonError::into_inner);
        *found = Named::default();
    }

    /// Writes what the frame has shown. If it `rests`, nothing changes without input.
    pub fn write(
        &mut self,
        state: impl Serialize,
        pixels_per_point: f32,
        rests: bool,
    ) -> std::io::Result<()> {
        let mut found = self.found.lock().unwrap_or_else(PoisonError::into_inner);
        let Named { places, values } = std::mem::take(&mut *found);
        drop(found);
        let pixels = |(name, rect): (String, Rect)| {
            let ends = [rect.left(), rect.top(), rect.right(), rect.bottom()];
            (name, ends.map(|end| end * pixels_per_point))
        };
        self.frames += 1;
        let seen = Seen {
            rests,
            frames: self.frames,
            state,
            places: places.into_iter().map(pixels).collect(),
            values,
        };
        self.put(serde_json::to_string(&seen)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::Value;

    #[test]
    fn a_report_at_rest_stirs_and_keeps_the_rest() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("places.json");
        let read = || -> Value { serde_json::from_slice(&std::fs::read(&file).unwrap()).unwrap() };
        let mut places = Places::new(Some(file.clone()), &egui::Context::default());
        assert!(!places.stir().unwrap(), "nothing is reported yet");
        places.write("a state", 1.0, true).unwrap();
        let mut report = read();
        assert_eq!(
            (&report["rests"], &report["frames"]),
            (&true.into(), &1.into())
        );
        assert_eq!(report["state"], "a state");
        assert!(places.stir().unwrap());
        report["rests"] = false.into();
        assert_eq!(read(), report);
        assert!(!places.stir().unwrap(), "once");
        places.write("a state", 1.0, false).unwrap();
        assert!(!places.stir().unwrap(), "it did not rest");
        assert_eq!(read()["frames"], 2);
    }
}
