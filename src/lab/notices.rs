//! Lines that are shown over the picture for a while: what has happened, and what went wrong.

use super::interface::Interface;

/// A line that stays for a while.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Notice {
    pub(super) text: String,
    pub(super) is_error: bool,
    pub(super) until: f64,
}

impl Interface {
    /// Files are dropped: what is wrong with one stays before what is said of the next.
    pub fn begin_drop(&mut self) {
        if self.dropped.is_none() {
            self.dropped = Some(Vec::new());
        }
    }

    /// All that were dropped are there, or will never be.
    pub fn end_drop(&mut self) {
        self.dropped = None;
    }

    /// Shows a line for a while.
    pub fn notice(&mut self, ctx: &egui::Context, text: impl Into<String>, is_error: bool) {
        let mut text: String = text.into();
        let mut is_error = is_error;
        if let Some(errors) = &mut self.dropped {
            if is_error {
                if !errors.contains(&text) {
                    errors.push(text);
                }
                text = errors.join("\n");
            } else if !errors.is_empty() {
                text = format!("{}\n{text}", errors.join("\n"));
                is_error = true;
            }
        }
        let seconds = 3.0 + 0.05 * text.len() as f64;
        self.notice = Some(Notice {
            text,
            is_error,
            until: ctx.input(|i| i.time) + if is_error { 3.0 * seconds } else { seconds },
        });
    }
}
