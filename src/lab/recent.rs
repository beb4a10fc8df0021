//! Scene files that were opened or saved last.

use std::path::{Path, PathBuf};

use egui::{RichText, Ui, vec2};
use serde::{Deserialize, Serialize};

use crate::lab::places::Marked as _;
use crate::lab::theme;

/// How many of them are remembered.
const MOST: usize = 8;

/// The last one first.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Recent(Vec<PathBuf>);

impl Recent {
    /// A file was opened or saved. One whose name is no text is not remembered: it could not be written down.
    pub fn note(&mut self, file: &Path) {
        if file.to_str().is_none() {
            return;
        }
        self.0.retain(|other| other != file);
        self.0.insert(0, file.to_owned());
        self.0.truncate(MOST);
    }

    /// Files that another window has kept since this one opened come after those that are new in this one.
    pub fn over(&self, opened: &Self, kept: &Self) -> Self {
        if self == opened {
            return kept.clone();
        }
        // The rest is in the order in which it was.
        let is_old = |rest: &[PathBuf]| {
            let mut before = opened.0.iter();
            rest.iter().all(|file| before.any(|other| other == file))
        };
        let new = (0..)
            .find(|&new| is_old(&self.0[new..]))
            .unwrap_or_default();
        let mut all = kept.clone();
        (self.0[..new].iter().rev()).for_each(|file| all.note(file));
        all
    }

    /// Shows the list; returns the file that was clicked.
    pub fn list(&self, ui: &mut Ui) -> Option<PathBuf> {
        let mut clicked = None;
        for (i, file) in self.0.iter().enumerate() {
            let name = file.file_name().unwrap_or(file.as_os_str());
            let entry = egui::Button::new(name.to_string_lossy())
                .truncate()
                .min_size(vec2(ui.available_width(), 0.0));
            let entry = ui.add(entry).on_hover_text(file.display().to_string());
            if entry.marked(&format!("recent={i}")).clicked() {
                clicked = Some(file.clone());
            }
        }
        if self.0.is_empty() {
            let text = RichText::new("Scene files that you open or save are listed here.");
            ui.label(text.small().color(theme::weak(ui)));
        }
        clicked
    }
}

/// A struct with these fields, each as it is now if it was changed since this window opened, and otherwise the kept one; further fields
/// follow as in other structs.
macro_rules! merged {
    ($now:ident, $opened:ident, $kept:ident: [$($field:ident),*] $($others:tt)*) => {
        Self {
            $($field: if $now.$field == $opened.$field { &$kept.$field } else { &$now.$field }.clone(),)*
            $($others)*
        }
    };
}
pub(super) use merged;

#[cfg(test)]
mod tests {
    use super::*;

    fn of(names: &[&str]) -> Recent {
        Recent(names.iter().map(PathBuf::from).collect())
    }

    #[test]
    fn the_last_comes_first_and_two_windows_keep_both_of_theirs() {
        let mut recent = Recent::default();
        for name in ["a", "b", "a", "c"] {
            recent.note(Path::new(name));
        }
        assert_eq!(recent, of(&["c", "a", "b"]));
        (0..20).for_each(|i| recent.note(Path::new(&i.to_string())));
        assert_eq!(recent.0.len(), MOST);
        assert_eq!(recent.0[0], Path::new("19"));

        let opened = of(&["a", "b"]);
        let kept = of(&["x", "a", "b"]);
        assert_eq!(opened.over(&opened, &kept), kept);
        let here = of(&["d", "c", "a", "b"]);
        assert_eq!(here.over(&opened, &kept), of(&["d", "c", "x", "a", "b"]));
        // A file that was there before is the latest now.
        let again = of(&["b", "a"]);
        assert_eq!(again.over(&opened, &kept), of(&["b", "x", "a"]));
        let both = of(&["a", "d", "b"]);
        assert_eq!(both.over(&opened, &kept), of(&["a", "d", "x", "b"]));
        assert_eq!(here.over(&Recent::default(), &Recent::default()), here);
    }
}
