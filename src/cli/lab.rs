//! `myxo lab`: the window.

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use myxo::Result;
use myxo::scene::Scene;
use myxo::scene::builtin::DEFAULT_SCENE;
use myxo::sim::checkpoint::Checkpoint;

use super::options::{DeviceOptions, SceneOptions, Size};
use super::progress::atlas_cache;
use super::{Command, Outcome, interrupt};
use crate::lab::{self, LabOptions, Opened, Preferences, SceneFile, kept_name};

/// Open a window: look, play, turn parameters
#[derive(Clone, Debug, Default, Args)]
#[command(after_help = "\
Examples:
  myxo lab                              the scene oats
  myxo lab cube --preset cells
  myxo lab fish.glb --set particles.count=2_000_000
  myxo lab --resume fish_000001.ckpt    continues where the file was written")]
pub struct Lab {
    /// A built-in name, a .toml file, a model, or a built-in mesh such as builtin:torus?tube=0.2; without one `oats`, where slime mold
    /// gathers round food
    scene: Option<PathBuf>,
    /// Continues from the state in this file, with its own scene if none is named
    #[arg(long, value_name = "FILE")]
    resume: Option<PathBuf>,
    /// Size of the window, in pixels; by default that of last time
    #[arg(long, value_name = "WIDTHxHEIGHT")]
    size: Option<Size>,
    /// Begins with the usual size and colours of the window, and does not keep those of this time
    #[arg(long)]
    no_preferences: bool,
    /// Keeps a file of where controls are; for tests
    #[arg(long, value_name = "FILE", hide = true)]
    places: Option<PathBuf>,
    /// Opens no window: its input comes as lines of the standard input, and each is answered on the standard output; for tests
    #[arg(long, hide = true)]
    windowless: bool,
    /// Closes the window after so many pictures; for tests
    #[arg(long, value_name = "N", hide = true)]
    frames: Option<u32>,
    /// Behaves as if the device were lost after so many pictures, and the one after it after so many more; for tests
    #[arg(long, value_name = "N,N", value_delimiter = ',', hide = true)]
    lose_device: Vec<u32>,
    #[command(flatten)]
    changes: SceneOptions,
    #[command(flatten)]
    device: DeviceOptions,
}

impl Command for Lab {
    /// Loads the scene and opens the window with it.
    fn run(&self) -> Result<Outcome> {
        let opened = match (&self.scene, &self.resume) {
            (None, Some(file)) => Opened::resumed(file.clone(), &self.changes.overrides())?,
            (_, file) => Opened {
                scene: self.load()?,
                from: match file {
                    Some(file) => Some((file.clone(), Arc::new(Checkpoint::read(file)?))),
                    None => None,
                },
                file: self.scene.as_deref().and_then(SceneFile::opened),
            },
        };
        let size = self.size.map(|size| [size.width, size.height]);
        let preferences = Preferences::file().filter(|_| !self.no_preferences);
        lab::run(
            opened,
            LabOptions {
                device: self.device.device.clone(),
                validation: self.device.validate,
                size,
                preferences,
                atlases: atlas_cache(),
                places: self.places.clone(),
                windowless: self.windowless,
                frames: self.frames,
                lose_device: self.lose_device.clone(),
                interrupt: interrupt::flag(),
            },
            |close| interrupt::install_with("closing the window", close),
        )?;
        Ok(if interrupt::requested() {
            Outcome::Interrupted
        } else {
            Outcome::Done
        })
    }
}

impl Lab {
    fn load(&self) -> Result<Scene> {
        let scene = self.scene.clone().unwrap_or_else(|| DEFAULT_SCENE.into());
        let mut loaded = Scene::load(&scene, &self.changes.overrides())?;
        if let Some(name) = kept_name(&scene) {
            loaded.name = name;
        }
        Ok(loaded)
    }
}
