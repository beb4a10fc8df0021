//! Lines that are shown over the picture for a while: what has happened, and what went wrong.

use super::interface::Interface;

/// A line that stays for a while.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Notice {
    pub(super) text: String,
    pub(super) is_error: bool,
    pub(super) until: f64,
    /// Its first lines, which stay above others until then.
    first: Option<(String, f64)>,
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
        let now = ctx.input(|i| i.time);
        let mut until = now + seconds_for(&text, is_error);
        let first = self.notice.take().and_then(|notice| notice.first);
        let first = first.filter(|(_, until)| now <= *until);
        if let Some((first, first_until)) = &first {
            text = format!("{first}\n{text}");
            is_error = true;
            until = until.max(*first_until);
        }
        self.notice = Some(Notice {
            text,
            is_error,
            until,
            first,
        });
    }

    /// Shows what is to be read whatever else there is to be said: lines that come meanwhile stand below it.
    pub fn first_notice(&mut self, ctx: &egui::Context, text: impl Into<String>) {
        let text = text.into();
        let until = ctx.input(|i| i.time) + seconds_for(&text, true);
        self.notice = Some(Notice {
            first: Some((text.clone(), until)),
            text,
            is_error: true,
            until,
        });
    }
}

/// How long a line is shown.
fn seconds_for(text: &str, is_error: bool) -> f64 {
    let seconds = 3.0 + 0.05 * text.len() as f64;
    if is_error { 3.0 * seconds } else { seconds }
}
