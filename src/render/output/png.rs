//! Pictures as PNG: the last frame, or every frame in a file of its own.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder, RgbaImage};

use super::OutputError;
use super::name::Numbering;
use crate::whole_file::WholeFile;

/// One PNG: the last frame.
#[derive(Debug)]
pub(super) struct Picture {
    file: WholeFile,
}

impl Picture {
    pub(super) fn create(path: &Path) -> Result<Self, OutputError> {
        let file = WholeFile::create(path).map_err(OutputError::file(path))?;
        Ok(Self { file })
    }

    pub(super) fn frame(&mut self, image: &RgbaImage) -> Result<(), OutputError> {
        let written = self
            .file
            .restart()
            .and_then(|()| write_png(&mut self.file, image));
        written.map_err(OutputError::file(self.file.path()))
    }

    pub(super) fn finish(self) -> Result<PathBuf, OutputError> {
        let path = self.file.path().to_owned();
        self.file.finish().map_err(OutputError::file(&path))?;
        Ok(path)
    }
}

/// Numbered PNGs.
#[derive(Debug)]
pub(super) struct Sequence {
    numbering: Numbering,
    files: Vec<PathBuf>,
    /// The folder, if it was created for them.
    made: Option<PathBuf>,
}

impl Sequence {
    pub(super) fn create(numbering: Numbering) -> Result<Self, OutputError> {
        // Begins and drops a file, to check now that the folder can be written.
        let first = numbering.path(0);
        let folder = first.parent().filter(|folder| !folder.exists());
        let made = folder.map(Path::to_owned);
        WholeFile::create(&first).map_err(OutputError::file(&first))?;
        Ok(Self {
            numbering,
            files: Vec::new(),
            made,
        })
    }

    pub(super) fn existing(&self, frames: u64) -> Vec<PathBuf> {
        self.numbering.existing(frames)
    }

    pub(super) fn frame(&mut self, image: &RgbaImage) -> Result<(), OutputError> {
        let mut picture = Picture::create(&self.numbering.path(self.files.len() as u64))?;
        picture.frame(image)?;
        self.files.push(picture.finish()?);
        Ok(())
    }

    pub(super) fn finish(mut self) -> Vec<PathBuf> {
        std::mem::take(&mut self.files)
    }
}

impl Drop for Sequence {
    fn drop(&mut self) {
        // A folder with files in it is not removed.
        if let Some(folder) = &self.made {
            let _ = std::fs::remove_dir(folder);
        }
    }
}

/// Writes a PNG; one without transparency has no alpha channel.
///
/// # Errors
/// When the file cannot be written.
pub fn write_png(mut file: impl Write, image: &RgbaImage) -> io::Result<()> {
    // Encoded in memory first: the encoder would return the error of a full disk as text only.
    let mut bytes = Vec::new();
    let (width, height) = image.dimensions();
    let encoder = PngEncoder::new(&mut bytes);
    let encoded = if image.pixels().all(|pixel| pixel.0[3] == 255) {
        let rgb: Vec<u8> = image
            .pixels()
            .flat_map(|p| [p.0[0], p.0[1], p.0[2]])
            .collect();
        encoder.write_image(&rgb, width, height, ExtendedColorType::Rgb8)
    } else {
        encoder.write_image(image.as_raw(), width, height, ExtendedColorType::Rgba8)
    };
    encoded.map_err(io::Error::other)?;
    file.write_all(&bytes)?;
    file.flush()
}
