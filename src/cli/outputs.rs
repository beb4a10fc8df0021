//! The files of a render: if one fails, its error is printed, and the others are written.

use std::path::{Path, PathBuf};

use image::RgbaImage;
use myxo::Result;
use myxo::render::output::{Output, OutputError, Written};

use super::interrupt;
use super::progress::Progress;
use crate::console;

/// Every `--out` of a run.
#[derive(Debug)]
pub struct Outputs {
    open: Vec<Output>,
    written: Vec<Written>,
    failed: bool,
}

impl Outputs {
    /// Begins all of them, `size` pixels each.
    pub fn create(paths: &[PathBuf], size: [u32; 2], frames_per_second: u32) -> Result<Self> {
        let create = |path: &PathBuf| {
            let mut output = Output::create(path, size.into(), f64::from(frames_per_second))?;
            output.set_interrupt(interrupt::flag());
            Ok::<_, OutputError>(output)
        };
        Ok(Self {
            open: paths.iter().map(create).collect::<Result<_, _>>()?,
            written: Vec::new(),
            failed: false,
        })
    }

    /// Does any of them keep more than the last frame?
    pub fn want_every_frame(&self) -> bool {
        self.open.iter().any(Output::wants_every_frame)
    }

    /// The first one that cannot be transparent.
    pub fn opaque(&self) -> Option<&Path> {
        let mut opaque = self.open.iter().filter(|output| !output.keeps_alpha());
        opaque.next().map(Output::path)
    }

    /// The numbered files that are there already and that this many frames will replace.
    pub fn existing(&self, frames: u32) -> Vec<PathBuf> {
        let files = self.open.iter();
        let files = files.flat_map(|output| output.existing(u64::from(frames)));
        files.collect()
    }

    /// Is there one that has not failed?
    pub fn any_left(&self) -> bool {
        !self.open.is_empty()
    }

    /// Has one failed?
    pub fn failed(&self) -> bool {
        self.failed
    }

    /// The next frame of films and sequences.
    pub fn frame(&mut self, picture: &RgbaImage, progress: &Progress) {
        self.take(picture, progress, Output::wants_every_frame);
    }

    /// The last frame, for outputs that do not have it yet: films do if it was filmed.
    pub fn last_frame(&mut self, picture: &RgbaImage, filmed: bool, progress: &Progress) {
        self.take(picture, progress, |output| {
            !(filmed && output.wants_every_frame())
        });
    }

    fn take(&mut self, picture: &RgbaImage, progress: &Progress, wanted: impl Fn(&Output) -> bool) {
        for mut output in std::mem::take(&mut self.open) {
            if !wanted(&output) {
                self.open.push(output);
                continue;
            }
            match output.frame(picture) {
                Ok(()) => self.open.push(output),
                Err(error) => {
                    self.failed = true;
                    progress.say(&failure(&output.cut(error)));
                }
            }
        }
    }

    /// Finishes all files.
    pub fn finish(&mut self) {
        for output in self.open.drain(..) {
            match output.finish() {
                Ok(written) => self.written.push(written),
                Err(error) => {
                    self.failed = true;
                    console::message(&failure(&error));
                }
            }
        }
    }

    /// Prints which files were written.
    pub fn print_written(&self) {
        for written in &self.written {
            console::message(&written.to_string());
        }
    }
}

fn failure(error: &OutputError) -> String {
    format!("myxo: {error}")
}
