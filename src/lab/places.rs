//! Where controls lie in the window, for tests that move a real pointer: `myxo lab --places FILE` keeps a file of them.

use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use egui::{Id, Rect, Response};
use myxo::whole_file::WholeFile;
use serde::Serialize;

/// What has been named in a frame.
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
    /// Gives the control a name, where names are asked for.
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

/// Gives the cross a name that closes a floating window with a title; egui does not tell where it lies.
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

/// Tells what a control holds, where names are asked for.
pub fn note_value(ctx: &egui::Context, name: &str, value: impl FnOnce() -> String) {
    if let Some(found) = ctx.data(|data| data.get_temp::<Found>(id())) {
        let mut found = found.lock().unwrap_or_else(PoisonError::into_inner);
        found.values.insert(name.to_owned(), value());
    }
}

/// What a frame has shown.
#[derive(Debug, PartialEq, Serialize)]
struct Seen<S> {
    /// What the lab is doing.
    state: S,
    /// Left, top, right and bottom of each control, in pixels of the window.
    places: BTreeMap<String, [f32; 4]>,
    /// What is held by those that hold something.
    values: BTreeMap<String, String>,
}

/// A file that tells where everything is.
pub struct Places {
    file: PathBuf,
    found: Found,
    /// What it says.
    last: String,
}

impl Places {
    /// Begins to look for names.
    pub fn new(file: &Path, ctx: &egui::Context) -> Self {
        let found = Found::default();
        ctx.data_mut(|data| data.insert_temp(id(), Arc::clone(&found)));
        Self {
            file: file.to_owned(),
            found,
            last: String::new(),
        }
    }

    /// What the frame has named was not shown.
    pub fn forget(&mut self) {
        let mut found = self.found.lock().unwrap_or_else(PoisonError::into_inner);
        *found = Named::default();
    }

    /// Writes what the frame has shown, if anything is elsewhere or otherwise than before.
    pub fn write(&mut self, state: impl Serialize, pixels_per_point: f32) -> std::io::Result<()> {
        let mut found = self.found.lock().unwrap_or_else(PoisonError::into_inner);
        let pixels = |(name, rect): (String, Rect)| {
            let ends = [rect.left(), rect.top(), rect.right(), rect.bottom()];
            (name, ends.map(|end| end * pixels_per_point))
        };
        let Named { places, values } = std::mem::take(&mut *found);
        let places = places.into_iter().map(pixels).collect();
        let seen = Seen {
            state,
            places,
            values,
        };
        let text = serde_json::to_string(&seen)?;
        if text != self.last {
            let mut file = WholeFile::create(&self.file)?;
            file.write_all(text.as_bytes())?;
            file.finish()?;
            self.last = text;
        }
        Ok(())
    }
}
