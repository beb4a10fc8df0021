//! Preferences kept between sessions: the look of the interface, the size of the window, the recent files and the choices in
//! Export.

use std::path::{Path, PathBuf};

use myxo::plain_text::Shown as _;
use myxo::whole_file::write_whole;
use serde::{Deserialize, Serialize};

use crate::lab::export_panel::ExportPanel;
use crate::lab::layout::{PANEL_WIDTH, PANEL_WIDTHS};
use crate::lab::looks::{LONGEST_MORPH, MORPH_SECONDS};
use crate::lab::recent::{Recent, merged};

/// Kept in `lab.toml` in the user's folder for settings. Entries that are missing or unreadable have their defaults.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Preferences {
    /// A light interface; else a dark one.
    pub light: bool,
    /// Is the panel shown?
    pub panel: bool,
    /// Its width, points.
    pub panel_width: f32,
    /// How much larger everything is than the system asks for.
    pub zoom: f32,
    /// Size of the window, pixels.
    pub size: [u32; 2],
    /// Seconds that the change to another look takes.
    pub morph_seconds: f64,
    /// The camera goes on for a moment after a drag.
    pub glides: bool,
    /// The strip of kept states is unfolded.
    pub timeline: bool,
    /// Scene files that were opened or saved last.
    pub recent: Recent,
    /// The choices in Export.
    pub out: ExportPanel,
}

impl Default for Preferences {
    fn default() -> Self {
        Self {
            light: false,
            panel: true,
            panel_width: PANEL_WIDTH,
            zoom: 1.0,
            size: [1440, 900],
            morph_seconds: MORPH_SECONDS,
            glides: true,
            timeline: false,
            recent: Recent::default(),
            out: ExportPanel::default(),
        }
    }
}

impl Preferences {
    /// The path of the file; `None` if the user has no such folder.
    pub fn file() -> Option<PathBuf> {
        directories::ProjectDirs::from("", "", "myxo")
            .map(|dirs| dirs.config_dir().join("lab.toml"))
    }

    /// Reads a file. A broken one is reported in the log and not used.
    pub fn read(file: &Path) -> Self {
        let text = match std::fs::read_to_string(file) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Self::default(),
            Err(error) => {
                log::warn!("cannot read {}: {error}", file.shown());
                return Self::default();
            }
        };
        let warn = |what: &str, error: toml::de::Error| {
            let reason = error.message().lines().next().unwrap_or_default();
            log::warn!("{}: {what} is not used: {reason}", file.shown());
        };
        let entries = match text.parse::<toml::Table>() {
            Ok(entries) => entries,
            Err(error) => {
                warn("it", error);
                return Self::default();
            }
        };
        // An error in one entry is no reason to drop the others.
        let of = |entries: toml::Table| entries.try_into::<Self>();
        let right = entries.into_iter().filter(|(key, value)| {
            let alone = of(std::iter::once((key.clone(), value.clone())).collect());
            alone.map_err(|error| warn(key, error)).is_ok()
        });
        of(right.collect()).unwrap_or_default().sane()
    }

    /// Writes a file, whole or not at all; of two windows that end at the same time, one prevails.
    pub fn write(&self, file: &Path) -> std::io::Result<()> {
        write_whole(file, toml::to_string(self).expect("plain values"))
    }

    /// The preferences that another window has kept since this one opened, except those that were changed in this one.
    pub fn over(&self, opened: &Self, kept: &Self) -> Self {
        merged! { self, opened, kept: [light, panel, panel_width, zoom, size, morph_seconds, glides, timeline]
            recent: self.recent.over(&opened.recent, &kept.recent),
            out: self.out.over(&opened.out, &kept.out),
        }
    }

    /// Replaces values with which the window could not be seen or read.
    fn sane(mut self) -> Self {
        if !(0.5..=4.0).contains(&self.zoom) {
            self.zoom = 1.0;
        }
        if !PANEL_WIDTHS.contains(self.panel_width) {
            self.panel_width = PANEL_WIDTH;
        }
        self.size = [
            self.size[0].clamp(480, 16_384),
            self.size[1].clamp(320, 16_384),
        ];
        if !(0.0..=LONGEST_MORPH).contains(&self.morph_seconds) {
            self.morph_seconds = MORPH_SECONDS;
        }
        self.out = self.out.kept();
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lab::export_panel::{Kind, Size};

    #[test]
    fn kept_preferences_come_back_and_nonsense_does_not() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("new/lab.toml");
        assert_eq!(Preferences::read(&file), Preferences::default());
        let mut recent = Recent::default();
        recent.note(Path::new("fern.toml"));
        let kept = Preferences {
            recent: recent.clone(),
            light: true,
            panel: false,
            panel_width: 400.0,
            zoom: 1.5,
            size: [800, 600],
            morph_seconds: 7.5,
            glides: false,
            timeline: true,
            out: ExportPanel {
                folder: "out".to_owned(),
                size: Size::Custom,
                kind: Kind::Gif,
                turns: -1.5,
                ..ExportPanel::default()
            },
        };
        kept.write(&file).unwrap();
        assert_eq!(Preferences::read(&file), kept);
        // Two windows that were open at once: each keeps what was changed in it.
        let opened = Preferences::default();
        let mut other = Preferences {
            light: false,
            zoom: 2.0,
            ..opened.clone()
        };
        other.out.every = 7;
        let both = other.over(&opened, &kept);
        assert_eq!((both.light, both.zoom, both.size), (true, 2.0, [800, 600]));
        let out = ExportPanel {
            every: 7,
            ..kept.out.clone()
        };
        assert_eq!((&both.out, &both.recent), (&out, &recent));
        let nonsense = "light = true\nzoom = 1e9\nsize = [1, 1]\nmorph_seconds = -3.0\n\
                        [out]\nseconds = nan\nevery = 0\nfps = 4000000000\ncustom = [0, 99999]\nkind = \"Gif\"\n";
        std::fs::write(&file, nonsense).unwrap();
        let read = Preferences::read(&file);
        assert!(read.light && read.panel && read.zoom == 1.0);
        assert_eq!(read.morph_seconds, MORPH_SECONDS);
        assert_eq!(read.size, [480, 320]);
        let wanted = ExportPanel {
            every: 1,
            fps: 60,
            custom: [16, 16_384],
            kind: Kind::Gif,
            ..ExportPanel::default()
        };
        assert_eq!(read.out, wanted);
        let half = "light = \"very\"\nzoom = 2.0\n[out]\nkind = \"Webm\"\n";
        std::fs::write(&file, half).unwrap();
        let rest = Preferences {
            zoom: 2.0,
            ..Preferences::default()
        };
        assert_eq!(Preferences::read(&file), rest);
        std::fs::write(&file, "light = ").unwrap();
        assert_eq!(Preferences::read(&file), Preferences::default());
        std::fs::write(&file, [0xff, 0xfe]).unwrap();
        assert_eq!(Preferences::read(&file), Preferences::default());
        assert_eq!(
            std::fs::read_dir(file.parent().unwrap()).unwrap().count(),
            1
        );
    }
}
